//! One door to all methods.

use crate::paper::{self, Centre, PaperParams, Trace};
use crate::{Estimate, Method, Request, SolveError, joint};

/// Locates the rod; `params` are those of the paper's methods.
///
/// # Errors
/// A malformed request or parameter. A rod that cannot be located is a refused [`Estimate`], not an error.
pub fn solve(
    request: &Request<'_>,
    method: Method,
    params: &PaperParams,
) -> Result<Estimate, SolveError> {
    solve_traced(request, method, params).map(|(estimate, _)| estimate)
}

/// As [`solve`], with everything that happened on the way, for pictures: of the paper's methods, which go by stages.
///
/// # Errors
/// As [`solve`].
pub fn solve_traced(
    request: &Request<'_>,
    method: Method,
    params: &PaperParams,
) -> Result<(Estimate, Option<Trace>), SolveError> {
    let centre = match method {
        Method::Paper => Centre::Average,
        Method::PaperBisector => Centre::Bisector,
        Method::Joint => return Ok((joint::solve(request)?, None)),
    };
    let (estimate, trace) = paper::solve(request, centre, params)?;
    Ok((estimate, Some(trace)))
}
