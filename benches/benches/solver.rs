//! Speed of the methods, the paper's stage by stage, on a synthetic 1080p pair with noise: one thread unless it says "pair".

use std::hint::black_box;

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use rodsight_geometry::{
    Camera, CameraFrame, Cylinder, Distortion, Eye, Image, Intrinsics, Line3, Mat3, MountedCamera,
    Pixel, Pose, Rig, RigFrame, Samples, StereoPair, Vec3,
};
use rodsight_solver::paper::{self, Rule};
use rodsight_solver::{
    EdgePoint, HueWindow, Method, PaperParams, Pick, Request, Roi, solve, solve_all,
};

const WINDOW: HueWindow = HueWindow {
    from_deg: 0.0,
    to_deg: 70.0,
    min_saturation: 0.25,
    min_value: 0.1,
};

fn rig() -> Rig {
    let intrinsics = Intrinsics {
        width_px: 1920,
        height_px: 1080,
        fx_px: 1566.5776,
        fy_px: 1566.5776,
        cx_px: 960.0,
        cy_px: 540.0,
    };
    let camera = Camera::new(intrinsics, Distortion::None).expect("a pinhole is a camera");
    let mounted = |y_m: f64| {
        let axes = Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
        let pose = Pose::<RigFrame, CameraFrame>::new(axes, Vec3::new(0.0, y_m, -1.0));
        MountedCamera::new(camera, pose)
    };
    Rig {
        left: mounted(-0.5),
        right: mounted(0.5),
    }
}

fn rod() -> Cylinder {
    Cylinder {
        axis: Line3::new(Vec3::new(2.3, 0.1, -1.0), &Vec3::new(0.4, 0.3, 1.0)),
        radius_m: 0.05,
    }
}

/// Orange over bluish green, edges a pixel wide, uniform noise of ±3 DN from a counter.
fn image(rig: &Rig, eye: Eye) -> Image {
    let mounted = rig.eye(eye);
    let [a, b, middle] = rod()
        .image_lines(&mounted.camera, &mounted.rig_from_camera)
        .expect("the rod is in view");
    let on_axis = mounted
        .project(&rod().axis.point_m)
        .expect("in front of the cameras");
    let inward = |line: &rodsight_geometry::ImageLine| line.distance_px(&on_axis).signum();
    let (side_a, side_b) = (inward(&a), inward(&b));
    assert!(
        middle.distance_px(&on_axis).abs() < 1e-6,
        "the axis is seen on its line"
    );
    let mut state = 0x2545_F491_u32 ^ (eye as u32 + 1);
    let mut samples = Vec::with_capacity(1920 * 1080 * 3);
    for y in 0..1080 {
        for x in 0..1920 {
            let pixel = Pixel::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let inside = (a.distance_px(&pixel) * side_a).min(b.distance_px(&pixel) * side_b);
            let cover = (inside + 0.5).clamp(0.0, 1.0);
            for (rod, water) in [(217.0, 26.0), (107.0, 82.0), (20.0, 115.0)] {
                state ^= state << 13;
                state ^= state >> 17;
                state ^= state << 5;
                let noise = f64::from(state % 7) - 3.0;
                samples.push((cover * rod + (1.0 - cover) * water + noise) as u8);
            }
        }
    }
    Image::new(1920, 1080, 3, Samples::U8(samples)).expect("the size is right")
}

fn pair() -> StereoPair {
    let rig = rig();
    StereoPair::new(rig, image(&rig, Eye::Left), image(&rig, Eye::Right)).expect("sizes agree")
}

/// 640×700 around the rod.
fn region(eye: Eye) -> Roi {
    let seen = rig()
        .eye(eye)
        .project(&rod().axis.point_m)
        .expect("in front of the cameras");
    Roi {
        x_px: (seen.x as u32 - 320).min(1280),
        y_px: 190,
        width_px: 640,
        height_px: 700,
    }
}

