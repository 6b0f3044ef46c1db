//! How sure a fit is, and whether its redundancies agree.

use nalgebra::{SMatrix, SVector};

use super::block::{ALL, EDGES};
use super::climb::{Fit, Prior, add_known};
use super::limbs::Found;
use super::state::{BEND, RADIUS, ROD, UNKNOWNS};
use crate::CalibrationSigma;

/// What no model of light and lens is free of, px: a limb may be shifted by so much.
const FLOOR_PX: f64 = 0.014;

/// Twice as much of rods of this radius, px: light changes faster across them.
const NARROW_PX: f64 = 5.0;

/// Nor of light that rises softly from a limb without a step: this, px, times the square of how softly.
const SOFT_PX: f64 = 0.15;
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

type Edges = SMatrix<f64, EDGES, EDGES>;

pub(crate) fn judge(
    fit: &Fit,
    limbs: &[[Found; 2]; 2],
    prior: Option<Prior>,
    calibration: Option<&CalibrationSigma>,
) -> Option<Judgement> {
    // Blurs, shadows and mean shading are eliminated from the rest.
    let nuisances: Vec<usize> = (ROD..UNKNOWNS).chain(UNKNOWNS + EDGES..ALL).collect();
    let rest: Vec<usize> = (0..ROD).chain(UNKNOWNS..UNKNOWNS + EDGES).collect();
    let all = fit.sums.all();
    let part = |rows: &[usize], columns: &[usize]| {
        nalgebra::DMatrix::from_fn(rows.len(), columns.len(), |i, j| all[(rows[i], columns[j])])
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
    // Blocks are measurements of their own: their scores' scatter is what the noise really is.
    let mut scatter = Edges::zeros();
    let mut score = SVector::<f64, EDGES>::zeros();
    for block in &fit.sums.blocks {
        let block = block.scores();
        let of_edges = SVector::<f64, EDGES>::from_fn(|i, _| {
            let of_nuisances = nuisances.iter().enumerate();
            let shared: f64 = of_nuisances
                .map(|(k, at)| gain[(k, ROD + i)] * block[*at])
                .sum();
            block[UNKNOWNS + i] - shared
        });
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
    // What was fitted to them they scatter less by.
    let count = 2.0 * fit.sums.blocks.len() as f64;
    let few = count / (count - FITTED).max(0.25 * count);
    let mut of_edges = no_surer(&(inverse * scatter * inverse * few), &inverse)?;
    for k in 0..EDGES {
        let found = limbs[k / 6][(k / 3) % 2];
        let Found {
            softness, middle, ..
        } = found;
        let softness = if found.is_explained() { 0.0 } else { softness };
        let narrow = middle.map_or(0.0, |middle| NARROW_PX / middle.radius_px);
        let blur_px = (fit.state.blur_px2[k / 6].sqrt() - SHARP_PX).max(0.0);
        let floor_px = libm::hypot(
            FLOOR_PX * (1.0 + narrow) + BLURRED * blur_px,
            SOFT_PX * softness * softness,
        );
        of_edges[(k, k)] += FLOORS[k % 3] * floor_px * floor_px;
    }
    if let Some(calibration) = calibration {
        add_calibration(&mut of_edges, limbs, calibration);
    }
    // Edges by the rod, and the rod by the edges: least squares by the information.
    let jacobian = inverse * by_rod;
    let weighted = jacobian.transpose() * information;
    let mut normal = weighted * jacobian;
    let mut unknowns = 0;
    for k in 0..ROD {
        if is_free(k) {
            unknowns += 1;
        } else {
            normal[(k, k)] = 1.0;
        }
    }
    let moved = inverse * score;
    // What the limbs say of the radius by themselves, if they do.
    let seen_radius = inverted(&normal).and_then(|free| {
        let estimator = free * weighted;
        let variance = (estimator * of_edges * estimator.transpose())[(RADIUS, RADIUS)];
        let sigma_m = variance.max(0.0).sqrt();
        let radius_m = fit.state.cylinder.radius_m + (estimator * moved)[RADIUS];
        (sigma_m < MOST_RADIUS_SIGMA * radius_m).then_some((radius_m, sigma_m))
    });
    if let Some(prior) = prior {
        normal[(RADIUS, RADIUS)] += 1.0 / (prior.sigma_m * prior.sigma_m);
    }
    let back = inverted(&normal)?;
    let estimator = back * weighted;
    let mut covariance = estimator * of_edges * estimator.transpose();
    if let Some(prior) = prior {
        let column = back.column(RADIUS) / prior.sigma_m;
        covariance += column * column.transpose();
    }
    // What the edges would like that no rod does.
    let left = Edges::identity() - jacobian * estimator;
    let chi2 = mahalanobis(&(left * moved), &(left * of_edges * left.transpose()));
    let seen = (0..EDGES)
        .filter(|k| edges[(*k, *k)] > 1e-6 * largest)
        .count();
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

/// A covariance where it is wider than another, and that other where it is not.
fn no_surer(covariance: &Edges, least: &Edges) -> Option<Edges> {
    let unit = least.cholesky()?.l();
    let inverse = unit.solve_lower_triangular(&Edges::identity())?;
    let times = inverse * covariance * inverse.transpose();
    let mut eigen = ((times + times.transpose()) * 0.5).symmetric_eigen();
    eigen.eigenvalues.apply(|value| *value = value.max(1.0));
    Some(unit * eigen.recompose() * unit.transpose())
}

/// The inverse, by way of a unit diagonal: metres and radians differ by orders of magnitude.
fn inverted<const N: usize>(normal: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    let scale = normal
        .diagonal()
        .map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
    let scales = scale * scale.transpose();
    Some(
        normal
            .component_mul(&scales)
            .try_inverse()?
            .component_mul(&scales),
    )
}

fn mahalanobis(residual: &SVector<f64, EDGES>, spread: &Edges) -> f64 {
    let scale = spread
        .diagonal()
        .map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
    let scaled = spread.component_mul(&(scale * scale.transpose()));
    let eigen = ((scaled + scaled.transpose()) * 0.5).symmetric_eigen();
    let residual = residual.component_mul(&scale);
    let largest = eigen.eigenvalues.max();
    let parts = eigen
        .eigenvalues
        .iter()
        .zip(eigen.eigenvectors.column_iter());
    let seen = parts.filter(|(value, _)| **value > 1e-6 * largest);
    let squares = seen.map(|(value, vector)| {
        let part = vector.dot(&residual);
        part * part / value
    });
    squares.sum()
}

/// What is not sure of the cameras moves both limbs of an eye together: each by how the image moves along its normal, and a roll
/// about the principal point shifts and turns it.
fn add_calibration(of_edges: &mut Edges, limbs: &[[Found; 2]; 2], calibration: &CalibrationSigma) {
    for (eye, limbs) in limbs.iter().enumerate() {
        let mut moves = [SVector::<f64, EDGES>::zeros(); 3];
        for (side, limb) in limbs.iter().enumerate() {
            let Some(middle) = limb.middle else {
                continue;
            };
            let ([across, along], [x, y]) = (middle.inwards, middle.from_centre_px);
            let shift = 6 * eye + 3 * side;
            moves[0][shift] = across * calibration.pixel_px;
            moves[1][shift] = along * calibration.pixel_px;
            let turn = -calibration.roll_rad * middle.half_px / across;
            let there = calibration.roll_rad * (along * x - across * y);
            moves[2][shift] = there - turn * middle.along;
            moves[2][shift + 1] = turn;
        }
        for moved in moves {
            *of_edges += moved * moved.transpose();
        }
    }
}
