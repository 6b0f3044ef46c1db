//! Bad, odd and hostile pictures: an answer, a weaker answer that says so, or a refusal with the reason. Never a panic.

#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use common::{Scene, bisector, offset_m, pick_at, refused, rod, scene, small_rig, truth};
use rodsight_geometry::{Eye, Image, Pixel, Samples, StereoPair};
use rodsight_solver::{
    Estimate, Method, PaperParams, Pick, Request, Roi, SegmentationMode, Status, solve, solve_all,
    solve_traced,
};

#[test]
fn depths_bits_and_colours() {
    for (channels, bits, noise) in [
        (3, 8, 0.0),
        (3, 16, 0.0),
        (1, 8, 0.0),
        (1, 16, 0.01),
        (3, 8, 0.01),
    ] {
        let scene = Scene {
            channels,
            bits,
            noise_sigma: noise,
            ..scene()
        };
        let pair = scene.pair();
        for pick in [
            None,
            Some(pick_at(&scene.rig, Eye::Left, &truth().axis.point_m)),
        ] {
            let mut request = Request::new(&pair);
            request.pick = pick;
            let estimate = bisector(&request);
            assert_eq!(
                estimate.status,
                Status::Ok,
                "{channels} {bits} {pick:?} {:?}",
                estimate.reason
            );
            assert!(offset_m(&estimate, &truth()) < 3e-3);
            let used = estimate.observability.left.segmentation.clone().unwrap();
            assert_eq!(used.starts_with("luminance"), channels == 1, "{used}");
            assert_eq!(estimate.grasp.is_some(), pick.is_some());
            assert_eq!(
                used.contains("no pick"),
                channels == 3 && pick.is_none(),
                "{used}"
            );
        }
    }
}

#[test]
fn luminance_of_a_dark_rod_and_of_a_grey_rod_in_colour() {
    let mut scene = scene();
    scene.rod_colour = [0.05, 0.05, 0.05];
    scene.background = [0.6, 0.6, 0.6];
    let pair = scene.pair();
    let mut request = Request::new(&pair);
    request.pick = Some(pick_at(&scene.rig, Eye::Left, &truth().axis.point_m));
    let estimate = bisector(&request);
    // No hue at all: luminance is used, and that is said.
    assert_eq!(estimate.status, Status::Degraded);
    assert!(
        estimate.reason.as_ref().unwrap().contains("luminance"),
        "{:?}",
        estimate.reason
    );
    assert!(offset_m(&estimate, &truth()) < 3e-3);
    let only_hue = PaperParams {
        segmentation: SegmentationMode::Hue,
        ..PaperParams::default()
    };
    refused(
        &solve(&request, Method::Paper, &only_hue).unwrap(),
        "hue_not_distinct",
    );
    let otsu = PaperParams {
        segmentation: SegmentationMode::Otsu,
        ..PaperParams::default()
    };
    assert_eq!(
        solve(&request, Method::Paper, &otsu).unwrap().status,
        Status::Ok
    );
}

fn filled(value: impl Fn(usize) -> u8) -> Image {
    Image::new(
        640,
        360,
        3,
        Samples::U8((0..640 * 360 * 3).map(value).collect()),
    )
    .unwrap()
}

#[test]
fn blank_and_noise_are_refused() {
    let mut random = common::Random::new(5);
    let noise: Vec<u8> = (0..2 * 640 * 360 * 3)
        .map(|_| random.next() as u8)
        .collect();
    let half = noise.len() / 2;
    let images = [
        [filled(|_| 0), filled(|_| 0)],
        [filled(|_| 255), filled(|_| 255)],
        [
            filled(|i| [20, 90, 120][i % 3]),
            filled(|i| [20, 90, 120][i % 3]),
        ],
        [filled(|i| noise[i]), filled(|i| noise[half + i])],
    ];
    for (k, [left, right]) in images.into_iter().enumerate() {
        let pair = StereoPair::new(small_rig(), left, right).unwrap();
        for pixel in [None, Some(Pixel::new(300.0, 200.0))] {
            let mut request = Request::new(&pair);
            request.pick = pixel.map(|pixel| Pick {
                pixel,
                eye: Eye::Right,
            });
            for segmentation in [
                SegmentationMode::Auto,
                SegmentationMode::Otsu,
                SegmentationMode::Hue,
            ] {
                let params = PaperParams {
                    segmentation,
                    ..PaperParams::default()
                };
                for method in [Method::Paper, Method::PaperBisector] {
                    let estimate = solve(&request, method, &params).unwrap();
                    assert_eq!(estimate.status, Status::Refused, "{k}: {estimate:?}");
                    assert!(estimate.reason.is_some_and(|r| !r.is_empty()));
                }
            }
        }
    }
}

