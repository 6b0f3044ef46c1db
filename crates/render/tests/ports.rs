//! Cameras behind glass: silhouettes of every band, light at the lens, what the other eye sees.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use rodsight_geometry::port::{DomePort, FlatPort, Port, PortShape, sea_water_index};
use rodsight_geometry::{
    Band, Camera, Cylinder, Distortion, Eye, Intrinsics, MountedCamera, Pixel, Side, Vec3,
};
use rodsight_render::{CpuRenderer, EyeFrame, Frame, Renderer, Truth};
use rodsight_scene::{EdgeSampling, Mode, Scene};

const GLASS: f64 = 1.49;
const FLAT_RADIANCE: [f64; 3] = [0.8, 0.5, 0.2];

/// The founding rig with cameras that see 63° of the water through a port, at an eighth of its resolution.
fn behind(shape: PortShape, mut scene: Scene) -> Scene {
    let port = Port::new(shape, GLASS, sea_water_index(35.0, 10.0)).unwrap();
    let lens = Intrinsics {
        width_px: 240,
        height_px: 135,
        fx_px: 122.4,
        fy_px: 122.4,
        cx_px: 120.0,
        cy_px: 67.5,
    };
    for eye in [&mut scene.rig.left, &mut scene.rig.right] {
        eye.camera = Camera::new(lens, Distortion::None).unwrap();
        eye.port = Some(port);
    }
    scene
}

fn flat(distance_m: f64, normal: Vec3) -> PortShape {
    PortShape::Flat(FlatPort {
        normal: normal.normalize(),
        distance_m,
        thickness_m: 0.01,
    })
}

fn dome(centre_m: Vec3) -> PortShape {
    PortShape::Dome(DomePort {
        centre_m,
        inner_radius_m: 0.06,
        thickness_m: 0.006,
    })
}

fn shapes() -> [(&'static str, PortShape); 5] {
    [
        ("flat", flat(0.02, Vec3::z())),
        ("flat, far", flat(0.1, Vec3::z())),
        ("flat, tilted", flat(0.05, Vec3::new(0.2, -0.1, 1.0))),
        ("dome, centred", dome(Vec3::zeros())),
        ("dome, off centre", dome(Vec3::new(0.004, -0.006, 0.015))),
    ]
}

/// A thick flat rod, steep in the image and well off its middle, where ports bend most.
fn rod_scene() -> Scene {
    let mut scene = common::empty(8);
    scene.rods.push(common::flat_rod(
        Vec3::new(1.4, 0.15, -1.0),
        Vec3::new(0.1, 0.35, 1.0),
        0.1,
    ));
    scene.sampling.edge = EdgeSampling::Fibonacci { points: 2584 };
    scene
}

/// Where a limb or (without a side) the axis is seen, densely along the rod.
fn curve(scene: &Scene, mounted: &MountedCamera, side: Option<Side>) -> Vec<Pixel> {
    let rod = &scene.rods[0];
    (-4000..=4000)
        .filter_map(|i| {
            let mut cylinder = Cylinder {
                axis: rodsight_geometry::Line3::new(rod.centre_m, &rod.direction),
                radius_m: rod.radius_m,
            };
            cylinder.axis.point_m += rod.direction * (rod.length_m * 0.5 * f64::from(i) / 4000.0);
            match side {
                Some(side) => mounted.project(&mounted.limb_point_m(&cylinder, side)?),
                None => mounted.project(&cylinder.axis.point_m),
            }
        })
        .collect()
}

/// The mean place, px, at which a curve crosses a row of pixels.
fn crossing(curve: &[Pixel], row: u32) -> Option<f64> {
    let at = |v: f64| {
        curve.windows(2).find_map(|pair| {
            let s = (v - pair[0].y) / (pair[1].y - pair[0].y);
            (0.0..1.0)
                .contains(&s)
                .then(|| pair[0].x + s * (pair[1].x - pair[0].x))
        })
    };
    let places = (0..8).map(|k| at(f64::from(row) + (f64::from(k) + 0.5) / 8.0));
    places.sum::<Option<f64>>().map(|sum| sum / 8.0)
}

/// Mean and largest distance, px, over rows and limbs between the edge in one band of an image and a camera's limbs: the light on a
/// row from outside to inside the rod, over that of the rod behind the glass there, is the place of the edge.
fn edge_errors(
    scene: &Scene,
    frame: &EyeFrame,
    eye: Eye,
    band: Band,
    limbs_of: &MountedCamera,
) -> (f64, f64) {
    let seen = scene.rig.eye(eye).in_band(band);
    let axis = curve(scene, limbs_of, None);
    let limbs = [Side::Plus, Side::Minus].map(|side| curve(scene, limbs_of, Some(side)));
    let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0.0);
    for row in 4..frame.height_px - 4 {
        for limb in &limbs {
            let (Some(middle), Some(edge)) = (crossing(&axis, row), crossing(limb, row)) else {
                continue;
            };
            let inside = middle.floor();
            let outside = (edge + (edge - inside).signum() * 4.0).floor();
            if inside.min(outside) < 0.0 || inside.max(outside) >= f64::from(frame.width_px) {
                continue;
            }
            let columns = inside.min(outside) as u32..inside.max(outside) as u32;
            let light: f64 = columns
                .map(|column| {
                    let centre = Pixel::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
                    let whole = f64::from(FLAT_RADIANCE[band.index()] as f32)
                        * seen.water_ray(&centre).unwrap().gain;
                    f64::from(frame.at(column, row).radiance[band.index()]) / whole
                })
                .sum();
            let found = if outside > inside {
                inside + light
            } else {
                inside - light
            };
            sum += found - edge;
            worst = worst.max((found - edge).abs());
            count += 1.0;
        }
    }
    assert!(count > 100.0, "the limbs are seen on {count} rows");
    (f64::abs(sum / count), worst)
}

