//! The pixels around the limbs: row by row (or column by column), with the rays that tell where in them a rod's limb is.

use rodsight_geometry::{MountedCamera, Pixel, Side, Vec3};

use super::light::Light;
use super::state::State;

/// Pixels to either side of a limb that are looked at.
pub(crate) const REACH_PX: f64 = 10.0;
/// Of them inside: as far as the light of a round rod is that of its limb, before another lamp's shadow begins.
pub(crate) const INSIDE_PX: f64 = 5.0;
/// Of a Gaussian's standard deviation, what is looked at.
const SOFT_REACH: f64 = 3.5;
/// Rows that share their shading.
const BLOCK_ROWS: usize = 24;
/// Of a row, or it says nothing.
const LEAST_PIXELS: usize = 4;

/// A ray in the rig frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ray {
    pub(crate) origin_m: Vec3,
    pub(crate) direction: Vec3,
}

/// The pixels of rows around one limb.
#[derive(Clone, Debug)]
pub(crate) struct Rows {
    /// Of each row its first pixel's centre from the limb, px, and where its values begin.
    starts: Vec<(f64, usize)>,
    values: Vec<f64>,
    /// Where the rod is from the limb: 1 towards larger places, −1 towards smaller ones.
    pub(crate) inwards: f64,
    /// The limb in the middle row from the principal point, across and along, px.
    pub(crate) from_centre_px: [f64; 2],
    /// Whether rows are columns of the image.
    pub(crate) by_columns: bool,
    /// Through the middle row at −`REACH_PX`, 0 and `REACH_PX` from the limb, and beside the limb a row up and a row down.
    pub(crate) rays: [Ray; 5],
}

impl Rows {
    /// Of each row its first pixel's centre from the limb, px, and its values.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (f64, &[f64])> {
        let ends = self.starts.iter().skip(1).map(|row| row.1);
        let ends = ends.chain([self.values.len()]);
        let rows = self.starts.iter().zip(ends);
        rows.map(|((first_px, from), to)| (*first_px, &self.values[*from..to]))
    }

    /// Where pixels are from the limb, px, and their values.
    pub(crate) fn pixels(&self) -> impl Iterator<Item = (f64, f64)> {
        self.iter().flat_map(|(first_px, values)| {
            let places = (0..values.len()).map(move |k| first_px + k as f64);
            places.zip(values.iter().copied())
        })
    }

    /// The mean light from one distance inside the limb to another, px.
    pub(crate) fn mean(&self, from_px: f64, to_px: f64) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0.0);
        for (place_px, value) in self.pixels() {
            if (from_px..to_px).contains(&(self.inwards * place_px)) {
                sum += value;
                count += 1.0;
            }
        }
        (count > 0.0).then(|| sum / count)
    }
}

/// Neighbouring rows of the image, or columns, that share their shading.
#[derive(Clone, Debug)]
pub(crate) struct Stretch {
    /// Place along the limbs, from −1 to 1.
    pub(crate) along: f64,
    /// Half of the length from −1 to 1, px.
    pub(crate) half_px: f64,
    /// Around the limbs plus and minus.
    pub(crate) limbs: [Option<Rows>; 2],
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

    /// Appends the pixels of a row from one place to another, as far as they are within the region.
    fn append(&self, rows: &mut Rows, row: usize, axis: &[f64], [from, limb, to]: [f64; 3]) {
        let roi = &self.light.roi;
        let (start, length, line) = if self.by_columns {
            (roi.y_px, self.light.height, row - roi.x_px as usize)
        } else {
            (roi.x_px, self.light.width, row - roi.y_px as usize)
        };
        let start = f64::from(start);
        let first = ((from - start).ceil().max(0.0)) as usize;
        let last = (to - start).floor().min(length as f64);
        if !(last >= (first + LEAST_PIXELS) as f64) {
            return;
        }
        let first_px = start + first as f64 + 0.5 - limb;
        rows.starts.push((first_px, rows.values.len()));
        rows.values.extend((first..last as usize).map(|k| {
            let (column, row) = if self.by_columns {
                (line, k)
            } else {
                (k, line)
            };
            self.light.along(axis, column, row)
        }));
    }

