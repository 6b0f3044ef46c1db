//! From the strips of both eyes to the estimate: choice, location, covariance, checks.

use std::time::Instant;

use rodsight_geometry::{Eye, Pixel, Vec3, angle_between, degrees, radians};

use super::choose::{Choice, Chooser};
use super::covariance::{UncertainLimbs, block};
use super::eye::Seen;
use super::locate::{Location, Setting, centerline, grasp, locate};
use super::pair::shortlist;
use super::report::{give_taper, report_eyes, warn_of_limbs};
use super::{PaperParams, Refusal, milliseconds};
use crate::{
    AxisEstimate, Centerlines, Estimate, GraspEstimate, Method, Request, Status, TimingMs,
};

/// Point, direction, depth, radius left, radius right, radius, grasp.
const QUANTITIES: usize = 13;
const DEPTH: usize = 6;
const RADIUS_LEFT: usize = 7;
const RADIUS_RIGHT: usize = 8;
const RADIUS: usize = 9;
const GRASP: usize = 10;

/// The estimate, and the strips it rests on if there are any.
pub(crate) fn answer(
    request: &Request<'_>,
    method: Method,
    params: &PaperParams,
    seen: [&Seen; 2],
) -> (Estimate, Option<Choice>) {
    let mut estimate = Estimate::refused(method.name(), String::new());
    estimate.timing_ms = slower(&seen[0].timing_ms, &seen[1].timing_ms);
    let o = &mut estimate.observability;
    (o.left, o.right) = (seen[0].report.clone(), seen[1].report.clone());
    o.warnings = seen.iter().filter_map(|s| s.warning.clone()).collect();

    let start = Instant::now();
    let choice = choose(request, method, params, seen);
    estimate.timing_ms.pair += milliseconds(start);
    let start = Instant::now();
    let (outcome, choice) = match choice {
        Ok((chooser, choice)) => {
            let outcome = fill(&mut estimate, request, method, params, &chooser, &choice);
            (outcome, Some(choice))
        }
        Err(refusal) => (Err(refusal), None),
    };
    match outcome {
        Ok(()) if estimate.observability.warnings.is_empty() => {
            estimate.status = Status::Ok;
            estimate.reason = None;
        }
        Ok(()) => {
            estimate.status = Status::Degraded;
            estimate.reason = Some(estimate.observability.warnings.join("; "));
        }
        Err(refusal) => {
            estimate.reason = Some(refusal.to_string());
            estimate.observability.refusal = Some(refusal.code().to_owned());
        }
    }
    estimate.timing_ms.locate = milliseconds(start);
    (estimate, choice)
}

fn slower(a: &TimingMs, b: &TimingMs) -> TimingMs {
    TimingMs {
        segment: a.segment.max(b.segment),
        canny: a.canny.max(b.canny),
        hough: a.hough.max(b.hough),
        refine: a.refine.max(b.refine),
        pair: a.pair.max(b.pair),
        locate: 0.0,
        total: 0.0,
    }
}