/// 2584 samples a pixel tell a row's edge to a thousandth of a pixel or two; what the curve is off adds to the mean.
const MEAN_LIMIT_PX: f64 = 0.002;
const WORST_LIMIT_PX: f64 = 0.01;

#[test]
fn silhouettes_of_every_band_lie_on_the_limbs() {
    for (name, shape) in shapes() {
        let scene = behind(shape, rod_scene());
        // In the right image the rod is nearer to the border.
        let eye = Eye::Right;
        // The graphics backend, which draws both eyes, on the two that bend most.
        let frames = if ["flat, tilted", "dome, off centre"].contains(&name) {
            common::on_each(&scene)
        } else {
            vec![CpuRenderer.render(&scene, &|_| ()).unwrap()]
        };
        for Frame { right, backend, .. } in frames {
            for band in Band::ALL {
                let limbs_of = scene.rig.eye(eye).in_band(band);
                let (mean, worst) = edge_errors(&scene, &right, eye, band, &limbs_of);
                println!("{name} {band:?} {backend}: mean {mean:.5} px, worst {worst:.5} px");
                assert!(
                    mean < MEAN_LIMIT_PX && worst < WORST_LIMIT_PX,
                    "{name} {band:?} {backend}: {mean}, {worst}"
                );
            }
        }
    }
}

/// Each of these is a way to get ports wrong, and each must fail the test above.
#[test]
fn limbs_of_other_cameras_fail_the_same_test() {
    let scene = behind(flat(0.02, Vec3::z()), rod_scene());
    let frame = CpuRenderer.render_eye(&scene, Eye::Right, &|_| ()).unwrap();
    let right = scene.rig.right;
    let i = *right.camera.intrinsics();
    let longer = |scale: f64| {
        let lens = Intrinsics {
            fx_px: i.fx_px * scale,
            fy_px: i.fy_px * scale,
            ..i
        };
        MountedCamera {
            camera: Camera::new(lens, Distortion::None).unwrap(),
            port: None,
            ..right
        }
    };
    let nearer = behind(flat(0.019, Vec3::z()), rod_scene()).rig.right;
    let tilted = behind(flat(0.02, Vec3::new(0.003, 0.0, 1.0)), rod_scene())
        .rig
        .right;
    for (name, limbs_of) in [
        ("no port, focal length in water", longer(1.34)),
        ("another band", right.in_band(Band::Blue)),
        ("a millimetre nearer", nearer),
        ("tilted by 0.17°", tilted),
    ] {
        let (mean, worst) = edge_errors(&scene, &frame, Eye::Right, Band::Green, &limbs_of);
        println!("control, {name}: mean {mean:.5} px, worst {worst:.5} px");
        assert!(
            mean >= MEAN_LIMIT_PX || worst >= WORST_LIMIT_PX,
            "{name}: {mean}, {worst}"
        );
    }
}

