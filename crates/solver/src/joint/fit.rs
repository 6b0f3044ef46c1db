//! The maximum-likelihood cylinder: limbs and shading of both images at once.
//!
//! A pixel's distance to a limb follows from its ray, g = (p − o)·m̂ ∓ r, m = v × d, whatever the camera. Inside, light is
//! a0 + a1 t + a2 √(1 − t²), with t the ray's distance to the axis over the radius: a matt round rod in any far light. Outside it is
//! a slope on each side. Both are blurred by lens and pixel. Shading is linear and eliminated block by block.

use nalgebra::{SMatrix, SVector};
use rodsight_geometry::{Cylinder, Line3, Vec3};

use super::bands::{Block, Cut, REACH_PX, Ray, Row};
use super::spread::{LEAST_BLUR_PX2, Spread};

/// Shading of a block: three inside each limb, then two outside each.
pub(crate) const SHADES: usize = 10;
/// Of the rod: two shifts across, two turns, the radius; then the blur of each eye.
pub(crate) const ROD: usize = 5;
pub(crate) const UNKNOWNS: usize = ROD + 2;
/// Shift and turn of each limb of each eye.
pub(crate) const EDGES: usize = 8;
/// Of a block: shading, rod, its eye's blur, and the edges of its eye.
const LOCAL: usize = SHADES + ROD + 1 + EDGES / 2;

pub(crate) type Shades = SVector<f64, SHADES>;
type Local = SMatrix<f64, LOCAL, LOCAL>;
type LocalVector = SVector<f64, LOCAL>;

/// Residuals beyond so many standard deviations weigh less.
const HUBER: f64 = 3.0;

/// A rod and what blurs it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    pub(crate) cylinder: Cylinder,
    /// Two unit vectors across the axis.
    pub(crate) across: [Vec3; 2],
    /// Of each eye, px².
    pub(crate) blur_px2: [f64; 2],
}

impl State {
    pub(crate) fn new(cylinder: Cylinder, blur_px2: f64) -> Self {
        let d = cylinder.axis.direction;
        let mut least = Vec3::zeros();
        least[d.iamin()] = 1.0;
        let first = d.cross(&least).normalize();
        Self {
            cylinder,
            across: [first, d.cross(&first)],
            blur_px2: [blur_px2; 2],
        }
    }

    pub(crate) fn moved(&self, by: &SVector<f64, UNKNOWNS>) -> Self {
        let [e1, e2] = self.across;
        let axis = &self.cylinder.axis;
        let d = (axis.direction + e1 * by[2] + e2 * by[3]).normalize();
        let first = (e1 - d * d.dot(&e1)).normalize();
        let blur = |k: usize| {
            let factor = libm::exp(by[ROD + k].clamp(-2.0, 2.0));
            (self.blur_px2[k] * factor).clamp(LEAST_BLUR_PX2, 25.0)
        };
        Self {
            cylinder: Cylinder {
                axis: Line3 {
                    point_m: axis.point_m + e1 * by[0] + e2 * by[1],
                    direction: d,
                },
                radius_m: (self.cylinder.radius_m + by[4]).max(0.2 * self.cylinder.radius_m),
            },
            across: [first, d.cross(&first)],
            blur_px2: [blur(0), blur(1)],
        }
    }
}

/// h of a ray and how it changes with the rod's two shifts and two turns.
fn distance(state: &State, ray: &Ray) -> (f64, [f64; 4]) {
    let axis = &state.cylinder.axis;
    let m = ray.direction.cross(&axis.direction);
    let norm = m.norm().max(1e-12);
    let unit = m / norm;
    let q = axis.point_m - ray.origin_m;
    let h = q.dot(&unit);
    let turn = (q - unit * h).cross(&ray.direction) / norm;
    let [e1, e2] = state.across;
    (
        h,
        [unit.dot(&e1), unit.dot(&e2), turn.dot(&e1), turn.dot(&e2)],
    )
}

