//! Pairs that this program did not render: polygons drawn by another library, limbs projected by the few lines of maths here,
//! and calibrations in three formats. Nothing but files goes in.

use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageBuffer, Luma, Rgb};
use rodsight_geometry::{Mat3, Vec3};
use rodsight_testkit::SplitMix64;
use serde_json::Value;
use tiny_skia::{Color, FillRule, Paint, PathBuilder, Pixmap, Transform};

use crate::harness::{folder, rodsight, text, vector};

/// Methods, and how far apart the same answer by two files may be, m and 1: closed forms keep the digits of a file, and climbs to one
/// summit from places a rounding apart come to rest near it.
const METHODS: [(&str, f64); 2] = [("paper-bisector", 1e-8), ("joint", 1e-5)];

const SIZE: (u32, u32) = (800, 600);
/// Focal lengths and principal point of both eyes, px from the corner.
const FX: f64 = 700.0;
const FY: f64 = 704.0;
const CX: f64 = 396.3;
const CY: f64 = 305.8;

/// The rod, in the rig frame.
const RADIUS_M: f64 = 0.05;
fn axis() -> (Vec3, Vec3) {
    (
        Vec3::new(2.0, 0.05, -0.8),
        Vec3::new(0.25, -0.2, 1.0).normalize(),
    )
}

/// A camera: `x_rig = R x_camera + t`.
struct Mount {
    rotation: Mat3,
    centre_m: Vec3,
}

/// Vehicle axes of camera axes, then pitched down and turned by a little.
fn mounts() -> [Mount; 2] {
    let axes = Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let turned = |pitch: f64, yaw: f64| {
        let (s, c) = libm::sincos(pitch);
        let about_y = Mat3::new(c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c);
        let (s, c) = libm::sincos(yaw);
        let about_z = Mat3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
        about_z * about_y * axes
    };
    [
        Mount {
            rotation: turned(-0.10, 0.04),
            centre_m: Vec3::new(0.3, -0.25, -1.1),
        },
        Mount {
            rotation: turned(-0.11, -0.05),
            centre_m: Vec3::new(0.31, 0.27, -1.12),
        },
    ]
}

/// Where a camera sees a point, px from the corner.
fn project(mount: &Mount, point_m: &Vec3) -> [f64; 2] {
    let p = mount.rotation.transpose() * (point_m - mount.centre_m);
    [FX * p.x / p.z + CX, FY * p.y / p.z + CY]
}

/// The strip between the limbs, far beyond the image at both ends.
fn strip(mount: &Mount) -> [[f64; 2]; 4] {
    let (point_m, d) = axis();
    let to_axis = point_m - mount.centre_m;
    let q = to_axis - d * d.dot(&to_axis);
    let (distance, p) = (q.norm(), q.normalize());
    let sin = RADIUS_M / distance;
    let cos = (1.0 - sin * sin).sqrt();
    // The tangent plane of a side holds the camera; its trace is the limb.
    let limb = |side: f64, v: f64| {
        let n = mount.rotation.transpose() * (p.cross(&d) * cos + p * (side * sin));
        let y = (v - CY) / FY;
        [FX * -(n.y * y + n.z) / n.x + CX, v]
    };
    let (above, below) = (-80.0, f64::from(SIZE.1) + 80.0);
    [
        limb(1.0, above),
        limb(1.0, below),
        limb(-1.0, below),
        limb(-1.0, above),
    ]
}

/// Normal by summing uniform numbers: variance 1.
fn normal(random: &mut SplitMix64) -> f64 {
    (0..12).map(|_| random.unit()).sum::<f64>() - 6.0
}

/// An orange strip on a bluish gradient with noise; samples in 0 to 1.
fn paint(mount: &Mount, seed: u64) -> Vec<[f64; 3]> {
    let mut cover = Pixmap::new(SIZE.0, SIZE.1).unwrap();
    let mut path = PathBuilder::new();
    for (k, [u, v]) in strip(mount).into_iter().enumerate() {
        if k == 0 {
            path.move_to(u as f32, v as f32);
        } else {
            path.line_to(u as f32, v as f32);
        }
    }
    path.close();
    let mut paint = Paint {
        anti_alias: true,
        ..Paint::default()
    };
    paint.set_color(Color::WHITE);
    cover.fill_path(
        &path.finish().unwrap(),
        &paint,
        FillRule::Winding,
        Transform::identity(),
        None,
    );
    let mut random = SplitMix64::new(seed);
    let pixel = |(index, cover): (usize, &[u8])| {
        let row = f64::from(index as u32 / SIZE.0) / f64::from(SIZE.1);
        let water = [0.10 - 0.04 * row, 0.30 - 0.08 * row, 0.45 - 0.12 * row];
        let rod = [0.78, 0.46, 0.16];
        let alpha = f64::from(cover[3]) / 255.0;
        [0, 1, 2].map(|k| {
            let clean = water[k] + alpha * (rod[k] - water[k]);
            (clean + 0.012 * normal(&mut random)).clamp(0.0, 1.0)
        })
    };
    cover
        .data()
        .chunks_exact(4)
        .enumerate()
        .map(pixel)
        .collect()
}

