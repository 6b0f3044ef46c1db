//! Errors of one estimate against the truth.

use nalgebra::Matrix3;
use rodsight_geometry::{Line3, Vec3, radians};
use serde::Serialize;

use crate::nees::{AxisCovariance, Nees, nees};

/// What is true of a rod, in the rig frame. The truth is the axis, never the silhouette.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TruthAxis {
    /// Centre line; for a bent rod the tangent at the grasp point.
    pub axis: Line3,
    /// Radius, m.
    pub radius_m: f64,
    /// The true grasp point, m: the foot on the axis of the picked surface point.
    pub grasp_m: Vec3,
    /// The part of the axis that both images show, m along the axis from its reference point.
    pub visible_span_m: [f64; 2],
    /// Unit direction along which depth is counted: the left camera's optical axis.
    pub depth_direction: Vec3,
}

/// What was estimated of a rod, in the rig frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located {
    /// Centre line.
    pub axis: Line3,
    /// Covariance of the axis' point and direction, if claimed.
    pub covariance: Option<AxisCovariance>,
    /// Radius, m, if estimated.
    pub radius_m: Option<f64>,
    /// Grasp point, m, if a pick was given.
    pub grasp_m: Option<Vec3>,
}

impl Located {
    /// An estimate of the axis alone.
    pub fn of_axis(axis: Line3) -> Self {
        Self {
            axis,
            covariance: None,
            radius_m: None,
            grasp_m: None,
        }
    }

    /// How far off the axis is claimed to be where it passes a point, m: the root mean square across the axis. What the reference point
    /// may be off along the axis does not count.
    pub fn claimed_offset_m(&self, at_m: &Vec3) -> Option<f64> {
        let covariance = self.covariance.as_ref()?;
        let direction = self.axis.direction;
        let along_m = direction.dot(&(at_m - self.axis.point_m));
        let block = |i: usize, j: usize| covariance.fixed_view::<3, 3>(i, j);
        let there: Matrix3<f64> =
            block(0, 0) + (block(0, 3) + block(3, 0)) * along_m + block(3, 3) * (along_m * along_m);
        let along_m2 = direction.dot(&(there * direction));
        Some((there.trace() - along_m2).max(0.0).sqrt())
    }
}

/// The errors of one estimate. What was not estimated has no error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// [`axis_angle_rad`].
    pub axis_angle_rad: f64,
    /// [`axis_offset_m`], the primary one.
    pub axis_offset_m: f64,
    /// [`max_span_distance_m`].
    pub max_span_distance_m: f64,
    /// [`depth_error_m`], signed.
    pub depth_m: f64,
    /// [`grasp_error`].
    pub grasp: Option<GraspError>,
    /// [`radius_error_m`], signed.
    pub radius_m: Option<f64>,
    /// [`nees`].
    pub nees: Option<Nees>,
}

impl Errors {
    /// All errors of an estimate.
    pub fn of(estimate: &Located, truth: &TruthAxis) -> Self {
        Self {
            axis_angle_rad: axis_angle_rad(&estimate.axis, &truth.axis),
            axis_offset_m: axis_offset_m(&estimate.axis, &truth.grasp_m),
            max_span_distance_m: max_span_distance_m(
                &estimate.axis,
                &truth.axis,
                truth.visible_span_m,
            ),
            depth_m: depth_error_m(&estimate.axis, &truth.grasp_m, &truth.depth_direction),
            grasp: estimate
                .grasp_m
                .map(|grasp_m| grasp_error(&grasp_m, &truth.grasp_m, &truth.axis.direction)),
            radius_m: estimate
                .radius_m
                .map(|radius_m| radius_error_m(radius_m, truth.radius_m)),
            nees: estimate
                .covariance
                .as_ref()
                .map(|covariance| nees(&estimate.axis, covariance, &truth.axis)),
        }
    }

    /// Whether the axis is within a level: its offset at the grasp and its angle.
    pub fn within(&self, level: &SuccessLevel) -> bool {
        self.axis_offset_m <= level.offset_m && self.axis_angle_rad <= level.angle_rad
    }
}

/// A level of success: within so many metres at the grasp and so many radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuccessLevel {
    /// Largest [`axis_offset_m`].
    pub offset_m: f64,
    /// Largest [`axis_angle_rad`].
    pub angle_rad: f64,
}

/// The levels that are reported: (1 mm, 0.1°), (5 mm, 0.5°), (20 mm, 2°).
pub const SUCCESS_LEVELS: [SuccessLevel; 3] =
    [level(0.001, 0.1), level(0.005, 0.5), level(0.02, 2.0)];

const fn level(offset_m: f64, angle_deg: f64) -> SuccessLevel {
    SuccessLevel {
        offset_m,
        angle_rad: radians(angle_deg),
    }
}

/// `e_ang`, rad in [0, π/2]: the angle between the estimated and the true axis, whatever their signs.
pub fn axis_angle_rad(estimate: &Line3, truth: &Line3) -> f64 {
    estimate.angle_to(truth)
}

/// `e_axis`, m: the distance of the estimated axis from the true grasp point, |(I − d̂ d̂ᵀ)(p̂ − G)|.
pub fn axis_offset_m(estimate: &Line3, true_grasp_m: &Vec3) -> f64 {
    estimate.distance_m(true_grasp_m)
}

/// `e_MSAD`, m: the largest distance of a point of the true visible span from the estimated axis (maximum symmetry-aware
/// distance, as BOP's MSSD with the rod's continuous symmetry removed). The distance to a line is convex along a segment:
/// the largest is at one of its ends.
pub fn max_span_distance_m(estimate: &Line3, truth: &Line3, visible_span_m: [f64; 2]) -> f64 {
    visible_span_m
        .iter()
        .map(|along_m| estimate.distance_m(&(truth.point_m + truth.direction * *along_m)))
        .fold(0.0, f64::max)
}

/// `e_Z`, m, signed: how much deeper than the true grasp point the nearest point of the estimated axis lies, along the unit
/// direction in which depth is counted. Negative is too near.
pub fn depth_error_m(estimate: &Line3, true_grasp_m: &Vec3, depth_direction: &Vec3) -> f64 {
    (estimate.foot(true_grasp_m) - true_grasp_m).dot(depth_direction)
}

/// `e_r`, m, signed: estimated minus true radius.
pub fn radius_error_m(estimate_m: f64, truth_m: f64) -> f64 {
    estimate_m - truth_m
}

/// The error of a grasp point, split along the true axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GraspError {
    /// Across the true axis, m: what stereo measures.
    pub across_m: f64,
    /// Along the true axis, m, without sign: what the pick says.
    pub along_m: f64,
}

impl GraspError {
    /// |Ĝ − G|, m.
    pub fn total_m(&self) -> f64 {
        (self.across_m * self.across_m + self.along_m * self.along_m).sqrt()
    }
}

/// `e_grasp`, m, split across and along the (unit) direction of the true axis.
pub fn grasp_error(estimate_m: &Vec3, truth_m: &Vec3, true_direction: &Vec3) -> GraspError {
    let error_m = estimate_m - truth_m;
    let along_m = error_m.dot(true_direction);
    GraspError {
        across_m: (error_m - true_direction * along_m).norm(),
        along_m: along_m.abs(),
    }
}