/// A cut as the present rod crosses it.
struct Crossing {
    /// h = h0 + h1 δ + h2 δ² at δ px from the cut's middle.
    h: [f64; 3],
    /// Its derivatives at the middle.
    slopes: [f64; 4],
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

/// How noisy the light of an eye is, in its variance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Noise {
    pub(crate) inside: f64,
    pub(crate) outside: f64,
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

/// The shading and the present spreads of an eye's limbs.
fn spreads(state: &State, blocks: &[Block]) -> [[Option<Spread>; 2]; 2] {
    let normal = |eye: usize, side: usize| {
        let mut cuts = blocks
            .iter()
            .filter(|block| block.eye == eye)
            .flat_map(|block| &block.rows)
            .filter_map(|row| row.cuts[side].as_ref());
        let count = cuts.clone().count();
        let cut = cuts.nth(count / 2)?;
        Some(Crossing::new(state, cut).normal)
    };
    [0, 1].map(|eye| {
        [0, 1].map(|side| {
            normal(eye, side)
                .or_else(|| normal(eye, 1 - side))
                .map(|normal| Spread::new(normal, state.blur_px2[eye]))
        })
    })
}

/// What a pixel knows, in the order of its row's sums: the near limb's three shapes inside and two outside, the light's derivatives
/// by the distance to the near limb and by blur; then, where the rod is so narrow that the far limb matters, its two shapes
/// outside and the derivative by its distance.
const KNOWN: usize = 10;
const KNOWN_NEAR: usize = 7;
const BY_NEAR: usize = 5;
const BY_BLUR: usize = 6;
const BY_FAR: usize = 9;

/// A pixel at x px inside the near limb and `far_x` px inside the far one; and the rod's share of it.
fn pixel(
    near: &Spread,
    far: &Spread,
    sign: f64,
    (x, far_x): (f64, f64),
    (inner, outer, beyond): ([f64; 3], [f64; 2], [f64; 2]),
) -> ([f64; KNOWN], f64) {
    let per_radius = 2.0 / (x + far_x);
    let [e, e1, e2] = near.step(x);
    let [ramp, ..] = near.ramp(x);
    let [root, root1, root2] = near.root(x);
    let [f, f1, _] = far.step(far_x);
    let [far_ramp, ..] = far.ramp(far_x);
    let [far_root, far_root1, _] = far.root(far_x);
    let inside = e + f - 1.0;
    let far_off = far_x - far_ramp;
    let linear = sign * (e - ramp * per_radius - (far_off * per_radius - (1.0 - f)));
    let rounded = far_root * per_radius;
    let [a0, a1, a2] = [inner[0], sign * inner[1], inner[2] * rounded];
    let (b0, b1) = (outer[0], outer[1] / REACH_PX);
    let (c0, c1) = (beyond[0], beyond[1] / REACH_PX);
    let known = [
        inside,
        linear,
        root * rounded,
        1.0 - e,
        (x - ramp) / REACH_PX,
        a0 * e1 + a1 * (e1 - e * per_radius) + a2 * root1 - b0 * e1 + b1 * (1.0 - e),
        0.5 * (a0 * e2 + a1 * (e2 - e1 * per_radius) + a2 * root2 - b0 * e2 - b1 * e1),
        1.0 - f,
        far_off / REACH_PX,
        a0 * f1 - a1 * (f1 + (1.0 - f) * per_radius) + inner[2] * root * far_root1 * per_radius
            - c0 * f1
            + c1 * (1.0 - f),
    ];
    (known, inside)
}

/// Sums over all pixels.
pub(crate) fn sums(state: &State, blocks: &[Block], shades: &[Shades], noise: &[Noise; 2]) -> Sums {
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
        let eye = block.eye;
        for row in &block.rows {
            let (mut squares, mut count) = (0.0, 0.0);
            for side in 0..2 {
                let (Some(cut), [Some(plus), Some(minus)]) = (&row.cuts[side], &spreads[eye])
                else {
                    continue;
                };
                let spreads = if side == 0 {
                    (plus, minus)
                } else {
                    (minus, plus)
                };
                let of_row = RowSums::new(state, cut, side, spreads, shades, &noise[eye]);
                squares += of_row.squares;
                count += cut.values.len() as f64;
                all.cost += row.weight * of_row.cost;
                let noise = &noise[eye];
                let without = cost_without(&cut.values, noise.inside.max(noise.outside));
                all.evidence[eye][side] += row.weight * (without - of_row.cost);
                all.chi2 += row.weight * of_row.chi2;
                all.pixels += row.weight * cut.values.len() as f64;
                of_row.add(row, side, state.blur_px2[eye], &mut local, &mut right);
            }
            rows.push(if count > 0.0 { squares / count } else { 0.0 });
        }
        all.rows.push(rows);
        add_block(&mut all, eye, &local, &right);
    }
    all
}

