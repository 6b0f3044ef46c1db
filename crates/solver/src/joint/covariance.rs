//! Covariances of edges, of one pair and between pairs.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::block::EDGES;

pub(crate) type Edges = SMatrix<f64, EDGES, EDGES>;
pub(crate) type OfEdges = SVector<f64, EDGES>;

/// The covariance of the edges of all pairs.
pub(crate) struct Covariance {
    /// Of each pair with each.
    parts: Vec<Vec<Option<Edges>>>,
}

impl Covariance {
    /// From each pair's own, and what moves the edges of all pairs together.
    pub(crate) fn new<'a>(pairs: impl Iterator<Item = (&'a Edges, &'a [OfEdges])>) -> Self {
        let all: Vec<_> = pairs.collect();
        let part = |i: usize, j: usize| {
            let ((own, a), (_, b)) = (all[i], all[j]);
            let mut part = (i == j).then_some(*own);
            for (a, b) in a.iter().zip(b) {
                *part.get_or_insert_with(Edges::zeros) += a * b.transpose();
            }
            part
        };
        let pairs = || 0..all.len();
        Self {
            parts: pairs()
                .map(|i| pairs().map(|j| part(i, j)).collect())
                .collect(),
        }
    }

    /// Of what is made of edges with what is made of them in another way.
    pub(crate) fn through<const N: usize>(
        &self,
        a: &[SMatrix<f64, N, EDGES>],
        b: &[SMatrix<f64, N, EDGES>],
    ) -> SMatrix<f64, N, N> {
        let mut sum = SMatrix::zeros();
        for (a, row) in a.iter().zip(&self.parts) {
            for (b, part) in b.iter().zip(row) {
                if let Some(part) = part {
                    sum += a * part * b.transpose();
                }
            }
        }
        sum
    }
}

/// A covariance where it is wider than another, and that other where it is not.
pub(crate) fn no_surer(covariance: &Edges, least: &Edges) -> Option<Edges> {
    let unit = least.cholesky()?.l();
    let inverse = unit.solve_lower_triangular(&Edges::identity())?;
    let times = inverse * covariance * inverse.transpose();
    let mut eigen = ((times + times.transpose()) * 0.5).symmetric_eigen();
    eigen.eigenvalues.apply(|value| *value = value.max(1.0));
    Some(unit * eigen.recompose() * unit.transpose())
}

/// The inverse, by way of a unit diagonal: metres and radians differ by orders of magnitude.
pub(crate) fn inverted<const N: usize>(normal: &SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
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

/// The square of a residual in units of its spread, as far as that has directions.
pub(crate) fn mahalanobis(residual: &DVector<f64>, spread: &DMatrix<f64>) -> f64 {
    let scale = spread
        .diagonal()
        .map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
    let scaled = spread.component_mul(&(&scale * scale.transpose()));
    let eigen = ((&scaled + scaled.transpose()) * 0.5).symmetric_eigen();
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
