//! The maximum-likelihood cylinder: limbs and shading of both images at once.
//!
//! A pixel's distance to a limb follows from its ray, g = (p − o)·m̂ ∓ r, m = v × d, whatever the camera. Inside, light is
//! a0 + a1 t + a2 √(1 − t²), with t the ray's distance to the axis over the radius: a matt round rod in any far light. Outside it is
//! a slope on each side. Both are blurred by lens and pixel. Shading is linear and eliminated block by block.

use nalgebra::{DMatrix, SMatrix, SVector};

use super::block::{
    ALL, Alike, BLUR, BlockSums, EDGES, Lit, Local, LocalVector, MEANS, OF_ALL, RIGID, SHADES,
    SHADOWS, Shading,
};
use super::crossing::{Crossing, spreads};
use super::lamp::Lamp;
use super::pool::{Block, Cut};
use super::shade::{self, BY_BLUR, BY_FAR, BY_NEAR, KNOWN, OF_FAR, OF_SHADOW, PixelModel};
use super::spread::Spread;
use super::state::{RADIUS, ROD, State, UNKNOWNS};

/// All that the pixels say about a state, shading eliminated.
#[derive(Clone, Debug)]
pub(crate) struct Sums {
    pub(crate) cost: f64,
    /// Sum of weighted squares, and pixels.
    pub(crate) chi2: f64,
    pub(crate) pixels: f64,
    pub(crate) normal: SMatrix<f64, UNKNOWNS, UNKNOWNS>,
    pub(crate) score: SVector<f64, UNKNOWNS>,
    pub(crate) blocks: Vec<BlockSums>,
    /// Of what is known of the means, one over the covariance, and the score.
    known_means: [Shading; 2],
    pub(crate) of_means: SVector<f64, { 2 * MEANS }>,
    /// Means become `shift − by_unknowns · step`.
    shift: SVector<f64, { 2 * MEANS }>,
    by_unknowns: SMatrix<f64, { 2 * MEANS }, UNKNOWNS>,
    /// Of each limb of each eye (plus, minus) how much more likely the pixels are with it than with a slope of light in its place.
    pub(crate) evidence: [[f64; 2]; 2],
    /// Of each limb of each block its squares over its pixels.
    pub(crate) squares: Vec<[Option<f64>; 2]>,
}

impl Sums {
    /// The light after a step of the unknowns.
    pub(crate) fn lit(&self, before: &Lit, step: &SVector<f64, UNKNOWNS>) -> Lit {
        let mut lit = before.clone();
        let moved = self.shift - self.by_unknowns * step;
        for (eye, means) in lit.means.iter_mut().enumerate() {
            for (k, mean) in means.iter_mut().enumerate() {
                *mean += moved.fixed_rows::<SHADES>(eye * MEANS + k * SHADES);
            }
        }
        for (shades, block) in lit.shades.iter_mut().zip(&self.blocks) {
            let first = block.eye * MEANS;
            let expected = moved.fixed_rows::<SHADES>(first)
                + moved.fixed_rows::<SHADES>(first + SHADES) * block.along;
            *shades += block.shaded(step, &expected);
        }
        lit
    }
}