/// What a camera may deliver.
#[derive(Clone, Copy, Debug)]
enum Kind {
    Rgb8,
    Rgb16,
    Grey8,
    Jpeg,
}

fn save(folder: &Path, name: &str, pixels: &[[f64; 3]], kind: Kind) -> PathBuf {
    let eight = |v: f64| (v * 255.0).round() as u8;
    let flat8 = || {
        pixels
            .iter()
            .flatten()
            .map(|v| eight(*v))
            .collect::<Vec<u8>>()
    };
    let (w, h) = SIZE;
    let rgb8 = || DynamicImage::from(ImageBuffer::<Rgb<u8>, _>::from_raw(w, h, flat8()).unwrap());
    let image = match kind {
        Kind::Rgb8 | Kind::Jpeg => rgb8(),
        Kind::Rgb16 => {
            let samples = pixels
                .iter()
                .flatten()
                .map(|v| (v * 65535.0).round() as u16)
                .collect();
            ImageBuffer::<Rgb<u16>, Vec<u16>>::from_raw(w, h, samples)
                .unwrap()
                .into()
        }
        Kind::Grey8 => {
            let samples = pixels
                .iter()
                .map(|[r, g, b]| eight(0.3 * r + 0.59 * g + 0.11 * b))
                .collect();
            ImageBuffer::<Luma<u8>, Vec<u8>>::from_raw(w, h, samples)
                .unwrap()
                .into()
        }
    };
    let path = folder.join(format!(
        "{name}.{}",
        if matches!(kind, Kind::Jpeg) {
            "jpg"
        } else {
            "png"
        }
    ));
    image.save(&path).unwrap();
    path
}

/// The rig in rodsight's own format.
fn toml(origin: &str, shift: f64) -> String {
    let eye = |name: &str, m: &Mount| {
        let (r, t) = (m.rotation, m.centre_m);
        let row = |k: usize| format!("[{:.15}, {:.15}, {:.15}]", r[(k, 0)], r[(k, 1)], r[(k, 2)]);
        format!(
            "[{name}]\nwidth_px = {}\nheight_px = {}\nfx_px = {FX:?}\nfy_px = {FY:?}\ncx_px = {:?}\ncy_px = {:?}\n\
             [{name}.rig_from_camera]\nrotation = [{}, {}, {}]\ntranslation_m = [{:?}, {:?}, {:?}]\n",
            SIZE.0,
            SIZE.1,
            CX + shift,
            CY + shift,
            row(0),
            row(1),
            row(2),
            t.x,
            t.y,
            t.z
        )
    };
    let [left, right] = mounts();
    format!(
        "schema = 1\npixel_origin = \"{origin}\"\n{}{}",
        eye("left", &left),
        eye("right", &right)
    )
}

/// `x_right = R x_left + T`.
fn right_from_left() -> (Mat3, Vec3) {
    let [left, right] = mounts();
    let back = right.rotation.transpose();
    (
        back * left.rotation,
        back * (left.centre_m - right.centre_m),
    )
}

/// As `cv2.FileStorage` writes a stereo calibration.
fn opencv() -> String {
    let (r, t) = right_from_left();
    let matrix = |name: &str, rows: usize, cols: usize, values: &[f64]| {
        let data: Vec<String> = values.iter().map(|v| format!("{v:.15}")).collect();
        format!(
            "{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {} ]\n",
            data.join(", ")
        )
    };
    let k = [FX, 0.0, CX - 0.5, 0.0, FY, CY - 0.5, 0.0, 0.0, 1.0];
    [
        format!(
            "%YAML:1.0\n---\nimage_width: {}\nimage_height: {}\n",
            SIZE.0, SIZE.1
        ),
        matrix("M1", 3, 3, &k),
        matrix("D1", 1, 5, &[0.0; 5]),
        matrix("M2", 3, 3, &k),
        matrix("D2", 1, 5, &[0.0; 5]),
        matrix("R", 3, 3, r.transpose().as_slice()),
        matrix("T", 3, 1, t.as_slice()),
    ]
    .concat()
}

