//! What draws by seed.

use rodsight_geometry::{Vec3, radians};

#[path = "../../../solver/tests/common/random.rs"]
#[allow(
    unreachable_pub,
    clippy::duplicate_mod,
    reason = "the painter has it as well, where there is one"
)]
mod random;

pub(crate) use random::Random;

/// What draws by seed.
pub(crate) struct Dice(pub(crate) Random);

impl Dice {
    pub(crate) fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.uniform()
    }

    /// Small values as often as large ones.
    pub(crate) fn log_within(&mut self, low: f64, high: f64) -> f64 {
        low * libm::pow(high / low, self.0.uniform())
    }

    pub(crate) fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[((self.0.uniform() * all.len() as f64) as usize).min(all.len() - 1)]
    }

    pub(crate) fn colour(&mut self) -> [f64; 3] {
        self.one_of(&[
            [0.6, 0.3, 0.06],
            [0.5, 0.5, 0.45],
            [0.15, 0.15, 0.15],
            [0.7, 0.6, 0.05],
            [0.4, 0.05, 0.03],
            [0.05, 0.3, 0.1],
        ])
    }

    /// A lamp at so many degrees from the view's axis, aside in a direction.
    pub(crate) fn lamp(&mut self, from_deg: f64, to_deg: f64, side_rad: f64) -> Vec3 {
        let off = radians(self.within(from_deg, to_deg));
        let aside = libm::sin(off);
        Vec3::new(
            -libm::cos(off),
            aside * libm::cos(side_rad),
            aside * libm::sin(side_rad),
        ) * self.within(0.5, 1.0)
    }
}
