//! How sure a fit is, and whether its redundancies agree.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::block::{ALL, EDGES, OF_ALL};
use super::climb::{Fit, Fits, Prior, add_known};
use super::covariance::{Covariance, Edges, OfEdges, inverted, mahalanobis, no_surer};
use super::drift::{DRIFT, Drift};
use super::limbs::{Found, Limb};
use super::state::{BEND, RADIUS, ROD, State, UNKNOWNS};
use crate::CalibrationSigma;

/// What no model of light and lens is free of, px: a limb may be shifted by so much.
const FLOOR_PX: f64 = 0.014;

/// Twice as much of rods of this radius, px: light changes faster across them.
const NARROW_PX: f64 = 5.0;

/// Nor of light that rises softly from a limb without a step: this, px, times the square of how softly.
const SOFT_PX: f64 = 0.15;
/// It may be where a lamp's light ends, before the limb: this share of the radius, times the sixth power of how softly; where one lamp explains it,
/// and where it takes two.
const SOFT_RADII: [f64; 3] = [0.05, 0.01, 0.03];
/// Of limbs of blocks so many are worth of what is fitted to all of them: edges, blurs, shadows and half of their mean shading.
const FITTED: f64 = 42.0;
/// Nor of lenses softer than this, px: a share of what is beyond it.
const SHARP_PX: f64 = 0.8;
const BLURRED: f64 = 0.06;
/// Less sure, a radius is not seen.
const MOST_RADIUS_SIGMA: f64 = 0.2;
/// Shares of it that its shift, turn and bow each may have, as variances; of a limb from −1 to 1.
const FLOORS: [f64; 3] = [1.0, 3.0, 5.0];

/// What the limbs say of the rod's parameters.
#[derive(Clone, Debug)]
pub(crate) struct Judgement {
    pub(crate) covariance: SMatrix<f64, ROD, ROD>,
    /// The radius that the limbs show without what is known of it, and its standard deviation, m; of one that they do show.
    pub(crate) seen_radius: Option<(f64, f64)>,
    /// Of the redundancies, in units of their variance.
    pub(crate) chi2: f64,
    pub(crate) redundancies: usize,
}

/// The rod's parameters by edges.
type Estimator = SMatrix<f64, ROD, EDGES>;

/// What the limbs of a pair say of the rod.
struct Told {
    /// Edges by the rod's parameters.
    jacobian: SMatrix<f64, EDGES, ROD>,
    /// What edges weigh as measurements, and what they are not sure of.
    information: Edges,
    covariance: Edges,
    /// By how much edges would like to be elsewhere.
    moved: OfEdges,
    /// How many edges are seen.
    seen: usize,
    /// What is not sure of each camera, as far as it moves edges.
    cameras: Vec<OfEdges>,
}

