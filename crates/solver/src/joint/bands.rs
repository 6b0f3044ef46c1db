//! The pixels around the limbs: row by row (or column by column), with the rays that tell where in them a rod's limb is.

use rodsight_geometry::{MountedCamera, Pixel, Side, Vec3};

use super::light::Light;
use super::noise;
use super::state::State;

/// Pixels to either side of a limb that are looked at.
pub(crate) const REACH_PX: f64 = 10.0;
/// Of them inside: as far as the light of a round rod is that of its limb, before another lamp's shadow begins.
pub(crate) const INSIDE_PX: f64 = 5.0;
/// Of a Gaussian's standard deviation, what is looked at.
const SOFT_REACH: f64 = 3.5;
/// Rows that share their shading.
const BLOCK_ROWS: usize = 24;

/// A ray in the rig frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin_m: Vec3,
    pub(crate) direction: Vec3,
}

/// The pixels of a row around one limb.
#[derive(Clone, Debug)]
pub(crate) struct Cut {
    /// The first pixel's centre from the cut's middle, px.
    pub(crate) first_px: f64,
    pub(crate) values: Vec<f64>,
    /// One over the variance of each.
    pub(crate) weights: Vec<f64>,
    /// What they cost as a slope of light without a limb.
    pub(crate) without: f64,
    /// Where the rod is from the limb: 1 towards larger places, −1 towards smaller ones.
    pub(crate) inwards: f64,
    /// Its middle from the principal point, across and along, px.
    pub(crate) from_centre_px: [f64; 2],
    /// Through the row at −`REACH_PX`, 0 and `REACH_PX` from the middle, and beside the middle a row up and a row down.
    pub(crate) rays: [Ray; 5],
}

/// A row of the image, or a column.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// Place along the limbs, from −1 to 1.
    pub(crate) along: f64,
    /// Around the limbs plus and minus.
    pub(crate) cuts: [Option<Cut>; 2],
    pub(crate) weight: f64,
}

/// Rows that share their shading.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    pub(crate) eye: usize,
    pub(crate) rows: Vec<Row>,
    /// Half of the length from −1 to 1 along the limbs, px.
    pub(crate) half_px: f64,
    /// By how much light rises inside the limbs plus and minus.
    pub(crate) rise: [f64; 2],
}

impl Block {
    fn new(eye: usize, half_px: f64, rows: Vec<Row>) -> Self {
        let rise = [0, 1].map(|side| {
            let mean = |from_px: f64, to_px: f64| {
                let (mut sum, mut count) = (0.0, 0.0);
                for cut in rows.iter().filter_map(|row| row.cuts[side].as_ref()) {
                    for (k, value) in cut.values.iter().enumerate() {
                        let inside_px = cut.inwards * (cut.first_px + k as f64);
                        if (from_px..to_px).contains(&inside_px) {
                            sum += value;
                            count += 1.0;
                        }
                    }
                }
                (count > 0.0).then(|| sum / count)
            };
            let rise = mean(3.0, INSIDE_PX).zip(mean(0.7, 1.7));
            rise.map_or(0.0, |(deep, shallow)| (deep - shallow).max(0.0))
        });
        Self {
            eye,
            rows,
            half_px,
            rise,
        }
    }

    /// Whether a limb is looked at.
    pub(crate) fn sees(&self, side: usize) -> bool {
        self.rows.iter().any(|row| row.cuts[side].is_some())
    }
}

/// The limbs as an eye's image is scanned.
struct Scan<'a> {
    mounted: &'a MountedCamera,
    light: &'a Light<'a>,
    /// Whether the limbs are flatter than 45° and cross columns.
    by_columns: bool,
}

