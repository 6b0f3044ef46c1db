//! The halo: light of surfaces that the water scatters forwards on its way to the camera.
//!
//!   forward = Σⱼ Gⱼ ∗ (fⱼ(z) [MTF(0, z) − e^(−c z)] L₀)
//!
//! The light is weighted by the share of each Gaussian at its own distance first and blurred after, so that a lamp-lit rod glows over the
//! dark behind it. Gaussians of 1 and 2 px are convolved as they are; each wider one of s px on cells of s/2 px, whose means and whose
//! interpolation take off the variance they add. What foreground hides of a halo is ignored.
//!
//! No light is missing at the borders: around the image, as far as a sixth of a rad, a ray in every 4×4 px (2×2 beside it) stands for them, and
//! farther out, as far as each Gaussian reaches (4 s), 16 rays in each of its cells.

use rayon::prelude::*;
use rodsight_geometry::Pixel;
use rodsight_optics::Halo;

use super::plane::Plane;
use crate::frame::PixelTruth;

/// Cells to either side that a Gaussian of 2 cells takes part in: 4 σ, all but 1e-4 of it.
pub(crate) const REACH: usize = 8;
/// Cells around the image: those, and one for the interpolation.
pub(crate) const MARGIN: usize = REACH + 1;
/// Widths that are blurred at full resolution: 0, 1 and 2 px.
pub(crate) const FINE: usize = 3;
/// Rows of a piece of work.
const ROWS: usize = 16;
/// Sides of what one ray stands for beside the image, and as far as it is sampled finely, px.
pub(crate) const PATCHES: [isize; 2] = [2, 4];
/// How far the smaller ones go: the reach of the fine widths.
pub(crate) const BESIDE: isize = REACH.cast_signed();
/// Cells farther out take so many rays a side.
pub(crate) const RAYS: usize = 4;

/// Light that is to be spread: what arrives scattered of a surface at a distance, W m⁻² sr⁻¹.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scattered {
    pub(super) light: [f32; 3],
    pub(super) range_m: f32,
}

/// Light of a pixel's column that has more than one distance.
pub(super) type Mixed = Vec<(u32, Scattered)>;

/// The image's light before it is spread.
pub(super) struct Sources<'a, F> {
    pub(super) width: usize,
    /// `forward` holds the light of pixels with one distance, `range_m`.
    pub(super) pixels: &'a [PixelTruth],
    /// The others, by row.
    pub(super) mixed: &'a [Mixed],
    /// The light at a place outside the image.
    pub(super) beyond: F,
    /// Width around the image that is sampled finely, px: a power of two, at least 16.
    pub(super) overscan: usize,
}

/// Light of a piece of the overscan: its corner, its size, px.
struct Patch {
    at: [isize; 2],
    size: [isize; 2],
    shares: [[f32; Halo::LEVELS]; 3],
}

/// Light summed over the cells of a level, of the image and its overscan. Cells start at the image's corner; `before` lie left of it
/// and above.
struct Cells {
    side: usize,
    before: usize,
    columns: usize,
    sums: Vec<[f32; 3]>,
}

impl Cells {
    fn new(level: usize, size: [usize; 2], overscan: usize) -> Self {
        let side = 1 << level;
        let before = overscan.div_ceil(side);
        let [columns, rows] = size.map(|size| before + (size + overscan).div_ceil(side));
        Self {
            side,
            before,
            columns,
            sums: vec![[0.0; 3]; columns * rows],
        }
    }

    /// The cell of a column and row of cells; those of the overscan left and above are negative.
    fn at(&mut self, column: isize, row: isize) -> &mut [f32; 3] {
        let [column, row] = [column, row].map(|at| (at + self.before.cast_signed()) as usize);
        &mut self.sums[row * self.columns + column]
    }

