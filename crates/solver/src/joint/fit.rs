//! The maximum-likelihood cylinder: limbs and shading of both images at once.
//!
//! A pixel's distance to a limb follows from its ray, g = (p − o)·m̂ ∓ r, m = v × d, whatever the camera. Inside, light is
//! a0 + a1 t + a2 √(1 − t²), with t the ray's distance to the axis over the radius: a matt round rod in any far light. Outside it is
//! a slope on each side. Both are blurred by lens and pixel. Shading is linear and eliminated block by block.

use nalgebra::{SMatrix, SVector};

use rodsight_geometry::Line3;

use super::bands::{Block, Cut, REACH_PX, Ray, Row};
use super::shade::{BY_BLUR, BY_FAR, BY_NEAR, KNOWN, OF_FAR, OF_SHADOW, PixelModel, Shading};
use super::spread::Spread;
use super::state::{RADIUS, ROD, State, UNKNOWNS, of_shadow};

/// Shading of a block: three inside each limb, then two outside each.
pub(crate) const SHADES: usize = 10;
/// Shift, turn and bow of each limb of each eye.
pub(crate) const EDGES: usize = 12;
/// Of a block: shading, rod, and of its eye the blur, the shadows and the edges.
const SHADOWS: usize = SHADES + ROD + 1;
const LIMBS: usize = SHADOWS + 4;
const LOCAL: usize = LIMBS + EDGES / 2;

pub(crate) type Shades = SVector<f64, SHADES>;
type Local = SMatrix<f64, LOCAL, LOCAL>;
type LocalVector = SVector<f64, LOCAL>;

/// Residuals beyond so many standard deviations weigh less.
pub(crate) const HUBER: f64 = 3.0;

/// h of a ray and how it changes with the rod's two shifts, two turns and two bends.
fn distance(state: &State, ray: &Ray) -> (f64, [f64; 6]) {
    let mut axis = state.cylinder.axis;
    // Where along the axis it is nearest to the ray: a bent one is as straight there as its tangent.
    let mut along_m = nearest_m(&axis, ray);
    if state.bend_per_m.is_some() {
        for _ in 0..2 {
            axis = state.tangent(along_m).axis;
            along_m += nearest_m(&axis, ray);
        }
        axis = state.tangent(along_m).axis;
    } else {
        axis.point_m += axis.direction * along_m;
    }
    let (point_m, direction) = (axis.point_m, axis.direction);
    let m = ray.direction.cross(&direction);
    let norm = m.norm().max(1e-12);
    let unit = m / norm;
    let q = point_m - ray.origin_m;
    let h = q.dot(&unit);
    let turn = (q - unit * h).cross(&ray.direction) / norm;
    let mut slopes = [0.0; 6];
    for (k, across) in state.across.iter().enumerate() {
        let (shifted, turned) = (unit.dot(across), turn.dot(across));
        slopes[k] = shifted;
        slopes[2 + k] = turned + along_m * shifted;
        slopes[4 + k] = along_m * (turned + 0.5 * along_m * shifted);
    }
    (h, slopes)
}

/// How far along an axis from its point it is nearest to a ray.
fn nearest_m(axis: &Line3, ray: &Ray) -> f64 {
    let w = axis.point_m - ray.origin_m;
    let cos = axis.direction.dot(&ray.direction);
    let square = ray.direction.norm_squared();
    let sin2 = (square - cos * cos).max(1e-9 * square);
    (cos * w.dot(&ray.direction) - square * w.dot(&axis.direction)) / sin2
}

/// A cut as the present rod crosses it.
struct Crossing {
    /// h = h0 + h1 δ + h2 δ² at δ px from the cut's middle.
    h: [f64; 3],
    /// Its derivatives at the middle.
    slopes: [f64; 6],
    /// |∇h|, m/px.
    per_px: f64,
    /// Unit normal of the limb in the image, as the image is scanned: across, along.
    normal: [f64; 2],
}

