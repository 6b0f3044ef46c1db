//! Elementary functions, samples, cameras.

use rodsight_geometry::{Camera, Distortion, Intrinsics, Pixel, Vec3};
use rodsight_scene::EdgeSampling;

use super::{grid, random, steps, vec3, yes};
use crate::gpu::shader_parity::Row;
use crate::lattice::{pcg, pixel_shift};
use crate::lens::vignetting;

fn maths() -> Vec<Row> {
    let half_turn = core::f32::consts::PI;
    vec![
        Row {
            name: "maths_sincos",
            body: "let r = maths_sincos(x(0u)); y(0u, r.x); y(1u, r.y);",
            inputs: grid(&[&steps(-half_turn, half_turn, 4001)]),
            twin: Box::new(|x| vec![libm::sin(x[0]), libm::cos(x[0])]),
            relative: 0.0,
            absolute: 4e-7,
            bounded_by: "a square near 1 taken from 1",
        },
        Row {
            name: "maths_atan2",
            body: "y(0u, maths_atan2(x(0u), x(1u)));",
            inputs: random(1, 4000, 2),
            twin: Box::new(|x| vec![libm::atan2(x[0], x[1])]),
            relative: 3e-7,
            absolute: 4e-7,
            bounded_by: "maths_sincos",
        },
        Row {
            name: "lattice_pcg",
            body: "y(0u, f32(lattice_pcg(u(0u)) >> 8u));",
            inputs: random(2, 1000, 1),
            twin: Box::new(|x| vec![f64::from(pcg((x[0] as f32).to_bits()) >> 8)]),
            relative: 0.0,
            absolute: 1e-3,
            bounded_by: "integers",
        },
        Row {
            name: "lattice_pixel_shift",
            body: "let r = lattice_pixel_shift(u32(x(0u)), u32(x(1u))); y(0u, r.x); y(1u, r.y);",
            inputs: grid(&[&steps(0.0, 1919.0, 102), &steps(0.0, 1079.0, 84)]),
            twin: Box::new(|x| {
                let pattern = EdgeSampling::Fibonacci { points: 233 };
                pixel_shift(pattern, x[0] as u32, x[1] as u32).to_vec()
            }),
            relative: 0.0,
            absolute: 6e-8,
            bounded_by: "32 bits in 24",
        },
        Row {
            name: "lattice_place",
            body: "let r = lattice_place(vec2<f32>(x(0u), x(1u)), vec2<f32>(x(2u), x(3u))); y(0u, r.x); y(1u, r.y);",
            inputs: grid(&[
                &[0.002, 0.33, 0.97],
                &[0.05, 0.5, 0.9],
                &[0.0, 0.41, 0.999],
                &[0.2, 0.7],
            ]),
            twin: Box::new(|x| {
                let wrapped = |s: f64| if s < 1.0 { s } else { s - 1.0 };
                vec![wrapped(x[0] + x[2]), wrapped(x[1] + x[3])]
            }),
            relative: 0.0,
            absolute: 1.3e-7,
            bounded_by: "rounding of a sum below 2",
        },
    ]
}

/// The tests' lenses, of numbers that `f32` holds.
fn lens(index: usize) -> Camera {
    let f = f64::from;
    let distortion = [
        Distortion::None,
        Distortion::BrownConrady([f(-0.12_f32), f(0.03_f32), f(0.001_f32), f(-0.002_f32), 0.0]),
        Distortion::KannalaBrandt([f(0.02_f32), f(-0.004_f32), f(0.001_f32), 0.0]),
    ][index];
    let i = Intrinsics {
        width_px: 240,
        height_px: 136,
        fx_px: 196.0,
        fy_px: 193.0,
        cx_px: 121.5,
        cy_px: 66.0,
    };
    Camera::new(i, distortion).unwrap()
}

/// How many numbers tell a lens: fx fy cx cy, k, p, fold, index, size, shift.
const LENS: usize = 16;
/// Added to the index of a lens that is seen through another point than its centre.
const ASIDE: usize = 10;

/// The lens of a row.
fn lens_of(x: &[f64]) -> Camera {
    let shift = Pixel::new(x[LENS - 2], x[LENS - 1]);
    lens(x[11] as usize).with_rays_shifted(&shift).unwrap()
}

