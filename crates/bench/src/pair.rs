//! From the renderer's truth record and a solver's answer to what the metrics take.

use std::path::Path;

use nalgebra::Matrix6;
use rodsight_geometry::{Cylinder, Line3, Rig, RigError, Vec3};
use rodsight_render::{EyeTruth, LineTruth, Truth};
use rodsight_solver::Estimate;

use crate::errors::{Errors, Located, TruthAxis};

/// The errors of a solver's answer on a rendered pair; `None` if it gave no axis.
///
/// # Errors
/// A truth record whose rig is none.
pub fn measure(truth: &Truth, estimate: &Estimate) -> Result<Option<Errors>, RigError> {
    let truth = truth_axis(truth)?;
    Ok(located(estimate).map(|located| Errors::of(&located, &truth)))
}

/// The errors of a solver's answer on a rod of which nothing but the cylinder is known, its grasp at the axis' reference point; `None`
/// if it gave no axis. Depth counts along the rig's x.
pub fn measure_cylinder(cylinder: &Cylinder, estimate: &Estimate) -> Option<Errors> {
    let truth = TruthAxis {
        axis: cylinder.axis,
        radius_m: cylinder.radius_m,
        grasp_m: cylinder.axis.point_m,
        visible_span_m: [0.0; 2],
        depth_direction: Vec3::x(),
    };
    Some(Errors::of(&located(estimate)?, &truth))
}

/// What the metrics need of a truth record: of the rod to be grasped, its tangent at the grasp.
///
/// # Errors
/// A rig that is none.
pub fn truth_axis(truth: &Truth) -> Result<TruthAxis, RigError> {
    let rod = truth.target();
    let forward = rig_of(truth)?.left.rig_from_camera.direction(&Vec3::z());
    Ok(TruthAxis {
        axis: line(&truth.grasp.axis),
        radius_m: rod.radius_m,
        grasp_m: truth.grasp.point_m.into(),
        visible_span_m: seen_by_both(truth),
        depth_direction: forward,
    })
}

pub(crate) fn rig_of(truth: &Truth) -> Result<Rig, RigError> {
    truth.rig.to_rig(Path::new("truth.json"))
}

pub(crate) fn line(line: &LineTruth) -> Line3 {
    Line3::new(line.point_m.into(), &line.direction.into())
}

/// First and last point of the axis that an eye sees, m from the rod's middle.
pub(crate) fn seen_by(eye: &EyeTruth) -> Option<[f64; 2]> {
    Some([eye.visible_m.first()?[0], eye.visible_m.last()?[1]])
}

/// The span that both eyes see, m along the tangent from the grasp's axis point; the grasp alone where they share nothing.
fn seen_by_both(truth: &Truth) -> [f64; 2] {
    let rod = truth.target();
    let (Some(left), Some(right)) = (seen_by(&rod.left), seen_by(&rod.right)) else {
        return [0.0; 2];
    };
    let span = [left[0].max(right[0]), left[1].min(right[1])];
    let middle: Vec3 = rod.axis.point_m.into();
    let grasp = line(&truth.grasp.axis);
    let grasp_along_m = grasp.direction.dot(&(grasp.point_m - middle));
    if span[0] < span[1] {
        span.map(|s_m| s_m - grasp_along_m)
    } else {
        [0.0; 2]
    }
}

/// What a solver answered, if it gave an axis.
pub fn located(estimate: &Estimate) -> Option<Located> {
    let axis = estimate.axis.as_ref()?;
    Some(Located {
        axis: Line3::new(axis.point_m?.into(), &axis.direction?.into()),
        covariance: axis
            .covariance
            .map(|rows| Matrix6::from_fn(|i, j| rows[i][j])),
        radius_m: estimate.radius_m,
        grasp_m: estimate
            .grasp
            .as_ref()
            .and_then(|grasp| grasp.point_m)
            .map(Into::into),
    })
}