fn kalibr() -> String {
    let (r, t) = right_from_left();
    let camera = format!(
        "  camera_model: pinhole\n  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n  distortion_model: radtan\n  \
         intrinsics: [{FX}, {FY}, {}, {}]\n  resolution: [{}, {}]\n",
        CX - 0.5,
        CY - 0.5,
        SIZE.0,
        SIZE.1
    );
    let row = |k: usize| {
        format!(
            "  - [{:.15}, {:.15}, {:.15}, {:.15}]\n",
            r[(k, 0)],
            r[(k, 1)],
            r[(k, 2)],
            t[k]
        )
    };
    format!(
        "cam0:\n{camera}cam1:\n  T_cn_cnm1:\n{}{}{}  - [0.0, 0.0, 0.0, 1.0]\n{camera}",
        row(0),
        row(1),
        row(2)
    )
}

/// An answer of `solve`, as point and direction in the frame of the rig that the rod is given in.
fn located(answer: &Value, in_left_camera: bool) -> (Vec3, Vec3, Vec3) {
    let [point, direction, grasp] = [
        &answer["axis"]["point_m"],
        &answer["axis"]["direction"],
        &answer["grasp"]["point_m"],
    ]
    .map(|value| Vec3::from(vector(value)));
    if !in_left_camera {
        return (point, direction, grasp);
    }
    // A calibration knows no vehicle: its frame stands at the left camera, with the vehicle's axes.
    let camera_from_axes = Mat3::new(0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0);
    let [left, _] = mounts();
    let turn = left.rotation * camera_from_axes;
    (
        turn * point + left.centre_m,
        turn * direction,
        turn * grasp + left.centre_m,
    )
}

fn check(kind: Kind) {
    for (method, same) in METHODS {
        check_by(kind, method, same);
    }
}

fn check_by(kind: Kind, method: &str, same: f64) {
    let folder = folder();
    let [left, right] = mounts();
    let images = [("left", &left, 5), ("right", &right, 6)]
        .map(|(name, mount, seed)| save(folder.path(), name, &paint(mount, seed), kind));
    let (true_point, true_direction) = axis();
    let [u, v] = project(&left, &true_point);
    // The pick's ray meets the surface before the axis; the grasp is the foot of that point.
    let ray = (true_point - left.centre_m).normalize();
    let before_axis_m = RADIUS_M / ray.cross(&true_direction).norm();
    let true_grasp = true_point - true_direction * (ray.dot(&true_direction) * before_axis_m);
    let pick = format!("{u:.2},{v:.2}");
    let rigs = [
        ("corner.toml", toml("corner", 0.0), false),
        ("center.toml", toml("center", -0.5), false),
        ("opencv.yml", opencv(), true),
        ("camchain.yaml", kalibr(), true),
    ];
    let answers = rigs.map(|(name, content, in_left_camera)| {
        let rig = folder.path().join(name);
        std::fs::write(&rig, content).unwrap();
        let args = [
            "solve",
            "--left",
            text(&images[0]),
            "--right",
            text(&images[1]),
            "--rig",
            text(&rig),
            "--pick",
            &pick,
            "--method",
            method,
            "--json",
        ];
        let answer = rodsight(&args).json();
        assert_eq!(answer["status"], "ok", "{kind:?} {method} {name}: {answer}");
        located(&answer, in_left_camera)
    });
    for (point, direction, grasp) in answers {
        let offset = (true_point - point) - direction * direction.dot(&(true_point - point));
        let angle_deg = true_direction.cross(&direction).norm().to_degrees();
        assert!(
            offset.norm() < 6e-3,
            "{kind:?} {method}: {:.1} mm off",
            offset.norm() * 1e3
        );
        assert!(angle_deg < 0.3, "{kind:?} {method}: {angle_deg:.3}° off");
        assert!(
            (grasp - true_grasp).norm() < 8e-3,
            "{kind:?} {method}: grasp {:.1} mm off",
            (grasp - true_grasp).norm() * 1e3
        );
        // Four files, one rig: the same answer to the digits a file has. The point is another foot on the same line.
        let (first_point, first_direction, first_grasp) = answers[0];
        let apart =
            (point - first_point) - first_direction * first_direction.dot(&(point - first_point));
        assert!(
            apart.norm() < same && first_direction.cross(&direction).norm() < same,
            "{kind:?} {method}: {apart:?}"
        );
        assert!((grasp - first_grasp).norm() < same, "{kind:?} {method}");
    }
}

#[test]
fn foreign_rgb_pair_is_located_through_every_rig_format() {
    check(Kind::Rgb8);
}

#[test]
fn foreign_16_bit_pair_is_located() {
    check(Kind::Rgb16);
}

#[test]
fn foreign_grey_pair_is_located() {
    check(Kind::Grey8);
}

#[test]
fn foreign_jpeg_pair_is_located() {
    check(Kind::Jpeg);
}