    /// No rows around a limb that is seen at a place across and along.
    fn none(&self, limb: f64, along: f64, inwards: f64) -> Option<Rows> {
        let i = self.mounted.camera.intrinsics();
        let centre_px = if self.by_columns {
            [i.cy_px, i.cx_px]
        } else {
            [i.cx_px, i.cy_px]
        };
        Some(Rows {
            starts: Vec::new(),
            values: Vec::new(),
            inwards,
            from_centre_px: [limb - centre_px[0], along - centre_px[1]],
            by_columns: self.by_columns,
            rays: [
                self.ray(limb - REACH_PX, along)?,
                self.ray(limb, along)?,
                self.ray(limb + REACH_PX, along)?,
                self.ray(limb, along - 1.0)?,
                self.ray(limb, along + 1.0)?,
            ],
        })
    }
}

/// What is looked at around a limb.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Window {
    /// How far inside, px; more through softer lenses, as outside.
    pub(crate) inside_px: f64,
    pub(crate) blur_px2: f64,
    /// Every so many-th row of a block, and every so many-th block.
    pub(crate) row_step: usize,
    pub(crate) block_step: usize,
}

/// Where a limb is seen in the direction across, at a row.
struct LimbLine {
    /// across = at + slope (along − from).
    from: f64,
    at: f64,
    slope: f64,
}

/// The stretches of an eye around where a rod's limbs are seen.
pub(crate) fn stretches(
    mounted: &MountedCamera,
    light: &Light<'_>,
    axes: &[[f64; 3]; 2],
    rod: &State,
    window: &Window,
) -> Option<Vec<Stretch>> {
    // A softer lens spreads a limb wider.
    let softness_px = SOFT_REACH * window.blur_px2.sqrt();
    let inside_px = window.inside_px.max(softness_px);
    let outside_px = REACH_PX.max(softness_px + 2.0);
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
    // Limbs are straight lines but behind lenses that bend them: short straight pieces stand for them.
    let pieces = limb_pieces(mounted, rod, across, along, first_row, rows);
    let line = |pair: &[[[f64; 2]; 2]], k: usize| LimbLine {
        from: pair[0][k][1],
        at: pair[0][k][0],
        slope: (pair[1][k][0] - pair[0][k][0]) / (pair[1][k][1] - pair[0][k][1]),
    };
    let lines: Vec<[LimbLine; 2]> = pieces
        .windows(2)
        .map(|pair| [line(pair, 0), line(pair, 1)])
        .collect();
    // Of both limbs at a row.
    let limbs = |along: f64| -> Option<[f64; 2]> {
        let at = |k: usize| {
            let before = lines.iter().rev().find(|piece| along >= piece[k].from);
            let line = &before.or(lines.first())?[k];
            Some(line.at + line.slope * (along - line.from))
        };
        Some([at(0)?, at(1)?])
    };
    let half = 0.5 * rows as f64;
    let last_row = first_row + rows;
    let mut found = Vec::new();
    for from in (first_row..last_row).step_by(BLOCK_ROWS * window.block_step) {
        let to = (from + BLOCK_ROWS).min(last_row);
        if to - from < BLOCK_ROWS / 3 {
            continue;
        }
        let along = 0.5 * (from + to) as f64;
        let Some(middle) = limbs(along) else {
            continue;
        };
        let mut stretch = Stretch {
            along: (along - first_row as f64 - half) / half,
            half_px: half,
            limbs: [None, None],
        };
        for (side, limb) in stretch.limbs.iter_mut().enumerate() {
            let (here, there) = (middle[side], middle[1 - side]);
            let is_upper = here > there;
            let inwards = if is_upper { -1.0 } else { 1.0 };
            let Some(mut all) = scan.none(here, along, inwards) else {
                continue;
            };
            for row in (from..to).step_by(window.row_step) {
                let Some(places) = limbs(row as f64 + 0.5) else {
                    continue;
                };
                let here = places[side];
                let between = 0.5 * (places[0] + places[1]);
                let window = if is_upper {
                    [(here - inside_px).max(between), here, here + outside_px]
                } else {
                    [here - outside_px, here, (here + inside_px).min(between)]
                };
                scan.append(&mut all, row, &axes[side][..light.channels()], window);
            }
            *limb = (!all.starts.is_empty()).then_some(all);
        }
        if stretch.limbs.iter().any(Option::is_some) {
            found.push(stretch);
        }
    }
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