    /// Adds a patch to every cell it lies in, by its area there.
    fn add_patch(&mut self, patch: &Patch, width: usize) {
        let side = self.side.cast_signed();
        let overlaps = |axis: usize| {
            let (from, to) = (patch.at[axis], patch.at[axis] + patch.size[axis]);
            let cells = from.div_euclid(side)..=(to - 1).div_euclid(side);
            cells.map(move |cell| (cell, to.min((cell + 1) * side) - from.max(cell * side)))
        };
        for (row, height) in overlaps(1) {
            for (column, width_px) in overlaps(0) {
                let area = (height * width_px) as f32;
                let light = patch.shares.map(|shares| area * shares[width]);
                add(self.at(column, row), light);
            }
        }
    }
}

fn add(sum: &mut [f32; 3], light: [f32; 3]) {
    *sum = core::array::from_fn(|k| sum[k] + light[k]);
}

impl<F: Fn(&Pixel) -> Scattered + Sync> Sources<'_, F> {
    fn size(&self) -> [usize; 2] {
        [self.width, self.pixels.len() / self.width]
    }

    /// The halo of the image: shape `[height, width]`.
    pub(super) fn spread(&self, halo: &Halo) -> Plane {
        let [width, height] = self.size();
        let mut fine = [(); FINE].map(|()| Plane::new(width, height, MARGIN));
        let mut levels: Vec<Cells> = (1..=halo.levels().saturating_sub(FINE))
            .map(|level| Cells::new(level, self.size(), self.overscan))
            .collect();
        self.weigh(halo, &mut fine, &mut levels);
        for patch in self.patches(halo) {
            for (level, cells) in levels.iter_mut().enumerate() {
                cells.add_patch(&patch, level + FINE);
            }
            for (level, plane) in fine.iter_mut().enumerate() {
                plane.fill_margin(
                    patch.at,
                    patch.size,
                    patch.shares.map(|shares| shares[level]),
                );
            }
        }

        let mut coarser: Option<Plane> = None;
        for (level, cells) in levels.iter().enumerate().rev() {
            let means = self.means(halo, level + FINE, cells);
            let mut blurred = means.blurred(&kernel(cells.side), 1);
            if let Some(coarser) = coarser {
                blurred.add_magnified(&coarser);
            }
            coarser = Some(blurred);
        }
        let mut sum = fine[0].cropped();
        for (width_px, plane) in [1.0, 2.0].into_iter().zip(&fine[1..]) {
            sum.add(&plane.blurred(&gaussian(width_px * width_px), 0));
        }
        if let Some(coarser) = coarser {
            sum.add_magnified(&coarser);
        }
        sum
    }

    /// Weighs every pixel's light by the shares of the widths: into the planes of the fine ones, and into the cells of the coarse levels.
    fn weigh(&self, halo: &Halo, fine: &mut [Plane; FINE], levels: &mut [Cells]) {
        let [unspread, one, two] = fine;
        let pieces: Vec<Vec<Cells>> = self
            .pixels
            .par_chunks(self.width * ROWS)
            .zip(self.mixed.par_chunks(ROWS))
            .zip(unspread.rows_mut(ROWS))
            .zip(one.rows_mut(ROWS))
            .zip(two.rows_mut(ROWS))
            .map(|((((pixels, mixed), unspread), one), two)| {
                let mut piece: Vec<Cells> = (1..=levels.len())
                    .map(|level| Cells::new(level, [self.width, mixed.len()], 0))
                    .collect();
                let stride = unspread.len() / mixed.len();
                // Fresh memory that is read before it is written costs two page faults, and the second interrupts every core.
                for plane in [&mut *unspread, one, two] {
                    plane.fill(0.0);
                }
                for (row, (pixels, mixed)) in pixels.chunks(self.width).zip(mixed).enumerate() {
                    let at = row * stride;
                    let mut fine = [&mut *unspread, one, two].map(|p| &mut p[at..at + stride]);
                    let mut run = Run::default();
                    for (column, pixel) in pixels.iter().enumerate() {
                        if pixel.forward != [0.0; 3] {
                            let light = Scattered {
                                light: pixel.forward,
                                range_m: pixel.range_m,
                            };
                            let shares = weighted(halo, &light);
                            deposit_fine(&shares, column, &mut fine);
                            run.add(&shares);
                        }
                        run.pass(column, row, &mut piece);
                    }
                    run.end(self.width, row, &mut piece);
                    let lit = |scattered: &Scattered| scattered.light != [0.0; 3];
                    for (column, scattered) in mixed.iter().filter(|(_, light)| lit(light)) {
                        let (column, shares) = (*column as usize, weighted(halo, scattered));
                        deposit_fine(&shares, column, &mut fine);
                        run.add(&shares);
                        run.end(column + 1, row, &mut piece);
                    }
                }
                piece
            })
            .collect();
        // Pieces of 16 rows to rows of cells, in order.
        for (first_row, piece) in (0..).step_by(ROWS).zip(&pieces) {
            for (cells, part) in levels.iter_mut().zip(piece) {
                for (i, sum) in part.sums.iter().enumerate() {
                    let (row, column) = (i / part.columns, i % part.columns);
                    let row = (first_row / part.side + row).cast_signed();
                    add(cells.at(column.cast_signed(), row), *sum);
                }
            }
        }
    }

    /// The overscan near the image.
    fn patches(&self, halo: &Halo) -> Vec<Patch> {
        let size = self.size().map(usize::cast_signed);
        let rings = [(0, BESIDE), (BESIDE, self.overscan.cast_signed())];
        let corners = rings
            .into_iter()
            .zip(PATCHES)
            .flat_map(|((from, to), side)| {
                let strips = ring(size, from, to).into_iter();
                strips.flat_map(move |(at, size)| tiles(at, size, side))
            });
        let corners: Vec<_> = corners.collect();
        let patches = corners.into_par_iter().map(|(at, size)| {
            let middle = [0, 1].map(|axis| at[axis] as f64 + 0.5 * size[axis] as f64);
            Patch {
                at,
                size,
                shares: weighted(halo, &(self.beyond)(&middle.into())),
            }
        });
        patches.collect()
    }

    /// The means over the cells of a level, with those farther out that its Gaussian reaches.
    fn means(&self, halo: &Halo, width: usize, cells: &Cells) -> Plane {
        let side = cells.side as f64;
        let [columns, rows] = self.size().map(|size| size.div_ceil(cells.side));
        let out = self.overscan as f64;
        let end = self.size().map(|size| size as f64 + out);
        let mut plane = Plane::new(columns, rows, MARGIN);
        plane.fill(|column, row| {
            let from = [column, row].map(|at| at as f64 * side);
            let [x, y] = [0, 1]
                .map(|axis| ((from[axis] + side).min(end[axis]) - from[axis].max(-out)).max(0.0));
            let known = (x * y) as f32;
            let area = (side * side) as f32;
            let index = [column, row].map(|at| at + cells.before.cast_signed());
            let sum = if known > 0.0 {
                cells.sums[index[1] as usize * cells.columns + index[0] as usize]
            } else {
                [0.0; 3]
            };
            if known == area {
                return sum.map(|sum| sum / area);
            }
            let (mut light, mut rays) = ([0.0; 3], 0.0);
            for k in 0..RAYS * RAYS {
                let place = |step: usize| (step as f64 + 0.5) * side / RAYS as f64;
                let [x, y] = [from[0] + place(k % RAYS), from[1] + place(k / RAYS)];
                if x < -out || y < -out || x > end[0] || y > end[1] {
                    let there = (self.beyond)(&Pixel::new(x, y));
                    add(
                        &mut light,
                        weighted(halo, &there).map(|shares| shares[width]),
                    );
                    rays += 1.0;
                }
            }
            if rays == 0.0 {
                // Less than an eighth of a side: as the rest of the cell.
                return sum.map(|sum| sum / known);
            }
            core::array::from_fn(|k| (sum[k] + (area - known) * light[k] / rays) / area)
        });
        plane
    }
}

