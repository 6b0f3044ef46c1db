//! Whether pairs contradict each other: what one by itself shows is elsewhere than all together have it.

use nalgebra::SVector;

use super::covariance::inverted;
use super::pair::Candidate;
use super::refine::{Located, refine};
use super::refusal::Refusal;
use super::shot::Shot;
use super::state::{RADIUS, State};
use crate::Request;

/// What places an axis: shifts and turns.
const PLACES: usize = RADIUS;
/// χ² of them that one pair in a thousand has by chance is a warning, so many times that a refusal.
const WARN: f64 = 18.5;
const REFUSE_TIMES: f64 = 4.0;

/// A pair by itself against all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Astray {
    pair: usize,
    /// How far off it is, in units of its variance.
    chi2: f64,
}

impl Astray {
    /// As a warning or a refusal.
    pub(super) fn told(self, warnings: &mut Vec<String>) -> Result<(), Refusal> {
        let Self { pair, chi2 } = self;
        let number = pair + 1;
        let refusal = Refusal::Astray { number, chi2 };
        if chi2 > REFUSE_TIMES * WARN {
            return Err(refusal);
        }
        warnings.push(refusal.to_string());
        Ok(())
    }
}

/// The first pair that surely shows another rod than all together do; looked for where not all is as it should be.
pub(super) fn astray(
    request: &Request<'_>,
    shots: &[Shot<'_>],
    candidate: &Candidate,
    located: &Located,
) -> Option<Astray> {
    if shots.len() == 1 || located.is_fine() {
        return None;
    }
    let mut pairs = located.shown.iter().zip(&located.fit.pairs);
    pairs.find_map(|(pair, fit)| {
        let strips = match pair.checked_sub(1) {
            None => candidate.strips,
            Some(more) => (*candidate.more.get(more)?)?,
        };
        let alone = Candidate {
            strips,
            more: Vec::new(),
            score: candidate.score,
        };
        let shot = core::slice::from_ref(&shots[*pair]);
        let alone = refine(request, shot, &alone).filter(Located::is_sure)?;
        let chi2 = chi2(&alone, &fit.state)?;
        (chi2 > WARN).then_some(Astray { pair: *pair, chi2 })
    })
}

/// How far off a rod is from what was located.
fn chi2(located: &Located, rod: &State) -> Option<f64> {
    let State {
        cylinder, across, ..
    } = located.fit.state();
    let axis = &cylinder.axis;
    // Where the other is as far along.
    let other = rod.tangent_at(Some(&(axis.point_m, across[0])));
    let other = other.cylinder;
    let direction = other.axis.direction * other.axis.direction.dot(&axis.direction).signum();
    let along_m = (axis.point_m - other.axis.point_m).dot(&axis.direction);
    let there_m = other.axis.point_m + direction * (along_m / direction.dot(&axis.direction));
    let mut off = SVector::<f64, PLACES>::zeros();
    for (k, across) in across.iter().enumerate() {
        off[k] = (there_m - axis.point_m).dot(across);
        off[2 + k] = (direction - axis.direction).dot(across);
    }
    let covariance = located.judgement.covariance;
    let covariance = covariance.fixed_view::<PLACES, PLACES>(0, 0);
    let chi2 = off.dot(&(inverted(&covariance.into_owned())? * off));
    chi2.is_finite().then_some(chi2)
}
