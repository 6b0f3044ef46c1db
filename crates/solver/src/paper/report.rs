//! What goes into the estimate beside the location: what each eye saw, what weakens the answer, and the direction that is left
//! when the depth is not known.

use rodsight_geometry::{Eye, radians};

use super::choose::{Choice, Chooser};
use super::covariance::UncertainLimbs;
use super::locate::taper_direction;
use super::{PaperParams, RefinedLine};
use crate::{AxisEstimate, Estimate};

/// The direction by the taper alone, with its sigma, where it says anything.
pub(crate) fn give_taper(
    estimate: &mut Estimate,
    chooser: &Chooser<'_>,
    uncertain: &UncertainLimbs<'_>,
) {
    let Some(nominal) = taper_direction(chooser.rig, &uncertain.lines()) else {
        return;
    };
    let covariance = uncertain.propagate(|lines| {
        let d = taper_direction(chooser.rig, lines)?;
        let d = if d.dot(&nominal) < 0.0 { -d } else { d };
        Some([d.x, d.y, d.z])
    });
    let Some(covariance) = covariance else { return };
    let sigma = (0..3).map(|i| covariance[i][i]).sum::<f64>().sqrt();
    // A direction known to no better than this is not known.
    if sigma > radians(10.0) {
        return;
    }
    estimate.observability.direction_sigma_rad = Some(sigma);
    let sign = if nominal[nominal.iamax()] < 0.0 {
        -1.0
    } else {
        1.0
    };
    estimate.axis = Some(AxisEstimate {
        direction: Some((nominal * sign).into()),
        ..AxisEstimate::default()
    });
}

pub(crate) fn report_eyes(estimate: &mut Estimate, choice: &Choice) {
    let o = &mut estimate.observability;
    o.runner_up_ratio = Some(choice.runner_up_ratio);
    for (strip, report) in choice.strips.iter().zip([&mut o.left, &mut o.right]) {
        let of = |f: fn(&RefinedLine) -> f64| [f(&strip.limbs[0]), f(&strip.limbs[1])];
        report.support = Some([strip.limbs[0].support, strip.limbs[1].support]);
        report.rms_px = Some(of(RefinedLine::rms_px));
        report.extent_px = Some(of(RefinedLine::extent_px));
        report.fill = Some(strip.fill);
    }
}

pub(crate) fn warn_of_limbs(estimate: &mut Estimate, params: &PaperParams, choice: &Choice) {
    let warnings = &mut estimate.observability.warnings;
    if choice.runner_up_ratio > params.runner_up_degraded {
        warnings.push(format!(
            "another rod fits almost as well ({:.0} % of the score): pick one",
            100.0 * choice.runner_up_ratio
        ));
    }
    for (strip, eye) in choice.strips.iter().zip(Eye::BOTH) {
        let limbs = || strip.limbs.iter();
        let eye = eye.name();
        if limbs().any(|l| l.support < 2 * params.min_support) {
            warnings.push(format!(
                "{eye} image: a side of the rod has few edge points"
            ));
        }
        if limbs().any(|l| l.rms_px() > 0.65 * params.max_rms_px) {
            warnings.push(format!("{eye} image: a side of the rod is ragged or bent"));
        }
        if limbs().any(|l| l.moved_px > params.refine_threshold_px) {
            warnings.push(format!(
                "{eye} image: the refinement had not settled, allow more rounds"
            ));
        }
        if strip.fill < 0.5 * (1.0 + params.min_fill) {
            warnings.push(format!(
                "{eye} image: only {:.0} % between the sides looks like the rod",
                100.0 * strip.fill
            ));
        }
    }
}