impl Scan<'_> {
    /// A place of the image from one across the limbs and one along them.
    fn pixel(&self, across: f64, along: f64) -> Pixel {
        if self.by_columns {
            Pixel::new(along, across)
        } else {
            Pixel::new(across, along)
        }
    }

    fn ray(&self, across: f64, along: f64) -> Option<Ray> {
        let (origin_m, direction) = self.mounted.ray(&self.pixel(across, along))?;
        Some(Ray {
            origin_m,
            direction,
        })
    }

    /// The pixels of a row from one place to another, both within the region.
    fn cut(
        &self,
        row: usize,
        axis: &[f64],
        [from, middle, to]: [f64; 3],
        inwards: f64,
    ) -> Option<Cut> {
        let roi = &self.light.roi;
        let (start, length, line) = if self.by_columns {
            (roi.y_px, self.light.height, row - roi.x_px as usize)
        } else {
            (roi.x_px, self.light.width, row - roi.y_px as usize)
        };
        let start = f64::from(start);
        let first = ((from - start).ceil().max(0.0)) as usize;
        let last = (to - start).floor().min(length as f64);
        if !(last > first as f64) {
            return None;
        }
        let last = last as usize;
        let values = (first..last).map(|k| {
            let (column, row) = if self.by_columns {
                (line, k)
            } else {
                (k, line)
            };
            self.light.along(axis, column, row)
        });
        let along = row as f64 + 0.5;
        let i = self.mounted.camera.intrinsics();
        let centre_px = if self.by_columns {
            [i.cy_px, i.cx_px]
        } else {
            [i.cx_px, i.cy_px]
        };
        Some(Cut {
            first_px: start + first as f64 + 0.5 - middle,
            values: values.collect(),
            weights: Vec::new(),
            without: 0.0,
            from_centre_px: [middle - centre_px[0], along - centre_px[1]],
            inwards,
            rays: [
                self.ray(middle - REACH_PX, along)?,
                self.ray(middle, along)?,
                self.ray(middle + REACH_PX, along)?,
                self.ray(middle, along - 1.0)?,
                self.ray(middle, along + 1.0)?,
            ],
        })
    }
}

/// Where a limb is seen in the direction across, at a row.
struct LimbLine {
    /// across = at + slope (along − from).
    from: f64,
    at: f64,
    slope: f64,
}

