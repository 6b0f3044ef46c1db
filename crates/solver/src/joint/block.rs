//! The light of blocks, and what a block's pixels say once it is eliminated.

use nalgebra::{DMatrix, SMatrix, SVector};

use super::pool::Block;
use super::state::{LAMPS, ROD, State, UNKNOWNS, of_shadow};

/// Shading of a block: three inside each limb, then two outside each.
pub(crate) const SHADES: usize = 10;
/// Shift, turn and bow of each limb of each eye.
pub(crate) const EDGES: usize = 12;
/// What else a block sees: how its limbs shift, px, the blur, of each limb the amount and the angle of a shadow, and what its shading
/// is expected to be.
const SEEN: usize = EXPECTED + SHADES;
pub(crate) const BLUR: usize = 2;
pub(crate) const SHADOWS: usize = 3;
const EXPECTED: usize = 7;
const LOCAL: usize = SHADES + SEEN;
/// The mean shading of an eye's blocks, and how it changes along the limbs.
pub(crate) const MEANS: usize = 2 * SHADES;
/// The unknowns, then the edges, then the means.
pub(crate) const ALL: usize = UNKNOWNS + EDGES + 2 * MEANS;

/// What a block sees stands for so many of them: both limbs for the rod and their edges, blur, shadows, and means.
pub(crate) const OF_ALL: usize = RIGID + MEANS + EDGES / 2;
/// Without means and edges.
pub(crate) const RIGID: usize = 2 * ROD + 5;

pub(crate) type Shades = SVector<f64, SHADES>;
pub(crate) type Shading = SMatrix<f64, SHADES, SHADES>;
/// Shading, then what else is seen.
pub(crate) type Local = SMatrix<f64, LOCAL, LOCAL>;
pub(crate) type LocalVector = SVector<f64, LOCAL>;

/// The light of all blocks.
#[derive(Clone, Debug)]
pub(crate) struct Lit {
    pub(crate) shades: Vec<Shades>,
    /// Of each eye what shading is in the middle of the limbs, and what it gains from there to their end.
    pub(crate) means: [[Shades; 2]; 2],
}

impl Lit {
    /// No light in so many blocks.
    pub(crate) fn dark(blocks: usize) -> Self {
        Self {
            shades: vec![Shades::zeros(); blocks],
            means: [[Shades::zeros(); 2]; 2],
        }
    }

    pub(crate) fn expected(&self, eye: usize, along: f64) -> Shades {
        self.means[eye][0] + self.means[eye][1] * along
    }
}

/// What is known of the shading of each eye before its pixels; zero where nothing is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Alike {
    /// Of how blocks differ from what is expected, one over the covariance.
    pub(crate) blocks: [Shading; 2],
    /// Of the means and of what they gain, one over the covariance of each.
    pub(crate) means: [Shading; 2],
    /// Of each block by itself, one over the covariance.
    pub(crate) each: [Shading; 2],
}

/// What a block's pixels say of what it sees, shading eliminated.
#[derive(Clone, Debug)]
pub(crate) struct BlockSums {
    pub(crate) eye: usize,
    pub(crate) along: f64,
    blur_px2: f64,
    is_by_lamps: bool,
    /// Of shading itself, by the pixels alone.
    pub(crate) shading: Shading,
    normal: SMatrix<f64, SEEN, SEEN>,
    score: SVector<f64, SEEN>,
    /// Shading becomes `shift − by_seen · step`.
    shift: Shades,
    by_seen: SMatrix<f64, SHADES, SEEN>,
    /// How limbs shift, px.
    by_rod: [[f64; ROD]; 2],
}

impl BlockSums {
    /// Eliminates the shading of a block that is off by so much from what is expected, and says what that costs.
    pub(crate) fn new(
        block: &Block,
        state: &State,
        by_rod: [[f64; ROD]; 2],
        (local, right): (&mut Local, &mut LocalVector),
        (shades, expected): (&Shades, &Shades),
        alike: &Alike,
    ) -> (Self, f64) {
        let mut sums = Self {
            eye: block.eye,
            along: block.along,
            blur_px2: state.blur_px2[block.eye],
            is_by_lamps: state.lamps_rad[0].is_some(),
            shading: local.fixed_view::<SHADES, SHADES>(0, 0).into_owned(),
            normal: SMatrix::zeros(),
            score: SVector::zeros(),
            shift: Shades::zeros(),
            by_seen: SMatrix::zeros(),
            by_rod,
        };
        let each = &alike.each[block.eye];
        let pull = each * shades;
        let mut cost = 0.5 * shades.dot(&pull);
        let mut part = local.fixed_view_mut::<SHADES, SHADES>(0, 0);
        part += each;
        let mut part = right.fixed_rows_mut::<SHADES>(0);
        part -= pull;
        cost += expect(&(shades - expected), &alike.blocks[block.eye], local, right);
        sums.eliminate(local, right);
        (sums, cost)
    }