impl Crossing {
    fn new(state: &State, cut: &Cut) -> Self {
        let at = |k: usize| distance(state, &cut.rays[k]).0;
        let (h0, slopes) = distance(state, &cut.rays[1]);
        let (before, after) = (at(0), at(2));
        let h1 = (after - before) / (2.0 * REACH_PX);
        let h2 = (after - 2.0 * h0 + before) / (2.0 * REACH_PX * REACH_PX);
        let up = 0.5 * (at(4) - at(3));
        let per_px = libm::hypot(h1, up);
        Self {
            h: [h0, h1, h2],
            slopes,
            per_px,
            normal: [h1 / per_px, up / per_px],
        }
    }
}

/// All that the pixels say about a state, shading eliminated.
#[derive(Clone, Debug)]
pub(crate) struct Sums {
    pub(crate) cost: f64,
    /// Sum of weighted squares, and pixels.
    pub(crate) chi2: f64,
    pub(crate) pixels: f64,
    pub(crate) normal: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    pub(crate) score: SVector<f64, UNKNOWNS>,
    /// What each block's shading becomes: `shift − by_unknowns · step`.
    pub(crate) shading: Vec<(Shades, SMatrix<f64, SHADES, UNKNOWNS>)>,
    /// Of the rod, the blurs and the edges together, for the covariance.
    pub(crate) joint: SMatrix<f64, { UNKNOWNS + EDGES }, { UNKNOWNS + EDGES }>,
    pub(crate) scores: Vec<SVector<f64, { UNKNOWNS + EDGES }>>,
    /// Of each limb of each eye (plus, minus) how much more likely the pixels are with it than with a slope of light in its place.
    pub(crate) evidence: [[f64; 2]; 2],
    /// Of each row of each block its squares over its pixels.
    pub(crate) rows: Vec<Vec<f64>>,
}

/// A limb where the middle one of its rows crosses it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Middle {
    /// The rod's radius, px.
    pub(crate) radius_px: f64,
    /// Unit vector inwards, across and along as the image is scanned.
    pub(crate) inwards: [f64; 2],
    /// From the principal point, across and along, px; and along from −1 to 1.
    pub(crate) from_centre_px: [f64; 2],
    pub(crate) along: f64,
    /// Half of the length from −1 to 1, px.
    pub(crate) half_px: f64,
}

impl Middle {
    pub(crate) fn of(state: &State, blocks: &[Block], eye: usize, side: usize) -> Option<Self> {
        let (block, row, cut) = middle_cut(blocks, eye, side)?;
        let crossing = Crossing::new(state, cut);
        let sign = if side == 0 { -1.0 } else { 1.0 };
        Some(Self {
            radius_px: state.cylinder.radius_m / crossing.per_px,
            inwards: crossing.normal.map(|v| sign * v),
            from_centre_px: cut.from_centre_px,
            along: row.along,
            half_px: block.half_px,
        })
    }
}

fn middle_cut(blocks: &[Block], eye: usize, side: usize) -> Option<(&Block, &Row, &Cut)> {
    let mut cuts = blocks
        .iter()
        .filter(|block| block.eye == eye)
        .flat_map(|block| block.rows.iter().map(move |row| (block, row)))
        .filter_map(|(block, row)| Some((block, row, row.cuts[side].as_ref()?)));
    let count = cuts.clone().count();
    cuts.nth(count / 2)
}

/// The shading and the present spreads of an eye's limbs.
fn spreads(state: &State, blocks: &[Block]) -> [[Option<Spread>; 2]; 2] {
    let normal = |eye: usize, side: usize| {
        Some(Crossing::new(state, middle_cut(blocks, eye, side)?.2).normal)
    };
    [0, 1].map(|eye| {
        [0, 1].map(|side| {
            normal(eye, side)
                .or_else(|| normal(eye, 1 - side))
                .map(|normal| Spread::new(normal, state.blur_px2[eye]))
        })
    })
}

