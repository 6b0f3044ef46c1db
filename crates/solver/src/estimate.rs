//! The answer: the stable JSON contract of every method, ours and other teams'.

use rodsight_geometry::ImageLine;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What became of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// Located, and the redundancies of the data agree.
    Ok,
    /// Located, but a check is weak: `reason` says which.
    Degraded,
    /// Not located: `reason` says why. What is known all the same is given.
    Refused,
}

/// Where the rod is, in the rig frame (x forward, y starboard, z down); what is not known is null.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct Estimate {
    /// Version of this format: 1.
    #[serde(default = "schema_version")]
    pub schema: u32,
    /// Name of the method.
    pub method: String,
    /// What became of the request.
    pub status: Status,
    /// Why the status is not `ok`.
    #[serde(default)]
    pub reason: Option<String>,
    /// The centre line.
    #[serde(default)]
    pub axis: Option<AxisEstimate>,
    /// Radius, m.
    #[serde(default)]
    pub radius_m: Option<f64>,
    /// Its standard deviation, m; 0 when it was given as exactly known.
    #[serde(default)]
    pub radius_sigma_m: Option<f64>,
    /// Where to grasp; null without a pick.
    #[serde(default)]
    pub grasp: Option<GraspEstimate>,
    /// The axis as seen in the undistorted images.
    #[serde(default)]
    pub centerlines: Option<Centerlines>,
    /// What the answer rests on.
    #[serde(default)]
    pub observability: Observability,
    /// How long it took; no part of the answer.
    #[serde(default)]
    pub timing_ms: TimingMs,
}

fn schema_version() -> u32 {
    Estimate::SCHEMA
}

/// Equal answers; the time they took is data about the run and does not count.
impl PartialEq for Estimate {
    fn eq(&self, other: &Self) -> bool {
        let Self {
            schema,
            method,
            status,
            reason,
            axis,
            radius_m,
            radius_sigma_m,
            grasp,
            centerlines,
            observability,
            timing_ms: _,
        } = self;
        *schema == other.schema
            && *method == other.method
            && *status == other.status
            && *reason == other.reason
            && *axis == other.axis
            && *radius_m == other.radius_m
            && *radius_sigma_m == other.radius_sigma_m
            && *grasp == other.grasp
            && *centerlines == other.centerlines
            && *observability == other.observability
    }
}

impl Estimate {
    /// The version this code reads and writes.
    pub const SCHEMA: u32 = 1;

    /// Sets the status: refused with a reason and its short name, or else as its warnings are.
    pub(crate) fn conclude(&mut self, outcome: Result<(), (String, &str)>) {
        let o = &mut self.observability;
        (self.status, self.reason) = match outcome {
            Ok(()) if o.warnings.is_empty() => (Status::Ok, None),
            Ok(()) => (Status::Degraded, Some(o.warnings.join("; "))),
            Err((reason, code)) => {
                o.refusal = Some(code.to_owned());
                (Status::Refused, Some(reason))
            }
        };
    }

    /// An answer that says nothing yet but no.
    pub fn refused(method: &str, reason: String) -> Self {
        Self {
            schema: Self::SCHEMA,
            method: method.to_owned(),
            status: Status::Refused,
            reason: Some(reason),
            axis: None,
            radius_m: None,
            radius_sigma_m: None,
            grasp: None,
            centerlines: None,
            observability: Observability::default(),
            timing_ms: TimingMs::default(),
        }
    }
}

/// A straight axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct AxisEstimate {
    /// The foot on the axis of the perpendicular from the midpoint of the two camera centres, m.
    pub point_m: Option<[f64; 3]>,
    /// Unit direction; its component of largest modulus is positive.
    pub direction: Option<[f64; 3]>,
    /// Covariance of (`point_m`, `direction`): m², m, 1.
    pub covariance: Option<[[f64; 6]; 6]>,
}

/// Where to grasp.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct GraspEstimate {
    /// Foot on the axis of the point of the surface that was picked, m.
    pub point_m: Option<[f64; 3]>,
    /// Covariance of `point_m`, m²; the pick is taken as meant.
    pub covariance_m2: Option<[[f64; 3]; 3]>,
    /// The paper's point, eqs (27)–(31): the point of the axis nearest to the pick's ray, m.
    pub paper_point_m: Option<[f64; 3]>,
}

/// The axis in both images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Centerlines {
    /// In the left image.
    pub left: Option<ImageLine>,
    /// In the right image.
    pub right: Option<ImageLine>,
}

/// What an answer rests on: the numbers behind the status.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct Observability {
    /// Short fixed name of the reason of a refusal, for counting.
    pub refusal: Option<String>,
    /// Everything that weakens the answer.
    pub warnings: Vec<String>,
    /// Angle between the two axis planes, rad.
    pub plane_angle_rad: Option<f64>,
    /// Angle between rod and baseline, rad, in [0, π/2].
    pub baseline_angle_rad: Option<f64>,
    /// Distance from the midpoint of the cameras to the axis where it is seen, m.
    pub depth_m: Option<f64>,
    /// Standard deviation of `depth_m`, m.
    pub depth_sigma_m: Option<f64>,
    /// Standard deviation of the direction, rad (root of the trace of its covariance).
    pub direction_sigma_rad: Option<f64>,
    /// Radius by the limbs of the left eye alone, m.
    pub radius_left_m: Option<f64>,
    /// Radius by the limbs of the right eye alone, m.
    pub radius_right_m: Option<f64>,
    /// Score of the second-best rod over that of the best; near 1 the choice is arbitrary.
    pub runner_up_ratio: Option<f64>,
    /// Shortest distance between pick ray and axis, m.
    pub pick_gap_m: Option<f64>,
    /// The left eye.
    pub left: EyeReport,
    /// The right eye.
    pub right: EyeReport,
}

/// What was found in one image.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
pub struct EyeReport {
    /// How rod and background were told apart, in words.
    pub segmentation: Option<String>,
    /// Fraction of the region that was taken for rod, in [0, 1].
    pub mask_fraction: Option<f64>,
    /// Number of edge points.
    pub edges: Option<usize>,
    /// Edge points on the two limbs.
    pub support: Option<[usize; 2]>,
    /// Root mean square distance of those points to their limbs, px.
    pub rms_px: Option<[f64; 2]>,
    /// Length over which the limbs were seen, px.
    pub extent_px: Option<[f64; 2]>,
    /// Fraction of the strip between the limbs that was taken for rod, in [0, 1].
    pub fill: Option<f64>,
    /// How the light rises from each side inwards, the exponent of the distance: 0 lit from that side, ½ from the camera, 1
    /// where the rod fades into its own shadow and the side is no limb. Null where it cannot be told.
    pub softness: Option<[Option<f64>; 2]>,
}

/// Wall-clock times of the stages, ms; where the eyes run side by side, of the slower one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[expect(missing_docs, reason = "the names say it")]
pub struct TimingMs {
    pub segment: f64,
    pub canny: f64,
    pub hough: f64,
    pub refine: f64,
    pub pair: f64,
    pub locate: f64,
    pub total: f64,
}