fn choose<'a>(
    request: &Request<'a>,
    method: Method,
    params: &PaperParams,
    seen: [&Seen; 2],
) -> Result<(Chooser<'a>, Choice), Refusal> {
    for eye in seen {
        if let Some(refusal) = &eye.refusal {
            return Err(refusal.clone());
        }
    }
    let rig = &request.pair.rig;
    let mut lists = Vec::with_capacity(2);
    for (seen, eye) in seen.into_iter().zip(Eye::BOTH) {
        let pick: Option<Pixel> = match &request.pick {
            Some(pick) if pick.eye == eye => {
                let undistorted = rig.eye(eye).camera.undistort(&pick.pixel);
                Some(undistorted.ok_or_else(|| Refusal::PickUnusable {
                    detail: "the lens has no ray there".to_owned(),
                })?)
            }
            _ => None,
        };
        let list = shortlist(&seen.strips, pick.as_ref(), params);
        if let (true, Some(pick)) = (list.is_empty(), &pick) {
            let distances = seen.strips.iter().map(|s| s.distance_px(pick));
            return Err(Refusal::PickOffStrip {
                eye: eye.name(),
                distance_px: distances.fold(f64::MAX, f64::min),
            });
        }
        lists.push(list);
    }
    let pick = match &request.pick {
        Some(pick) => {
            let ray = rig.eye(pick.eye).ray(&pick.pixel);
            Some((
                pick.eye,
                ray.ok_or_else(|| Refusal::PickUnusable {
                    detail: "the lens has no ray there".to_owned(),
                })?,
            ))
        }
        None => None,
    };
    let chooser = Chooser {
        rig,
        method,
        pick,
        prior_radius_m: request.radius.map(|prior| prior.radius_m),
    };
    let choice = chooser
        .choose(&lists[0], &lists[1])
        .ok_or(Refusal::Behind)?;
    Ok((chooser, choice))
}

/// Fills in everything that is known, then says whether that is an answer.
fn fill(
    estimate: &mut Estimate,
    request: &Request<'_>,
    method: Method,
    params: &PaperParams,
    chooser: &Chooser<'_>,
    choice: &Choice,
) -> Result<(), Refusal> {
    let rig = &request.pair.rig;
    let [left, right] = &choice.strips;
    let limbs = [
        [&left.limbs[0], &left.limbs[1]],
        [&right.limbs[0], &right.limbs[1]],
    ];
    report_eyes(estimate, choice);
    warn_of_limbs(estimate, params, choice);

    let uncertain = UncertainLimbs::new(limbs, params);
    let lines = uncertain.lines();
    let line_of = |k: usize, eye| centerline(&rig.eye(eye).camera, &lines[k], method);
    estimate.centerlines = Some(Centerlines {
        left: line_of(0, Eye::Left),
        right: line_of(1, Eye::Right),
    });

    let (_, middle) = chooser.looked_at(left).ok_or(Refusal::Behind)?;
    let setting = Setting {
        rig,
        method,
        pick: chooser.pick.map(|(_, ray)| ray),
        middle,
        radius: None,
    };
    let taper = |estimate: &mut Estimate| {
        // The paper knows no taper: only the bisector's tangent planes give a direction without a second view.
        if method == Method::PaperBisector {
            give_taper(estimate, chooser, &uncertain);
        }
    };
    let parallel = |angle_rad: f64, relative: f64| Refusal::ParallelToBaseline {
        plane_angle_deg: degrees(angle_rad),
        relative_percent: 100.0 * relative.min(9.99),
    };
    let Some(location) = locate(&setting, &lines) else {
        taper(estimate);
        return Err(parallel(0.0, f64::INFINITY));
    };
    let between =
        0.5 * (rig.left.rig_from_camera.origin_m() + rig.right.rig_from_camera.origin_m());
    let depth_m = (location.seen_m - between).norm();
    let o = &mut estimate.observability;
    o.plane_angle_rad = Some(location.plane_angle_rad);
    let to_baseline = angle_between(&location.axis.direction, &rig.baseline());
    o.baseline_angle_rad = Some(to_baseline.min(core::f64::consts::PI - to_baseline));

    // Whether the depth is known at all comes before anything that is derived from it.
    let mut covariance = covariance_of(&uncertain, &setting, &location, &between);
    if method == Method::Paper
        && let Some(covariance) = &mut covariance
    {
        add_averaging_bias(
            covariance,
            &setting,
            &uncertain,
            &location,
            &between,
            Some(&mut o.warnings),
        );
    }
    let depth_sigma = covariance.map_or(f64::INFINITY, |c| c[DEPTH][DEPTH].sqrt());
    let relative = depth_sigma / depth_m;
    o.depth_sigma_m = depth_sigma.is_finite().then_some(depth_sigma);
    let narrow = location.plane_angle_rad < radians(params.min_plane_angle_deg);
    let Some(covariance) =
        covariance.filter(|_| relative <= params.max_relative_depth_sigma && !narrow)
    else {
        taper(estimate);
        return Err(if narrow || location.plane_angle_rad < radians(3.0) {
            parallel(location.plane_angle_rad, relative)
        } else {
            Refusal::DepthUncertain {
                relative_percent: 100.0 * relative.min(9.99),
                limit_percent: 100.0 * params.max_relative_depth_sigma,
            }
        });
    };
    let seen_by_right = rig.right.rig_from_camera.inverse().point(&location.seen_m);
    let seen_by_left = rig.left.rig_from_camera.inverse().point(&location.seen_m);
    if location.seen_along_m <= 0.0 || seen_by_right.z <= 0.0 || seen_by_left.z <= 0.0 {
        return Err(Refusal::Behind);
    }
    o.depth_m = Some(depth_m);
    let [left_m, right_m] = location.radii_m;
    (o.radius_left_m, o.radius_right_m) = (Some(left_m), Some(right_m));
    let mismatch = (left_m - right_m).abs() / location.radius_m;
    let mismatch_sigma = libm::sqrt(
        (covariance[RADIUS_LEFT][RADIUS_LEFT] + covariance[RADIUS_RIGHT][RADIUS_RIGHT]
            - 2.0 * covariance[RADIUS_LEFT][RADIUS_RIGHT])
            .max(0.0),
    ) / location.radius_m;
    if mismatch > params.radius_mismatch_refused.max(3.0 * mismatch_sigma) {
        return Err(Refusal::RadiiDisagree { left_m, right_m });
    }
    if mismatch > params.radius_mismatch_degraded.max(2.0 * mismatch_sigma) {
        o.warnings.push(format!(
            "the radius is {left_m:.4} m by the left eye and {right_m:.4} m by the right"
        ));
    }
    give_location(
        estimate,
        request,
        &setting,
        &uncertain,
        &between,
        (&location, &covariance),
        params,
    )
}