fn stages(criterion: &mut Criterion) {
    let pair = pair();
    let params = PaperParams::default();
    let rule = Rule::Hue {
        window: WINDOW,
        source: paper::HueSource::Given,
    };
    let regions = [
        ("1080p", Roi::whole(&pair.left)),
        ("640x700", region(Eye::Left)),
    ];

    let mut group = criterion.benchmark_group("segmentation");
    for (name, roi) in &regions {
        group.throughput(Throughput::Elements(roi.area_px() as u64));
        group.bench_function(*name, |b| {
            b.iter(|| paper::binarise(black_box(&pair.left), roi, &rule));
        });
    }
    group.finish();

    let mut group = criterion.benchmark_group("canny");
    for (name, roi) in &regions {
        let mask = paper::binarise(&pair.left, roi, &rule);
        group.throughput(Throughput::Elements(roi.area_px() as u64));
        group.bench_function(*name, |b| {
            b.iter(|| paper::canny(black_box(&mask), roi, &params));
        });
    }
    group.finish();

    let (_, whole) = regions[0];
    let edges: Vec<EdgePoint> =
        paper::canny(&paper::binarise(&pair.left, &whole, &rule), &whole, &params);
    let points: Vec<Pixel> = edges.iter().map(|e| e.pixel).collect();
    let mut group = criterion.benchmark_group("hough");
    for (rho_px, theta_deg) in [(2.5, 4.5), (1.0, 1.0), (0.5, 0.25)] {
        let params = PaperParams {
            hough_rho_step_px: rho_px,
            hough_theta_step_deg: theta_deg,
            ..PaperParams::default()
        };
        let votes = points.len() as f64 * 180.0 / theta_deg;
        group.throughput(Throughput::Elements(votes as u64));
        let id = BenchmarkId::new(format!("{rho_px}px"), format!("{theta_deg}deg"));
        group.bench_function(id, |b| b.iter(|| paper::hough(black_box(&points), &params)));
    }
    group.finish();

    let (_, coarse) = paper::hough(&points, &params);
    let mut group = criterion.benchmark_group("refinement");
    group.throughput(Throughput::Elements(points.len() as u64));
    group.bench_function("1080p", |b| {
        b.iter(|| paper::refine(black_box(&edges), &coarse, &params));
    });
    group.finish();
}

fn whole(criterion: &mut Criterion) {
    let pair = pair();
    let pick = rig()
        .left
        .project(&rod().axis.point_m)
        .expect("in front of the cameras");
    let mut request = Request::new(&pair);
    request.pick = Some(Pick {
        pixel: pick,
        eye: Eye::Left,
    });
    for method in [Method::Paper, Method::Joint] {
        let mut group = criterion.benchmark_group(format!("solve {method}"));
        for (name, regions) in [
            ("pair 1080p", None),
            (
                "pair 640x700",
                Some((region(Eye::Left), region(Eye::Right))),
            ),
        ] {
            request.roi_left = regions.map(|(left, _)| left);
            request.roi_right = regions.map(|(_, right)| right);
            let estimate = solve(&request, method, &PaperParams::default());
            let answered = estimate.is_ok_and(|e| e.radius_m.is_some());
            assert!(answered, "a refusal is no benchmark");
            group.bench_function(name, |b| {
                b.iter(|| solve(black_box(&request), method, &PaperParams::default()));
            });
        }
        group.finish();
    }
}

/// How `joint` takes longer as it sees more: regions around the rod, each twice the last, and batches on all threads.
fn growth(criterion: &mut Criterion) {
    let pair = pair();
    let params = PaperParams::default();
    let around = |eye: Eye, width_px: u32, height_px: u32| {
        let Roi { x_px, y_px, .. } = region(eye);
        Some(Roi {
            x_px: (x_px + 320 - width_px / 2).min(1920 - width_px),
            y_px: y_px + 350 - height_px / 2,
            width_px,
            height_px,
        })
    };
    let asked = |width_px: u32, height_px: u32| Request {
        roi_left: around(Eye::Left, width_px, height_px),
        roi_right: around(Eye::Right, width_px, height_px),
        ..Request::new(&pair)
    };
    let mut group = criterion.benchmark_group("joint by region");
    for (width_px, height_px) in [(160, 175), (320, 350), (640, 700), (1280, 1050)] {
        let request = asked(width_px, height_px);
        let estimate = solve(&request, Method::Joint, &params);
        let answered = estimate.is_ok_and(|e| e.radius_m.is_some());
        assert!(answered, "a refusal is no benchmark");
        group.throughput(Throughput::Elements(2 * u64::from(width_px * height_px)));
        let id = format!("{width_px}x{height_px}");
        group.bench_function(id, |b| {
            b.iter(|| solve(black_box(&request), Method::Joint, &params));
        });
    }
    group.finish();

    let batch = vec![asked(640, 700); 16];
    let mut group = criterion.benchmark_group("joint by batch");
    group.throughput(Throughput::Elements(batch.len() as u64));
    group.sample_size(20);
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads start");
        let id = BenchmarkId::new("16 pairs 640x700, threads", threads);
        group.bench_function(id, |b| {
            b.iter(|| pool.install(|| solve_all(black_box(&batch), Method::Joint, &params)));
        });
    }
    group.finish();
}

criterion_group!(benches, stages, whole, growth);
criterion_main!(benches);