#[test]
fn one_blank_eye_is_refused_and_named() {
    let good = scene().pair();
    let pair = StereoPair::new(
        good.rig,
        good.left.clone(),
        filled(|i| [20, 90, 120][i % 3]),
    )
    .unwrap();
    let mut request = Request::new(&pair);
    request.pick = Some(pick_at(&pair.rig, Eye::Left, &truth().axis.point_m));
    let estimate = bisector(&request);
    refused(&estimate, "no_region");
    assert!(estimate.reason.unwrap().starts_with("right image"));
}

#[test]
fn swapped_images_are_refused() {
    let good = scene().pair();
    let pair = StereoPair::new(good.rig, good.right.clone(), good.left.clone()).unwrap();
    refused(&bisector(&Request::new(&pair)), "behind");
}

#[test]
fn pick_off_the_rod_is_refused() {
    let scene = scene();
    let pair = scene.pair();
    let on = pick_at(&scene.rig, Eye::Left, &truth().axis.point_m);
    for shift in [-150.0, 100.0] {
        let mut request = Request::new(&pair);
        request.pick = Some(Pick {
            pixel: on.pixel + Pixel::new(shift, 0.0),
            eye: Eye::Left,
        });
        let estimate = bisector(&request);
        // Off the rod the pick shows background: either nothing stands out or the rod that does is far away.
        assert_eq!(estimate.status, Status::Refused, "{estimate:?}");
        assert!(estimate.grasp.is_none());
        // With the hue given, the rod is found and the distance named.
        let window = rodsight_solver::HueWindow {
            from_deg: 5.0,
            to_deg: 60.0,
            min_saturation: 0.3,
            min_value: 0.1,
        };
        let params = PaperParams {
            hue_window: Some(window),
            ..PaperParams::default()
        };
        refused(
            &solve(&request, Method::Paper, &params).unwrap(),
            "pick_off_rod",
        );
    }
}

#[test]
fn two_rods_the_pick_chooses_and_without_one_the_doubt_is_told() {
    let near = rod([1.5, -0.12, 0.0], [0.1, 0.2, 1.0], 0.04);
    let far = rod([1.7, 0.2, 0.0], [0.1, 0.2, 1.0], 0.025);
    let scene = Scene::new(&small_rig(), vec![near, far]);
    let pair = scene.pair();
    for eye in Eye::BOTH {
        for truth in [&near, &far] {
            let mut request = Request::new(&pair);
            request.pick = Some(pick_at(&scene.rig, eye, &truth.axis.point_m));
            let estimate = bisector(&request);
            assert_ne!(estimate.status, Status::Refused, "{:?}", estimate.reason);
            assert!(
                offset_m(&estimate, truth) < 4e-3,
                "{eye:?} {}",
                offset_m(&estimate, truth)
            );
        }
    }
    let estimate = bisector(&Request::new(&pair));
    assert_eq!(
        estimate.status,
        Status::Degraded,
        "{:?}",
        estimate.observability
    );
    assert!(estimate.reason.unwrap().contains("another rod"));
}

#[test]
fn two_rods_that_look_alike_are_never_matched_with_confidence() {
    // Equally wide in both images: nothing but the other rod's existence tells that the match may be wrong.
    let near = rod([1.5, -0.12, 0.0], [0.1, 0.2, 1.0], 0.04);
    let far = rod([1.7, 0.2, 0.0], [0.1, 0.2, 1.0], 0.045);
    let scene = Scene::new(&small_rig(), vec![near, far]);
    let pair = scene.pair();
    for eye in Eye::BOTH {
        for truth in [&near, &far] {
            let mut request = Request::new(&pair);
            request.pick = Some(pick_at(&scene.rig, eye, &truth.axis.point_m));
            let estimate = bisector(&request);
            assert_eq!(
                estimate.status,
                Status::Degraded,
                "{:?}",
                estimate.observability
            );
            assert!(estimate.reason.unwrap().contains("another rod"));
        }
    }
}

#[test]
fn noise_sigma_of_a_tenth_never_gives_a_confident_wrong_answer() {
    for seed in 0..6 {
        let scene = Scene {
            noise_sigma: 0.1,
            seed,
            ..scene()
        };
        let pair = scene.pair();
        let mut request = Request::new(&pair);
        request.pick = Some(pick_at(&scene.rig, Eye::Left, &truth().axis.point_m));
        let estimate = bisector(&request);
        if estimate.status != Status::Refused {
            let sigma = estimate.observability.depth_sigma_m.unwrap();
            let off = offset_m(&estimate, &truth());
            assert!(
                off < 4.0 * sigma.max(2e-3),
                "{seed}: {off} {sigma} {:?}",
                estimate.reason
            );
        }
    }
}