type Covariance = [[f64; QUANTITIES]; QUANTITIES];

/// The point of [`Location`] and all that is computed with it, differentiated together.
fn covariance_of(
    uncertain: &UncertainLimbs<'_>,
    setting: &Setting<'_>,
    nominal: &Location,
    between: &Vec3,
) -> Option<Covariance> {
    uncertain.propagate(|lines| Some(quantities(&locate(setting, lines)?, nominal, between)))
}

fn quantities(l: &Location, nominal: &Location, between: &Vec3) -> [f64; QUANTITIES] {
    let turned = l.axis.direction.dot(&nominal.axis.direction) < 0.0;
    let (p, d) = (
        l.axis.point_m,
        l.axis.direction * if turned { -1.0 } else { 1.0 },
    );
    let depth = (l.seen_m - between).norm() * l.seen_along_m.signum();
    let g = l.grasp_m.or(nominal.grasp_m).unwrap_or(p);
    let [left, right] = l.radii_m;
    let mut all = [0.0; QUANTITIES];
    all[..DEPTH].copy_from_slice(&[p.x, p.y, p.z, d.x, d.y, d.z]);
    all[DEPTH..GRASP].copy_from_slice(&[depth, left, right, l.radius_m]);
    all[GRASP..].copy_from_slice(g.as_slice());
    all
}