/// Sums over all pixels.
pub(crate) fn sums(state: &State, blocks: &[Block], lit: &Lit, alike: &Alike) -> Sums {
    let spreads = spreads(state, blocks);
    let mut sums = Sums {
        cost: 0.0,
        chi2: 0.0,
        pixels: 0.0,
        normal: SMatrix::zeros(),
        score: SVector::zeros(),
        blocks: Vec::with_capacity(blocks.len()),
        known_means: alike.means,
        of_means: SVector::zeros(),
        shift: SVector::zeros(),
        by_unknowns: SMatrix::zeros(),
        evidence: [[0.0; 2]; 2],
        squares: Vec::with_capacity(blocks.len()),
    };
    for (block, shades) in blocks.iter().zip(&lit.shades) {
        let mut local = Local::zeros();
        let mut right = LocalVector::zeros();
        let mut squares = [None; 2];
        let mut by_rod = [[0.0; ROD]; 2];
        let eye = block.eye;
        for (side, cut) in block.cuts.iter().enumerate() {
            let (Some(cut), [Some(plus), Some(minus)]) = (cut, &spreads[eye]) else {
                continue;
            };
            let spreads = if side == 0 {
                (plus, minus)
            } else {
                (minus, plus)
            };
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let shadow = (state.shadows[eye][side], block.rise[side]);
            let lamps = Lamp::of(state, &cut.rays[1], sign);
            let light = shade::Shading::new(shades, side, shadow, lamps);
            let of_cut = CutSums::new(state, cut, side, spreads, &light);
            squares[side] = Some(of_cut.squares / cut.pixels);
            sums.cost += cut.weight * of_cut.cost;
            sums.evidence[eye][side] += cut.weight * (cut.without - of_cut.cost);
            sums.chi2 += cut.weight * of_cut.chi2;
            sums.pixels += cut.weight * cut.pixels;
            of_cut.add(side, cut.weight, &mut local, &mut right);
            by_rod[side] = of_cut.by_rod;
            // Of a rod so narrow that the other limb is felt without rows of its own.
            if block.cuts[1 - side].is_none() {
                by_rod[1 - side] = of_cut.by_rod.map(|by| -by);
                by_rod[1 - side][RADIUS] = of_cut.by_rod[RADIUS];
            }
        }
        let expected = lit.expected(eye, block.along);
        let sums_of = (&mut local, &mut right);
        let (block, cost) =
            BlockSums::new(block, state, by_rod, sums_of, (shades, &expected), alike);
        sums.cost += cost;
        sums.blocks.push(block);
        sums.squares.push(squares);
    }
    for (eye, (known, means)) in alike.means.iter().zip(&lit.means).enumerate() {
        for (k, mean) in means.iter().enumerate() {
            let pull = known * mean;
            sums.cost += 0.5 * mean.dot(&pull);
            sums.of_means
                .fixed_rows_mut::<SHADES>(eye * MEANS + k * SHADES)
                .copy_from(&-pull);
        }
    }
    sums.eliminate(alike.blocks != Alike::default().blocks);
    sums
}

impl Sums {
    /// Of the unknowns, the edges and the means.
    pub(crate) fn all(&self) -> DMatrix<f64> {
        self.first_of_all(OF_ALL)
    }

    fn first_of_all(&self, first: usize) -> DMatrix<f64> {
        let mut all = DMatrix::zeros(ALL, ALL);
        for block in &self.blocks {
            block.add_to(&mut all, first);
        }
        for (eye, known) in self.known_means.iter().enumerate() {
            for k in 0..2 {
                let at = UNKNOWNS + EDGES + eye * MEANS + k * SHADES;
                let mut part = all.view_mut((at, at), (SHADES, SHADES));
                part += known;
            }
        }
        all.fill_upper_triangle_with_lower_triangle();
        all
    }

    /// Fills in what is left without the means.
    fn eliminate(&mut self, is_expected: bool) {
        const FIRST: usize = UNKNOWNS + EDGES;
        let means = if is_expected { MEANS } else { 0 };
        let all = self.first_of_all(RIGID + means);
        let mut scores = SVector::<f64, ALL>::zeros();
        for block in &self.blocks {
            scores += block.scores();
        }
        let mut of_means = scores.fixed_rows_mut::<{ 2 * MEANS }>(FIRST);
        of_means += self.of_means;
        self.normal = all.fixed_view::<UNKNOWNS, UNKNOWNS>(0, 0).into();
        self.score = scores.fixed_rows::<UNKNOWNS>(0).into();
        let mut means: SMatrix<f64, { 2 * MEANS }, { 2 * MEANS }> = all
            .fixed_view::<{ 2 * MEANS }, { 2 * MEANS }>(FIRST, FIRST)
            .into();
        let largest = means.diagonal().max();
        if largest == 0.0 {
            return;
        }
        for k in 0..2 * MEANS {
            means[(k, k)] += 1e-9 * means[(k, k)] + 1e-12 * largest;
        }
        if let Some(factor) = means.cholesky() {
            let cross = all.fixed_view::<{ 2 * MEANS }, UNKNOWNS>(FIRST, 0);
            self.shift = factor.solve(&scores.fixed_rows::<{ 2 * MEANS }>(FIRST));
            self.by_unknowns = factor.solve(&cross);
            self.normal -= cross.transpose() * self.by_unknowns;
            self.score -= cross.transpose() * self.shift;
        }
    }
}

