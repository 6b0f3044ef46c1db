//! What holds for every medium, and for every row of the table.

use proptest::prelude::*;
use rodsight_geometry::Vec3;
use rodsight_optics::{Airlight, Medium, Phase, transmittance, water};

fn bands(range: core::ops::Range<f64>) -> impl Strategy<Value = [f64; 3]> {
    proptest::array::uniform3(range)
}

fn unit() -> impl Strategy<Value = Vec3> {
    (-1.0..1.0_f64, 0.0..core::f64::consts::TAU).prop_map(|(z, azimuth)| {
        let r = (1.0 - z * z).sqrt();
        Vec3::new(r * libm::cos(azimuth), r * libm::sin(azimuth), z)
    })
}

proptest! {
    #[test]
    fn transmittance_is_multiplicative_in_distance(k in bands(0.0..3.0), s in 0.0..20.0, t in 0.0..20.0) {
        let (first, second, both) = (transmittance(&k, s), transmittance(&k, t), transmittance(&k, s + t));
        for band in 0..3 {
            prop_assert!((first[band] * second[band] / both[band] - 1.0).abs() < 1e-13);
            prop_assert!(both[band] <= first[band] && first[band] <= 1.0);
        }
    }

    #[test]
    fn attenuations_are_ordered(a in bands(0.0..1.0), b in bands(0.0..2.0), g in -0.99..0.99) {
        let medium = Medium::new(a, b, Phase::henyey_greenstein(g).unwrap()).unwrap();
        let (c, k) = (medium.beam_attenuation_per_m(), medium.transport_attenuation_per_m());
        for band in 0..3 {
            prop_assert!(k[band] >= a[band]);
            prop_assert!(g < 0.0 || k[band] <= c[band]);
            prop_assert!((c[band] - a[band] - b[band]).abs() < 1e-15);
        }
    }

    #[test]
    fn phase_is_positive_everywhere(cos in -1.0..1.0, n in 1.02..1.3, slope in 3.1..4.9) {
        for phase in [
            Phase::petzold3(),
            Phase::petzold4(),
            Phase::FournierForand { refractive_index: n, junge_slope: slope },
        ] {
            let p = phase.value_per_sr(cos);
            prop_assert!(p > 0.0 && p.is_finite(), "{:?} {} {}", phase, cos, p);
        }
    }

    /// Turning lamp and ray together changes nothing; nor does more light than there is come back.
    #[test]
    fn airlight_depends_on_relative_geometry_alone(lamp in unit(), ray in unit(), axis in unit(), turn in 0.0..6.0) {
        let medium = water::by_name("II").unwrap().medium();
        let airlight = Airlight {
            medium: &medium,
            attenuation_per_m: medium.beam_attenuation_per_m(),
            points: 16,
        };
        let (sin, cos) = libm::sincos(turn);
        let turned = |v: &Vec3| v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos));
        // A lamp nearly on the ray stands for no real rig, and there every rounding is magnified.
        prop_assume!(lamp.cross(&ray).norm() > 1e-3);
        let here = airlight.lamp(&lamp, &ray, 3.0, |_, _| 1.0);
        let there = airlight.lamp(&turned(&lamp), &turned(&ray), 3.0, |_, _| 1.0);
        for band in 0..3 {
            prop_assert!((here[band] / there[band] - 1.0).abs() < 1e-9);
        }
    }
}

#[test]
fn vacuum_takes_nothing() {
    let vacuum = Medium::vacuum();
    assert!(vacuum.is_vacuum());
    assert_eq!(
        transmittance(&vacuum.beam_attenuation_per_m(), 1e3),
        [1.0; 3]
    );
    assert!(!water::by_name("IB").unwrap().medium().is_vacuum());
    assert_eq!(
        Medium::new([0.0; 3], [0.0; 3], Phase::Isotropic).unwrap(),
        vacuum
    );
}

#[test]
fn waters_are_the_recommended_rows_of_the_table() {
    let names = water::names();
    assert_eq!(
        names,
        [
            "pure_sea", "IB", "II", "III", "1C", "3C", "5C", "I", "IA", "7C", "9C"
        ]
    );
    for name in &names {
        let water = water::by_name(name).unwrap();
        assert_eq!(&water.label, name);
        let medium = water.medium();
        assert_eq!(medium.absorption_per_m(), water.absorption_per_m);
        assert!(medium.beam_attenuation_per_m().iter().all(|&c| c > 0.0));
        // Red is absorbed most in every clear water; the bands are in the right order.
        if name != "9C" && name != "7C" {
            assert!(
                water.absorption_per_m[0] > water.absorption_per_m[2],
                "{name}"
            );
        }
        assert_eq!(
            water.diffuse_attenuation_per_m.is_none(),
            name == "pure_sea"
        );
        assert!(!water.source.is_empty());
    }
    let clear = water::by_name("IB").unwrap();
    assert_eq!(clear.absorption_per_m, [0.227, 0.0516, 0.0372]);
    assert_eq!(clear.scattering_per_m, [0.118, 0.125, 0.131]);
    assert_eq!(clear.confidence, "medium");
    assert!(clear.source.contains("OGL v3"));
    assert_eq!(water::by_name("ib"), None);
}

#[test]
fn waters_have_the_transport_attenuation_of_the_table() {
    // c and K at 525 nm as published with the recommended rows.
    for (name, c, k) in [
        ("IB", 0.177, 0.061),
        ("II", 0.242, 0.075),
        ("III", 0.374, 0.105),
        ("1C", 0.530, 0.131),
        ("3C", 0.786, 0.183),
        ("5C", 1.384, 0.268),
    ] {
        let medium = water::by_name(name).unwrap().medium();
        assert!(
            (medium.beam_attenuation_per_m()[1] - c).abs() < 5.01e-4,
            "{name}"
        );
        assert!(
            (medium.transport_attenuation_per_m()[1] - k).abs() < 7e-4,
            "{name}"
        );
    }
}