/// Sums over all pixels.
pub(crate) fn sums(state: &State, blocks: &[Block], shades: &[Shades]) -> Sums {
    let spreads = spreads(state, blocks);
    let mut all = Sums {
        cost: 0.0,
        chi2: 0.0,
        pixels: 0.0,
        normal: SMatrix::zeros(),
        score: SVector::zeros(),
        shading: Vec::with_capacity(blocks.len()),
        joint: SMatrix::zeros(),
        scores: Vec::with_capacity(blocks.len()),
        evidence: [[0.0; 2]; 2],
        rows: Vec::with_capacity(blocks.len()),
    };
    for (block, shades) in blocks.iter().zip(shades) {
        let mut local = Local::zeros();
        let mut right = LocalVector::zeros();
        let mut rows = Vec::with_capacity(block.rows.len());
        let mut sides = [SideSums::default(), SideSums::default()];
        let eye = block.eye;
        for row in &block.rows {
            let (mut squares, mut count) = (0.0, 0.0);
            for (side, sums) in sides.iter_mut().enumerate() {
                let (Some(cut), [Some(plus), Some(minus)]) = (&row.cuts[side], &spreads[eye])
                else {
                    continue;
                };
                let spreads = if side == 0 {
                    (plus, minus)
                } else {
                    (minus, plus)
                };
                let light = Shading::new(shades, side, state.shadows[eye][side], block.rise[side]);
                let of_row = RowSums::new(state, cut, side, spreads, &light);
                squares += of_row.squares;
                count += cut.values.len() as f64;
                all.cost += row.weight * of_row.cost;
                all.evidence[eye][side] += row.weight * (cut.without - of_row.cost);
                all.chi2 += row.weight * of_row.chi2;
                all.pixels += row.weight * cut.values.len() as f64;
                if of_row.known == KNOWN {
                    of_row.add(row, side, state.blur_px2[eye], &mut local, &mut right);
                } else {
                    sums.add(&of_row, row);
                }
            }
            rows.push(if count > 0.0 { squares / count } else { 0.0 });
        }
        for (side, sums) in sides.iter().enumerate() {
            sums.scatter(side, state.blur_px2[eye], &mut local, &mut right);
        }
        all.rows.push(rows);
        add_block(&mut all, eye, &local, &right);
    }
    all
}

/// Sums over the pixels of a cut.
struct RowSums {
    /// So many of what pixels know are known.
    known: usize,
    normal: [[f64; KNOWN]; KNOWN],
    right: [f64; KNOWN],
    cost: f64,
    chi2: f64,
    squares: f64,
    /// Of the distance to the near limb, px, by the rod's unknowns; to the far one only the last has the same sign.
    by_rod: [f64; ROD],
}

impl RowSums {
    fn new(
        state: &State,
        cut: &Cut,
        side: usize,
        (near, far): (&Spread, &Spread),
        light: &Shading,
    ) -> Self {
        let crossing = Crossing::new(state, cut);
        let radius_m = state.cylinder.radius_m;
        let per_m = 1.0 / crossing.per_px;
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let [h0, h1, h2] = crossing.h;
        let distance = |h: f64| ((radius_m - sign * h) * per_m, (radius_m + sign * h) * per_m);
        // The far limb matters where the innermost pixel is within its reach.
        let innermost = if cut.inwards > 0.0 {
            cut.first_px + cut.values.len() as f64 - 1.0
        } else {
            cut.first_px
        };
        let (_, far_x) = distance(h0 + innermost * (h1 + innermost * h2));
        let is_narrow = far_x < far.reach_px();
        let model = PixelModel {
            near,
            far,
            sign,
            radius_px: radius_m * per_m,
            light,
        };
        let known = match (is_narrow, light.shadow) {
            (true, _) => KNOWN,
            (false, Some(_)) => OF_FAR,
            (false, None) => OF_SHADOW,
        };
        let [s0, s1, s2, s3, s5, s6] = crossing.slopes.map(|slope| -sign * per_m * slope);
        let mut sums = Self {
            known,
            normal: [[0.0; KNOWN]; KNOWN],
            right: [0.0; KNOWN],
            cost: 0.0,
            chi2: 0.0,
            squares: 0.0,
            by_rod: [s0, s1, s2, s3, per_m, s5, s6],
        };
        for (k, (value, weight)) in cut.values.iter().zip(&cut.weights).enumerate() {
            let delta = cut.first_px + k as f64;
            let place = distance(h0 + delta * (h1 + delta * h2));
            let (p, modelled) = model.at(place);
            let residual = value - modelled;
            let mut weight = *weight;
            let off2 = residual * residual * weight;
            sums.squares += off2;
            if off2 <= HUBER * HUBER {
                sums.cost += 0.5 * off2;
                sums.chi2 += off2;
            } else {
                let off = off2.sqrt();
                sums.cost += HUBER * (off - 0.5 * HUBER);
                sums.chi2 += HUBER * off;
                weight *= HUBER / off;
            }
            match known {
                OF_SHADOW => sums.gather::<OF_SHADOW>(&p, weight, residual),
                OF_FAR => sums.gather::<OF_FAR>(&p, weight, residual),
                _ => sums.gather::<KNOWN>(&p, weight, residual),
            }
        }
        sums
    }

