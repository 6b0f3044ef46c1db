//! What makes no difference to the scene makes none to what `joint` says of it: which eye is called left, a mirror, the gain and the
//! offset of the images. And what makes a difference does.

#![allow(
    clippy::unwrap_used,
    clippy::allow_attributes,
    reason = "a test that cannot go on panics"
)]

mod common;

use common::{Scene, pick_at, rig_of, rod};
use rodsight_geometry::{
    Camera, Cylinder, Distortion, Eye, Image, Intrinsics, Line3, MountedCamera, Pose, Rig, Samples,
    StereoPair, Vec3,
};
use rodsight_solver::{Estimate, Method, PaperParams, Pick, Request, Status, solve};

const WIDTH: u32 = 960;
const HEIGHT: u32 = 540;

fn truth() -> Cylinder {
    rod([1.5, 0.05, 0.0], [0.3, 0.3, 1.0], 0.05)
}

/// Noisy, in 16 bits, so that what is done to the codes loses nothing.
fn pair() -> StereoPair {
    let rig = rig_of(WIDTH, HEIGHT, 1566.5776 / 2.0, Distortion::None);
    let mut scene = Scene::new(&rig, vec![truth()]);
    let lamp = |aside: f64| Vec3::new(-0.5, aside, -0.15).normalize();
    scene.lamps = vec![lamp(-0.9), lamp(0.9)];
    scene.rod_colour = [0.6, 0.3, 0.06];
    scene.background = [0.02, 0.05, 0.08];
    scene.noise_sigma = 0.01;
    let pair = scene.pair();
    let [left, right] = [&pair.left, &pair.right].map(|image| relit(image, |light| light));
    StereoPair::new(pair.rig, left, right).unwrap()
}

/// An image whose linear light is changed, in 16 bits of sRGB.
fn relit(image: &Image, change: impl Fn(f64) -> f64) -> Image {
    let linear = |value: f64| {
        if value <= 0.04045 {
            value / 12.92
        } else {
            libm::pow((value + 0.055) / 1.055, 2.4)
        }
    };
    let encoded = |light: f64| {
        if light <= 0.003_130_8 {
            12.92 * light
        } else {
            1.055 * libm::pow(light, 1.0 / 2.4) - 0.055
        }
    };
    let code = |value: f64| (65535.0 * encoded(change(linear(value)))).round() as u16;
    let codes = match image.samples() {
        Samples::U8(codes) => codes.iter().map(|c| code(f64::from(*c) / 255.0)).collect(),
        Samples::U16(codes) => codes
            .iter()
            .map(|c| code(f64::from(*c) / 65535.0))
            .collect(),
    };
    let (width_px, height_px) = (image.width_px(), image.height_px());
    Image::new(width_px, height_px, image.channels(), Samples::U16(codes)).unwrap()
}

fn answer(pair: &StereoPair, pick: Pick) -> Estimate {
    let request = Request {
        pick: Some(pick),
        ..Request::new(pair)
    };
    let estimate = solve(&request, Method::Joint, &PaperParams::default()).unwrap();
    assert_eq!(estimate.status, Status::Ok, "{:?}", estimate.reason);
    estimate
}

fn picked(pair: &StereoPair) -> Estimate {
    answer(pair, pick_at(&pair.rig, Eye::Left, &truth().axis.point_m))
}

fn axis(estimate: &Estimate) -> Line3 {
    let axis = estimate.axis.unwrap();
    Line3::new(
        axis.point_m.unwrap().into(),
        &axis.direction.unwrap().into(),
    )
}

/// How far apart two axes are at the rod, how far apart the radii, in standard deviations of the first; and by how much the second's is
/// larger, as a share.
fn apart(first: &Estimate, second: &Estimate, line: &Line3) -> [f64; 3] {
    let sigma_m = |estimate: &Estimate| estimate.observability.depth_sigma_m.unwrap();
    let grasp_m = axis(first).foot(&truth().axis.point_m);
    let radii_m = [first, second].map(|estimate| estimate.radius_m.unwrap());
    [
        line.distance_m(&grasp_m) / sigma_m(first),
        (radii_m[1] - radii_m[0]).abs() / first.radius_sigma_m.unwrap(),
        (sigma_m(second) / sigma_m(first) - 1.0).abs(),
    ]
}

