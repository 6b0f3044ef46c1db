//! From a fitted rod to the answer: what is given out, and whether it may be.

use nalgebra::{SMatrix, SVector};
use rodsight_geometry::{Eye, PaperGrasp, Vec3, angle_between, surface_foot};

use super::climb::Fits;
use super::judge::Judgement;
use super::limbs::Limb;
use super::refine::{Located, MOST_MISS_RADII, is_enough};
use super::refusal::Refusal;
use super::state::{RADIUS, ROD, State};
use crate::{AxisEstimate, Centerlines, Estimate, GraspEstimate, Request};

/// Where a depth is worth nothing.
const MOST_RELATIVE_DEPTH_SIGMA: f64 = 0.1;
/// Nearer to the baseline than this, rad, a rod whose depth is not known is said to be so.
const NEAR_BASELINE_RAD: f64 = 0.1;
/// Shares of the rows that do not look as a rod's: a warning, and a refusal.
const WARN_HIDDEN: f64 = 0.25;
const MOST_HIDDEN: f64 = 0.6;
/// So many limbs of a pair from which light rises softly are a warning.
const MOST_FADED: usize = 1;
/// Redundancies that disagree by more than one rod in a thousand by chance are a warning, by so many times that a refusal.
const WARN_NORMAL: f64 = 3.09;
const REFUSE_TIMES: f64 = 12.0;
/// A given radius may be off by so many standard deviations from what the limbs show.
const MOST_RADIUS_OFF: f64 = 4.0;

