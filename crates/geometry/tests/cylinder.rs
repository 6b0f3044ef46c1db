//! Tangent planes from which no cylinder follows.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use rodsight_geometry::{Cylinder, CylinderError, Line3, Side, TangentPlane, Vec3};

fn planes() -> Vec<TangentPlane> {
    let rod = Cylinder {
        axis: Line3::new(Vec3::new(0.1, 0.2, 2.0), &Vec3::new(0.1, 1.0, 0.2)),
        radius_m: 0.05,
    };
    [Vec3::zeros(), Vec3::x()]
        .iter()
        .flat_map(|centre| {
            let pair = rod.tangent_planes(centre).unwrap();
            [(pair.plus, Side::Plus), (pair.minus, Side::Minus)].map(|(normal, side)| {
                TangentPlane {
                    normal,
                    centre_m: *centre,
                    side,
                }
            })
        })
        .collect()
}

#[test]
fn cylinder_from_too_few_planes_is_refused() {
    for (count, known, needed) in [(2, None, 3), (1, Some(0.05), 2), (0, None, 3)] {
        assert_eq!(
            Cylinder::from_tangent_planes(&planes()[..count], known),
            Err(CylinderError::TooFewPlanes {
                needed,
                found: count
            })
        );
    }
    // One view of both limbs leaves the size open.
    let one_view = Cylinder::from_tangent_planes(&planes()[..2], Some(0.05)).unwrap();
    assert!((one_view.cylinder.axis.distance_m(&Vec3::new(0.1, 0.2, 2.0))) < 1e-9);
    // One limb in two views, its radius known.
    let one_limb = [planes()[0], planes()[2]];
    let one_limb = Cylinder::from_tangent_planes(&one_limb, Some(0.05)).unwrap();
    assert!((one_limb.cylinder.axis.distance_m(&Vec3::new(0.1, 0.2, 2.0))) < 1e-9);
}

#[test]
fn cylinder_from_numbers_that_are_not_finite_is_refused() {
    let mut spoilt = planes();
    spoilt[2].normal.y = f64::NAN;
    assert_eq!(
        Cylinder::from_tangent_planes(&spoilt, None),
        Err(CylinderError::NotFinite { index: 2 })
    );
    for radius_m in [0.0, -0.05, f64::INFINITY] {
        assert_eq!(
            Cylinder::from_tangent_planes(&planes(), Some(radius_m)),
            Err(CylinderError::NegativeRadius { radius_m })
        );
    }
    assert!(Cylinder::from_tangent_planes(&planes(), Some(f64::NAN)).is_err());
}

#[test]
fn cylinder_of_one_repeated_plane_is_degenerate() {
    let one = [planes()[0]; 4];
    for known in [None, Some(0.05)] {
        let refused = Cylinder::from_tangent_planes(&one, known);
        assert!(
            matches!(refused, Err(CylinderError::Degenerate { .. })),
            "{refused:?}"
        );
    }
}

#[test]
fn cylinder_from_inside_has_no_tangents() {
    let rod = Cylinder {
        axis: Line3::new(Vec3::zeros(), &Vec3::x()),
        radius_m: 1.0,
    };
    assert_eq!(rod.tangent_planes(&Vec3::new(3.0, 0.5, 0.5)), None);
    assert_eq!(rod.intersect(&Vec3::zeros(), &Vec3::x()), None);
}
