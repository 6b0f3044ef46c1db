//! Cameras seen through points of their apertures, against the formulas of thin pencils of light.

use rodsight_geometry::port::PortShape;
use rodsight_geometry::{
    Camera, CameraError, Distortion, Intrinsics, MountedCamera, Pixel, Vec3, radians,
};

use super::{GLASS, WATER, camera, dome, flat, with_indices};

const FOCUS_M: f64 = 1.7;

fn mounted(shape: PortShape) -> MountedCamera {
    with_indices(shape, GLASS, [WATER; 3])
}

/// The place of a point of the camera's frame in its own frame's rig.
fn seen(mounted: &MountedCamera, from: &MountedCamera, point_m: &Vec3) -> Pixel {
    mounted
        .project(&from.rig_from_camera.point(point_m))
        .unwrap()
}

/// From one plane to the next: each layer as thick as it is over its index.
#[test]
fn plates_bring_what_is_behind_them_nearer() {
    for (distance_m, thickness_m) in [(0.0, 0.0), (0.05, 0.01), (0.3, 0.05)] {
        let camera = mounted(flat(distance_m, thickness_m, Vec3::z()));
        for depth_m in [0.5, 1.7, 20.0] {
            let water_m = depth_m - distance_m - thickness_m;
            let wanted_m = distance_m + thickness_m / GLASS + water_m / WATER;
            let found_m = camera.apparent_depth_m(depth_m).unwrap();
            assert!(
                (found_m / wanted_m - 1.0).abs() < 1e-6,
                "{found_m} {wanted_m}"
            );
        }
        assert_eq!(camera.apparent_depth_m(distance_m + thickness_m), None);
    }
}

/// Vergences: (n' − n) / R more at each sphere.
#[test]
fn a_centred_dome_is_a_lens_that_images_near_itself() {
    let (inner_m, thickness_m) = (0.05, 0.008);
    let outer_m = inner_m + thickness_m;
    let camera = mounted(dome(Vec3::zeros(), inner_m, thickness_m));
    for depth_m in [0.3, 1.7, 20.0] {
        let outside = -WATER / (depth_m - outer_m) + (GLASS - WATER) / outer_m;
        let inside = outside / (1.0 - thickness_m * outside / GLASS) + (1.0 - GLASS) / inner_m;
        let wanted_m = inner_m - 1.0 / inside;
        let found_m = camera.apparent_depth_m(depth_m).unwrap();
        assert!(
            (found_m / wanted_m - 1.0).abs() < 1e-5,
            "{found_m} {wanted_m}"
        );
        assert!(found_m < 0.3);
    }
}

/// All of the plane in focus stays where it is, whatever the lens; all else moves by fx a (1/z − 1/s).
#[test]
fn the_plane_in_focus_stays_behind_any_lens() {
    let i = *camera().intrinsics();
    for distortion in [
        Distortion::None,
        Distortion::BrownConrady([-0.12, 0.03, 0.001, -0.002, 0.004]),
        Distortion::KannalaBrandt([0.02, -0.004, 0.001, 0.0]),
    ] {
        let centre = MountedCamera {
            camera: Camera::new(i, distortion).unwrap(),
            port: None,
            ..mounted(flat(0.0, 0.0, Vec3::z()))
        };
        let aside_m = Pixel::new(0.004, -0.007);
        let through = centre.through(&aside_m, FOCUS_M).unwrap();
        for (x, y) in [(0.0, 0.0), (0.5, 0.3), (-0.6, 0.2)] {
            let point_m = Vec3::new(x, y, 1.0) * FOCUS_M;
            let moved_px = seen(&through, &centre, &point_m) - seen(&centre, &centre, &point_m);
            assert!(moved_px.norm() < 1e-9, "{distortion:?} {moved_px}");
            // Its own rays agree with where it sees things.
            let pixel = seen(&through, &centre, &(0.6 * point_m));
            let (origin_m, direction) = through.ray(&pixel).unwrap();
            let to_point = through
                .rig_from_camera
                .inverse()
                .direction(&(centre.rig_from_camera.point(&(0.6 * point_m)) - origin_m));
            let along = through.rig_from_camera.inverse().direction(&direction);
            assert!(to_point.normalize().cross(&along).norm() < 1e-12);
        }
        let near_m = Vec3::new(0.0, 0.0, 1.0);
        let moved_px = seen(&through, &centre, &near_m) - seen(&centre, &centre, &near_m);
        let wanted_px = -aside_m * (i.fx_px * (1.0 - 1.0 / FOCUS_M));
        assert!(
            (moved_px - wanted_px).norm() < 1e-3,
            "{moved_px} {wanted_px}"
        );
    }
}

/// Behind ports: the axis' point in focus stays but for the port's spherical aberration, and nearer and farther ones move by the
/// difference of the vergences.
#[test]
fn what_is_in_focus_on_the_axis_stays_behind_any_port() {
    let tilted = Vec3::new(libm::sin(radians(4.0)), 0.0, libm::cos(radians(4.0)));
    for (name, shape, worst_px) in [
        ("plate", flat(0.06, 0.012, Vec3::z()), 1e-4),
        ("tilted plate", flat(0.06, 0.012, tilted), 0.03),
        ("dome", dome(Vec3::zeros(), 0.05, 0.008), 0.02),
        (
            "dome aside",
            dome(Vec3::new(0.002, 0.0, -0.01), 0.05, 0.008),
            0.02,
        ),
    ] {
        let centre = mounted(shape);
        let aside_m = Pixel::new(0.0012, 0.0016);
        let through = centre.through(&aside_m, FOCUS_M).unwrap();
        let focal_px = centre.camera.intrinsics().fx_px;
        let middle = Pixel::new(960.0, 540.0);
        let (from_m, along) = centre.ray(&middle).unwrap();
        let forward = centre.rig_from_camera.direction(&Vec3::z());
        let start_m = (from_m - centre.rig_from_camera.origin_m()).dot(&forward);
        for depth_m in [1.0, FOCUS_M, 4.0] {
            let point_m = from_m + along * ((depth_m - start_m) / along.dot(&forward));
            let moved_px = through.project(&point_m).unwrap() - middle;
            let [there, focus] =
                [depth_m, FOCUS_M].map(|depth_m| 1.0 / centre.apparent_depth_m(depth_m).unwrap());
            let wanted_px = -aside_m * (focal_px * (there - focus));
            assert!(
                (moved_px - wanted_px).norm() < worst_px,
                "{name} {depth_m}: {moved_px} {wanted_px}"
            );
        }
    }
}

#[test]
fn lenses_without_a_plane_in_focus_are_refused() {
    let centre = mounted(flat(0.06, 0.012, Vec3::z()));
    let aside_m = Pixel::new(0.001, 0.0);
    let error = centre.through(&aside_m, 0.07).unwrap_err();
    assert!(
        matches!(error, CameraError::Value { key: "focus_m", found, .. } if found == 0.07),
        "{error}"
    );
    // All around: f = 600 px, 1100 px from the axis, 105°.
    let fisheye = Camera::new(
        Intrinsics {
            fx_px: 600.0,
            fy_px: 600.0,
            ..*camera().intrinsics()
        },
        Distortion::KannalaBrandt([0.0; 4]),
    );
    let fisheye = MountedCamera {
        camera: fisheye.unwrap(),
        port: None,
        ..centre
    };
    let error = fisheye.through(&aside_m, FOCUS_M).unwrap_err();
    assert!(matches!(error, CameraError::Sideways { .. }), "{error}");
}