/// Fills in what a fit says, or says why it is no answer.
pub(super) fn give(
    request: &Request<'_>,
    estimate: &mut Estimate,
    Located {
        fit,
        judgement,
        prior,
        limbs,
        faded,
        ..
    }: &Located,
) -> Result<(), Refusal> {
    let rig = &request.pair.rig;
    let ray = request
        .pick
        .and_then(|pick| rig.eye(pick.eye).ray(&pick.pixel));
    let state = &fit.state().tangent_at(ray.as_ref());
    let mut cylinder = state.cylinder;
    if cylinder.axis.direction[cylinder.axis.direction.iamax()] < 0.0 {
        cylinder.axis.direction = -cylinder.axis.direction;
    }
    let between =
        0.5 * (rig.left.rig_from_camera.origin_m() + rig.right.rig_from_camera.origin_m());
    let depth_m = (state.cylinder.axis.point_m - between).norm();
    let towards = (state.cylinder.axis.point_m - between) / depth_m;
    // Point, direction, grasp by the rod's parameters.
    let quantities = |state: &State| -> Option<SVector<f64, 9>> {
        let mut all = SVector::<f64, 9>::zeros();
        let state = state.tangent_at(ray.as_ref());
        let axis = &state.cylinder.axis;
        let turned = axis.direction.dot(&cylinder.axis.direction).signum();
        all.fixed_rows_mut::<3>(0).copy_from(&axis.foot(&between));
        all.fixed_rows_mut::<3>(3)
            .copy_from(&(axis.direction * turned));
        if let Some((from_m, along)) = &ray {
            let foot = surface_foot(&state.cylinder, from_m, along);
            let paper = || PaperGrasp::new(axis, from_m, along).map(|grasp| grasp.point_m);
            let grasp = foot.or_else(|| paper().ok())?;
            all.fixed_rows_mut::<3>(6).copy_from(&grasp);
        }
        Some(all)
    };
    let covariance = &judgement.covariance;
    let mut jacobian = SMatrix::<f64, 9, ROD>::zeros();
    for k in 0..ROD {
        let mut step = SVector::zeros();
        step[k] = 0.1 * covariance[(k, k)].max(0.0).sqrt().clamp(1e-9, 1e-3);
        let [more, less] = [step, -step].map(|step| quantities(&fit.state().moved(&step)));
        let change = more.ok_or(Refusal::Lost)? - less.ok_or(Refusal::Lost)?;
        jacobian.set_column(k, &(change / (2.0 * step[k])));
    }
    let all = jacobian * covariance * jacobian.transpose();
    let here = quantities(fit.state()).ok_or(Refusal::Lost)?;
    let o = &mut estimate.observability;
    // Of the reference point, which the images see, along the line of sight.
    let of_point = |k: usize| state.across[k].dot(&towards);
    let depth_variance: f64 = (0..2)
        .flat_map(|i| (0..2).map(move |j| (i, j)))
        .map(|(i, j)| of_point(i) * of_point(j) * covariance[(i, j)])
        .sum();
    let depth_sigma_m = depth_variance.max(0.0).sqrt();
    o.depth_m = Some(depth_m);
    o.depth_sigma_m = Some(depth_sigma_m);
    let direction_sigma: f64 = (3..6).map(|i| all[(i, i)]).sum();
    o.direction_sigma_rad = Some(direction_sigma.max(0.0).sqrt());
    let angle = angle_between(&cylinder.axis.direction, &rig.baseline());
    let angle = angle.min(core::f64::consts::PI - angle);
    o.baseline_angle_rad = Some(angle);
    let line = |eye: Eye| {
        let mounted = rig.eye(eye);
        if mounted.port.is_some() {
            return None;
        }
        let lines = cylinder.image_lines(&mounted.camera, &mounted.rig_from_camera)?;
        Some(lines[2])
    };
    estimate.centerlines = Some(Centerlines {
        left: line(Eye::Left),
        right: line(Eye::Right),
    });
    let direction: [f64; 3] = cylinder.axis.direction.into();
    let relative_percent = 100.0 * depth_sigma_m / depth_m;
    if !(depth_sigma_m <= MOST_RELATIVE_DEPTH_SIGMA * depth_m) {
        estimate.axis = Some(AxisEstimate {
            direction: Some(direction),
            ..AxisEstimate::default()
        });
        return Err(if angle < NEAR_BASELINE_RAD {
            Refusal::ParallelToBaseline
        } else {
            Refusal::DepthUncertain { relative_percent }
        });
    }
    if let (Some((seen_m, sigma_m)), Some(prior)) = (judgement.seen_radius, prior) {
        let off = (seen_m - prior.radius_m) / libm::hypot(sigma_m, prior.sigma_m);
        if off.abs() > MOST_RADIUS_OFF {
            return Err(Refusal::RadiusContradicts {
                given_mm: 1e3 * prior.radius_m,
                seen_mm: 1e3 * seen_m,
                sigma_mm: 1e3 * sigma_m,
            });
        }
    }
    check(&mut o.warnings, fit, judgement)?;
    check_limbs(&mut o.warnings, limbs, prior.is_some())?;
    if faded.iter().any(|faded| *faded >= MOST_FADED) {
        let faded: usize = faded.iter().sum();
        o.warnings.push(format!(
            "light rises softly from {faded} of the {} limbs, as one lamp near the cameras makes it: they may lie farther out",
            number(limbs)
        ));
    }
    estimate.axis = Some(AxisEstimate {
        point_m: Some(here.fixed_rows::<3>(0).into_owned().into()),
        direction: Some(direction),
        covariance: Some(core::array::from_fn(|i| {
            core::array::from_fn(|j| all[(i, j)])
        })),
    });
    // Of the radius that is known exactly there is nothing to be found.
    let exact = request.radius.filter(|prior| prior.sigma_m.is_none());
    let sigma_m = covariance[(RADIUS, RADIUS)].max(0.0).sqrt();
    estimate.radius_m = Some(exact.map_or(cylinder.radius_m, |exact| exact.radius_m));
    estimate.radius_sigma_m = Some(match (exact, prior) {
        (Some(_), _) => 0.0,
        (None, Some(prior)) => prior.sigma_m.min(sigma_m),
        (None, None) => sigma_m,
    });
    let Some((from_m, along)) = ray else {
        return Ok(());
    };
    let paper = PaperGrasp::new(&cylinder.axis, &from_m, &along).map_err(|error| {
        Refusal::PickUnusable {
            detail: error.to_string(),
        }
    })?;
    o.pick_gap_m = Some(paper.gap_m);
    let radii = paper.gap_m / cylinder.radius_m;
    if radii > 1.0 + MOST_MISS_RADII {
        return Err(Refusal::PickOffRod {
            gap_m: paper.gap_m,
            radii,
        });
    }
    let foot = surface_foot(&cylinder, &from_m, &along).unwrap_or(paper.point_m);
    estimate.grasp = Some(GraspEstimate {
        point_m: Some(foot.into()),
        covariance_m2: Some(core::array::from_fn(|i| {
            core::array::from_fn(|j| all[(6 + i, 6 + j)])
        })),
        paper_point_m: Some(Vec3::into(paper.point_m)),
    });
    Ok(())
}