/// A rectangle: its corner, its size, px.
pub(crate) type Rectangle = ([isize; 2], [isize; 2]);

/// What lies between `from` and `to` pixels outside an image: above, left, right and below.
pub(crate) fn ring([width, height]: [isize; 2], from: isize, to: isize) -> [Rectangle; 4] {
    let (thick, across, down) = (to - from, width + 2 * to, height + 2 * from);
    [
        ([-to, -to], [across, thick]),
        ([-to, -from], [thick, down]),
        ([width + from, -from], [thick, down]),
        ([-to, height + from], [across, thick]),
    ]
}

/// A rectangle in squares of a side, row by row; the last are cut.
fn tiles(at: [isize; 2], size: [isize; 2], side: isize) -> impl Iterator<Item = Rectangle> {
    let steps = move |axis: usize| (0..size[axis]).step_by(side as usize);
    steps(1).flat_map(move |y| {
        steps(0).map(move |x| {
            let rest = [size[0] - x, size[1] - y].map(|rest| rest.min(side));
            ([at[0] + x, at[1] + y], rest)
        })
    })
}

/// A light's parts in every width.
fn weighted(halo: &Halo, scattered: &Scattered) -> [[f32; Halo::LEVELS]; 3] {
    let mut shares = halo.shares(scattered.range_m);
    for (shares, light) in shares.iter_mut().zip(scattered.light) {
        for share in shares {
            *share *= light;
        }
    }
    shares
}