/// Averaging (ρ, θ) is biased, by −r²/Z in depth for a rod across the view, and the limbs themselves say by how much: what the
/// bisector makes of them differs by just that. The method stays the paper's, its covariance is honest about it.
fn add_averaging_bias(
    covariance: &mut Covariance,
    setting: &Setting<'_>,
    uncertain: &UncertainLimbs<'_>,
    nominal: &Location,
    between: &Vec3,
    warnings: Option<&mut Vec<String>>,
) {
    let bisector = Setting {
        method: Method::PaperBisector,
        ..*setting
    };
    let Some(other) = locate(&bisector, &uncertain.lines()) else {
        return;
    };
    let (a, b) = (
        quantities(nominal, nominal, between),
        quantities(&other, nominal, between),
    );
    let bias: [f64; QUANTITIES] = core::array::from_fn(|i| a[i] - b[i]);
    if let Some(warnings) = warnings
        && bias[DEPTH].abs() > 3.0 * covariance[DEPTH][DEPTH].sqrt()
    {
        warnings.push(format!(
            "averaging the limbs of so thick a rod puts it about {:.1} mm off in depth; {} does not",
            1e3 * bias[DEPTH].abs(),
            Method::PaperBisector
        ));
    }
    for (row, a) in covariance.iter_mut().zip(&bias) {
        for (entry, b) in row.iter_mut().zip(&bias) {
            *entry += a * b;
        }
    }
}

fn give_location(
    estimate: &mut Estimate,
    request: &Request<'_>,
    setting: &Setting<'_>,
    uncertain: &UncertainLimbs<'_>,
    between: &Vec3,
    (location, covariance): (&Location, &Covariance),
    params: &PaperParams,
) -> Result<(), Refusal> {
    let measured_sigma = covariance[RADIUS][RADIUS].sqrt();
    let mut setting = *setting;
    let mut radius_sigma = measured_sigma;
    if let Some(prior) = &request.radius {
        let prior_sigma = prior.sigma_m.unwrap_or(0.0);
        let off = (location.radius_m - prior.radius_m).abs();
        let limit = 3.0 * libm::hypot(measured_sigma, prior_sigma);
        if off > limit.max(params.radius_mismatch_degraded * prior.radius_m) {
            estimate.observability.warnings.push(format!(
                "the limbs give a radius of {:.4} m, not {:.4} m",
                location.radius_m, prior.radius_m
            ));
        }
        // Inverse variances; a radius without a sigma is exact.
        let measured = measured_sigma * measured_sigma;
        let weight = measured / (measured + prior_sigma * prior_sigma).max(f64::MIN_POSITIVE);
        setting.radius = Some((prior.radius_m, if prior_sigma > 0.0 { weight } else { 1.0 }));
        radius_sigma = prior_sigma * libm::sqrt(if prior_sigma > 0.0 { weight } else { 0.0 });
    }
    let located = locate(&setting, &uncertain.lines()).unwrap_or(*location);
    let direction_sigma: f64 = (3..6).map(|i| covariance[i][i]).sum();
    estimate.observability.direction_sigma_rad = Some(direction_sigma.sqrt());
    if direction_sigma.sqrt() > radians(2.0) {
        estimate.observability.warnings.push(format!(
            "the direction is uncertain by {:.1}°",
            degrees(direction_sigma.sqrt())
        ));
    }
    estimate.axis = Some(AxisEstimate {
        point_m: Some(located.axis.point_m.into()),
        direction: Some(located.axis.direction.into()),
        covariance: Some(block(covariance, 0)),
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
    estimate.observability.pick_gap_m = Some(paper.gap_m);
    let radii = paper.gap_m / located.radius_m;
    if radii > params.pick_max_gap_radii {
        return Err(Refusal::PickOffRod {
            gap_m: paper.gap_m,
            radii,
        });
    }
    let mut grasp_covariance = covariance_of(uncertain, &setting, &located, between);
    if setting.method == Method::Paper
        && let Some(covariance) = &mut grasp_covariance
    {
        add_averaging_bias(covariance, &setting, uncertain, &located, between, None);
    }
    estimate.grasp = Some(GraspEstimate {
        point_m: Some(foot.into()),
        covariance_m2: grasp_covariance.map(|c| block(&c, GRASP)),
        paper_point_m: Some(paper.point_m.into()),
    });
    Ok(())
}
