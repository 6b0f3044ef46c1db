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

#[cfg(test)]
mod tests {
    use super::super::state::UNKNOWNS;
    use super::*;

    fn state() -> State {
        let cylinder = Cylinder {
            axis: Line3::new(Vec3::new(1.5, 0.1, -0.2), &Vec3::new(0.3, 0.2, 1.0)),
            radius_m: 0.05,
        };
        let mut state = State::new(cylinder, 0.2);
        let [a, b] = state.across;
        state.bend_per_m = Some(a * 0.3 - b * 0.2);
        state
    }

    fn drift() -> Drift {
        let sigma = MoveSigma {
            translation_m: 0.01,
            rotation_rad: 0.005,
        };
        Drift::new(&sigma, Vec3::new(0.1, -0.3, 0.2))
    }

    /// The axis at places along, and the radius.
    fn shape(state: &State) -> Vec<Vec3> {
        let d = state.cylinder.axis.direction;
        let reference = self::state().cylinder.axis;
        let at = |k: i32| {
            // Where the curve crosses planes across the axis: a slide along itself is no change.
            let plane_m = 0.2 * f64::from(k);
            let mut along_m = plane_m;
            for _ in 0..50 {
                let point_m = state.tangent(along_m).axis.point_m;
                let ahead_m = (point_m - reference.point_m).dot(&reference.direction);
                along_m += (plane_m - ahead_m) / d.dot(&reference.direction);
            }
            state.tangent(along_m).axis.point_m
        };
        (-2..=2).map(at).collect()
    }

    /// A drift moves the rod as the unknowns do that stand for it.
    #[test]
    fn drifts_are_steps_of_the_rod() {
        let (state, drift) = (state(), drift());
        let by = drift.of_rod(&state);
        for k in 0..DRIFT {
            let size = 1e-5;
            let mut drifted = SVector::<f64, DRIFT>::zeros();
            drifted[k] = size;
            let mut step = SVector::<f64, UNKNOWNS>::zeros();
            step.fixed_rows_mut::<ROD>(0).copy_from(&(by * drifted));
            let found = shape(&drift.moved(&drifted).seen(&state, &state));
            let expected = shape(&state.moved(&step));
            let far_m = found.iter().zip(shape(&state));
            let far_m = far_m.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
            for (found, expected) in found.iter().zip(&expected) {
                let off_m = (found - expected).norm();
                // A parabola that slides is not quite one that turns.
                assert!(off_m < 3e-3 * size, "{k}: {off_m} of {far_m}");
            }
            // Only along itself a rod would not be seen to move.
            assert!(far_m > 0.01 * size, "{k}: {far_m}");
        }
    }

    /// A rod that drifted there and back is where it was; and one that is not known to drift does not.
    #[test]
    fn turns_keep_shape() {
        let (state, drift) = (state(), drift());
        let still = drift.seen(&state, &state).cylinder.axis;
        assert!((still.point_m - state.cylinder.axis.point_m).norm() < 1e-15);
        assert_eq!(still.direction, state.cylinder.axis.direction);
        let far = drift.moved(&SVector::from([0.1, -0.2, 0.3, 0.5, -0.4, 0.7]));
        let seen = far.seen(&state, &state);
        let [a, b] = seen.across;
        let d = seen.cylinder.axis.direction;
        for off in [
            d.norm() - 1.0,
            a.norm() - 1.0,
            a.dot(&b),
            a.dot(&d),
            b.dot(&d),
        ] {
            assert!(off.abs() < 1e-14, "{off}");
        }
        let bends = [&seen, &state].map(|s| s.bend_per_m.map_or(0.0, |bend| bend.norm()));
        assert!((bends[0] - bends[1]).abs() < 1e-14);
        let squares = [0.1, 0.2, 0.3].map(|v: f64| v * v / 1e-4);
        let turns = [0.5, 0.4, 0.7].map(|v: f64| v * v / 2.5e-5);
        let expected: f64 = squares.iter().chain(&turns).sum();
        assert!((2.0 * far.cost() / expected - 1.0).abs() < 1e-12);
    }
}
