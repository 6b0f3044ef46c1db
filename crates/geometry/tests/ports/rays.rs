//! Rays and projections undo each other, take the shortest way of light, and touch the limbs of rods.

use rodsight_geometry::port::PortShape;
use rodsight_geometry::{Band, Cylinder, Distortion, Line3, MountedCamera, Pixel, Side, Vec3};

use super::{GLASS, behind, camera, flat, ports};

fn pixels() -> impl Iterator<Item = Pixel> {
    (0..=8)
        .flat_map(|i| (0..=6).map(move |j| Pixel::new(240.0 * f64::from(i), 180.0 * f64::from(j))))
}

/// Largest error, px, of casting a ray in one band and projecting its points in another.
fn worst_round_trip_px(mounted: &MountedCamera, cast: Band, project: Band) -> f64 {
    let mut worst = 0.0_f64;
    for pixel in pixels() {
        let ray = mounted.in_band(cast).water_ray(&pixel).unwrap();
        assert!((ray.direction.norm() - 1.0).abs() < 1e-15);
        for range_m in [0.01, 0.3, 1.0, 2.3, 30.0] {
            let point_m = ray.origin_m + ray.direction * range_m;
            let back = mounted.in_band(project).project(&point_m).unwrap();
            worst = worst.max((back - pixel).norm());
        }
    }
    worst
}

/// V14: the limit of the renderer's truth is 1e-3 px; rounding alone stays below 1e-9.
#[test]
fn projection_undoes_the_ray() {
    for shape in ports() {
        let mut mounted = behind(shape);
        for distortion in [
            Distortion::None,
            Distortion::BrownConrady([-0.12, 0.03, 0.001, -0.002, 0.0]),
        ] {
            let intrinsics = *camera().intrinsics();
            mounted.camera = rodsight_geometry::Camera::new(intrinsics, distortion).unwrap();
            for band in Band::ALL {
                let worst = worst_round_trip_px(&mounted, band, band);
                assert!(
                    worst < 1e-9,
                    "{shape:?} {distortion:?} {band:?}: {worst} px"
                );
            }
        }
    }
}

#[test]
fn projection_of_another_band_or_without_the_port_fails_the_round_trip() {
    let mounted = behind(flat(0.02, 0.01, Vec3::z()));
    assert!(worst_round_trip_px(&mounted, Band::Red, Band::Blue) > 5.0);
    let bare = MountedCamera {
        port: None,
        ..mounted
    };
    let pixel = Pixel::new(1500.0, 700.0);
    let ray = mounted.water_ray(&pixel).unwrap();
    let back = bare.project(&(ray.origin_m + ray.direction)).unwrap();
    assert!((back - pixel).norm() > 100.0, "{back:?}");
}

#[test]
fn line_of_sight_begins_where_its_ray_does() {
    for shape in ports() {
        let mounted = behind(shape).in_band(Band::Blue);
        for pixel in pixels() {
            let ray = mounted.water_ray(&pixel).unwrap();
            let sight = mounted
                .sight(&(ray.origin_m + ray.direction * 1.7))
                .unwrap();
            assert!((sight.pixel - pixel).norm() < 1e-9, "{shape:?}");
            assert!((sight.from_m - ray.origin_m).norm() < 1e-13, "{shape:?}");
        }
    }
}

/// Where a straight line from inside meets the inner or the outer face, in the camera's frame.
fn on_face(shape: &PortShape, outer: bool, towards_m: &Vec3) -> Vec3 {
    match shape {
        PortShape::Flat(flat) => {
            let away_m = flat.distance_m + if outer { flat.thickness_m } else { 0.0 };
            towards_m + flat.normal * (away_m - flat.normal.dot(towards_m))
        }
        PortShape::Dome(dome) => {
            let radius_m = dome.inner_radius_m + if outer { dome.thickness_m } else { 0.0 };
            dome.centre_m + (towards_m - dome.centre_m).normalize() * radius_m
        }
    }
}

/// Where light from the pupil meets the inner face, in the camera's frame.
fn entry_m(shape: &PortShape, air: &Vec3) -> Vec3 {
    match shape {
        PortShape::Flat(flat) => air * (flat.distance_m / air.dot(&flat.normal)),
        PortShape::Dome(dome) => {
            let along_m = air.dot(&dome.centre_m);
            let gap2 = dome.centre_m.norm_squared() - along_m * along_m;
            air * ((dome.inner_radius_m * dome.inner_radius_m - gap2).sqrt() + along_m)
        }
    }
}

