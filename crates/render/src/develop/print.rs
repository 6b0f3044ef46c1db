//! From linear values to the image: white balance, colour matrix, sRGB.

use rodsight_scene::{Emva, Scene};

use super::emva;
use crate::srgb::srgb_encode;

/// What turns linear values of a scene into encoded ones.
#[derive(Clone, Copy)]
pub(super) struct Printer {
    white_balance: [f64; 3],
    colour_matrix: Option<[[f64; 3]; 3]>,
}

impl Printer {
    pub(super) fn new(scene: &Scene) -> Self {
        Self {
            white_balance: scene.white_balance,
            colour_matrix: scene.colour_matrix,
        }
    }

    /// The sRGB of a pixel, in [0, 1].
    pub(super) fn encode(&self, linear: [f64; 3]) -> [f64; 3] {
        let balanced: [f64; 3] = core::array::from_fn(|k| self.white_balance[k] * linear[k]);
        match self.colour_matrix {
            None => balanced,
            Some(rows) => rows.map(|row| (0..3).map(|k| row[k] * balanced[k]).sum()),
        }
        .map(srgb_encode)
    }

    /// The same for a converter's codes times `parts`. They are few: unless a matrix mixes the bands, each is encoded once. Demosaicing
    /// overshoots them now and then.
    pub(super) fn of_codes<T: Copy + Send + Sync>(
        self,
        emva: &Emva,
        parts: u16,
        quantise: impl Fn(f64) -> T + Sync,
    ) -> impl Fn([i32; 3]) -> [T; 3] + Sync {
        let highest = i32::from(parts) * i32::from(emva::steps(emva));
        let dark = emva::dark_level(emva);
        let linear = move |code: i32| f64::from(code) / f64::from(highest) - dark;
        let tables = [0, 1, 2].map(|k| {
            let codes = 0..=highest * i32::from(self.colour_matrix.is_none());
            let encoded = codes.map(|code| srgb_encode(self.white_balance[k] * linear(code)));
            encoded.map(&quantise).collect::<Vec<T>>()
        });
        move |codes| {
            let known = codes.iter().all(|code| (0..=highest).contains(code));
            if self.colour_matrix.is_none() && known {
                [0, 1, 2].map(|k| tables[k][codes[k] as usize])
            } else {
                self.encode(codes.map(linear)).map(&quantise)
            }
        }
    }
}
