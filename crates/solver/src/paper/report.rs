//! What goes into the estimate beside the location: what each eye saw, what weakens the answer, and the direction that is left
//! when the depth is not known.

use rodsight_geometry::{Eye, radians};

use super::choose::{Choice, Chooser};
use super::covariance::UncertainLimbs;
use super::locate::taper_direction;
use super::softness::Shading;
use super::{PaperParams, RefinedLine};
use crate::{AxisEstimate, Estimate};

/// A bow of more than this is worth a word, px; the covariance has it from less.
const BOW_TOLD_PX: f64 = 1.0;

/// Standard deviations of limbs that a check doubts are taken so many times.
const DOUBT: f64 = 3.0;

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

pub(crate) fn report_eyes(estimate: &mut Estimate, choice: &Choice, shading: &[Shading; 2]) {
    let o = &mut estimate.observability;
    o.runner_up_ratio = Some(choice.runner_up_ratio);
    for ((strip, report), shading) in choice
        .strips
        .iter()
        .zip([&mut o.left, &mut o.right])
        .zip(shading)
    {
        report.softness = Some(shading.softness);
        let of = |f: fn(&RefinedLine) -> f64| [f(&strip.limbs[0]), f(&strip.limbs[1])];
        report.support = Some([strip.limbs[0].support, strip.limbs[1].support]);
        report.rms_px = Some(of(RefinedLine::rms_px));
        report.extent_px = Some(of(RefinedLine::extent_px));
        report.fill = Some(strip.fill);
    }
}

/// Writes down what weakens the limbs; how many times their standard deviations are to be taken for it.
pub(crate) fn warn_of_limbs(
    estimate: &mut Estimate,
    params: &PaperParams,
    choice: &Choice,
    shading: &[Shading; 2],
    picked: Option<Eye>,
) -> f64 {
    let mut doubt = if estimate.observability.warnings.is_empty() {
        1.0
    } else {
        DOUBT
    };
    let warnings = &mut estimate.observability.warnings;
    if choice.runner_up_ratio > params.runner_up_degraded {
        let percent = 100.0 * choice.runner_up_ratio;
        warnings.push(match picked {
            None => format!(
                "another rod fits almost as well ({percent:.0} % of the score): pick one"
            ),
            Some(eye) => format!(
                "another rod fits almost as well ({percent:.0} % of the score): the match in the {} image is in doubt, give a region there",
                other(eye).name()
            ),
        });
        doubt = DOUBT;
    }
    for ((strip, eye), shading) in choice.strips.iter().zip(Eye::BOTH).zip(shading) {
        let limbs = || strip.limbs.iter();
        let eye = eye.name();
        let mut warn = |told: bool, text: String, factor: f64| {
            if told {
                warnings.push(format!("{eye} image: {text}"));
                doubt = doubt.max(factor);
            }
        };
        warn(
            shading.fades(),
            "a side of the rod fades into its own shadow, the limb may lie beyond".to_owned(),
            1.0,
        );
        warn(
            shading.is_strange(),
            "something else lies along a side of the rod".to_owned(),
            DOUBT,
        );
        warn(
            limbs().any(|l| l.support < 2 * params.min_support),
            "a side of the rod has few edge points".to_owned(),
            1.0,
        );
        warn(
            limbs().any(|l| l.rms_px() > 0.65 * params.max_rms_px),
            "a side of the rod is ragged or bent".to_owned(),
            DOUBT,
        );
        warn(
            limbs().any(|l| l.is_bent() && l.sagitta_px.abs() > BOW_TOLD_PX),
            format!(
                "a side of the rod is bent, by {:.1} px",
                limbs().map(|l| l.sagitta_px.abs()).fold(0.0, f64::max)
            ),
            1.0,
        );
        warn(
            limbs().any(|l| l.moved_px > params.refine_threshold_px),
            "the refinement had not settled, allow more rounds".to_owned(),
            DOUBT,
        );
        warn(
            strip.fill < 0.5 * (1.0 + params.min_fill),
            format!(
                "only {:.0} % between the sides looks like the rod",
                100.0 * strip.fill
            ),
            DOUBT,
        );
    }
    doubt
}

fn other(eye: Eye) -> Eye {
    match eye {
        Eye::Left => Eye::Right,
        Eye::Right => Eye::Left,
    }
}