/// Sums over the samples of a cut.
struct CutSums {
    /// So many of what samples know are known.
    known: usize,
    normal: [[f64; KNOWN]; KNOWN],
    right: [f64; KNOWN],
    cost: f64,
    chi2: f64,
    squares: f64,
    /// Of the distance to the near limb, px, by the rod's unknowns.
    by_rod: [f64; ROD],
}

impl CutSums {
    fn new(
        state: &State,
        cut: &Cut,
        side: usize,
        (near, far): (&Spread, &Spread),
        light: &shade::Shading,
    ) -> Self {
        let crossing = Crossing::new(state, cut);
        let radius_m = state.cylinder.radius_m;
        let per_m = 1.0 / crossing.per_px;
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let [h0, h1, h2] = crossing.h;
        let distance = |delta: f64| {
            let h = h0 + delta * (h1 + delta * h2);
            ((radius_m - sign * h) * per_m, (radius_m + sign * h) * per_m)
        };
        // The far limb matters where the innermost pixel is within its reach.
        let ends = [cut.samples.first(), cut.samples.last()]
            .into_iter()
            .flatten();
        let is_narrow = ends
            .map(|end| distance(end.place_px).1)
            .any(|far_x| far_x < far.reach_px());
        let model = PixelModel {
            near,
            far,
            sign,
            radius_px: radius_m * per_m,
            light,
        };
        let known = if is_narrow {
            KNOWN
        } else if light.shadow.is_some() || light.lamps[0].is_some() {
            OF_FAR
        } else {
            OF_SHADOW
        };
        let [s0, s1, s2, s3, s5, s6] = crossing.slopes.map(|slope| -sign * per_m * slope);
        let mut sums = Self {
            known,
            normal: [[0.0; KNOWN]; KNOWN],
            right: [0.0; KNOWN],
            cost: 0.0,
            chi2: cut.chi2,
            squares: cut.squares,
            by_rod: [s0, s1, s2, s3, per_m, s5, s6],
        };
        for sample in &cut.samples {
            let (p, modelled) = model.at(distance(sample.place_px));
            let residual = sample.value - modelled;
            let (cost, square, weight) = sample.cost(residual);
            sums.cost += cost;
            sums.squares += square;
            sums.chi2 += weight * residual * residual;
            match known {
                OF_SHADOW => sums.gather::<OF_SHADOW>(&p, weight, residual),
                OF_FAR => sums.gather::<OF_FAR>(&p, weight, residual),
                _ => sums.gather::<KNOWN>(&p, weight, residual),
            }
        }
        sums
    }

    /// Adds a sample.
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

    /// Adds what the samples know to where a block has it.
    fn add(&self, side: usize, weight: f64, local: &mut Local, right: &mut LocalVector) {
        let mut places = [0; KNOWN];
        for (k, place) in places.iter_mut().enumerate() {
            *place = match k {
                0..3 => 3 * side + k,
                3 | 4 => 6 + 2 * side + k - 3,
                BY_NEAR => SHADES + side,
                BY_BLUR => SHADES + BLUR,
                OF_SHADOW..OF_FAR => SHADES + SHADOWS + 2 * side + k - OF_SHADOW,
                OF_FAR..BY_FAR => 6 + 2 * (1 - side) + k - OF_FAR,
                _ => SHADES + 1 - side,
            };
        }
        let known = places.iter().take(self.known);
        for ((a, row), value) in known.clone().zip(&self.normal).zip(&self.right) {
            right[*a] += weight * value;
            for (b, value) in known.clone().zip(row) {
                local[(*a, *b)] += weight * value;
            }
        }
    }
}

#[cfg(test)]
mod tests;
