//! What textbooks and papers say of ports: the quartic, thin plates, plates in air, centred domes, the index of water.

use nalgebra::DMatrix;
use rodsight_geometry::port::{Port, PortShape, sea_water_index};
use rodsight_geometry::{Band, Pixel, Vec3, radians};

use super::{GLASS, HALF_FIELD_DEG, WATER, behind, camera, dome, flat, ports, with_indices};

/// Agrawal, Ramalingam, Taguchi, Chari (CVPR 2012): with one refraction at the distance d the place x (from the normal) at which
/// light enters solves a quartic. For a point h beyond the plate and r off the normal, Snell's law squared gives
///
///   (r − x)² (n² d² + (n² − 1) x²) − h² x² = 0.
fn entry_by_quartic_m(distance_m: f64, index: f64, height_m: f64, off_m: f64) -> f64 {
    let (a, b) = (index * index * distance_m * distance_m, index * index - 1.0);
    // Coefficients from x⁰ to x⁴.
    let c = [
        a * off_m * off_m,
        -2.0 * a * off_m,
        a + b * off_m * off_m - height_m * height_m,
        -2.0 * b * off_m,
        b,
    ];
    let mut companion = DMatrix::zeros(4, 4);
    for k in 0..4 {
        companion[(k, 3)] = -c[k] / c[4];
        if k > 0 {
            companion[(k, k - 1)] = 1.0;
        }
    }
    let roots = companion.complex_eigenvalues();
    // Of its real roots one lies between the normal and the point.
    let mut between = roots
        .iter()
        .filter(|z| z.im.abs() < 1e-9 && z.re > 0.0 && z.re < off_m);
    let root = between.next().unwrap().re;
    assert!(between.next().is_none());
    // The eigenvalues of a companion matrix are good to 1e-8 or so: one Newton step more.
    let value = c.iter().rev().fold(0.0, |sum, c| sum * root + c);
    let slope = (1..5)
        .rev()
        .fold(0.0, |sum, k| sum * root + k as f64 * c[k]);
    root - value / slope
}

#[test]
fn projection_agrees_with_the_published_quartic() {
    // Glass like water: all of it is water beyond the first face.
    for (distance_m, thickness_m, glass) in [(0.05, 0.0, GLASS), (0.04, 0.01, WATER)] {
        let shape = flat(distance_m, thickness_m, Vec3::z());
        let port = Port::new(shape, glass, [WATER; 3]).unwrap();
        for (off_m, depth_m) in [(0.1, 0.3), (0.5, 1.0), (1.2, 2.0), (0.02, 5.0), (3.0, 3.0)] {
            let point_m = Vec3::new(0.6 * off_m, -0.8 * off_m, depth_m);
            let air = port.air_direction(&point_m).unwrap();
            let entry_m = distance_m * libm::hypot(air.x, air.y) / air.z;
            let by_quartic_m = entry_by_quartic_m(distance_m, WATER, depth_m - distance_m, off_m);
            // 1e-13 m on a plate 0.05 m away are 2e-9 px of a camera with f = 1000 px.
            assert!(
                (entry_m - by_quartic_m).abs() < 1e-13,
                "{entry_m} {by_quartic_m}"
            );
            let wrong_m = entry_by_quartic_m(distance_m, WATER + 1e-6, depth_m - distance_m, off_m);
            assert!(
                (entry_m - wrong_m).abs() > 1e-10,
                "the quartic does not feel the index"
            );
        }
    }
}

/// An infinitely thin port at the pupil leaves one centre and the law `sin θ_air = n sin θ_water`.
#[test]
fn thin_port_at_the_pupil_is_snells_law_alone() {
    let port = Port::new(flat(0.0, 0.0, Vec3::z()), GLASS, [WATER; 3]).unwrap();
    for angle_deg in [1.0, 10.0, 30.0, 45.0] {
        let (sin, cos) = libm::sincos(radians(angle_deg));
        let air = port
            .air_direction(&Vec3::new(2.0 * sin, 0.0, 2.0 * cos))
            .unwrap();
        assert!((air.x - WATER * sin).abs() < 1e-14, "{angle_deg}°");
        let ray = port.water_ray(&air).unwrap();
        assert_eq!(ray.origin_m, Vec3::zeros());
        assert!((ray.direction.x - sin).abs() < 1e-14, "{angle_deg}°");
    }
    // Beyond the critical angle of 48.3° there is no air direction.
    let (sin, cos) = libm::sincos(radians(48.5));
    assert_eq!(port.air_direction(&Vec3::new(sin, 0.0, cos)), None);
}

/// A plate with air on both sides displaces a ray by t sin θ (1 − cos θ / √(n² − sin² θ)) and does not turn it.
#[test]
fn plate_in_air_only_displaces() {
    let thickness_m = 0.02;
    let port = Port::new(flat(0.03, thickness_m, Vec3::z()), GLASS, [1.0; 3]).unwrap();
    for angle_deg in [0.0, 20.0, 60.0] {
        let (sin, cos) = libm::sincos(radians(angle_deg));
        let air = Vec3::new(sin, 0.0, cos);
        let ray = port.water_ray(&air).unwrap();
        assert!((ray.direction - air).norm() < 1e-15);
        let displaced_m = (ray.origin_m - air * ray.origin_m.dot(&air)).norm();
        let textbook_m = thickness_m * sin * (1.0 - cos / (GLASS * GLASS - sin * sin).sqrt());
        assert!(
            (displaced_m - textbook_m).abs() < 1e-15,
            "{angle_deg}°: {displaced_m}"
        );
    }
}