/// Of all pairs: by the same cameras, so that what is not sure of them moves the edges of all pairs together.
pub(crate) fn judge(
    fits: &Fits,
    limbs: &[[[Found; 2]; 2]],
    prior: Option<Prior>,
    calibration: Option<&CalibrationSigma>,
) -> Option<Judgement> {
    let is_alone = fits.pairs.len() == 1;
    // A pair that sees no limb says nothing.
    let is_seen = |limbs: &[[Found; 2]; 2]| limbs.iter().flatten().any(|f| f.limb == Limb::Seen);
    let pairs = fits.pairs.iter().zip(limbs).enumerate();
    let all: Vec<Told> = pairs
        .filter(|(pair, (_, limbs))| *pair == 0 || is_seen(limbs))
        .map(|(_, (fit, limbs))| told(fit, limbs, calibration, is_alone))
        .collect::<Option<_>>()?;
    let is_straight = fits.state().bend_per_m.is_none();
    let is_free = |k: usize| !(is_straight && (BEND..BEND + 2).contains(&k));
    let of_edges = Covariance::new(all.iter().map(|told| (&told.covariance, &told.cameras[..])));
    // Edges by the rod, and the rod by the edges: least squares by the information.
    let weighted: Vec<Estimator> = all
        .iter()
        .map(|told| told.jacobian.transpose() * told.information)
        .collect();
    let estimators = |back: &SMatrix<f64, ROD, ROD>| -> Vec<Estimator> {
        weighted.iter().map(|weighted| back * weighted).collect()
    };
    let mut normal = SMatrix::<f64, ROD, ROD>::zeros();
    for (weighted, told) in weighted.iter().zip(&all) {
        normal += weighted * told.jacobian;
    }
    let mut unknowns = 0;
    for k in 0..ROD {
        if is_free(k) {
            unknowns += 1;
        } else {
            normal[(k, k)] = 1.0;
        }
    }
    // What the limbs say of the radius by themselves, if they do.
    let seen_radius = inverted(&normal).and_then(|free| {
        let estimators = estimators(&free);
        let variance = of_edges.through(&estimators, &estimators)[(RADIUS, RADIUS)];
        // Where light is not as its model has it rods look thicker or thinner, in all pairs alike.
        let sigma_m = (variance * all.len() as f64).max(0.0).sqrt();
        let moves = estimators.iter().zip(&all);
        let moved_m: f64 = moves.map(|(by, told)| (by * told.moved)[RADIUS]).sum();
        let radius_m = fits.state().cylinder.radius_m + moved_m;
        (sigma_m < MOST_RADIUS_SIGMA * radius_m).then_some((radius_m, sigma_m))
    });
    if let Some(prior) = prior {
        normal[(RADIUS, RADIUS)] += 1.0 / (prior.sigma_m * prior.sigma_m);
    }
    let back = inverted(&normal)?;
    let estimators = estimators(&back);
    let mut covariance = of_edges.through(&estimators, &estimators);
    if let Some(prior) = prior {
        let column = back.column(RADIUS) / prior.sigma_m;
        covariance += column * column.transpose();
    }
    let chi2 = left_over(&all, &estimators, &of_edges);
    let seen: usize = all.iter().map(|told| told.seen).sum();
    let redundancies = (seen + usize::from(prior.is_some())).saturating_sub(unknowns);
    covariance
        .iter()
        .all(|v| v.is_finite())
        .then_some(Judgement {
            covariance,
            seen_radius,
            chi2,
            redundancies,
        })
}

/// What the edges of all pairs would like that no rod does, in units of its variance.
fn left_over(all: &[Told], estimators: &[Estimator], of_edges: &Covariance) -> f64 {
    let rows: Vec<Vec<Edges>> = all
        .iter()
        .enumerate()
        .map(|(pair, told)| {
            let of_pair = |(other, estimator): (usize, &Estimator)| {
                let fitted = told.jacobian * estimator;
                if other == pair {
                    Edges::identity() - fitted
                } else {
                    -fitted
                }
            };
            estimators.iter().enumerate().map(of_pair).collect()
        })
        .collect();
    let len = EDGES * all.len();
    let mut residual = DVector::zeros(len);
    let mut spread = DMatrix::zeros(len, len);
    for (i, row) in rows.iter().enumerate() {
        for (left, told) in row.iter().zip(all) {
            let mut part = residual.fixed_rows_mut::<EDGES>(i * EDGES);
            part += left * told.moved;
        }
        for (j, column) in rows.iter().enumerate() {
            let part = of_edges.through(row, column);
            let mut place = spread.fixed_view_mut::<EDGES, EDGES>(i * EDGES, j * EDGES);
            place.copy_from(&part);
        }
    }
    mahalanobis(&residual, &spread)
}

