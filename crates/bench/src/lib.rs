//! How far an estimate of a rod is from the truth: each metric a pure function with its unit and definition.
//!
//! [`Errors::of`] takes an [`Located`] and a [`TruthAxis`], both in the rig frame, and answers with every error that can be
//! computed; what was not estimated is `None`, never zero.
//!
//! ```
//! use rodsight_bench::{Errors, Located, TruthAxis};
//! use rodsight_geometry::{Line3, Vec3};
//! let truth = TruthAxis {
//!     axis: Line3::new(Vec3::new(2.0, 0.0, 0.0), &Vec3::y()),
//!     radius_m: 0.05,
//!     grasp_m: Vec3::new(2.0, 0.1, 0.0),
//!     visible_span_m: [-0.5, 0.5],
//!     depth_direction: Vec3::x(),
//! };
//! let estimate = Located::of_axis(Line3::new(Vec3::new(2.003, 0.0, 0.0), &Vec3::y()));
//! let errors = Errors::of(&estimate, &truth);
//! assert!((errors.axis_offset_m - 0.003).abs() < 1e-12);
//! assert_eq!(errors.radius_m, None);
//! ```
//!
//! [`measure`] does the same for a rendered pair's truth record and a solver's answer; [`limit`] says how accurate any method
//! could have been on it, [`limit_of`] on any other, and [`statistics`] sums up many. This crate neither renders nor solves.

mod errors;
mod limit;
mod nees;
mod pair;
pub mod statistics;

pub use errors::{
    Errors, GraspError, Located, SUCCESS_LEVELS, SuccessLevel, TruthAxis, axis_angle_rad,
    axis_offset_m, depth_error_m, grasp_error, max_span_distance_m, radius_error_m,
};
pub use limit::{LimbStretch, Limit, edge_sigma_px, limit, limit_of, step_contrast_to_noise};
pub use nees::{AxisCovariance, Nees, nees};
pub use pair::{located, measure, measure_cylinder, truth_axis};
