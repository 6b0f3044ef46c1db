//! The paper's chain: stages that can be called one by one, and the chain of them all.
//!
//! Cameras with distortion: edge points are found in the image as taken and then undistorted, so that every line lives in the
//! undistorted image (same focal lengths and principal point). For a pinhole the two are the same.

mod answer;
mod canny;
mod choose;
mod covariance;
mod eye;
mod give;
mod hough;
mod locate;
mod pair;
mod params;
mod quantities;
mod refine;
mod refusal;
mod report;
mod segment;
mod softness;

use std::time::Instant;

use rodsight_geometry::{Eye, ImageLine};

use crate::{Estimate, Method, Request, Roi, SolveError};

pub use canny::{EdgePoint, canny};
pub use eye::undistort;
pub use hough::{VotedLine, Votes, hough, peaks, vote};
pub use locate::average;
pub use pair::{Strip, strips};
pub use params::{HueWindow, PaperParams, SegmentationMode, VoteThreshold};
pub use refine::{Polarity, RefinedLine, refine};
pub use refusal::Refusal;
pub use segment::{Hsv, HueSource, Rule, binarise, learn, majority, segment};

/// Everything that happened on the way, for pictures.
#[derive(Clone, Debug)]
pub struct Trace {
    /// The left eye.
    pub left: EyeTrace,
    /// The right eye.
    pub right: EyeTrace,
}

/// Everything that happened in one eye: the paper's Figure 6.
#[derive(Clone, Debug)]
pub struct EyeTrace {
    /// The region looked at.
    pub roi: Roi,
    /// 0 or 255, shape `[roi.height, roi.width]`.
    pub mask: Vec<u8>,
    /// Canny's points, undistorted (Figure 6 a).
    pub edges: Vec<EdgePoint>,
    /// The accumulator.
    pub votes: Votes,
    /// Its lines, fullest first (Figure 6 b).
    pub coarse: Vec<VotedLine>,
    /// One entry per round of refinement (Figure 6 c, d).
    pub refined: Vec<Vec<RefinedLine>>,
    /// The two sides of the rod, if found.
    pub limbs: Option<[ImageLine; 2]>,
    /// What the method takes for the axis, if found.
    pub centerline: Option<ImageLine>,
}

/// What makes one line of the two limbs of an eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Centre {
    /// The mean of their parameters, as the paper has it.
    Average,
    /// The plane that bisects their tangent planes.
    Bisector,
}

impl Centre {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Average => Method::Paper.name(),
            Self::Bisector => Method::PaperBisector.name(),
        }
    }
}

/// Locates the rod, and tells everything that happened on the way.
///
/// # Errors
/// A malformed request or parameter. A rod that cannot be located is a refused [`Estimate`], not an error.
pub(crate) fn solve(
    request: &Request<'_>,
    centre: Centre,
    params: &PaperParams,
) -> Result<(Estimate, Trace), SolveError> {
    params.validate()?;
    request.validate()?;
    request.refuse_ports()?;
    request.refuse_more()?;
    let start = Instant::now();
    let [left, right] = eye::see_both(request, params);
    let (mut estimate, choice) = answer::answer(request, centre, params, [&left, &right]);
    estimate.timing_ms.total = milliseconds(start);
    let lines = |k: usize| choice.as_ref().map(|c| c.strips[k].lines());
    let trace = Trace {
        left: left.into_trace(&request.pair.rig.eye(Eye::Left).camera, lines(0), centre),
        right: right.into_trace(&request.pair.rig.eye(Eye::Right).camera, lines(1), centre),
    };
    Ok((estimate, trace))
}

fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}