/// Of one pair, alone or among others.
fn told(
    fit: &Fit,
    limbs: &[[Found; 2]; 2],
    calibration: Option<&CalibrationSigma>,
    is_alone: bool,
) -> Option<Told> {
    // Blurs, shadows and mean shading are eliminated from the rest.
    let nuisances: Vec<usize> = (ROD..UNKNOWNS).chain(UNKNOWNS + EDGES..ALL).collect();
    let rest: Vec<usize> = (0..ROD).chain(UNKNOWNS..UNKNOWNS + EDGES).collect();
    let all = fit.sums.all();
    let part = |rows: &[usize], columns: &[usize]| {
        DMatrix::from_fn(rows.len(), columns.len(), |i, j| all[(rows[i], columns[j])])
    };
    let mut of_nuisances = part(&nuisances, &nuisances);
    let mut known = SMatrix::zeros();
    add_known(&mut known, &mut SVector::zeros(), &fit.state);
    let largest = of_nuisances.diagonal().max();
    for k in 0..nuisances.len() {
        of_nuisances[(k, k)] += 1e-9 * of_nuisances[(k, k)] + 1e-12 * largest;
    }
    let of_unknowns = UNKNOWNS - ROD;
    let mut part_known = of_nuisances.view_mut((0, 0), (of_unknowns, of_unknowns));
    part_known += known.view((ROD, ROD), (of_unknowns, of_unknowns));
    let gain = of_nuisances.cholesky()?.solve(&part(&nuisances, &rest));
    let joint = part(&rest, &rest) - part(&rest, &nuisances) * &gain;
    let edges = Edges::from_fn(|i, j| joint[(ROD + i, ROD + j)]);
    let is_straight = fit.state.bend_per_m.is_none();
    let is_free = |k: usize| !(is_straight && (BEND..BEND + 2).contains(&k));
    let by_rod =
        SMatrix::<f64, EDGES, ROD>::from_fn(
            |i, j| {
                if is_free(j) { joint[(ROD + i, j)] } else { 0.0 }
            },
        );
    let of_edges = |scores: &SVector<f64, ALL>| {
        OfEdges::from_fn(|i, _| {
            let of_nuisances = nuisances.iter().enumerate();
            let shared: f64 = of_nuisances
                .map(|(k, at)| gain[(k, ROD + i)] * scores[*at])
                .sum();
            scores[UNKNOWNS + i] - shared
        })
    };
    // Blocks are measurements of their own: their scores' scatter is what the noise really is.
    let mut scatter = Edges::zeros();
    let mut score = OfEdges::zeros();
    for block in &fit.sums.blocks {
        let of_edges = of_edges(&block.scores());
        scatter += of_edges * of_edges.transpose();
        score += of_edges;
    }
    // What is known of mean shading pulls as well.
    let first = nuisances.len() - fit.sums.of_means.len();
    for (i, score) in score.iter_mut().enumerate() {
        let pulls = fit.sums.of_means.iter().enumerate();
        *score -= pulls
            .map(|(k, pull)| gain[(first + k, ROD + i)] * pull)
            .sum::<f64>();
    }
    // A limb that is not seen says nothing.
    let mut information = edges;
    let largest = edges.diagonal().max();
    for k in 0..EDGES {
        information[(k, k)] += 1e-9 * largest;
    }
    let inverse = information.try_inverse()?;
    let moved = inverse * score;
    if !is_alone {
        // Other pairs may have pulled its edges away, which all blocks feel alike: that is no noise.
        let mut there = SVector::<f64, ALL>::zeros();
        for (i, k) in (UNKNOWNS..UNKNOWNS + EDGES).enumerate() {
            there[k] = moved[i];
            for (k, at) in nuisances.iter().enumerate() {
                there[*at] -= gain[(k, ROD + i)] * moved[i];
            }
        }
        scatter.fill(0.0);
        for block in &fit.sums.blocks {
            let mut normal = DMatrix::zeros(ALL, ALL);
            block.add_to(&mut normal, OF_ALL);
            normal.fill_upper_triangle_with_lower_triangle();
            let of_edges = of_edges(&(block.scores() - normal * there));
            scatter += of_edges * of_edges.transpose();
        }
    }
    // What was fitted to them they scatter less by.
    let count = 2.0 * fit.sums.blocks.len() as f64;
    let few = count / (count - FITTED).max(0.25 * count);
    let mut covariance = no_surer(&(inverse * scatter * inverse * few), &inverse)?;
    for k in 0..EDGES {
        let found = limbs[k / 6][(k / 3) % 2];
        let Found {
            softness, middle, ..
        } = found;
        let radius_px = middle.map_or(0.0, |middle| middle.radius_px);
        let narrow = middle.map_or(0.0, |middle| NARROW_PX / middle.radius_px);
        let blur_px = (fit.state.blur_px2[k / 6].sqrt() - SHARP_PX).max(0.0);
        let soft2 = softness * softness;
        let lamps = fit.state.lamps_rad.iter().flatten().count();
        let soft_px = if lamps == 0 { SOFT_PX * soft2 } else { 0.0 };
        let floor_px = libm::hypot(
            FLOOR_PX * (1.0 + narrow) + BLURRED * blur_px,
            libm::hypot(
                soft_px,
                SOFT_RADII[lamps] * radius_px * soft2 * soft2 * soft2,
            ),
        );
        covariance[(k, k)] += FLOORS[k % 3] * floor_px * floor_px;
    }
    let seen = (0..EDGES)
        .filter(|k| edges[(*k, *k)] > 1e-6 * largest)
        .count();
    let told = Told {
        jacobian: inverse * by_rod,
        information,
        covariance,
        moved,
        seen,
        cameras: calibration.map_or_else(Vec::new, |sigma| calibrated(limbs, sigma)),
    };
    match &fit.drift {
        Some(drift) => told.adrift(drift, &fit.state),
        None => Some(told),
    }
}