/// Whether pixels and limbs agree with one straight round rod; what is weak is a warning.
fn check(warnings: &mut Vec<String>, fit: &Fits, judgement: &Judgement) -> Result<(), Refusal> {
    let (chi2, redundancies) = (judgement.chi2, judgement.redundancies);
    let usual = chi2_quantile(redundancies, WARN_NORMAL);
    if chi2 > REFUSE_TIMES * usual {
        return Err(Refusal::Contradiction { chi2, redundancies });
    }
    if chi2 > usual {
        warnings.push(format!(
            "the limbs agree badly with one rod (χ² = {chi2:.0} of {redundancies} redundancies)"
        ));
    }
    if !fit.converged {
        return Err(Refusal::Restless);
    }
    let hidden = 1.0 - fit.rows_kept;
    if hidden > MOST_HIDDEN {
        return Err(Refusal::Misfit {
            percent: 100.0 * hidden,
        });
    }
    if hidden > WARN_HIDDEN {
        warnings.push(format!(
            "{:.0} % of the limbs are not those of a straight round rod: hidden, overgrown or bent",
            100.0 * hidden
        ));
    }
    Ok(())
}

/// The quantile of χ² at a quantile of the normal distribution (Wilson, Hilferty 1931).
fn chi2_quantile(freedoms: usize, normal: f64) -> f64 {
    let n = freedoms.max(1) as f64;
    let part = 2.0 / (9.0 * n);
    let root = 1.0 - part + normal * part.sqrt();
    n * root * root * root
}

/// Whether the limbs that are seen place the rod.
fn check_limbs(
    warnings: &mut Vec<String>,
    limbs: &[[[Limb; 2]; 2]],
    is_radius_known: bool,
) -> Result<(), Refusal> {
    let all = || limbs.iter().flatten().flatten();
    let count = |which| all().filter(|limb| **limb == which).count();
    let number = number(limbs);
    let (unseen, soft) = (count(Limb::Unseen), count(Limb::Soft));
    if !is_enough(limbs, is_radius_known) {
        return Err(Refusal::Unseen {
            number,
            unseen,
            soft,
        });
    }
    for (pair, limbs) in limbs.iter().enumerate() {
        if !limbs.iter().flatten().any(|limb| *limb == Limb::Seen) {
            warnings.push(format!(
                "pair {} shows no limb where the others put the rod: is its move right?",
                pair + 1
            ));
        }
    }
    if unseen > 0 {
        warnings.push(format!(
            "{unseen} of the {number} limbs not seen: the others place the rod"
        ));
    }
    if soft > 0 {
        warnings.push(format!(
            "{soft} of the {number} limbs lost in the rod's own shadow: the others place the rod"
        ));
    }
    Ok(())
}

/// How many limbs there are, in words.
fn number(limbs: &[[[Limb; 2]; 2]]) -> String {
    match limbs.len() {
        1 => "four".to_owned(),
        pairs => (4 * pairs).to_string(),
    }
}
