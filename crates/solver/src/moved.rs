//! More pairs of one rod, each from where the rig went.

use rodsight_geometry::{Mat3, Pose, RigFrame, StereoPair};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::{Request, Roi, SolveError};

/// Rotations are inverted by transposing.
const MOST_SKEW: f64 = 1e-9;

/// How well a move is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MoveSigma {
    /// Standard deviation along each axis, m.
    pub translation_m: f64,
    /// Standard deviation about each axis, rad.
    pub rotation_rad: f64,
}

/// The same rod once more, from where the rig went: what cannot be told from one place can be told from two.
#[derive(Clone, Copy, Debug)]
pub struct MovedPair<'a> {
    /// Images and rig, in the frame of this rig.
    pub pair: &'a StereoPair,
    /// Where this rig is in the frame of the first pair's.
    pub rig_from_moved: Pose<RigFrame, RigFrame>,
    /// Absent: the move is exact.
    pub sigma: Option<MoveSigma>,
    /// Region of the left image; absent: all of it.
    pub roi_left: Option<Roi>,
    /// Region of the right image; absent: all of it.
    pub roi_right: Option<Roi>,
}

impl<'a> MovedPair<'a> {
    /// Whole images, after a move that is known exactly.
    pub fn new(pair: &'a StereoPair, rig_from_moved: Pose<RigFrame, RigFrame>) -> Self {
        Self {
            pair,
            rig_from_moved,
            sigma: None,
            roi_left: None,
            roi_right: None,
        }
    }

    /// Its images as if they were all there is.
    pub(crate) fn alone(&self) -> Request<'a> {
        Request {
            roi_left: self.roi_left,
            roi_right: self.roi_right,
            ..Request::new(self.pair)
        }
    }

    pub(crate) fn validate(&self) -> Result<(), SolveError> {
        self.alone().validate()?;
        let complain = |expected, found: f64| Err(SolveError::Move { expected, found });
        let (r, t) = (
            self.rig_from_moved.rotation(),
            self.rig_from_moved.origin_m(),
        );
        if let Some(found) = t.iter().find(|v| !v.is_finite()) {
            return complain("a translation of finite numbers", *found);
        }
        let off = (r * r.transpose() - Mat3::identity()).norm();
        // `!(…)` refuses NaN too.
        if !(off < MOST_SKEW) || r.determinant() < 0.0 {
            return complain("a rotation, |R Rᵀ − 1| = 0 and no mirror", off);
        }
        let sigmas = self.sigma.map(|s| [s.translation_m, s.rotation_rad]);
        let bad = |v: &f64| !(v.is_finite() && *v >= 0.0);
        match sigmas.into_iter().flatten().find(bad) {
            Some(found) => complain("standard deviations, 0 or more", found),
            None => Ok(()),
        }
    }
}
