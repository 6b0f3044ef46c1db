//! Base-colour textures, prefiltered.

use rodsight_scene::{Texture, Wrap};

use crate::srgb::srgb_decode;

/// An image at every size down to one pixel, each a quarter of the one before, linear.
#[derive(Clone, Debug)]
pub(crate) struct Pyramid {
    /// Width, height, first texel in `texels`.
    pub(crate) levels: Vec<(u32, u32, usize)>,
    pub(crate) texels: Vec<[f32; 3]>,
    pub(crate) wrap: [Wrap; 2],
}

impl Pyramid {
    pub(crate) fn new(texture: &Texture) -> Self {
        let linear = |byte: u8| srgb_decode(f64::from(byte) / 255.0) as f32;
        let mut pyramid = Self {
            levels: vec![(texture.width_px, texture.height_px, 0)],
            texels: texture.srgb.iter().map(|rgb| rgb.map(linear)).collect(),
            wrap: texture.wrap,
        };
        while let Some(&(width, height, first)) = pyramid.levels.last()
            && (width > 1 || height > 1)
        {
            let (half_width, half_height) = (width.div_ceil(2), height.div_ceil(2));
            pyramid
                .levels
                .push((half_width, half_height, pyramid.texels.len()));
            for (row, column) in (0..half_height).flat_map(|r| (0..half_width).map(move |c| (r, c)))
            {
                let mut sum = [0.0_f64; 3];
                for (r, c) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                    let (r, c) = (
                        (2 * row + r).min(height - 1),
                        (2 * column + c).min(width - 1),
                    );
                    let texel = pyramid.texels[first + r as usize * width as usize + c as usize];
                    sum = core::array::from_fn(|k| sum[k] + f64::from(texel[k]));
                }
                pyramid.texels.push(sum.map(|s| (0.25 * s) as f32));
            }
        }
        pyramid
    }

    pub(crate) fn size_px(&self) -> [f64; 2] {
        let (width, height, _) = self.levels[0];
        [f64::from(width), f64::from(height)]
    }

    /// The mean colour about a point over a square of `footprint_px` texels a side: linear between texels and between levels.
    pub(crate) fn at(&self, uv: [f64; 2], footprint_px: f64) -> [f64; 3] {
        let last = self.levels.len() - 1;
        let (lower, share) = level(footprint_px, last);
        let fine = self.bilinear(uv, lower);
        if share == 0.0 {
            return fine;
        }
        let coarse = self.bilinear(uv, lower + 1);
        core::array::from_fn(|k| fine[k] + share * (coarse[k] - fine[k]))
    }

    fn bilinear(&self, uv: [f64; 2], level: usize) -> [f64; 3] {
        let (width, height, first) = self.levels[level];
        let (x, y) = (
            uv[0] * f64::from(width) - 0.5,
            uv[1] * f64::from(height) - 0.5,
        );
        let (x0, y0) = (libm::floor(x), libm::floor(y));
        let texel = |dx: f64, dy: f64| {
            let column = wrapped(x0 + dx, width, self.wrap[0]);
            let row = wrapped(y0 + dy, height, self.wrap[1]);
            self.texels[first + row * width as usize + column].map(f64::from)
        };
        let (fx, fy) = (x - x0, y - y0);
        let [a, b, c, d] = [
            texel(0.0, 0.0),
            texel(1.0, 0.0),
            texel(0.0, 1.0),
            texel(1.0, 1.0),
        ];
        core::array::from_fn(|k| {
            let upper = a[k] + fx * (b[k] - a[k]);
            let lower = c[k] + fx * (d[k] - c[k]);
            upper + fy * (lower - upper)
        })
    }
}

/// The finer of the two levels for samples this many texels apart, and the share of the coarser one.
pub(crate) fn level(footprint_px: f64, last: usize) -> (usize, f64) {
    let level = libm::log2(footprint_px.max(1.0)).min(last as f64);
    let lower = libm::floor(level);
    (lower as usize, level - lower)
}

/// The texel that a coordinate beyond the image stands for.
pub(crate) fn wrapped(at: f64, size: u32, wrap: Wrap) -> usize {
    let n = f64::from(size);
    let modulo = |value: f64, period: f64| value - period * libm::floor(value / period);
    let inside = match wrap {
        Wrap::Repeat => modulo(at, n),
        Wrap::Clamp => at,
        Wrap::Mirror => {
            let back = modulo(at, 2.0 * n);
            if back < n { back } else { 2.0 * n - 1.0 - back }
        }
    };
    inside.clamp(0.0, n - 1.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn checker(wrap: Wrap) -> Pyramid {
        Pyramid::new(&Texture {
            width_px: 4,
            height_px: 2,
            srgb: (0..8)
                .map(|i| [if (i + i / 4) % 2 == 0 { 255 } else { 0 }; 3])
                .collect(),
            wrap: [wrap; 2],
        })
    }

    #[test]
    fn texels_are_met_at_their_centres_and_far_away_all_is_their_mean() {
        let pyramid = checker(Wrap::Repeat);
        assert_eq!(pyramid.at([0.125, 0.25], 0.0), [1.0; 3]);
        assert_eq!(pyramid.at([0.375, 0.25], 0.5), [0.0; 3]);
        assert_eq!(pyramid.at([0.25, 0.25], 1.0), [0.5; 3]);
        for footprint in [2.0, 4.0, 1e9] {
            let grey = pyramid.at([0.3, 0.8], footprint);
            assert!((grey[0] - 0.5).abs() < 1e-7, "{footprint}: {grey:?}");
        }
    }

    #[test]
    fn wrapping_repeats_mirrors_and_clamps() {
        let column = |at: f64, wrap| wrapped(at, 4, wrap);
        for (at, repeat, mirror, clamp) in [
            (-1.0, 3, 0, 0),
            (4.0, 0, 3, 3),
            (5.0, 1, 2, 3),
            (-5.0, 3, 3, 0),
        ] {
            assert_eq!(column(at, Wrap::Repeat), repeat, "{at}");
            assert_eq!(column(at, Wrap::Mirror), mirror, "{at}");
            assert_eq!(column(at, Wrap::Clamp), clamp, "{at}");
        }
        assert_eq!(column(f64::NAN, Wrap::Repeat), 0);
    }
}
