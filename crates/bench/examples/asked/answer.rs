//! What a method answered, and how far off that is.

use rodsight_bench::{Errors, Nees, located, measure_cylinder, statistics::is_wrong};
use rodsight_geometry::{Cylinder, StereoPair, degrees};
use rodsight_solver::{
    Estimate, Method, MovedPair, PaperParams, Request, SolveError, Status, solve,
};

use super::Asked;

/// An answer and its errors, if it gave an axis and there is a rod.
pub(crate) struct Answer {
    pub(crate) seed: u64,
    pub(crate) estimate: Estimate,
    pub(crate) errors: Option<Errors>,
    /// How far off the axis is claimed to be at the true grasp, m.
    pub(crate) claimed_offset_m: Option<f64>,
    has_rod: bool,
}

impl Answer {
    /// Solves a pair; `target` is the rod with its grasp as the axis' reference point, if there is one.
    pub(crate) fn of(
        seed: u64,
        asked: &Asked,
        target: Option<&Cylinder>,
        pair: &StereoPair,
        method: Method,
    ) -> Result<Self, SolveError> {
        Self::of_all(seed, asked, target, (pair, &[]), method)
    }

    /// Solves more pairs.
    pub(crate) fn of_all(
        seed: u64,
        asked: &Asked,
        target: Option<&Cylinder>,
        (pair, more): (&StereoPair, &[MovedPair<'_>]),
        method: Method,
    ) -> Result<Self, SolveError> {
        let request = Request {
            more,
            ..asked.of(pair)
        };
        let estimate = solve(&request, method, &PaperParams::default())?;
        let errors = target.and_then(|target| measure_cylinder(target, &estimate));
        let claimed_offset_m =
            target.and_then(|target| located(&estimate)?.claimed_offset_m(&target.axis.point_m));
        Ok(Self {
            seed,
            errors,
            claimed_offset_m,
            has_rod: target.is_some(),
            estimate,
        })
    }

    pub(crate) fn status(&self) -> Status {
        self.estimate.status
    }

    /// Whether there is something to answer, or an answer all the same: that nothing was found where nothing is costs no coverage.
    pub(crate) fn counts(&self) -> bool {
        self.has_rod || self.is_answered()
    }

    pub(crate) fn is_answered(&self) -> bool {
        self.status() != Status::Refused
    }

    /// Errors of an answer that is not refused.
    pub(crate) fn answered(&self) -> Option<&Errors> {
        self.errors.as_ref().filter(|_| self.is_answered())
    }

    pub(crate) fn offset_mm(&self) -> Option<f64> {
        Some(1e3 * self.answered()?.axis_offset_m)
    }

    pub(crate) fn angle_deg(&self) -> Option<f64> {
        Some(degrees(self.answered()?.axis_angle_rad))
    }

    pub(crate) fn radius_error_mm(&self) -> Option<f64> {
        Some(1e3 * self.answered()?.radius_m?)
    }

    pub(crate) fn nees(&self) -> Option<Nees> {
        self.answered()?.nees
    }

    /// Whether it is farther off than it may be, or of a rod that is not there. A method that claims nothing is never wrong.
    pub(crate) fn is_wrong(&self) -> bool {
        let is_invented = self.is_answered() && !self.has_rod;
        is_invented || self.nees().is_some_and(|nees| is_wrong(&nees))
    }

    /// Short fixed name of the reason of a refusal.
    pub(crate) fn reason_code(&self) -> &str {
        let code = self.estimate.observability.refusal.as_deref();
        code.unwrap_or_default()
    }
}

/// As in files.
pub(crate) fn status_name(status: Status) -> &'static str {
    match status {
        Status::Ok => "ok",
        Status::Degraded => "degraded",
        Status::Refused => "refused",
    }
}