/// Straight pieces between the curve's points are right to 1e-3 px wherever the image shows them.
#[test]
fn curves_of_the_truth_are_fine_enough() {
    for (name, shape) in shapes() {
        let mut scene = behind(shape, rod_scene());
        scene.sampling.edge = EdgeSampling::Fibonacci { points: 5 };
        let frame = CpuRenderer.render(&scene, &|_| ()).unwrap();
        let truth = Truth::of(&scene, &frame, 1.0).unwrap();
        let view = &truth.rods[0].left;
        assert!(
            view.lines.is_none(),
            "{name}: behind glass there are no straight limbs"
        );
        let curves = view.curves.as_ref().unwrap();
        for (side, points) in [
            (Some(Side::Plus), &curves.plus_limb),
            (Some(Side::Minus), &curves.minus_limb),
            (None, &curves.axis),
        ] {
            let pieces: Vec<Pixel> = points.iter().map(|&p| p.into()).collect();
            let mut checked = 0;
            for exact in curve(&scene, &scene.rig.left, side) {
                if !scene.rig.left.camera.contains(&exact) {
                    continue;
                }
                let off_px = pieces.windows(2).map(|piece| {
                    let along = piece[1] - piece[0];
                    let s = ((exact - piece[0]).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
                    (piece[0] + along * s - exact).norm()
                });
                let off_px = off_px.fold(f64::INFINITY, f64::min);
                assert!(off_px < 1e-3, "{name} {side:?}: {off_px} px at {exact:?}");
                checked += 1;
            }
            assert!(checked > 100, "{name}: {checked}");
        }
    }
}

/// `L_lens = T L_water / n²`: acrylic loses 3.87 % and 0.3 % at right angles, and n² spreads what is left.
#[test]
fn radiance_at_the_lens_is_that_of_the_water_less_fresnel_over_n_squared() {
    let mut scene = behind(flat(0.02, Vec3::z()), common::empty(8));
    scene
        .rods
        .push(common::flat_rod(Vec3::new(1.5, -0.5, -1.0), Vec3::z(), 0.3));
    let frames = common::on_each(&scene);
    let index = sea_water_index(35.0, 10.0);
    for (frame, (k, n)) in frames
        .iter()
        .flat_map(|f| index.into_iter().enumerate().map(move |n| (f, n)))
    {
        let pixel = frame.left.at(120, 67);
        let passes = |a: f64, b: f64| 1.0 - ((a - b) / (a + b)) * ((a - b) / (a + b));
        let expected = FLAT_RADIANCE[k] * passes(1.0, GLASS) * passes(GLASS, n) / (n * n);
        let found = f64::from(pixel.radiance[k]);
        // The pixel's centre is a quarter of a degree off the axis: 1e-6 of Fresnel's loss.
        assert!(
            (found / expected - 1.0).abs() < 1e-5,
            "band {k}: {found}, {expected}"
        );
    }
}

/// The water begins at the outer face: 30 mm of air and glass take nothing.
#[test]
fn water_begins_at_the_outer_face() {
    let mut scene = behind(flat(0.02, Vec3::z()), common::wet(8));
    scene.seabed = None;
    scene
        .rods
        .push(common::flat_rod(Vec3::new(1.5, -0.5, -1.0), Vec3::z(), 0.3));
    scene.mode = Mode::Single;
    let frame = CpuRenderer.render_eye(&scene, Eye::Left, &|_| ()).unwrap();
    let pixel = frame.at(120, 67);
    // The rod's front is 1.2 m before the lens; the pixel's centre meets it 4 mm beside its middle, 2.4e-5 m farther.
    assert!(
        (f64::from(pixel.range_m) - 1.17).abs() < 5e-5,
        "{}",
        pixel.range_m
    );
    assert!(
        (f64::from(pixel.depth_m) - 1.2).abs() < 5e-5,
        "{}",
        pixel.depth_m
    );
    for (k, c) in scene
        .medium
        .beam_attenuation_per_m()
        .into_iter()
        .enumerate()
    {
        let expected = libm::exp(-c * f64::from(pixel.range_m));
        assert!((f64::from(pixel.transmission[k]) / expected - 1.0).abs() < 1e-6);
    }
}

/// Disparity and occlusion are those of the lines of sight behind the other eye's glass.
#[test]
fn other_eye_is_asked_through_its_own_port() {
    let mut scene = behind(flat(0.1, Vec3::new(0.1, 0.0, 1.0)), common::crossing(8));
    scene.mode = Mode::Air;
    for frame in common::on_each(&scene) {
        check_other_eye(&scene, &frame);
    }
}

fn check_other_eye(scene: &Scene, frame: &Frame) {
    // Rays that just graze a rod may be called either way: the range is an f32, and so is all on the graphics backend.
    let grazing_m = if frame.backend == "cpu" { 2e-6 } else { 2e-5 };
    let frame = &frame.left;
    let (mut hidden, mut seen) = (0, 0);
    for row in 0..frame.height_px {
        for column in 0..frame.width_px {
            let pixel = frame.at(column, row);
            if pixel.instance < 2 {
                continue;
            }
            let centre = Pixel::new(f64::from(column) + 0.5, f64::from(row) + 0.5);
            let (origin, ray) = scene.rig.left.ray(&centre).unwrap();
            let point = origin + ray * f64::from(pixel.range_m);
            let Some(there) = scene.rig.right.project(&point) else {
                assert!(pixel.occluded && pixel.disparity_px.is_infinite());
                continue;
            };
            let error_px = f64::from(pixel.disparity_px) - (centre.x - there.x);
            assert!(error_px.abs() < 1e-3, "({column}, {row}): {error_px}");
            // Back along the other eye's own ray: does it come to this point first?
            let (from, towards) = scene.rig.right.ray(&there).unwrap();
            let distance = (point - from).norm();
            assert!((from + towards * distance - point).norm() < 1e-6);
            let rods = scene.rods.iter().map(|rod| {
                let axis = rodsight_geometry::Line3::new(rod.centre_m, &rod.direction);
                let radius_m = rod.radius_m;
                (rod, Cylinder { axis, radius_m })
            });
            let grazes = |cylinder: &Cylinder| {
                [Side::Plus, Side::Minus].into_iter().any(|side| {
                    let gap_m = cylinder.tangency_residual_m(&from, &towards, side);
                    gap_m.is_some_and(|gap_m| gap_m.abs() < grazing_m)
                })
            };
            if rods.clone().any(|(_, cylinder)| grazes(&cylinder)) {
                continue;
            }
            let blocked = rods.clone().any(|(rod, cylinder)| {
                cylinder
                    .intersect(&from, &towards)
                    .is_some_and(|(enter, _)| {
                        let along = rod.direction.dot(&(from + towards * enter - rod.centre_m));
                        along.abs() < 0.5 * rod.length_m && enter < distance - 1e-4
                    })
            });
            let expected = blocked || !scene.rig.right.camera.contains(&there);
            assert_eq!(pixel.occluded, expected, "({column}, {row})");
            if blocked { hidden += 1 } else { seen += 1 }
        }
    }
    assert!(hidden > 20 && seen > 100, "{hidden} hidden, {seen} seen");
}

/// Where the port does not part the bands, one pass does: the same bytes as three.
#[test]
fn one_pass_and_three_give_the_same_light() {
    let mut scene = behind(flat(0.02, Vec3::z()), rod_scene());
    scene.sampling.edge = EdgeSampling::Fibonacci { points: 21 };
    let with = |scene: &Scene, index: [f64; 3]| {
        let mut scene = scene.clone();
        scene.rig.left.port = Some(Port::new(flat(0.02, Vec3::z()), GLASS, index).unwrap());
        CpuRenderer.render_eye(&scene, Eye::Left, &|_| ()).unwrap()
    };
    let one = with(&scene, [1.34; 3]);
    let three = with(&scene, [1.34, 1.34, 1.35]);
    let (mut alike, mut apart) = (true, 0);
    for (a, b) in one.pixels.iter().zip(&three.pixels) {
        alike &= a.radiance[..2] == b.radiance[..2] && a.depth_m == b.depth_m;
        apart += usize::from(a.radiance[2] != b.radiance[2]);
    }
    assert!(alike && apart > 1000, "{apart} blue pixels differ");
}