/// Every row, after the numbers of every lens.
fn seen_by(lenses: &[usize], rows: &[Vec<f32>]) -> Vec<Vec<f32>> {
    let numbers = |&index: &usize| -> Vec<f32> {
        let camera = lens(index % ASIDE);
        let shift = if index < ASIDE {
            [0.0; 2]
        } else {
            [0.031, -0.022]
        };
        let i = *camera.intrinsics();
        let (k, p) = match *camera.distortion() {
            Distortion::None => ([0.0; 4], [0.0; 2]),
            Distortion::BrownConrady([k1, k2, p1, p2, k3]) => ([k1, k2, k3, 0.0], [p1, p2]),
            Distortion::KannalaBrandt(k) => (k, [0.0; 2]),
        };
        let of_lens = [
            camera.fold().min(1e30),
            (index % ASIDE) as f64,
            240.0,
            136.0,
        ];
        let all = [
            &[i.fx_px, i.fy_px, i.cx_px, i.cy_px][..],
            &k,
            &p,
            &of_lens,
            &shift,
        ]
        .concat();
        all.into_iter().map(|v| v as f32).collect()
    };
    let lenses = lenses.iter().map(numbers);
    lenses
        .flat_map(|lens| rows.iter().map(move |row| [&lens[..], row].concat()))
        .collect()
}

/// Axes of the tests' camera in the rig's frame.
const RIGHT: Vec3 = Vec3::new(0.955_336_5, 0.295_520_2, 0.0);
const DOWN: Vec3 = Vec3::new(-0.243_902_56, 0.788_475_2, 0.564_642_5);
const FORWARD: Vec3 = Vec3::new(0.166_863_28, -0.539_429_8, 0.825_335_6);

macro_rules! with_camera {
    ($body:literal) => {
        concat!(
            "let camera = Camera(vec3<f32>(0.9553365, 0.2955202, 0.0), x(0u), ",
            "vec3<f32>(-0.24390256, 0.7884752, 0.5646425), x(1u), ",
            "vec3<f32>(0.16686328, -0.5394298, 0.8253356), x(2u), vec3<f32>(0.0), x(3u), ",
            "vec4<f32>(v(4u), x(7u)), vec2<f32>(x(8u), x(9u)), x(10u), vec2<f32>(x(12u), x(13u)), vec2<f32>(x(14u), x(15u)));\n",
            $body
        )
    };
}