    /// Adds a pixel.
    fn gather<const N: usize>(&mut self, p: &[f64; KNOWN], weight: f64, residual: f64) {
        let p: &[f64; N] = p.first_chunk().expect("no more than are known");
        for ((row, right), value) in self.normal.iter_mut().zip(&mut self.right).zip(p) {
            let scaled = weight * value;
            *right += scaled * residual;
            // All of them: half of them are not done faster.
            for (sum, other) in row.iter_mut().zip(p) {
                *sum += scaled * other;
            }
        }
    }

    /// Adds what the pixels know as a block's unknowns have it.
    fn add(
        &self,
        row: &Row,
        side: usize,
        blur_px2: f64,
        local: &mut Local,
        right: &mut LocalVector,
    ) {
        // Of each of what is known, which unknowns it stands for and how much.
        let mut columns = [[(0_usize, 0.0); ROD + 3]; KNOWN];
        let mut counts = [1_usize; KNOWN];
        let single = |place: usize| [(place, 1.0); ROD + 3];
        for (k, column) in columns.iter_mut().enumerate().take(3) {
            *column = single(3 * side + k);
        }
        for k in 0..2 {
            columns[3 + k] = single(6 + 2 * side + k);
            columns[OF_FAR + k] = single(6 + 2 * (1 - side) + k);
            columns[OF_SHADOW + k] = single(SHADOWS + 2 * side + k);
        }
        columns[BY_BLUR] = single(SHADES + ROD);
        columns[BY_BLUR][0].1 = blur_px2;
        for (at, side, sign) in [(BY_NEAR, side, 1.0), (BY_FAR, 1 - side, -1.0)] {
            for (k, (column, by_rod)) in columns[at].iter_mut().zip(self.by_rod).enumerate() {
                let turned = if k == RADIUS { 1.0 } else { sign };
                *column = (SHADES + k, turned * by_rod);
            }
            let first = LIMBS + 3 * side;
            columns[at][ROD] = (first, 1.0);
            columns[at][ROD + 1] = (first + 1, row.along);
            columns[at][ROD + 2] = (first + 2, row.along * row.along - 1.0 / 3.0);
            counts[at] = ROD + 3;
        }
        for i in 0..self.known {
            for &(a, of_a) in &columns[i][..counts[i]] {
                right[a] += row.weight * of_a * self.right[i];
                for j in 0..self.known {
                    let value = row.weight * of_a * self.normal[i][j];
                    for &(b, of_b) in &columns[j][..counts[j]] {
                        local[(a, b)] += value * of_b;
                    }
                }
            }
        }
    }
}

/// By how many unknowns a limb's distance is known: those of the rod, and its shift, turn and bow.
const MOVES: usize = ROD + 3;

