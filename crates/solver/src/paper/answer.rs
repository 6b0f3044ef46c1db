//! From the strips of both eyes to the estimate: choice, location, covariance, checks.

use std::time::Instant;

use rodsight_geometry::{Eye, Pixel, angle_between, degrees, radians};

use super::Centre;
use super::choose::{Choice, Chooser};
use super::covariance::UncertainLimbs;
use super::eye::Seen;
use super::give::{Found, check_radius};
use super::locate::{Setting, centerline, locate};
use super::pair::shortlist;
use super::quantities::{DEPTH, covariance_of};
use super::report::{give_taper, report_eyes, warn_of_limbs};
use super::softness::Shading;
use super::{PaperParams, Refusal, milliseconds};
use crate::{Centerlines, Estimate, Request, TimingMs};

/// Nearer than this to one plane with the baseline a rod whose depth is not known is said to be so, degrees.
const NEAR_BASELINE_DEG: f64 = 5.0;

/// The estimate, and the strips it rests on if there are any.
pub(crate) fn answer(
    request: &Request<'_>,
    centre: Centre,
    params: &PaperParams,
    seen: [&Seen; 2],
) -> (Estimate, Option<Choice>) {
    let mut estimate = Estimate::refused(centre.name(), String::new());
    estimate.timing_ms = slower(&seen[0].timing_ms, &seen[1].timing_ms);
    let o = &mut estimate.observability;
    (o.left, o.right) = (seen[0].report.clone(), seen[1].report.clone());
    o.warnings = seen.iter().filter_map(|s| s.warning.clone()).collect();

    let start = Instant::now();
    let choice = choose(request, centre, params, seen);
    estimate.timing_ms.pair += milliseconds(start);
    let start = Instant::now();
    let (outcome, choice) = match choice {
        Ok((chooser, choice)) => {
            let outcome = fill(&mut estimate, request, centre, params, &chooser, &choice);
            (outcome, Some(choice))
        }
        Err(refusal) => (Err(refusal), None),
    };
    estimate.conclude(outcome.map_err(|refusal| (refusal.to_string(), refusal.code())));
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
    centre: Centre,
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
        centre,
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
    centre: Centre,
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
    let shading = [(0, Eye::Left), (1, Eye::Right)].map(|(k, eye)| {
        let camera = &rig.eye(eye).camera;
        Shading::of(request.image(eye), camera, &choice.strips[k])
    });
    report_eyes(estimate, choice, &shading);
    let picked = request.pick.map(|pick| pick.eye);
    let doubt = warn_of_limbs(estimate, params, choice, &shading, picked);
    let unseen_px = shading.map(|s| s.unseen_px);
    let mut uncertain = UncertainLimbs::new(limbs, params);
    let lines = uncertain.lines();
    let line_of = |k: usize, eye| centerline(&rig.eye(eye).camera, &lines[k], centre);
    estimate.centerlines = Some(Centerlines {
        left: line_of(0, Eye::Left),
        right: line_of(1, Eye::Right),
    });

    let (_, middle) = chooser.looked_at(left).ok_or(Refusal::Behind)?;
    let mut setting = Setting {
        rig,
        centre,
        pick: None,
        middle,
        radius: None,
        by_radius: None,
    };
    let taper = |estimate: &mut Estimate| {
        // The paper knows no taper: only the bisector's tangent planes give a direction without a second view.
        if centre == Centre::Bisector {
            give_taper(estimate, chooser, &uncertain);
        }
    };
    let unobservable = |off_rad: f64, relative: f64| {
        let relative_percent = 100.0 * relative.min(9.99);
        if off_rad < radians(NEAR_BASELINE_DEG) {
            Refusal::ParallelToBaseline {
                off_baseline_deg: degrees(off_rad),
                relative_percent,
            }
        } else {
            Refusal::DepthUncertain {
                relative_percent,
                limit_percent: 100.0 * params.max_relative_depth_sigma,
            }
        }
    };
    let between =
        0.5 * (rig.left.rig_from_camera.origin_m() + rig.right.rig_from_camera.origin_m());
    // Whether the depth is known at all comes before anything that is derived from it.
    let place = |setting: &Setting<'_>, warnings: Option<&mut Vec<String>>| {
        let location = locate(setting, &lines)?;
        let depth_m = (location.seen_m - between).norm();
        let covariance = covariance_of(&uncertain, setting, &location, &between, warnings);
        let depth_sigma = covariance.map_or(f64::INFINITY, |c| c[DEPTH][DEPTH].sqrt());
        let narrow = setting.by_radius.is_none()
            && location.plane_angle_rad < radians(params.min_plane_angle_deg);
        let known = depth_sigma <= params.max_relative_depth_sigma * depth_m && !narrow;
        Some((location, depth_m, depth_sigma, known))
    };
    let o = &mut estimate.observability;
    let by_planes = place(&setting, Some(&mut o.warnings));
    if let Some((location, _, depth_sigma, _)) = &by_planes {
        o.plane_angle_rad = Some(location.plane_angle_rad);
        o.depth_sigma_m = depth_sigma.is_finite().then_some(*depth_sigma);
    }
    let mut placed = by_planes.filter(|(.., known)| *known);
    if let (None, Centre::Bisector, Some(prior)) = (&placed, centre, &request.radius) {
        setting.by_radius = Some((prior.radius_m, prior.sigma_m.unwrap_or(0.0)));
        placed = place(&setting, None).filter(|(.., known)| *known);
        o.warnings.extend(placed.map(|_| {
            "the two eyes do not see the depth of a rod that lies so: it follows from the given radius"
                .to_owned()
        }));
    }
    let found = placed.or(by_planes);
    o.baseline_angle_rad = found.map(|(location, ..)| {
        let angle = angle_between(&location.axis.direction, &rig.baseline());
        angle.min(core::f64::consts::PI - angle)
    });
    let Some((location, depth_m, ..)) = placed else {
        taper(estimate);
        return Err(by_planes.map_or_else(
            || unobservable(0.0, f64::INFINITY),
            |(location, depth_m, sigma, _)| {
                unobservable(location.off_baseline_rad, sigma / depth_m)
            },
        ));
    };
    let seen_by_right = rig.right.rig_from_camera.inverse().point(&location.seen_m);
    let seen_by_left = rig.left.rig_from_camera.inverse().point(&location.seen_m);
    if location.seen_along_m <= 0.0 || seen_by_right.z <= 0.0 || seen_by_left.z <= 0.0 {
        return Err(Refusal::Behind);
    }
    o.depth_m = Some(depth_m);
    let [left_m, right_m] = location.radii_m;
    (o.radius_left_m, o.radius_right_m) = (Some(left_m), Some(right_m));
    // What hides in the shadow is no lack of sight of the whole: it degrades.
    uncertain.hide(unseen_px);
    let covariance =
        covariance_of(&uncertain, &setting, &location, &between, None).ok_or(Refusal::Behind)?;
    let (widening, prior) = check_radius(
        o,
        (request.radius, setting.by_radius.is_some()),
        &location,
        &covariance,
        doubt,
        params,
    )?;
    uncertain.widen(widening);
    let found = Found {
        setting: Setting {
            pick: chooser.pick.map(|(_, ray)| ray),
            ..setting
        },
        uncertain: &uncertain,
        between,
        location,
        prior,
    };
    found.give(estimate, params)
}
