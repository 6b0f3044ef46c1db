//! How sure a fit is, and whether its redundancies agree.

use nalgebra::{SMatrix, SVector};

use super::climb::{Fit, Prior};
use super::fit::{EDGES, ROD, UNKNOWNS};

/// What no model of light and lens is free of, px: a limb may be shifted by so much.
const FLOOR_PX: f64 = 0.02;

/// What the limbs say of the rod's five parameters.
#[derive(Clone, Debug)]
pub(crate) struct Judgement {
    pub(crate) covariance: SMatrix<f64, ROD, ROD>,
    /// Of three redundancies, in units of their variance.
    pub(crate) chi2: f64,
    pub(crate) redundancies: usize,
}

type Edges = SMatrix<f64, EDGES, EDGES>;

pub(crate) fn judge(fit: &Fit, prior: Option<Prior>) -> Option<Judgement> {
    let sums = &fit.sums;
    // The blurs are eliminated from the rest.
    let blurs = [ROD, ROD + 1];
    let rest: Vec<usize> = (0..ROD).chain(UNKNOWNS..UNKNOWNS + EDGES).collect();
    let part = |rows: &[usize], columns: &[usize]| {
        nalgebra::DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
            sums.joint[(rows[i], columns[j])]
        })
    };
    let mut of_blurs = part(&blurs, &blurs);
    for k in 0..2 {
        of_blurs[(k, k)] += 1e-9 * of_blurs[(k, k)] + 1e-12;
    }
    let gain = of_blurs.try_inverse()? * part(&blurs, &rest);
    let joint = part(&rest, &rest) - part(&rest, &blurs) * &gain;
    let edges = Edges::from_fn(|i, j| joint[(ROD + i, ROD + j)]);
    let by_rod = SMatrix::<f64, EDGES, ROD>::from_fn(|i, j| joint[(ROD + i, j)]);
    // Blocks are measurements of their own: their scores' scatter is what the noise really is.
    let mut scatter = Edges::zeros();
    let mut score = SVector::<f64, EDGES>::zeros();
    for block in &sums.scores {
        let of_edges = SVector::<f64, EDGES>::from_fn(|i, _| {
            let blur: f64 = (0..2).map(|k| gain[(k, ROD + i)] * block[ROD + k]).sum();
            block[UNKNOWNS + i] - blur
        });
        scatter += of_edges * of_edges.transpose();
        score += of_edges;
    }
    // A limb that is not seen says nothing.
    let mut information = edges;
    let largest = edges.diagonal().max();
    for k in 0..EDGES {
        information[(k, k)] += 1e-9 * largest;
    }
    let inverse = information.try_inverse()?;
    let count = sums.scores.len() as f64;
    let few = count / (count - 4.0).max(1.0);
    let by_noise = inverse * scatter * inverse * few;
    let mut of_edges = by_noise;
    for k in 0..EDGES / 2 {
        of_edges[(2 * k, 2 * k)] += FLOOR_PX * FLOOR_PX;
        of_edges[(2 * k + 1, 2 * k + 1)] += 3.0 * FLOOR_PX * FLOOR_PX;
    }
    // Edges by the rod, and the rod by the edges: least squares by the information.
    let jacobian = inverse * by_rod;
    let weighted = jacobian.transpose() * information;
    let mut normal = weighted * jacobian;
    if let Some(prior) = prior {
        normal[(ROD - 1, ROD - 1)] += 1.0 / (prior.sigma_m * prior.sigma_m);
    }
    let scale = normal
        .diagonal()
        .map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
    let scaled = SMatrix::<f64, ROD, ROD>::from_fn(|i, j| normal[(i, j)] * scale[i] * scale[j]);
    let scaled = scaled.try_inverse()?;
    let back = SMatrix::<f64, ROD, ROD>::from_fn(|i, j| scaled[(i, j)] * scale[i] * scale[j]);
    let estimator = back * weighted;
    let mut covariance = estimator * of_edges * estimator.transpose();
    if let Some(prior) = prior {
        let column = back.column(ROD - 1) / prior.sigma_m;
        covariance += column * column.transpose();
    }
    // What the edges would like that no rod does.
    let left = Edges::identity() - jacobian * estimator;
    let residual = left * (inverse * score);
    let spread = left * of_edges * left.transpose();
    let (chi2, redundancies) = mahalanobis(&residual, &spread);
    covariance
        .iter()
        .all(|v| v.is_finite())
        .then_some(Judgement {
            covariance,
            chi2,
            redundancies,
        })
}

fn mahalanobis(residual: &SVector<f64, EDGES>, spread: &Edges) -> (f64, usize) {
    let scale = spread
        .diagonal()
        .map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
    let scaled =
        Edges::from_fn(|i, j| 0.5 * (spread[(i, j)] + spread[(j, i)]) * scale[i] * scale[j]);
    let eigen = scaled.symmetric_eigen();
    let residual = residual.component_mul(&scale);
    let largest = eigen.eigenvalues.max();
    let mut sum = 0.0;
    let mut count = 0;
    for (k, value) in eigen.eigenvalues.iter().enumerate() {
        if *value > 1e-6 * largest {
            let part = eigen.eigenvectors.column(k).dot(&residual);
            sum += part * part / value;
            count += 1;
        }
    }
    (sum, count)
}