impl Told {
    /// Of a pair that may be elsewhere than it is said to be: all its edges move with it.
    fn adrift(self, drift: &Drift, state: &State) -> Option<Self> {
        let by_drift = self.jacobian * drift.of_rod(state);
        let moves = by_drift * SMatrix::<f64, DRIFT, DRIFT>::from_diagonal(&drift.sigmas);
        // Woodbury's identity for the inverse of a sum.
        let weighed = self.information * moves;
        let inner = SMatrix::<f64, DRIFT, DRIFT>::identity() + moves.transpose() * weighed;
        let shared = inner.cholesky()?.solve(&weighed.transpose());
        Some(Self {
            information: self.information - weighed * shared,
            covariance: self.covariance + moves * moves.transpose(),
            // From where the pair was said to be.
            moved: self.moved + by_drift * drift.by,
            ..self
        })
    }
}

/// What is not sure of the cameras moves both limbs of an eye together: each by how the image moves along its normal, and a roll
/// about the principal point shifts and turns it. Of each eye how a move to the right, a move down and a roll shift its edges.
fn calibrated(limbs: &[[Found; 2]; 2], calibration: &CalibrationSigma) -> Vec<OfEdges> {
    let of_eye = |(eye, limbs): (usize, &[Found; 2])| {
        let mut moves = [OfEdges::zeros(); 3];
        for (side, limb) in limbs.iter().enumerate() {
            let Some(middle) = limb.middle else {
                continue;
            };
            let ([across, along], [x, y]) = (middle.inwards, middle.from_centre_px);
            let shift = 6 * eye + 3 * side;
            let (of_across, of_along, roll_rad) = if middle.by_columns {
                (1, 0, -calibration.roll_rad)
            } else {
                (0, 1, calibration.roll_rad)
            };
            moves[of_across][shift] = across * calibration.pixel_px;
            moves[of_along][shift] = along * calibration.pixel_px;
            let turn = -roll_rad * middle.half_px / across;
            let there = roll_rad * (along * x - across * y);
            moves[2][shift] = there - turn * middle.along;
            moves[2][shift + 1] = turn;
        }
        moves
    };
    limbs.iter().enumerate().flat_map(of_eye).collect()
}