/// So little, in all of these.
const LITTLE: f64 = 0.05;
/// Pixels are pooled in bins, which a mirror cuts elsewhere: other noise in each.
const LITTLE_POOLED: f64 = 0.6;

#[track_caller]
fn assert_alike(first: &Estimate, (second, line): (&Estimate, &Line3), most: f64) {
    let apart = apart(first, second, line);
    assert!(apart.iter().all(|apart| *apart < most), "{apart:?}");
}

#[test]
fn it_does_not_matter_which_eye_is_called_left() {
    let pair = pair();
    let rig = Rig {
        left: pair.rig.right,
        right: pair.rig.left,
    };
    let here = picked(&pair);
    let pick = pick_at(&pair.rig, Eye::Left, &truth().axis.point_m);
    let exchanged = StereoPair::new(rig, pair.right, pair.left).unwrap();
    let there = answer(
        &exchanged,
        Pick {
            eye: Eye::Right,
            ..pick
        },
    );
    assert_alike(&here, (&there, &axis(&there)), LITTLE);
}

/// The world in a mirror that swaps port and starboard: y becomes −y, u becomes W − u.
#[test]
fn a_mirror_mirrors() {
    let mirrored = |v: Vec3| Vec3::new(v.x, -v.y, v.z);
    let flipped = |image: &Image| {
        let Samples::U16(codes) = image.samples() else {
            panic!("expected 16 bits");
        };
        let rows = codes.chunks(3 * WIDTH as usize);
        let codes = rows.flat_map(|row| row.chunks(3).rev().flatten().copied());
        Image::new(WIDTH, HEIGHT, 3, Samples::U16(codes.collect())).unwrap()
    };
    // Cameras look straight ahead: their axes stay, and so does the middle of the image.
    let seen = |mounted: &MountedCamera| {
        let pose = mounted.rig_from_camera;
        let i = *mounted.camera.intrinsics();
        let cx_px = f64::from(i.width_px) - i.cx_px;
        let camera = Camera::new(Intrinsics { cx_px, ..i }, Distortion::None).unwrap();
        MountedCamera::new(
            camera,
            Pose::new(*pose.rotation(), mirrored(pose.origin_m())),
        )
    };
    let pair = pair();
    let here = picked(&pair);
    let rig = Rig {
        left: seen(&pair.rig.right),
        right: seen(&pair.rig.left),
    };
    let other = StereoPair::new(rig, flipped(&pair.right), flipped(&pair.left)).unwrap();
    let pick = pick_at(&rig, Eye::Right, &mirrored(truth().axis.point_m));
    let there = answer(&other, pick);
    let line = axis(&there);
    let back = Line3::new(mirrored(line.point_m), &mirrored(line.direction));
    assert_alike(&here, (&there, &back), LITTLE_POOLED);
    // Without the mirror it is elsewhere.
    assert!(apart(&here, &there, &line)[0] > 10.0);
}

#[test]
fn gain_and_offset_of_light_do_not_matter() {
    let pair = pair();
    let here = picked(&pair);
    for (gain, offset) in [(0.5, 0.0), (0.25, 0.0), (1.0, 0.1), (0.6, 0.2)] {
        let [left, right] =
            [&pair.left, &pair.right].map(|image| relit(image, |light| gain * light + offset));
        let there = picked(&StereoPair::new(pair.rig, left, right).unwrap());
        assert_alike(&here, (&there, &axis(&there)), LITTLE);
    }
}

/// A pixel to the side in one eye is seen.
#[test]
fn a_shift_of_a_pixel_does_matter() {
    let pair = pair();
    let here = picked(&pair);
    let Samples::U16(codes) = pair.left.samples() else {
        panic!("expected 16 bits");
    };
    let mut codes = codes.clone();
    codes.rotate_right(3);
    let left = Image::new(WIDTH, HEIGHT, 3, Samples::U16(codes)).unwrap();
    let there = picked(&StereoPair::new(pair.rig, left, pair.right).unwrap());
    assert!(apart(&here, &there, &axis(&there))[0] > 10.0);
}