/// The blocks of an eye around where a rod's limbs are seen, of every so many-th row.
pub(crate) fn blocks(
    eye: usize,
    mounted: &MountedCamera,
    light: &Light<'_>,
    axes: &[[f64; 3]; 2],
    rod: &State,
    stride: usize,
) -> Option<Vec<Block>> {
    let block_rows = BLOCK_ROWS / stride;
    // A softer lens spreads a limb wider.
    let softness_px = SOFT_REACH * rod.blur_px2[eye].sqrt();
    let (inside_px, outside_px) = (INSIDE_PX.max(softness_px), REACH_PX.max(softness_px + 2.0));
    let middle = limb_pixels(mounted, rod, 0.0)?;
    let step = limb_pixels(mounted, rod, 0.02 * distance_m(mounted, rod))?;
    let direction = step[0] - middle[0] + step[1] - middle[1];
    let by_columns = direction.x.abs() > direction.y.abs();
    let (across, along) = if by_columns { (1, 0) } else { (0, 1) };
    let scan = Scan {
        mounted,
        light,
        by_columns,
    };
    let roi = &light.roi;
    let (first_row, rows) = if by_columns {
        (roi.x_px as usize, light.width)
    } else {
        (roi.y_px as usize, light.height)
    };
    let mut limbs: Vec<[LimbLine; 2]> = Vec::new();
    // Limbs are straight lines but behind lenses that bend them: short straight pieces stand for them.
    let pieces = limb_pieces(mounted, rod, across, along, first_row, rows);
    for pair in pieces.windows(2) {
        let line = |k: usize| LimbLine {
            from: pair[0][k][1],
            at: pair[0][k][0],
            slope: (pair[1][k][0] - pair[0][k][0]) / (pair[1][k][1] - pair[0][k][1]),
        };
        limbs.push([line(0), line(1)]);
    }
    let half = 0.5 * rows as f64;
    let mut found = Vec::new();
    let mut block = Vec::with_capacity(block_rows);
    for row in (first_row..first_row + rows).step_by(stride) {
        let along = row as f64 + 0.5;
        let at = |k: usize| -> Option<f64> {
            let piece = limbs.iter().rev().find(|piece| {
                let p = &piece[k];
                (along - p.from) >= 0.0
            });
            let p = &piece.or(limbs.first())?[k];
            Some(p.at + p.slope * (along - p.from))
        };
        let (Some(plus), Some(minus)) = (at(0), at(1)) else {
            continue;
        };
        let between = 0.5 * (plus + minus);
        let cut = |here: f64, axis: &[f64; 3]| {
            let (from, to, inwards) = if here > between {
                ((here - inside_px).max(between), here + outside_px, -1.0)
            } else {
                (here - outside_px, (here + inside_px).min(between), 1.0)
            };
            scan.cut(row, &axis[..light.channels()], [from, here, to], inwards)
                .filter(|cut| cut.values.len() >= 4)
        };
        let cuts = [cut(plus, &axes[0]), cut(minus, &axes[1])];
        if cuts.iter().all(Option::is_none) {
            continue;
        }
        block.push(Row {
            along: (along - first_row as f64 - half) / half,
            cuts,
            weight: 1.0,
        });
        if block.len() == block_rows {
            found.push(Block::new(eye, half, core::mem::take(&mut block)));
        }
    }
    if block.len() >= block_rows / 3 {
        found.push(Block::new(eye, half, block));
    }
    // Noise is more of a nuisance than what smoothing hides.
    let rises: Vec<[f64; 2]> = found.iter().map(|block| block.rise).collect();
    for (k, block) in found.iter_mut().enumerate() {
        let near = &rises[k.saturating_sub(1)..(k + 2).min(rises.len())];
        block.rise =
            [0, 1].map(|side| near.iter().map(|rise| rise[side]).sum::<f64>() / near.len() as f64);
    }
    noise::weigh(&mut found);
    Some(found)
}

fn distance_m(mounted: &MountedCamera, rod: &State) -> f64 {
    (rod.cylinder.axis.point_m - mounted.rig_from_camera.origin_m()).norm()
}

/// Both limbs' pixels in the cross-section at a place along the axis.
fn limb_pixels(mounted: &MountedCamera, rod: &State, along_m: f64) -> Option<[Pixel; 2]> {
    let moved = rod.tangent(along_m);
    let pixel = |side| mounted.project(&mounted.limb_point_m(&moved, side)?);
    Some([pixel(Side::Plus)?, pixel(Side::Minus)?])
}

/// Places [across, along] of both limbs, in the order of growing rows, from before the first row to after the last where the rod is
/// seen there.
fn limb_pieces(
    mounted: &MountedCamera,
    rod: &State,
    across: usize,
    along: usize,
    first_row: usize,
    rows: usize,
) -> Vec<[[f64; 2]; 2]> {
    let (low, high) = (first_row as f64, (first_row + rows) as f64);
    let scale_m = distance_m(mounted, rod);
    let mut found: Vec<[[f64; 2]; 2]> = Vec::new();
    for k in -40..=40 {
        let reach = f64::from(k) / 40.0;
        // Dense in the middle, far at the ends.
        let along_m = scale_m * (0.6 * reach + 1.4 * reach * reach * reach);
        if let Some(pixels) = limb_pixels(mounted, rod, along_m) {
            let place = pixels.map(|p| [p[across], p[along]]);
            let margin = rows as f64;
            if place
                .iter()
                .all(|p| p[1] > low - margin && p[1] < high + margin)
            {
                found.push(place);
            }
        }
    }
    if found.len() >= 2 && found[0][0][1] > found[found.len() - 1][0][1] {
        found.reverse();
    }
    found.retain(|p| p.iter().flatten().all(|v| v.is_finite()));
    found
}
