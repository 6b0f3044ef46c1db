//! By how much a pair's rig is off from where its move was said to have brought it.
//!
//! The pair's cameras stay where they were said to be, and the rod is moved before them instead.

use nalgebra::{SMatrix, SVector};
use rodsight_geometry::{Cylinder, Line3, Mat3, Vec3};

use super::state::{BEND, ROD, State};
use crate::MoveSigma;

/// Shifts along the rig's axes, m, then turns about them, rad.
pub(crate) const DRIFT: usize = 6;
/// Nothing is known better, m and rad.
const LEAST_SIGMA: f64 = 1e-7;

/// A drift, and how large it may be.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Drift {
    pub(crate) by: SVector<f64, DRIFT>,
    /// Of each of them, the standard deviation.
    pub(crate) sigmas: SVector<f64, DRIFT>,
    /// What the rig turns about.
    pivot_m: Vec3,
}

impl Drift {
    pub(crate) fn new(sigma: &MoveSigma, pivot_m: Vec3) -> Self {
        let [along, about] =
            [sigma.translation_m, sigma.rotation_rad].map(|sigma| sigma.max(LEAST_SIGMA));
        Self {
            by: SVector::zeros(),
            sigmas: SVector::from([along, along, along, about, about, about]),
            pivot_m,
        }
    }

    pub(crate) fn moved(self, by: &SVector<f64, DRIFT>) -> Self {
        Self {
            by: self.by + by,
            ..self
        }
    }

    fn shift_m(&self) -> Vec3 {
        self.by.fixed_rows::<3>(0).into()
    }

    /// The pair's own state, with the rod as the pair sees the first one's.
    pub(crate) fn seen(&self, first: &State, own: &State) -> State {
        let turn = turn(&self.by.fixed_rows::<3>(3).into());
        let axis = &first.cylinder.axis;
        let point_m = self.pivot_m + turn * (axis.point_m - self.pivot_m) + self.shift_m();
        State {
            cylinder: Cylinder {
                axis: Line3 {
                    point_m,
                    direction: turn * axis.direction,
                },
                ..first.cylinder
            },
            across: first.across.map(|across| turn * across),
            bend_per_m: first.bend_per_m.map(|bend| turn * bend),
            ..*own
        }
    }

    /// How the rod's unknowns in the pair change with the drift.
    pub(crate) fn of_rod(&self, own: &State) -> SMatrix<f64, ROD, DRIFT> {
        let axis = &own.cylinder.axis;
        let bend = own.bend_per_m.unwrap_or_default();
        let from_pivot = axis.point_m - self.pivot_m - self.shift_m();
        let mut found = SMatrix::zeros();
        for k in 0..DRIFT {
            let unit = Vec3::from_fn(|i, _| if i == k % 3 { 1.0 } else { 0.0 });
            let (moved, turned) = if k < 3 {
                (unit, Vec3::zeros())
            } else {
                (unit.cross(&from_pivot), unit)
            };
            // Along itself a bent rod turns.
            let along = axis.direction.dot(&moved);
            let turned_axis = turned.cross(&axis.direction) - bend * along;
            let turned_bend = turned.cross(&bend);
            for (i, across) in own.across.iter().enumerate() {
                found[(i, k)] = moved.dot(across);
                found[(2 + i, k)] = turned_axis.dot(across);
                found[(BEND + i, k)] = turned_bend.dot(across);
            }
        }
        found
    }

    /// What it costs to be so far off.
    pub(crate) fn cost(&self) -> f64 {
        0.5 * self.by.component_div(&self.sigmas).norm_squared()
    }
}

/// A small rotation by a vector (Cayley): orthonormal for any.
fn turn(by_rad: &Vec3) -> Mat3 {
    let half = (0.5 * by_rad).cross_matrix();
    let inverse = (Mat3::identity() - half).try_inverse();
    inverse.unwrap_or_else(Mat3::identity) * (Mat3::identity() + half)
}