/// Adds a pixel's parts to the fine planes' row.
#[inline]
fn deposit_fine(shares: &[[f32; Halo::LEVELS]; 3], column: usize, fine: &mut [&mut [f32]; FINE]) {
    for (level, plane) in fine.iter_mut().enumerate() {
        for (k, shares) in shares.iter().enumerate() {
            plane[3 * (column + MARGIN) + k] += shares[level];
        }
    }
}

/// Parts of the pixels of a row since its last cell of each level began: a cell is written once a row, not once a pixel.
#[derive(Default)]
struct Run {
    sums: [[f32; Halo::LEVELS]; 3],
}

impl Run {
    #[inline]
    fn add(&mut self, shares: &[[f32; Halo::LEVELS]; 3]) {
        for (sums, shares) in self.sums.iter_mut().zip(shares) {
            for (sum, share) in sums.iter_mut().zip(shares) {
                *sum += share;
            }
        }
    }

    /// Writes what ends with a column: as cells double from level to level, those of the first few.
    #[inline]
    fn pass(&mut self, column: usize, row: usize, levels: &mut [Cells]) {
        let ended = (column + 1).trailing_zeros() as usize;
        let ended = ended.min(levels.len());
        self.write(column, row, &mut levels[..ended]);
    }

    /// Writes all that is left, before a column.
    fn end(&mut self, column: usize, row: usize, levels: &mut [Cells]) {
        self.write(column - 1, row, levels);
    }

    fn write(&mut self, column: usize, row: usize, levels: &mut [Cells]) {
        for (level, cells) in levels.iter_mut().enumerate() {
            let cell = (row >> (level + 1)) * cells.columns + (column >> (level + 1));
            let sums = self.sums.each_mut();
            let light = sums.map(|sums| core::mem::take(&mut sums[level + FINE]));
            add(&mut cells.sums[cell], light);
        }
    }
}

/// The kernel on cells of `side` px. Their means add (side² − 1)/12 px² of variance and their interpolation, down to pixels by factors of
/// two, (side² − 1)/4: what is left of (2 side)² is in cells² 4 − (1 − 1/side²)/3.
pub(crate) fn kernel(side: usize) -> Vec<f32> {
    gaussian(4.0 - (1.0 - 1.0 / (side * side) as f64) / 3.0)
}

/// A Gaussian of this variance at whole steps, from the middle to its reach; all of it sums to 1.
pub(crate) fn gaussian(variance: f64) -> Vec<f32> {
    let reach = (4.0 * variance.sqrt()).ceil().min(REACH as f64) as usize;
    let values: Vec<f64> = (0..=reach)
        .map(|k| libm::exp(-0.5 * (k * k) as f64 / variance))
        .collect();
    let total = 2.0 * values.iter().sum::<f64>() - values[0];
    values.iter().map(|v| (v / total) as f32).collect()
}

#[cfg(test)]
mod tests;
