//! The planes of an image's halo: how large they are and where they lie.

use rodsight_optics::Halo;

use super::super::layout::{self, HaloLevel, HaloStrip, Vec2i, Vec4f};
use crate::cpu::halo::{BESIDE, FINE, MARGIN, PATCHES, REACH, gaussian, kernel, ring};

/// Pixels of a row that one invocation weighs; longer stretches are summed from such runs.
pub(super) const RUN_PX: u32 = 16;
/// Cells of at least this side are summed by a workgroup each.
const WIDE_PX: u32 = 32;

/// All of an eye's image.
#[derive(Debug)]
pub(super) struct Shape {
    size: [u32; 2],
    overscan: u32,
    strips: [HaloStrip; 8],
    patches: u32,
    /// By level; that of 0 px is not blurred.
    levels: Vec<HaloLevel>,
    /// Sums of a row, of all levels.
    runs: u32,
}

impl Shape {
    pub(super) fn new(size: [u32; 2], overscan: usize, levels: usize) -> Self {
        let [width, height] = size;
        let mut patches = 0;
        let strip = |(at, size, side): ([isize; 2], [isize; 2], isize)| {
            let [columns, rows] = size.map(|size| (size as u32).div_ceil(side as u32));
            let first = patches;
            patches += columns * rows;
            HaloStrip {
                at: at.into(),
                size: size.into(),
                side: side as i32,
                columns,
                first,
            }
        };
        let image = size.map(|size| size.cast_signed() as isize);
        let rings = [(0, BESIDE), (BESIDE, overscan.cast_signed())];
        let all: Vec<HaloStrip> = rings
            .into_iter()
            .zip(PATCHES)
            .flat_map(|((from, to), side)| ring(image, from, to).map(|(at, size)| (at, size, side)))
            .map(strip)
            .collect();
        let strips = all.try_into().expect("two rings of four");

        let mut runs = 0;
        let mut of_levels: Vec<HaloLevel> = (0..levels.max(FINE))
            .map(|at| {
                let is_fine = at < FINE;
                let side = if is_fine { 1 } else { 1 << (at + 1 - FINE) };
                let weights = match at {
                    0 => vec![1.0],
                    1 | 2 => gaussian((at * at) as f64),
                    _ => kernel(side as usize),
                };
                let run_px = side.min(RUN_PX);
                let first_run = runs;
                if !is_fine {
                    runs += width.div_ceil(run_px);
                }
                HaloLevel {
                    columns: width.div_ceil(side),
                    rows: height.div_ceil(side),
                    side,
                    coarser_columns: 0,
                    run_px,
                    first_run,
                    border: u32::from(!is_fine),
                    kernel: [0, 1].map(|k| {
                        let weight = |i| weights.get(4 * k + i).copied().unwrap_or(0.0);
                        Vec4f::from(core::array::from_fn::<f32, 4, _>(weight))
                    }),
                    farthest: weights.get(REACH).copied().unwrap_or(0.0),
                }
            })
            .collect();
        for at in FINE..of_levels.len() {
            of_levels[at - 1].coarser_columns = of_levels[at].columns + 2;
        }
        Self {
            size,
            overscan: overscan as u32,
            strips,
            patches,
            levels: of_levels,
            runs,
        }
    }

    /// Everything of the uniform but what the water says.
    pub(super) fn uniform(&self) -> layout::Halo {
        let mut levels = [HaloLevel::default(); Halo::LEVELS];
        levels[..self.levels.len()].copy_from_slice(&self.levels);
        layout::Halo {
            size: self.size.map(|size| size.cast_signed() as isize).into(),
            overscan: self.overscan,
            patches: self.patches,
            count: self.levels.len() as u32,
            runs: self.runs,
            strips: self.strips,
            levels,
            ..layout::Halo::default()
        }
    }

    pub(super) fn levels(&self) -> usize {
        self.levels.len()
    }

    pub(super) fn level(&self, at: usize) -> &HaloLevel {
        &self.levels[at]
    }

    pub(super) fn patches(&self) -> u32 {
        self.patches
    }

    /// Whether a level has cells beyond the overscan.
    pub(super) fn is_far(&self, at: usize) -> bool {
        // Also the last cell of a row may end beyond it.
        (MARGIN as u32 + 1) * self.levels[at].side > self.overscan
    }

