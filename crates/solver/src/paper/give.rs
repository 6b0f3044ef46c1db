//! The last steps: whether the radii agree, and what is given out.

use rodsight_geometry::{Vec3, degrees, radians};

use super::covariance::{UncertainLimbs, block};
use super::locate::{Location, Setting, grasp, locate};
use super::quantities::{
    Covariance, DEPTH, GRASP, RADIUS, RADIUS_LEFT, RADIUS_RIGHT, covariance_of,
};
use super::{PaperParams, Refusal};
use crate::{AxisEstimate, Estimate, GraspEstimate, Observability, RadiusPrior};

/// Holds the radius of one eye against that of the other and against the one given beforehand. Returns how many times the
/// standard deviations of the limbs are to be taken, at least `doubt`, and the given radius if it does not contradict.
pub(crate) fn check_radius(
    o: &mut Observability,
    (prior, placed_by_it): (Option<RadiusPrior>, bool),
    location: &Location,
    covariance: &Covariance,
    doubt: f64,
    params: &PaperParams,
) -> Result<(f64, Option<RadiusPrior>), Refusal> {
    let limit = params.radius_mismatch_degraded_sigmas;
    let [left_m, right_m] = location.radii_m;
    let off = (left_m - right_m).abs();
    let variance = covariance[RADIUS_LEFT][RADIUS_LEFT] + covariance[RADIUS_RIGHT][RADIUS_RIGHT]
        - 2.0 * covariance[RADIUS_LEFT][RADIUS_RIGHT];
    let sigmas = off / libm::sqrt(variance.max(f64::MIN_POSITIVE));
    let mut widening = doubt;
    if sigmas > limit {
        if off > params.radius_mismatch_refused * location.radius_m
            || sigmas > params.radius_mismatch_refused_sigmas
        {
            return Err(Refusal::RadiiDisagree { left_m, right_m });
        }
        o.warnings.push(format!(
            "the radius is {left_m:.4} m by the left eye and {right_m:.4} m by the right, {sigmas:.0} sigma apart"
        ));
        widening = widening.max(sigmas);
    }
    // A radius that placed the axis has been used, and agrees with itself.
    let Some(given) = prior.filter(|_| !placed_by_it) else {
        return Ok((widening, None));
    };
    let measured_sigma = widening * libm::sqrt(covariance[RADIUS][RADIUS]);
    let off = (location.radius_m - given.radius_m).abs();
    let sigmas = off / libm::hypot(measured_sigma, given.sigma_m.unwrap_or(0.0));
    if sigmas <= limit {
        return Ok((widening, prior));
    }
    let (measured_m, given_m) = (location.radius_m, given.radius_m);
    if off > params.radius_mismatch_refused * given_m {
        return Err(Refusal::RadiusContradicted {
            measured_m,
            given_m,
        });
    }
    o.warnings.push(format!(
        "the limbs give a radius of {measured_m:.4} m, not {given_m:.4} m, {sigmas:.0} sigma apart: the given one is not used"
    ));
    // Either the given radius or the limbs are wrong, and which is not known.
    Ok((widening * (off / measured_sigma).max(1.0), None))
}

/// Everything the answer is computed from.
pub(crate) struct Found<'a, 'b> {
    pub setting: Setting<'a>,
    pub uncertain: &'a UncertainLimbs<'b>,
    /// Midpoint of the camera centres.
    pub between: Vec3,
    pub location: Location,
    pub prior: Option<RadiusPrior>,
}

impl Found<'_, '_> {
    pub(crate) fn give(
        &self,
        estimate: &mut Estimate,
        params: &PaperParams,
    ) -> Result<(), Refusal> {
        let Self {
            uncertain,
            between,
            location,
            ..
        } = self;
        let without_pick = Setting {
            pick: None,
            ..self.setting
        };
        let covariance = covariance_of(uncertain, &without_pick, location, between, None)
            .ok_or(Refusal::Behind)?;
        let o = &mut estimate.observability;
        o.depth_sigma_m = Some(covariance[DEPTH][DEPTH].sqrt());
        let mut setting = self.setting;
        let mut radius_sigma = covariance[RADIUS][RADIUS].sqrt();
        let mut prior_sigma = 0.0;
        if let Some(prior) = &self.prior {
            prior_sigma = prior.sigma_m.unwrap_or(0.0);
            // Inverse variances; a radius without a sigma is exact.
            let measured = radius_sigma * radius_sigma;
            let weight = if prior_sigma > 0.0 {
                measured / (measured + prior_sigma * prior_sigma).max(f64::MIN_POSITIVE)
            } else {
                1.0
            };
            setting.radius = Some((prior.radius_m, weight));
            radius_sigma = prior_sigma * libm::sqrt(weight);
        }
        let located = locate(&setting, &uncertain.lines()).unwrap_or(*location);
        let direction_sigma: f64 = (3..6).map(|i| covariance[i][i]).sum();
        o.direction_sigma_rad = Some(direction_sigma.sqrt());
        if direction_sigma.sqrt() > radians(2.0) {
            o.warnings.push(format!(
                "the direction is uncertain by {:.1}°",
                degrees(direction_sigma.sqrt())
            ));
        }
        estimate.axis = Some(AxisEstimate {
            point_m: Some(located.axis.point_m.into()),
            direction: Some(located.axis.direction.into()),
            covariance: Some(block(&covariance, 0)),
        });
        estimate.radius_m = Some(located.radius_m);
        estimate.radius_sigma_m = Some(radius_sigma);
        let Some(ray) = &setting.pick else {
            return Ok(());
        };
        let (foot, paper) =
            grasp(&located.axis, located.radius_m, ray).map_err(|error| Refusal::PickUnusable {
                detail: error.to_string(),
            })?;
        o.pick_gap_m = Some(paper.gap_m);
        let radii = paper.gap_m / located.radius_m;
        if radii > params.pick_max_gap_radii {
            return Err(Refusal::PickOffRod {
                gap_m: paper.gap_m,
                radii,
            });
        }
        let grasp_covariance = covariance_of(uncertain, &setting, &located, between, None)
            .and_then(|c| {
                let moved = self.grasp_by_prior(&setting, prior_sigma)?;
                let mut block: [[f64; 3]; 3] = block(&c, GRASP);
                for (row, a) in block.iter_mut().zip(moved.iter()) {
                    for (entry, b) in row.iter_mut().zip(moved.iter()) {
                        *entry += a * b;
                    }
                }
                Some(block)
            });
        estimate.grasp = Some(GraspEstimate {
            point_m: Some(foot.into()),
            covariance_m2: grasp_covariance,
            paper_point_m: Some(paper.point_m.into()),
        });
        Ok(())
    }

    /// How the grasp point moves with one standard deviation of the radius given beforehand.
    fn grasp_by_prior(&self, setting: &Setting<'_>, sigma_m: f64) -> Option<Vec3> {
        let Some((radius_m, weight)) = setting.radius.filter(|_| sigma_m > 0.0) else {
            return Some(Vec3::zeros());
        };
        let at = |radius_m: f64| {
            let setting = Setting {
                radius: Some((radius_m, weight)),
                ..*setting
            };
            locate(&setting, &self.uncertain.lines())?.grasp_m
        };
        let step = sigma_m.min(0.01 * radius_m);
        Some((at(radius_m + step)? - at(radius_m - step)?) * (0.5 * sigma_m / step))
    }
}