/// The sums of a limb's rows in a block, where the far limb does not matter: dense, and told apart only at the end.
#[derive(Clone, Debug, Default)]
struct SideSums {
    normal: [[f64; OF_FAR]; OF_FAR],
    right: [f64; OF_FAR],
    by_moves: [[f64; MOVES]; OF_FAR],
    of_moves: [[f64; MOVES]; MOVES],
    right_moves: [f64; MOVES],
}

impl SideSums {
    fn add(&mut self, of_row: &RowSums, row: &Row) {
        let mut moves = [1.0; MOVES];
        moves[..ROD].copy_from_slice(&of_row.by_rod);
        moves[ROD + 1] = row.along;
        moves[ROD + 2] = row.along * row.along - 1.0 / 3.0;
        let weight = row.weight;
        for (i, by_moves) in self.by_moves.iter_mut().enumerate() {
            for (sum, value) in self.normal[i].iter_mut().zip(&of_row.normal[i]) {
                *sum += weight * value;
            }
            self.right[i] += weight * of_row.right[i];
            let of_near = weight * of_row.normal[i][BY_NEAR];
            for (sum, value) in by_moves.iter_mut().zip(&moves) {
                *sum += of_near * value;
            }
        }
        let of_near = weight * of_row.normal[BY_NEAR][BY_NEAR];
        for (sums, of_one) in self.of_moves.iter_mut().zip(&moves) {
            for (sum, value) in sums.iter_mut().zip(&moves) {
                *sum += of_near * of_one * value;
            }
        }
        for (sum, value) in self.right_moves.iter_mut().zip(&moves) {
            *sum += weight * of_row.right[BY_NEAR] * value;
        }
    }

    /// To where a block's unknowns are.
    fn scatter(&self, side: usize, blur_px2: f64, local: &mut Local, right: &mut LocalVector) {
        let place = |i: usize| match i {
            0..3 => (3 * side + i, 1.0),
            3 | 4 => (6 + 2 * side + i - 3, 1.0),
            BY_BLUR => (SHADES + ROD, blur_px2),
            _ => (SHADOWS + 2 * side + i - OF_SHADOW, 1.0),
        };
        let of_move = |k: usize| match k {
            0..ROD => SHADES + k,
            _ => LIMBS + 3 * side + k - ROD,
        };
        let singles = || (0..OF_FAR).filter(|i| *i != BY_NEAR);
        for i in singles() {
            let (a, of_a) = place(i);
            right[a] += of_a * self.right[i];
            for j in singles() {
                let (b, of_b) = place(j);
                local[(a, b)] += of_a * of_b * self.normal[i][j];
            }
            for (k, value) in self.by_moves[i].iter().enumerate() {
                local[(a, of_move(k))] += of_a * value;
                local[(of_move(k), a)] += of_a * value;
            }
        }
        for (k, values) in self.of_moves.iter().enumerate() {
            right[of_move(k)] += self.right_moves[k];
            for (l, value) in values.iter().enumerate() {
                local[(of_move(k), of_move(l))] += value;
            }
        }
    }
}