fn lenses() -> Vec<Row> {
    let on_plane = grid(&[&steps(-0.6, 0.6, 61), &steps(-0.33, 0.33, 33)]);
    let angles = grid(&[&steps(0.0, 0.68, 401)]);
    vec![
        Row {
            name: "camera_distort_brown_conrady",
            body: with_camera!(
                "let r = camera_distort_brown_conrady(camera, vec2<f32>(x(16u), x(17u))); y(0u, r.x); y(1u, r.y);"
            ),
            inputs: seen_by(&[1], &on_plane),
            twin: Box::new(|x| {
                let pixel = lens(1)
                    .project(&Vec3::new(x[LENS], x[LENS + 1], 1.0))
                    .unwrap();
                vec![(pixel.x - 121.5) / 196.0, (pixel.y - 66.0) / 193.0]
            }),
            relative: 3e-7,
            absolute: 6e-8,
            bounded_by: "rounding",
        },
        Row {
            name: "camera_undistort_brown_conrady",
            body: with_camera!(
                "let r = camera_undistort_brown_conrady(camera, vec2<f32>(x(16u), x(17u))); y(0u, r.x); y(1u, r.y);"
            ),
            inputs: seen_by(&[1], &on_plane),
            twin: Box::new(|x| {
                let pixel = Pixel::new(121.5 + 196.0 * x[LENS], 66.0 + 193.0 * x[LENS + 1]);
                let ray = lens(1).ray(&pixel).unwrap();
                vec![ray.x / ray.z, ray.y / ray.z]
            }),
            relative: 3e-7,
            absolute: 1.2e-7,
            bounded_by: "Newton's method ends where rounding hides the error: 2e-4 px at f = 1566 px",
        },
        Row {
            name: "camera_distorted_angle",
            body: with_camera!("y(0u, camera_distorted_angle(camera, x(16u)));"),
            inputs: seen_by(&[2], &angles),
            twin: Box::new(|x| {
                let (sin, cos) = libm::sincos(x[LENS]);
                let pixel = lens(2).project(&Vec3::new(sin, 0.0, cos)).unwrap();
                vec![(pixel.x - 121.5) / 196.0]
            }),
            relative: 3e-7,
            absolute: 1e-9,
            bounded_by: "rounding",
        },
        Row {
            name: "camera_undistort_kannala_brandt",
            body: with_camera!("y(0u, camera_undistort_kannala_brandt(camera, x(16u)));"),
            inputs: seen_by(&[2], &angles),
            twin: Box::new(|x| {
                let ray = lens(2)
                    .ray(&Pixel::new(121.5 + 196.0 * x[LENS], 66.0))
                    .unwrap();
                vec![libm::atan2(ray.x, ray.z)]
            }),
            relative: 4e-7,
            absolute: 1e-9,
            bounded_by: "rounding",
        },
        Row {
            name: "camera_ray",
            body: with_camera!(
                "w(0u, camera_ray(u32(x(11u)), camera, vec2<f32>(x(16u), x(17u)), vec2<f32>(x(18u), 0.25)));"
            ),
            inputs: seen_by(
                &[0, 1, 2, ASIDE + 1, ASIDE + 2],
                &grid(&[
                    &steps(0.0, 239.0, 49),
                    &steps(0.0, 135.0, 35),
                    &[0.002, 0.77],
                ]),
            ),
            twin: Box::new(|x| {
                let pixel = Pixel::new(x[LENS] + x[LENS + 2], x[LENS + 1] + 0.25);
                lens_of(x).ray(&pixel).unwrap().as_slice().to_vec()
            }),
            relative: 0.0,
            absolute: 3e-7,
            bounded_by: "the inverse of the lens",
        },
        Row {
            name: "camera_project",
            body: with_camera!(
                "let r = camera_project(u32(x(11u)), camera, v(16u)); w(0u, select(vec3<f32>(0.0), r, r.z > 0.0));"
            ),
            inputs: seen_by(
                &[0, 1, 2, ASIDE + 1, ASIDE + 2],
                &grid(&[
                    &steps(-1.1, 1.3, 25),
                    &steps(-1.3, 1.1, 25),
                    &[-1.0, 0.7, 1.0, 3.0],
                ]),
            ),
            twin: Box::new(|x| {
                let seen = lens_of(x).project(&vec3(x, LENS));
                seen.map_or(vec![0.0; 3], |p| vec![p.x, p.y, 1.0])
            }),
            relative: 4e-7,
            absolute: 6e-5,
            bounded_by: "pixels counted from the corner, far from which digits are lost",
        },
        Row {
            name: "lens_vignetting",
            body: with_camera!(
                "y(0u, lens_vignetting(u32(x(11u)), camera, vec2<f32>(-0.5, 0.125), vec2<f32>(x(16u), x(17u))));"
            ),
            inputs: seen_by(
                &[0, 1, 2],
                &grid(&[&steps(0.0, 239.0, 49), &steps(0.0, 135.0, 35)]),
            ),
            twin: Box::new(|x| {
                let pixel = Pixel::new(x[LENS] + 0.5, x[LENS + 1] + 0.5);
                vec![vignetting(&lens(x[11] as usize), [-0.5, 0.125], &pixel)]
            }),
            relative: 2e-6,
            absolute: 0.0,
            bounded_by: "four times a cosine to 3e-7",
        },
    ]
}

fn frames() -> Vec<Row> {
    vec![
        Row {
            name: "camera_to_rig",
            body: with_camera!("w(0u, camera_to_rig(camera, v(16u)));"),
            inputs: seen_by(&[0], &random(3, 500, 3)),
            twin: Box::new(|x| {
                let v = RIGHT * x[LENS] + DOWN * x[LENS + 1] + FORWARD * x[LENS + 2];
                v.as_slice().to_vec()
            }),
            relative: 0.0,
            absolute: 3e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "camera_from_rig",
            body: with_camera!("w(0u, camera_from_rig(camera, v(16u)));"),
            inputs: seen_by(&[0], &random(4, 500, 3)),
            twin: Box::new(|x| {
                [RIGHT, DOWN, FORWARD]
                    .map(|axis| axis.dot(&vec3(x, LENS)))
                    .to_vec()
            }),
            relative: 0.0,
            absolute: 3e-7,
            bounded_by: "rounding",
        },
        Row {
            name: "camera_contains",
            body: with_camera!(
                "y(0u, select(0.0, 1.0, camera_contains(camera, vec2<f32>(x(16u), x(17u)))));"
            ),
            inputs: seen_by(
                &[0],
                &grid(&[
                    &[-0.1, 0.0, 100.0, 240.0, 240.1],
                    &[-0.1, 0.0, 70.0, 136.0, 136.1],
                ]),
            ),
            twin: Box::new(|x| yes(lens(0).contains(&Pixel::new(x[LENS], x[LENS + 1])))),
            relative: 0.0,
            absolute: 1e-6,
            bounded_by: "yes or no",
        },
    ]
}

pub(super) fn rows() -> Vec<Row> {
    let mut rows = maths();
    rows.extend(lenses());
    rows.extend(frames());
    rows
}