/// How fast the optical length of the way to a point seen at a pixel changes as its crossings of the faces are moved, the largest
/// of all moves; zero for light.
fn slope_of_optical_length(mounted: &MountedCamera, pixel: &Pixel, index: f64) -> f64 {
    const STEP_M: f64 = 1e-6;
    let port = mounted.port.unwrap();
    let air = mounted.camera.ray(pixel).unwrap();
    let ray = port.water_ray(&air).unwrap();
    let point_m = ray.origin_m + ray.direction * 1.3;
    let length_m = |inner_m: &Vec3, outer_m: &Vec3| {
        inner_m.norm() + GLASS * (outer_m - inner_m).norm() + index * (point_m - outer_m).norm()
    };
    let (inner_m, outer_m) = (entry_m(port.shape(), &air), ray.origin_m);
    let (air_gap, glass) = (inner_m.norm() > 1e-3, (outer_m - inner_m).norm() > 1e-3);
    let mut worst = 0.0_f64;
    for side in [Vec3::x(), Vec3::y()] {
        let moved = |by: f64| {
            let inner = on_face(port.shape(), false, &(inner_m + side * by));
            let outer = on_face(port.shape(), true, &(outer_m + side * by));
            let ways = [
                (air_gap, inner, outer),
                (air_gap && glass, inner, outer_m),
                (glass, inner_m, outer),
            ];
            ways.map(|(is_free, inner, outer)| {
                if is_free {
                    length_m(&inner, &outer)
                } else {
                    0.0
                }
            })
        };
        for (there, back) in moved(STEP_M).into_iter().zip(moved(-STEP_M)) {
            worst = worst.max(((there - back) / (2.0 * STEP_M)).abs());
        }
    }
    worst
}

/// Fermat: no small change of the way makes its optical length shorter. This knows nothing of Snell's law.
#[test]
fn light_takes_the_shortest_way() {
    for shape in ports() {
        let mounted = behind(shape);
        let index = mounted.port.unwrap().water_index()[Band::Green.index()];
        let worst = |index| {
            pixels()
                .map(|p| slope_of_optical_length(&mounted, &p, index))
                .fold(0.0, f64::max)
        };
        // A few roundings of a metre over the step of a micrometre.
        assert!(worst(index) < 1e-8, "{shape:?}: {}", worst(index));
        // Another water bends otherwise, but for a dome in its place and a port without extent.
        let is_bent = !matches!(shape, PortShape::Dome(dome) if dome.centre_m == Vec3::zeros());
        let has_extent =
            !matches!(shape, PortShape::Flat(flat) if flat.thickness_m + flat.distance_m == 0.0);
        if is_bent && has_extent {
            assert!(
                worst(index + 1e-4) > 1e-6,
                "{shape:?}: {}",
                worst(index + 1e-4)
            );
        }
    }
}

/// Where the limb is seen, the ray touches the rod: `g = (p − o)·m̂ − s r = 0`.
#[test]
fn rays_at_the_limbs_touch_the_rod() {
    let (mut touched, mut missed) = (0, 0);
    for shape in ports() {
        let mounted = behind(shape);
        for (k, direction) in [
            Vec3::z(),
            Vec3::y(),
            Vec3::new(0.5, 0.3, 1.0),
            Vec3::new(1.0, 0.1, -0.2),
        ]
        .iter()
        .enumerate()
        {
            for along_m in [-0.4, 0.0, 0.3] {
                let middle_m = Vec3::new(1.2 + 0.5 * k as f64, -0.3, -1.0);
                let direction = direction.normalize();
                let cylinder = Cylinder {
                    axis: Line3 {
                        point_m: middle_m + direction * along_m,
                        direction,
                    },
                    radius_m: 0.07,
                };
                for (side, band) in [(Side::Plus, Band::Green), (Side::Minus, Band::Blue)] {
                    let mounted = mounted.in_band(band);
                    let limb_m = mounted.limb_point_m(&cylinder, side).unwrap();
                    let from_axis = limb_m - cylinder.axis.point_m;
                    assert!((from_axis.norm() - 0.07).abs() < 1e-15);
                    assert!(from_axis.dot(&direction).abs() < 1e-15);
                    let residual_m = |mounted: &MountedCamera| {
                        let pixel = mounted.project(&limb_m)?;
                        let ray = mounted.water_ray(&pixel)?;
                        cylinder.tangency_residual_m(&ray.origin_m, &ray.direction, side)
                    };
                    let residual = residual_m(&mounted).unwrap();
                    assert!(
                        residual.abs() < 1e-12,
                        "{shape:?} {direction:?}: {residual}"
                    );
                    touched += 1;
                    // The limb of a camera without port is another one.
                    let bare = MountedCamera {
                        port: None,
                        ..mounted
                    };
                    let other_m = bare.limb_point_m(&cylinder, side).unwrap();
                    missed += usize::from((other_m - limb_m).norm() > 1e-6);
                }
            }
        }
    }
    assert!(
        missed * 2 > touched,
        "{missed} of {touched} limbs differ without the port"
    );
}