/// Eliminates a block's shading and adds what is left.
fn add_block(all: &mut Sums, eye: usize, local: &Local, right: &LocalVector) {
    const REST: usize = LOCAL - SHADES;
    let mut shading = local.fixed_view::<SHADES, SHADES>(0, 0).into_owned();
    let least = 1e-7 * shading.trace() / SHADES as f64 + f64::MIN_POSITIVE;
    for i in 0..SHADES {
        shading[(i, i)] += least;
    }
    let empty = (Shades::zeros(), SMatrix::zeros());
    let Some(factor) = shading.cholesky() else {
        all.shading.push(empty);
        all.scores.push(SVector::zeros());
        return;
    };
    let cross = local.fixed_view::<SHADES, REST>(0, SHADES).into_owned();
    let right_shading = right.fixed_rows::<SHADES>(0).into_owned();
    let shift = factor.solve(&right_shading);
    let by_rest = factor.solve(&cross);
    let rest = local.fixed_view::<REST, REST>(SHADES, SHADES) - cross.transpose() * by_rest;
    let score = right.fixed_rows::<REST>(SHADES) - cross.transpose() * shift;
    // Where the block's unknowns are among all.
    let place = |k: usize| match k {
        0..ROD => k,
        ROD => ROD + eye,
        8..12 => of_shadow(eye, 0) + k - ROD - 1,
        _ => UNKNOWNS + eye * EDGES / 2 + k - ROD - 5,
    };
    let mut scores = SVector::<f64, { UNKNOWNS + EDGES }>::zeros();
    for i in 0..REST {
        scores[place(i)] = score[i];
        for j in 0..REST {
            all.joint[(place(i), place(j))] += rest[(i, j)];
        }
    }
    let mut by_unknowns = SMatrix::<f64, SHADES, UNKNOWNS>::zeros();
    for k in 0..REST - EDGES / 2 {
        by_unknowns.set_column(place(k), &by_rest.column(k));
        all.score[place(k)] += score[k];
        for j in 0..REST - EDGES / 2 {
            all.normal[(place(k), place(j))] += rest[(k, j)];
        }
    }
    all.shading.push((shift, by_unknowns));
    all.scores.push(scores);
}

#[cfg(test)]
mod tests {
    use rodsight_geometry::{
        Camera, Cylinder, Distortion, Image, Intrinsics, Line3, Mat3, MountedCamera, Pose, Samples,
        Vec3,
    };

    use super::super::bands::blocks;
    use super::super::light::Light;
    use super::super::state::{BEND, Shadow};
    use super::*;
    use crate::Roi;

    fn cameras() -> [MountedCamera; 2] {
        let intrinsics = Intrinsics {
            width_px: 160,
            height_px: 120,
            fx_px: 150.0,
            fy_px: 150.0,
            cx_px: 80.0,
            cy_px: 60.0,
        };
        let lens = Distortion::BrownConrady([-0.1, 0.02, 0.001, -0.001, 0.0]);
        let camera = Camera::new(intrinsics, lens).expect("a camera");
        [-0.2, 0.2].map(|y_m| {
            let axes = Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
            MountedCamera::new(camera, Pose::new(axes, Vec3::new(0.0, y_m, 0.0)))
        })
    }

    fn rod(radius_m: f64) -> Cylinder {
        Cylinder {
            axis: Line3::new(Vec3::new(1.0, 0.02, 0.0), &Vec3::new(0.2, 0.3, 1.0)),
            radius_m,
        }
    }

    const WHOLE: Roi = Roi {
        x_px: 0,
        y_px: 0,
        width_px: 160,
        height_px: 120,
    };

    /// A matt rod lit from the camera, sampled once a pixel.
    fn image(mounted: &MountedCamera, cylinder: &Cylinder) -> Image {
        let value = |index: usize| {
            let place = rodsight_geometry::Pixel::new(
                (index % 160) as f64 + 0.5,
                (index / 160) as f64 + 0.5,
            );
            let (origin_m, direction) = mounted.ray(&place).expect("a ray");
            let ray = Ray {
                origin_m,
                direction,
            };
            let t = distance(&State::new(*cylinder, 0.3), &ray).0 / cylinder.radius_m;
            let inside = 0.3 + 0.1 * t + 0.5 * (1.0 - t * t).max(0.0).sqrt();
            let light = if t.abs() < 1.0 { inside } else { 0.1 };
            // sRGB.
            (65535.0 * (1.055 * libm::pow(light, 1.0 / 2.4) - 0.055)) as u16
        };
        let samples = Samples::U16((0..160 * 120).map(value).collect());
        Image::new(160, 120, 1, samples).expect("an image")
    }

    /// The likelihood of a state at its best shading, and its derivatives.
    fn profile(state: &State, blocks: &[Block]) -> Sums {
        let mut shades = vec![Shades::zeros(); blocks.len()];
        for _ in 0..12 {
            let here = sums(state, blocks, &shades);
            for (shades, (shift, _)) in shades.iter_mut().zip(&here.shading) {
                *shades += shift;
            }
        }
        sums(state, blocks, &shades)
    }