    pub(super) fn image_floats(&self) -> u64 {
        let [width, height] = self.size.map(u64::from);
        3 * width * height
    }

    pub(super) fn fine_floats(&self) -> u64 {
        let [width, height] = self.size.map(|size| u64::from(size) + 2 * MARGIN as u64);
        3 * width * height
    }

    pub(super) fn run_floats(&self) -> u64 {
        3 * u64::from(self.runs) * u64::from(self.size[1])
    }

    pub(super) fn cell_floats(&self) -> u64 {
        self.levels.get(FINE).map_or(0, |finest| {
            let [columns, rows] = finest.cells().map(u64::from);
            3 * columns * rows
        })
    }

    pub(super) fn row_floats(&self) -> u64 {
        let floats = self.levels[1..].iter().map(|level| {
            let [floats, rows] = level.blurred()[0].map(u64::from);
            floats * rows
        });
        floats.max().unwrap_or(0)
    }

    pub(super) fn blurred_floats(&self, at: usize) -> u64 {
        self.levels.get(at).map_or(0, |level| {
            let [floats, rows] = level.blurred()[1].map(u64::from);
            floats * rows
        })
    }
}

impl HaloLevel {
    /// Cells of the plane with its margin: columns and rows.
    pub(super) fn cells(&self) -> [u32; 2] {
        [self.columns, self.rows].map(|cells| cells + 2 * MARGIN as u32)
    }

    pub(super) fn is_wide(&self) -> bool {
        self.side >= WIDE_PX
    }

    /// Floats of a row and rows: after the convolution along rows, and after that along columns.
    pub(super) fn blurred(&self) -> [[u32; 2]; 2] {
        let floats = 3 * (self.columns + 2 * self.border);
        let rows = self.rows + 2 * self.border;
        [[floats, rows + 2 * REACH as u32], [floats, rows]]
    }
}

impl From<[isize; 2]> for Vec2i {
    fn from(values: [isize; 2]) -> Self {
        values.map(|value| value as i32).into()
    }
}

#[cfg(test)]
mod tests {
    use rodsight_shaders::{GATHER, OVERSCAN, Pass, WEIGH};

    use super::*;
    use crate::cpu::halo::RAYS;

    /// A constant of a pass.
    fn constant(pass: &Pass, name: &str) -> u32 {
        let module = naga::front::wgsl::parse_str(&pass.source()).unwrap();
        let mut all = module.constants.iter();
        let (_, found) = all
            .find(|(_, constant)| constant.name.as_deref() == Some(name))
            .unwrap_or_else(|| panic!("no {name} in {}", pass.name));
        match module.global_expressions[found.init] {
            naga::Expression::Literal(naga::Literal::U32(value)) => value,
            naga::Expression::Literal(naga::Literal::I32(value)) => value as u32,
            ref other => panic!("{name}: {other:?}"),
        }
    }

    #[test]
    fn shaders_count_as_we_do() {
        for (pass, name, ours) in [
            (&OVERSCAN, "FINE", FINE as u32),
            (&OVERSCAN, "MARGIN", MARGIN as u32),
            (&OVERSCAN, "REACH", REACH as u32),
            (&OVERSCAN, "LEVELS", Halo::LEVELS as u32),
            (&OVERSCAN, "RAYS", RAYS as u32),
            (&GATHER, "INVOCATIONS", super::super::ROW),
            (&WEIGH, "RUN_PX", RUN_PX),
            (&WEIGH, "THINGS", super::super::super::tile::THINGS as u32),
        ] {
            assert_eq!(constant(pass, name), ours, "{name}");
        }
    }

    /// The overscan is cut as the reference cuts it, and every pixel of the image's margin lies in one square.
    #[test]
    fn overscan_has_a_square_for_every_pixel_beside_the_image() {
        let shape = Shape::new([37, 21], 16, 9);
        let mut patches = 0;
        let mut area = 0;
        for strip in &shape.strips {
            assert_eq!(strip.first, patches);
            let [width, height] = <[i32; 2]>::from(strip.size);
            patches += strip.columns * (height as u32).div_ceil(strip.side as u32);
            area += width * height;
        }
        assert_eq!(patches, shape.patches());
        assert_eq!(area, (37 + 32) * (21 + 32) - 37 * 21);
    }
}