#[test]
fn centred_dome_and_glass_of_air_refract_nothing() {
    let centred = behind(dome(Vec3::zeros(), 0.06, 0.006));
    let mut airy: Vec<_> = ports()
        .into_iter()
        .map(|shape| with_indices(shape, 1.0, [1.0; 3]))
        .collect();
    airy.push(centred);
    for mounted in airy {
        for pixel in [
            Pixel::new(0.0, 0.0),
            Pixel::new(960.0, 540.0),
            Pixel::new(1900.0, 800.0),
        ] {
            let ray = mounted.water_ray(&pixel).unwrap();
            let straight = mounted
                .rig_from_camera
                .direction(&mounted.camera.ray(&pixel).unwrap());
            let from_pupil = ray.origin_m - mounted.rig_from_camera.origin_m();
            assert!(
                (ray.direction - straight).norm() < 1e-14,
                "{:?}",
                mounted.port
            );
            assert!(
                from_pupil.cross(&straight).norm() < 1e-15,
                "{:?}",
                mounted.port
            );
        }
    }
}

/// A dome out of centre by a thousandth of its radius moves the image by about as much of a radian; one radius larger, less.
#[test]
fn decentred_dome_refracts_in_proportion_to_its_offset() {
    let shift_px = |offset_m: f64| {
        let mounted = with_indices(
            dome(Vec3::new(offset_m, 0.0, 0.0), 0.06, 0.006),
            GLASS,
            [WATER; 3],
        );
        let point_m = mounted.rig_from_camera.point(&Vec3::new(0.0, 0.0, 3.0));
        mounted.project(&point_m).unwrap().x - 960.0
    };
    let (one, two) = (shift_px(5e-5), shift_px(1e-4));
    assert!((two / one - 2.0).abs() < 1e-3, "{one} {two}");
    // Thin-lens theory: a ray at height h from the centre of a thin dome turns by h (n_w − 1)/(n_w R) on entering the air; the glass
    // between 60 and 66 mm adds its own share.
    let thin = camera().intrinsics().fx_px * 5e-5 * (WATER - 1.0) / WATER / 0.063;
    assert!(
        (one.abs() / thin - 1.0).abs() < 0.25,
        "{one} px, thin dome {thin} px"
    );
}

/// Quan & Fry's table in research notes, and the shift it makes at the edge of the field: 7.5 px between red and blue.
#[test]
fn water_disperses_as_published() {
    for ((salinity_psu, temperature_c), published) in [
        ((35.0, 10.0), [1.3399, 1.3427, 1.3452]),
        ((0.0, 20.0), [1.3327, 1.3353, 1.3377]),
    ] {
        let found = sea_water_index(salinity_psu, temperature_c);
        for k in 0..3 {
            assert!((found[k] - published[k]).abs() < 6e-5, "{found:?}");
        }
    }
    let mounted = behind(flat(0.02, 0.01, Vec3::z()));
    let (sin, cos) = libm::sincos(radians(HALF_FIELD_DEG));
    // Far away, so that only the direction counts.
    let point_m = mounted
        .rig_from_camera
        .point(&(Vec3::new(sin, 0.0, cos) * 500.0));
    let at = |band| mounted.in_band(band).project(&point_m).unwrap().x;
    let apart_px = at(Band::Blue) - at(Band::Red);
    assert!((apart_px - 7.5).abs() < 0.1, "{apart_px} px");
}

/// Acrylic's own dispersion (1.490 to 1.498 from 600 to 475 nm), which we leave out, is small beside that.
#[test]
fn dispersion_of_the_glass_is_hundredths_of_a_pixel() {
    let at = |glass: f64| {
        let mounted = with_indices(flat(0.02, 0.01, Vec3::z()), glass, [WATER; 3]);
        let (sin, cos) = libm::sincos(radians(HALF_FIELD_DEG));
        let point_m = mounted
            .rig_from_camera
            .point(&(Vec3::new(sin, 0.0, cos) * 2.0));
        mounted.project(&point_m).unwrap().x
    };
    let apart_px = (at(1.498) - at(1.490)).abs();
    assert!(apart_px > 1e-3 && apart_px < 0.05, "{apart_px} px");
}

#[test]
fn what_is_not_in_the_water_or_not_before_the_port_is_seen_nowhere() {
    for shape in ports() {
        let port = Port::new(shape, GLASS, [WATER; 3]).unwrap();
        assert_eq!(port.air_direction(&Vec3::zeros()), None, "{shape:?}");
        assert_eq!(port.air_direction(&Vec3::new(f64::NAN, 0.0, 1.0)), None);
        if let PortShape::Flat(flat) = &shape {
            assert_eq!(port.air_direction(&-flat.normal), None);
            let along = flat.normal.cross(&Vec3::y()).normalize();
            assert_eq!(port.water_ray(&along), None);
            assert_eq!(port.water_ray(&-flat.normal), None);
        }
    }
}