    /// Of rods that are wide and of one so narrow that each limb is within the other's blur, behind lenses that bend lines.
    #[test]
    fn derivatives_are_those_of_the_likelihood() {
        for radius_m in [0.06, 0.008] {
            let truth = rod(radius_m);
            let cameras = cameras();
            let mut all = Vec::new();
            for (eye, mounted) in cameras.iter().enumerate() {
                let image = image(mounted, &truth);
                let light = Light::of(&image, WHOLE);
                let axes = [[1.0, 0.0, 0.0]; 2];
                let found = blocks(eye, mounted, &light, &axes, &State::new(truth, 0.1), 1);
                all.extend(found.expect("blocks"));
                let cuts = all.iter_mut().flat_map(|block: &mut Block| &mut block.rows);
                for cut in cuts.flat_map(|row| row.cuts.iter_mut().flatten()) {
                    cut.weights.fill(1.0);
                }
            }
            let mut off = SVector::<f64, UNKNOWNS>::zeros();
            let values = [2e-3, -1e-3, 2e-3, 3e-3, 1e-3, 0.03, -0.05, 0.2, -0.1];
            off.fixed_rows_mut::<9>(0).copy_from_slice(&values);
            let mut state = State::new(truth, 0.4);
            state.bend_per_m = Some(Vec3::zeros());
            let mut state = state.moved(&off);
            let shadow = |amount, angle_rad| {
                Some(Shadow {
                    amount,
                    angle_rad,
                    within_rad: [0.1, 1.0],
                })
            };
            state.shadows = [
                [shadow(0.4, 0.4), None],
                [shadow(-0.2, 0.6), shadow(0.7, 0.5)],
            ];
            let here = profile(&state, &all);
            for k in (0..UNKNOWNS).filter(|k| ![11, 12].contains(k)) {
                let mut step = SVector::zeros();
                step[k] = 1e-5;
                let [more, less] =
                    [step, -step].map(|step| profile(&state.moved(&step), &all).cost);
                let slope = (less - more) / 2e-5;
                let scale = (here.normal[(k, k)] * 2.0 * here.cost).sqrt();
                // Nothing rises inside so narrow a rod, and no shadow can be told.
                if k >= of_shadow(0, 0) && radius_m < 0.01 && scale == 0.0 {
                    continue;
                }
                // That shading is across the radius is left out of its derivative; it tells where all of the rod is a limb.
                let most = if k == RADIUS && radius_m < 0.01 {
                    2.5e-2
                } else {
                    2e-2
                };
                assert!(
                    (here.score[k] - slope).abs() < most * scale,
                    "radius {radius_m}, unknown {k}: {} {slope} of {scale}",
                    here.score[k]
                );
            }
        }
    }

    #[test]
    fn turns_and_shifts_move_rays_as_they_say() {
        let mut state = State::new(rod(0.05), 0.3);
        let ray = Ray {
            origin_m: Vec3::new(0.0, -0.2, 0.0),
            direction: Vec3::new(1.0, 0.15, 0.2).normalize(),
        };
        state.bend_per_m = Some(Vec3::new(0.2, -0.1, 0.0));
        state.bend_per_m = Some(
            state
                .moved(&SVector::zeros())
                .bend_per_m
                .unwrap_or_default(),
        );
        let (_, slopes) = distance(&state, &ray);
        let places = [0, 1, 2, 3, BEND, BEND + 1];
        for (k, slope) in places.into_iter().zip(slopes) {
            let mut step = SVector::zeros();
            step[k] = 1e-6;
            let [more, less] = [step, -step].map(|step| distance(&state.moved(&step), &ray).0);
            let found = (more - less) / 2e-6;
            assert!((found - slope).abs() < 2e-4, "{k}: {slope} {found}");
        }
    }
}