/// What pixels cost that lie on a line.
fn cost_without(values: &[f64], variance: f64) -> f64 {
    let count = values.len() as f64;
    let middle = 0.5 * (count - 1.0);
    let places = (0..values.len()).map(|k| k as f64 - middle);
    let mean = values.iter().sum::<f64>() / count;
    let (mut along, mut squares) = (0.0, 0.0);
    for (value, place) in values.iter().zip(places.clone()) {
        along += place * value;
        squares += place * place;
    }
    let slope = along / squares;
    let residuals = values.iter().zip(places);
    let costs = residuals.map(|(value, place)| {
        let off = (value - mean - slope * place).abs() / variance.sqrt();
        if off <= HUBER {
            0.5 * off * off
        } else {
            HUBER * (off - 0.5 * HUBER)
        }
    });
    costs.sum()
}

/// Sums over the pixels of a cut.
struct RowSums {
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
        shades: &Shades,
        noise: &Noise,
    ) -> Self {
        let crossing = Crossing::new(state, cut);
        let radius_m = state.cylinder.radius_m;
        let per_m = 1.0 / crossing.per_px;
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let (within, here, there) = (3 * side, 6 + 2 * side, 6 + 2 * (1 - side));
        let inner = [shades[within], shades[within + 1], shades[within + 2]];
        let outer = [shades[here], shades[here + 1]];
        let beyond = [shades[there], shades[there + 1]];
        let [h0, h1, h2] = crossing.h;
        let distance = |h: f64| ((radius_m - sign * h) * per_m, (radius_m + sign * h) * per_m);
        // The far limb matters where the innermost pixel is within its reach.
        let innermost = if cut.inwards > 0.0 {
            cut.first_px + cut.values.len() as f64 - 1.0
        } else {
            cut.first_px
        };
        let (_, far_x) = distance(h0 + innermost * (h1 + innermost * h2));
        let known = if far_x < far.reach_px() {
            KNOWN
        } else {
            KNOWN_NEAR
        };
        let [s0, s1, s2, s3] = crossing.slopes.map(|slope| -sign * per_m * slope);
        let mut sums = Self {
            known,
            normal: [[0.0; KNOWN]; KNOWN],
            right: [0.0; KNOWN],
            cost: 0.0,
            chi2: 0.0,
            squares: 0.0,
            by_rod: [s0, s1, s2, s3, per_m],
        };
        for (k, value) in cut.values.iter().enumerate() {
            let delta = cut.first_px + k as f64;
            let place = distance(h0 + delta * (h1 + delta * h2));
            let (p, inside) = pixel(near, far, sign, place, (inner, outer, beyond));
            let mut model = inner[0] * p[0] + inner[1] * p[1] + inner[2] * p[2];
            model += outer[0] * p[3] + outer[1] * p[4] + beyond[0] * p[7] + beyond[1] * p[8];
            let residual = value - model;
            let share = inside.clamp(0.0, 1.0);
            let variance = share * noise.inside + (1.0 - share) * noise.outside;
            let off2 = residual * residual / variance;
            sums.squares += off2;
            let mut weight = 1.0 / variance;
            if off2 <= HUBER * HUBER {
                sums.cost += 0.5 * off2;
                sums.chi2 += off2;
            } else {
                let off = off2.sqrt();
                sums.cost += HUBER * (off - 0.5 * HUBER);
                sums.chi2 += HUBER * off;
                weight *= HUBER / off;
            }
            for i in 0..known {
                let scaled = weight * p[i];
                sums.right[i] += scaled * residual;
                for (sum, other) in sums.normal[i].iter_mut().zip(&p[..=i]) {
                    *sum += scaled * other;
                }
            }
        }
        sums
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
        let mut columns = [[(0_usize, 0.0); ROD + 2]; KNOWN];
        let mut counts = [1_usize; KNOWN];
        let single = |place: usize| [(place, 1.0); ROD + 2];
        for (k, column) in columns.iter_mut().enumerate().take(3) {
            *column = single(3 * side + k);
        }
        for k in 0..2 {
            columns[3 + k] = single(6 + 2 * side + k);
            columns[KNOWN_NEAR + k] = single(6 + 2 * (1 - side) + k);
        }
        columns[BY_BLUR] = single(SHADES + ROD);
        columns[BY_BLUR][0].1 = blur_px2;
        let edges = SHADES + ROD + 1;
        for (at, side, sign) in [(BY_NEAR, side, 1.0), (BY_FAR, 1 - side, -1.0)] {
            for (k, (column, by_rod)) in columns[at].iter_mut().zip(self.by_rod).enumerate() {
                let turned = if k + 1 == ROD { 1.0 } else { sign };
                *column = (SHADES + k, turned * by_rod);
            }
            columns[at][ROD] = (edges + 2 * side, 1.0);
            columns[at][ROD + 1] = (edges + 2 * side + 1, row.along);
            counts[at] = ROD + 2;
        }
        for i in 0..self.known {
            for &(a, of_a) in &columns[i][..counts[i]] {
                right[a] += row.weight * of_a * self.right[i];
                for j in 0..self.known {
                    let (high, low) = if i >= j { (i, j) } else { (j, i) };
                    let value = row.weight * of_a * self.normal[high][low];
                    for &(b, of_b) in &columns[j][..counts[j]] {
                        local[(a, b)] += value * of_b;
                    }
                }
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
        _ => UNKNOWNS + eye * EDGES / 2 + k - ROD - 1,
    };
    let mut scores = SVector::<f64, { UNKNOWNS + EDGES }>::zeros();
    for i in 0..REST {
        scores[place(i)] = score[i];
        for j in 0..REST {
            all.joint[(place(i), place(j))] += rest[(i, j)];
        }
    }
    let mut by_unknowns = SMatrix::<f64, SHADES, UNKNOWNS>::zeros();
    for k in 0..=ROD {
        by_unknowns.set_column(place(k), &by_rest.column(k));
        all.score[place(k)] += score[k];
        for j in 0..=ROD {
            all.normal[(place(k), place(j))] += rest[(k, j)];
        }
    }
    all.shading.push((shift, by_unknowns));
    all.scores.push(scores);
}

#[cfg(test)]
mod tests {
    use rodsight_geometry::{
        Camera, Distortion, Image, Intrinsics, Mat3, MountedCamera, Pose, Samples,
    };

    use super::super::bands::{INSIDE_PX, blocks};
    use super::super::light::Light;
    use super::*;
    use crate::Roi;

    const NOISE: Noise = Noise {
        inside: 1.0,
        outside: 1.0,
    };

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
        for _ in 0..3 {
            let here = sums(state, blocks, &shades, &[NOISE; 2]);
            for (shades, (shift, _)) in shades.iter_mut().zip(&here.shading) {
                *shades += shift;
            }
        }
        sums(state, blocks, &shades, &[NOISE; 2])
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
                all.extend(blocks(eye, mounted, &light, &axes, &truth, INSIDE_PX).expect("blocks"));
            }
            let off = SVector::from([2e-3, -1e-3, 2e-3, 3e-3, 1e-3, 0.2, -0.1]);
            let state = State::new(truth, 0.4).moved(&off);
            let here = profile(&state, &all);
            for k in 0..UNKNOWNS {
                let mut step = SVector::zeros();
                step[k] = 1e-5;
                let [more, less] =
                    [step, -step].map(|step| profile(&state.moved(&step), &all).cost);
                let slope = (less - more) / 2e-5;
                let scale = (here.normal[(k, k)] * 2.0 * here.cost).sqrt();
                assert!(
                    (here.score[k] - slope).abs() < 2e-2 * scale,
                    "radius {radius_m}, unknown {k}: {} {slope} of {scale}",
                    here.score[k]
                );
            }
        }
    }

    #[test]
    fn turns_and_shifts_move_rays_as_they_say() {
        let state = State::new(rod(0.05), 0.3);
        let ray = Ray {
            origin_m: Vec3::new(0.0, -0.2, 0.0),
            direction: Vec3::new(1.0, 0.15, 0.2).normalize(),
        };
        let (_, slopes) = distance(&state, &ray);
        for (k, slope) in slopes.into_iter().enumerate() {
            let mut step = SVector::zeros();
            step[k] = 1e-6;
            let [more, less] = [step, -step].map(|step| distance(&state.moved(&step), &ray).0);
            assert!(((more - less) / 2e-6 - slope).abs() < 1e-8, "{k}: {slope}");
        }
    }
}
