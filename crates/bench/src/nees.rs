//! The normalised estimation error squared of an axis.

use nalgebra::{Matrix4, Matrix6, SMatrix, Vector4};
use rodsight_geometry::{Line3, Vec3};

/// Covariance of (point, direction) of an axis, in m², m and 1: 6×6, singular along the axis and along the direction's length.
pub type AxisCovariance = Matrix6<f64>;

/// The normalised estimation error squared, and of how many degrees of freedom it is.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Nees {
    /// eᵀ Σ⁺ e, dimensionless; infinite where an error is claimed to be impossible. Of an honest estimate it is χ² distributed
    /// with `dof` degrees of freedom.
    pub value: f64,
    /// Rank of the covariance: 4 unless some direction is claimed to be known exactly.
    pub dof: usize,
}

/// An eigenvalue of the correlation matrix below this is none.
const RANK: f64 = 1e-12;

/// The error of an axis in units of its claimed covariance.
///
/// An axis has four degrees of freedom. With (a, b) an orthonormal basis across the estimated direction d̂,
///
///   e = (a·δp, b·δp, a·δd, b·δd),  δp = p̂ − x,  δd = d̂ − d/(d·d̂)
///
/// where x is the point at which the true axis passes the plane through p̂ across d̂, and d the true direction, turned alike.
/// Σ is the 6×6 covariance taken to the same basis, and Σ⁺ its pseudo-inverse, formed from the correlation matrix so that
/// neither the units nor the basis matter.
pub fn nees(estimate: &Line3, covariance: &AxisCovariance, truth: &Line3) -> Nees {
    let across = basis_across(&estimate.direction);
    let cos = truth.direction.dot(&estimate.direction);
    // Through the plane at p̂: at right angles the true axis never passes it, and no covariance explains that.
    if cos == 0.0 {
        return Nees {
            value: f64::INFINITY,
            dof: 4,
        };
    }
    let direction = truth.direction / cos;
    let ahead_m = (estimate.point_m - truth.point_m).dot(&estimate.direction);
    let point_error_m = estimate.point_m - (truth.point_m + direction * ahead_m);
    let direction_error = estimate.direction - direction;

    let mut to_basis = SMatrix::<f64, 4, 6>::zeros();
    let mut error = Vector4::zeros();
    for (k, axis) in across.iter().enumerate() {
        to_basis
            .fixed_view_mut::<1, 3>(k, 0)
            .copy_from(&axis.transpose());
        to_basis
            .fixed_view_mut::<1, 3>(k + 2, 3)
            .copy_from(&axis.transpose());
        error[k] = axis.dot(&point_error_m);
        error[k + 2] = axis.dot(&direction_error);
    }
    mahalanobis(&error, &(to_basis * covariance * to_basis.transpose()))
}

fn mahalanobis(error: &Vector4<f64>, covariance: &Matrix4<f64>) -> Nees {
    let impossible = |dof| Nees {
        value: f64::INFINITY,
        dof,
    };
    if !covariance.iter().chain(error.iter()).all(|v| v.is_finite()) {
        return impossible(0);
    }
    let sigma = covariance.diagonal().map(|v| v.max(0.0).sqrt());
    // A coordinate without variance has no correlation either: a zero row.
    let inverse = sigma.map(|s| if s > 0.0 { 1.0 / s } else { 0.0 });
    let correlation = Matrix4::from_fn(|i, j| covariance[(i, j)] * inverse[i] * inverse[j]);
    let certain = (0..4).any(|k| sigma[k] == 0.0 && error[k].abs() > 1e-12);
    let scaled = error.component_mul(&inverse);
    let eigen = ((correlation + correlation.transpose()) * 0.5).symmetric_eigen();
    let (mut value, mut dof) = (0.0, 0);
    for (k, eigenvalue) in eigen.eigenvalues.iter().enumerate() {
        let component = eigen.eigenvectors.column(k).dot(&scaled);
        if *eigenvalue > RANK {
            value += component * component / eigenvalue;
            dof += 1;
        } else if component.abs() > 10.0 * RANK.sqrt() {
            value = f64::INFINITY;
        }
    }
    if certain {
        impossible(dof)
    } else {
        Nees { value, dof }
    }
}

/// Two unit vectors across a unit direction and each other.
fn basis_across(direction: &Vec3) -> [Vec3; 2] {
    let mut least = Vec3::zeros();
    least[direction.iamin()] = 1.0;
    let first = direction.cross(&least).normalize();
    [first, direction.cross(&first)]
}
