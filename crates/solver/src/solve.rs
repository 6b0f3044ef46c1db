//! One door to all methods.

use rayon::prelude::*;

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

/// As [`solve`] of each, in their order and the same whatever the number of threads, as many at once as rayon has.
///
/// A pair's images are borrowed: thousands of pairs are solved as they are read, some hundred at a time.
pub fn solve_all(
    requests: &[Request<'_>],
    method: Method,
    params: &PaperParams,
) -> Vec<Result<Estimate, SolveError>> {
    let requests = requests.par_iter();
    requests
        .map(|request| solve(request, method, params))
        .collect()
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