    /// Of each that is seen of which of all it is, and how much; the edges last.
    fn of_all(&self) -> [(usize, usize, f64); OF_ALL] {
        let mut found = [(0, 0, 0.0); OF_ALL];
        let mut places = found.iter_mut();
        let mut put = |seen, at, by| {
            if let Some(place) = places.next() {
                *place = (seen, at, by);
            }
        };
        for (side, by_rod) in self.by_rod.iter().enumerate() {
            for (k, by) in by_rod.iter().enumerate() {
                put(side, k, *by);
            }
        }
        put(BLUR, ROD + self.eye, self.blur_px2);
        for k in 0..4 {
            // Lamps are the same for all limbs: their derivatives stand where those of a shadow would.
            let at = if self.is_by_lamps {
                LAMPS + k % 2
            } else {
                of_shadow(self.eye, 0) + k
            };
            put(SHADOWS + k, at, 1.0);
        }
        let means = UNKNOWNS + EDGES + self.eye * MEANS;
        for k in 0..SHADES {
            put(EXPECTED + k, means + k, 1.0);
            put(EXPECTED + k, means + SHADES + k, self.along);
        }
        let bow = self.along * self.along - 1.0 / 3.0;
        for side in 0..2 {
            let first = UNKNOWNS + self.eye * EDGES / 2 + 3 * side;
            for (k, by) in [1.0, self.along, bow].into_iter().enumerate() {
                put(side, first + k, by);
            }
        }
        found
    }

    /// By how much shading changes with a step and with what is expected.
    pub(crate) fn shaded(&self, step: &SVector<f64, UNKNOWNS>, expected: &Shades) -> Shades {
        let mut seen = SVector::<f64, SEEN>::zeros();
        for (k, at, by) in self.of_all() {
            if at < UNKNOWNS {
                seen[k] += by * step[at];
            }
        }
        seen.fixed_rows_mut::<SHADES>(EXPECTED).copy_from(expected);
        self.shift - self.by_seen * seen
    }

    /// Of the unknowns, the edges and the means.
    pub(crate) fn scores(&self) -> SVector<f64, ALL> {
        let mut scores = SVector::zeros();
        for (k, at, by) in self.of_all() {
            scores[at] += by * self.score[k];
        }
        scores
    }

    /// Adds the first of all to one triangle of their matrix.
    pub(crate) fn add_to(&self, all: &mut DMatrix<f64>, first: usize) {
        let of_all = self.of_all();
        let of_all = &of_all[..first];
        for (i, (k, a, by_a)) in of_all.iter().enumerate() {
            for (j, (l, b, by_b)) in of_all.iter().enumerate().skip(i) {
                let twice = if i != j && a == b { 2.0 } else { 1.0 };
                all[((*a).max(*b), (*a).min(*b))] += twice * by_a * self.normal[(*k, *l)] * by_b;
            }
        }
    }

    /// Takes over a block's sums without its shading.
    fn eliminate(&mut self, local: &Local, right: &LocalVector) {
        let mut shading = local.fixed_view::<SHADES, SHADES>(0, 0).into_owned();
        let least = 1e-7 * shading.trace() / SHADES as f64 + f64::MIN_POSITIVE;
        for i in 0..SHADES {
            shading[(i, i)] += least;
        }
        if let Some(factor) = shading.cholesky() {
            let cross = local.fixed_view::<SHADES, SEEN>(0, SHADES);
            self.shift = factor.solve(&right.fixed_rows::<SHADES>(0));
            self.by_seen = factor.solve(&cross);
            let seen = local.fixed_view::<SEEN, SEEN>(SHADES, SHADES);
            self.normal = seen - cross.transpose() * self.by_seen;
            self.score = right.fixed_rows::<SEEN>(SHADES) - cross.transpose() * self.shift;
        }
    }
}

/// Adds what is known of a block's shading, which is off by so much from what is expected, and says what that costs.
fn expect(off: &Shades, alike: &Shading, local: &mut Local, right: &mut LocalVector) -> f64 {
    let pull = alike * off;
    let expected = SHADES + EXPECTED;
    for (a, b, sign) in [
        (0, 0, 1.0),
        (0, expected, -1.0),
        (expected, 0, -1.0),
        (expected, expected, 1.0),
    ] {
        let mut part = local.fixed_view_mut::<SHADES, SHADES>(a, b);
        part += alike * sign;
    }
    let mut part = right.fixed_rows_mut::<SHADES>(0);
    part -= pull;
    let mut part = right.fixed_rows_mut::<SHADES>(expected);
    part += pull;
    0.5 * off.dot(&pull)
}