#[test]
fn the_same_request_gives_the_same_answer() {
    let scene = Scene {
        noise_sigma: 0.02,
        ..scene()
    };
    let pair = scene.pair();
    let mut request = Request::new(&pair);
    request.pick = Some(pick_at(&scene.rig, Eye::Left, &truth().axis.point_m));
    let first = bisector(&request);
    for _ in 0..4 {
        assert_eq!(bisector(&request), first);
    }
    let other = solve(&request, Method::Paper, &PaperParams::default()).unwrap();
    assert_ne!(other, first, "equality must be able to fail");
}

/// A batch is its requests, in their order, whatever the number of threads; one that makes no sense is an error at its place.
#[test]
fn a_batch_is_its_requests() {
    let pairs = [0.005, 0.01, 0.02].map(|noise_sigma| {
        Scene {
            noise_sigma,
            ..scene()
        }
        .pair()
    });
    let mut requests: Vec<Request<'_>> = pairs.iter().map(Request::new).collect();
    let outside = Roi {
        x_px: 10_000,
        ..Roi::whole(&pairs[0].left)
    };
    requests.insert(
        1,
        Request {
            roi_left: Some(outside),
            ..Request::new(&pairs[0])
        },
    );
    let params = PaperParams::default();
    for method in Method::ALL {
        let one_by_one = |request| solve(request, method, &params).ok();
        let expected: Vec<_> = requests.iter().map(one_by_one).collect();
        assert!(expected[1].is_none() && expected[0] != expected[2]);
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            let found = pool.install(|| solve_all(&requests, method, &params));
            let found: Vec<_> = found.into_iter().map(Result::ok).collect();
            assert_eq!(found, expected, "{method}, {threads} threads");
        }
    }
}

#[test]
fn the_trace_shows_every_stage() {
    let pair = scene().pair();
    let (estimate, trace) =
        solve_traced(&Request::new(&pair), Method::Paper, &PaperParams::default()).unwrap();
    assert_eq!(estimate.status, Status::Ok, "{:?}", estimate.reason);
    let trace = trace.unwrap();
    for eye in [&trace.left, &trace.right] {
        assert_eq!(eye.mask.len(), eye.roi.area_px());
        assert!(eye.mask.iter().all(|m| matches!(m, 0 | 255)));
        assert!(eye.edges.len() > 400 && eye.coarse.len() >= 2);
        assert!(eye.votes.counts.iter().any(|v| *v > 0));
        assert_eq!(eye.refined.len(), 2);
        let limbs = eye.limbs.unwrap();
        let middle = rodsight_solver::paper::average(&limbs);
        assert_eq!(eye.centerline, Some(middle));
    }
}

#[test]
fn json_has_the_contract_and_comes_back() {
    let scene = scene();
    let pair = scene.pair();
    let mut request = Request::new(&pair);
    request.pick = Some(pick_at(&scene.rig, Eye::Left, &truth().axis.point_m));
    let estimate = bisector(&request);
    let json = serde_json::to_value(&estimate).unwrap();
    let mut keys: Vec<&str> = json
        .as_object()
        .unwrap()
        .keys()
        .map(String::as_str)
        .collect();
    keys.sort_unstable();
    assert_eq!(
        keys,
        [
            "axis",
            "centerlines",
            "grasp",
            "method",
            "observability",
            "radius_m",
            "radius_sigma_m",
            "reason",
            "schema",
            "status",
            "timing_ms"
        ]
    );
    assert_eq!(json["status"], "ok");
    assert_eq!(json["method"], "paper-bisector");
    assert!(json["reason"].is_null());
    for key in ["point_m", "direction", "covariance"] {
        assert!(json["axis"][key].is_array());
    }
    for key in ["point_m", "covariance_m2", "paper_point_m"] {
        assert!(json["grasp"][key].is_array());
    }
    assert!(json["centerlines"]["right"]["theta_rad"].is_number());
    assert!(json["timing_ms"]["total"].as_f64().unwrap() > 0.0);
    let back: Estimate = serde_json::from_value(json).unwrap();
    assert_eq!(back.status, estimate.status);
    assert_eq!(back.centerlines.is_some(), estimate.centerlines.is_some());
    // Others may leave out what they do not know.
    let short: Estimate =
        serde_json::from_str(r#"{"method": "theirs", "status": "refused"}"#).unwrap();
    assert_eq!((short.axis, short.schema), (None, 1));
}
