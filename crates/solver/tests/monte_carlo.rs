//! Random rods, half of the scenes with a second rod of the same colour: an answer given as `ok` must be right.

mod common;

use common::{Random, Scene, rod, small_rig};
use rodsight_geometry::{Cylinder, Eye, Line3, Pixel, Vec3};
use rodsight_solver::{Estimate, Method, PaperParams, Pick, Request, Status, solve};

/// One scene with the pick on its first rod; `None` if that is not seen by both eyes.
fn draw(index: usize, random: &mut Random) -> Option<(Scene, Pixel)> {
    let mut within = |low: f64, high: f64| low + (high - low) * random.uniform();
    let at = [within(1.0, 3.0), within(-0.15, 0.15), within(-0.2, 0.2)];
    let direction = [within(-1.0, 1.0), within(-1.0, 1.0), within(-1.0, 1.0)];
    let first = rod(at, direction, within(0.015, 0.115));
    let beside = [
        at[0] + within(0.0, 0.8),
        at[1] + within(-0.8, 0.8),
        at[2] + within(-0.5, 0.5),
    ];
    let direction = [within(-1.0, 1.0), within(-1.0, 1.0), within(-1.0, 1.0)];
    let second = rod(beside, direction, within(0.015, 0.115));
    let mut rods = vec![first];
    if index % 2 == 1 {
        rods.push(second);
    }
    let scene = Scene {
        half_length_m: within(0.4, 1.4),
        samples: 4,
        noise_sigma: [0.0, 0.01, 0.03, 0.06][index % 4],
        seed: index as u64,
        ..Scene::new(&small_rig(), rods)
    };
    let mut seen = Eye::BOTH.into_iter().map(|eye| {
        let mounted = scene.rig.eye(eye);
        let pixel = mounted.project(&first.axis.point_m)?;
        mounted.camera.contains(&pixel).then_some(pixel)
    });
    let (left, _) = (seen.next()??, seen.next()??);
    let (origin, ray) = scene.rig.left.ray(&left)?;
    // The other rod in front would be what the operator picked.
    let hidden = scene.rods[1..]
        .iter()
        .any(|rod| rod.intersect(&origin, &ray).is_some());
    (!hidden).then_some((scene, left))
}

#[test]
fn an_answer_given_as_ok_is_right() {
    let mut random = Random::new(77);
    let (mut total, mut answered) = (0, 0);
    for index in 0..160 {
        let Some((scene, pixel)) = draw(index, &mut random) else {
            continue;
        };
        let truth = scene.rods[0];
        let pair = scene.pair();
        let mut request = Request::new(&pair);
        request.pick = Some(Pick {
            pixel,
            eye: Eye::Left,
        });
        let estimate = solve(&request, Method::PaperBisector, &PaperParams::default()).unwrap();
        total += 1;
        answered += usize::from(estimate.status != Status::Refused);
        if estimate.status != Status::Ok {
            assert!(estimate.reason.is_some());
            continue;
        }
        assert_within(&estimate, &truth, 4.0, index);
    }
    assert!(total > 80, "{total}");
    assert!(answered * 100 > total * 80, "{answered} of {total}");
}

/// The axis is within so many standard deviations of the truth, in depth.
fn assert_within(estimate: &Estimate, truth: &Cylinder, sigmas: f64, index: usize) {
    let axis = estimate.axis.expect("an axis");
    let line = Line3::new(
        axis.point_m.expect("a point").into(),
        &Vec3::from(axis.direction.expect("a direction")),
    );
    let off = line.distance_m(&truth.axis.point_m);
    // Shifts common to both eyes are no depth error: 0.5 px across at the rod's distance.
    let across = 0.5 * truth.axis.point_m.x / 522.0;
    let depth_sigma = estimate.observability.depth_sigma_m.expect("a depth");
    let limit = sigmas * libm::hypot(depth_sigma, across);
    assert!(
        off < limit,
        "{index}: {off} m, limit {limit} m: {estimate:?}"
    );
}

/// One lamp from any side: the rod fades to black before its limb, in front of black or of pale water.
#[test]
fn a_shadow_s_edge_is_no_limb() {
    const BLACK: [f64; 3] = [0.001, 0.002, 0.003];
    const PALE: [f64; 3] = [0.004, 0.03, 0.06];
    let mut random = Random::new(4711);
    let (mut ok, mut faded, mut answered, mut total) = (0, 0, 0, 0);
    for index in 0..96 {
        let Some((mut scene, pixel)) = draw(2 * index, &mut random) else {
            continue;
        };
        // From beside the cameras (x forward) to far to a side.
        let side = core::f64::consts::TAU * random.uniform();
        let angle = 1.3 * random.uniform();
        let across = libm::sin(angle);
        scene.lamps = vec![Vec3::new(
            -libm::cos(angle),
            across * libm::cos(side),
            across * libm::sin(side),
        )];
        scene.rod_colour = [0.7, 0.15, 0.01];
        scene.background = if index % 3 == 0 { PALE } else { BLACK };
        scene.noise_sigma = 0.01;
        let pair = scene.pair();
        let mut request = Request::new(&pair);
        request.pick = Some(Pick {
            pixel,
            eye: Eye::Left,
        });
        for method in [Method::Paper, Method::PaperBisector] {
            let estimate = solve(&request, method, &PaperParams::default()).unwrap();
            let reason = estimate.reason.as_deref().unwrap_or_default();
            total += 1;
            answered += usize::from(estimate.status != Status::Refused);
            faded += usize::from(reason.contains("shadow"));
            if estimate.status == Status::Ok {
                ok += 1;
                assert_within(&estimate, &scene.rods[0], 4.0, index);
            }
        }
    }
    println!("{ok} ok, {faded} faded, {answered} answered of {total}");
    assert!(ok * 10 > total, "{ok} of {total}");
    assert!(faded * 5 > total, "{faded} of {total}");
    assert!(answered * 100 > total * 60, "{answered} of {total}");
}
