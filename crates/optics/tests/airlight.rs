//! V4 and V10: the scattering integral against closed forms and limits.

use core::f64::consts::PI;

use rodsight_geometry::Vec3;
use rodsight_optics::{Airlight, EquiAngular, Medium, Phase, transmittance, water};

fn medium(phase: Phase) -> Medium {
    Medium::new([0.2, 0.1, 0.05], [0.4, 0.45, 0.5], phase).expect("a valid medium")
}

fn airlight(medium: &Medium, points: u32) -> Airlight<'_> {
    Airlight {
        medium,
        attenuation_per_m: medium.beam_attenuation_per_m(),
        points,
    }
}

/// F(u, v) = ∫₀^v e^(−u tan ξ) dξ, by Simpson's rule.
fn special_f(u: f64, v: f64) -> f64 {
    let n = 4000;
    let value = |k: i32| libm::exp(-u * libm::tan(v * f64::from(k) / f64::from(n)));
    let sum: f64 = (1..n)
        .map(|k| value(k) * if k % 2 == 1 { 4.0 } else { 2.0 })
        .sum();
    v / (3.0 * f64::from(n)) * (value(0) + sum + value(n))
}

/// Airlight of a lamp with an isotropic phase function (Sun et al. 2005): with S the lamp's distance, γ its angle off
/// the ray and h = S sin γ,
///
///   L = b e^(−c S cos γ) / (2π h) [F(c h, π/4 + ½ atan((D − S cos γ)/h)) − F(c h, γ/2)]
fn sun_2005(b: f64, c: f64, lamp: &Vec3, direction: &Vec3, distance_m: f64) -> f64 {
    let along = lamp.dot(direction);
    let h = (lamp - direction * along).norm();
    let gamma = libm::atan2(h, along);
    b * libm::exp(-c * along) / (2.0 * PI * h)
        * (special_f(c * h, PI / 4.0 + 0.5 * libm::atan((distance_m - along) / h))
            - special_f(c * h, 0.5 * gamma))
}

/// Directions over a 63° field, lamps around the camera.
fn rays_and_lamps() -> impl Iterator<Item = (Vec3, Vec3)> {
    let lamps = [
        Vec3::new(-0.4, -0.35, 0.1),
        Vec3::new(0.1, 0.0, 0.0),
        Vec3::new(0.6, -0.2, -0.3),
        Vec3::new(0.3, 0.2, 0.4),
    ];
    (0..25).flat_map(move |k| {
        let (u, v) = (f64::from(k % 5) * 0.3 - 0.6, f64::from(k / 5) * 0.17 - 0.34);
        let direction = Vec3::new(u, v, 1.0).normalize();
        lamps.map(move |lamp| (direction, lamp))
    })
}

#[test]
fn airlight_isotropic_matches_the_closed_form() {
    let medium = medium(Phase::Isotropic);
    let c = medium.beam_attenuation_per_m();
    let b = medium.scattering_per_m();
    for (points, tolerance) in [(16, 5e-3), (256, 5e-5)] {
        for distance_m in [0.7, 2.3, 6.0] {
            for (direction, lamp) in rays_and_lamps() {
                let found =
                    airlight(&medium, points).lamp(&lamp, &direction, distance_m, |_, _| 1.0);
                for k in 0..3 {
                    let exact = sun_2005(b[k], c[k], &lamp, &direction, distance_m);
                    let error = (found[k] / exact - 1.0).abs();
                    assert!(
                        error < tolerance,
                        "{points} {distance_m} {lamp} {direction}: {error:e}"
                    );
                }
            }
        }
    }
}

#[test]
fn airlight_with_petzold_and_a_cone_converges_to_plain_marching() {
    let medium = water::by_name("1C").unwrap().medium();
    let k = medium.transport_attenuation_per_m();
    let axis = Vec3::new(0.2, 0.15, 1.0).normalize();
    let cone = |w: &Vec3| {
        let x = ((w.dot(&axis) - 0.5) / 0.4).clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    for (direction, lamp) in rays_and_lamps() {
        // The integral itself, in t, with nothing of the equi-angular form in it.
        let (distance_m, steps) = (2.3, 100_000);
        let mut exact = [0.0; 3];
        for j in 0..steps {
            let t = distance_m * (f64::from(j) + 0.5) / f64::from(steps);
            let from_lamp = direction * t - lamp;
            let r = from_lamp.norm();
            let w = from_lamp / r;
            let source = medium.phase().value_per_sr(-w.dot(&direction)) * cone(&w) / (r * r);
            for band in 0..3 {
                exact[band] += source
                    * medium.scattering_per_m()[band]
                    * libm::exp(-k[band] * (r + t))
                    * distance_m
                    / f64::from(steps);
            }
        }
        // Shares of what is typical: in a corner that the cone hardly reaches, percent of nothing mean nothing.
        for (points, tolerance) in [(16, 0.03), (64, 0.003), (1024, 3e-5)] {
            let found = Airlight {
                medium: &medium,
                attenuation_per_m: k,
                points,
            }
            .lamp(&lamp, &direction, distance_m, |w, _| cone(w));
            for band in 0..3 {
                let error = (found[band] - exact[band]).abs() / exact[band].max(1e-4);
                assert!(error < tolerance, "{points} {lamp} {direction}: {error:e}");
            }
        }
    }
}

#[test]
fn scattering_angle_is_forward_for_a_lamp_that_shines_at_the_camera() {
    let along = Vec3::z();
    // A lamp 5 m ahead, just off the ray: its light goes on nearly unturned into the camera.
    for node in EquiAngular::new(&Vec3::new(0.01, 0.0, 5.0), &along, 4.0, 8) {
        assert!(node.cos_scatter > 0.999, "{node:?}");
        assert!(node.from_lamp.z < -0.999);
    }
    // A lamp beside the camera: its light comes back.
    let mut far = 0.0;
    for node in EquiAngular::new(&Vec3::new(0.1, 0.0, 0.0), &along, 4.0, 64) {
        far = node.cos_scatter;
        assert!(far < 0.0, "{node:?}");
    }
    assert!(far < -0.999);
    // A phase function that is all forward shows the lamp ahead and hides the lamp beside.
    let medium = medium(Phase::henyey_greenstein(0.9).unwrap());
    let veil = |lamp: Vec3| airlight(&medium, 64).lamp(&lamp, &along, 2.0, |_, _| 1.0)[1];
    assert!(veil(Vec3::new(0.2, 0.0, 3.0)) > 100.0 * veil(Vec3::new(0.2, 0.0, -1.0)));
}

#[test]
fn nodes_lie_on_the_ray_and_know_their_lamp() {
    let direction = Vec3::new(0.3, -0.2, 1.0).normalize();
    for lamp in [
        Vec3::new(-0.4, 0.3, 0.2),
        Vec3::new(0.5, 0.5, 4.0),
        Vec3::new(0.0, 0.1, -2.0),
    ] {
        let nodes = EquiAngular::new(&lamp, &direction, 3.0, 32);
        assert_eq!(nodes.len(), 32);
        let mut last_t_m = 0.0;
        for node in nodes {
            assert!(node.t_m > last_t_m && node.t_m < 3.0);
            last_t_m = node.t_m;
            let from_lamp = direction * node.t_m - lamp;
            assert!((from_lamp.norm() - node.r_m).abs() < 1e-13);
            assert!((from_lamp / node.r_m - node.from_lamp).norm() < 1e-13);
            assert!((node.cos_scatter + node.from_lamp.dot(&direction)).abs() < 1e-13);
        }
    }
    assert_eq!(EquiAngular::new(&Vec3::x(), &Vec3::z(), 0.0, 16).count(), 0);
    assert_eq!(
        EquiAngular::new(&Vec3::x(), &Vec3::z(), f64::NAN, 16).count(),
        0
    );
    assert_eq!(EquiAngular::new(&Vec3::x(), &Vec3::z(), 1.0, 0).count(), 0);
}

#[test]
fn airlight_through_the_lamp_itself_stays_finite() {
    let medium = medium(Phase::petzold3());
    for lamp in [Vec3::z(), Vec3::new(1e-12, 0.0, 1.0), Vec3::zeros()] {
        let veil = airlight(&medium, 16).lamp(&lamp, &Vec3::z(), 2.0, |w, _| {
            assert!((w.norm() - 1.0).abs() < 1e-12);
            1.0
        });
        assert!(veil.iter().all(|v| v.is_finite() && *v > 0.0), "{veil:?}");
    }
}

#[test]
fn airlight_limits_nothing_scattered_and_saturation() {
    let clear = Medium::new([0.2, 0.1, 0.05], [0.0; 3], Phase::petzold3()).unwrap();
    let lamp = Vec3::new(-0.4, -0.3, 0.1);
    assert_eq!(
        airlight(&clear, 16).lamp(&lamp, &Vec3::z(), 5.0, |_, _| 1.0),
        [0.0; 3]
    );
    // b → 0 in proportion.
    let thin = |b: f64| {
        let medium = Medium::new([0.1; 3], [b; 3], Phase::petzold3()).unwrap();
        Airlight {
            medium: &medium,
            attenuation_per_m: [0.1; 3],
            points: 64,
        }
        .lamp(&lamp, &Vec3::z(), 5.0, |_, _| 1.0)[0]
    };
    assert!((thin(1e-6) / thin(1e-3) * 1e3 - 1.0).abs() < 1e-12);

    let medium = medium(Phase::petzold3());
    let veil =
        |distance_m: f64| airlight(&medium, 512).lamp(&lamp, &Vec3::z(), distance_m, |_, _| 1.0);
    let endless = veil(f64::INFINITY);
    let mut last = [0.0; 3];
    for distance_m in [0.0, 0.01, 0.1, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0] {
        let now = veil(distance_m);
        for k in 0..3 {
            assert!(
                now[k] >= last[k] * (1.0 - 1e-4),
                "{distance_m}: {now:?} after {last:?}"
            );
        }
        last = now;
    }
    for k in 0..3 {
        assert!(
            (last[k] / endless[k] - 1.0).abs() < 1e-3,
            "{last:?} {endless:?}"
        );
    }
}

#[test]
fn airlight_asks_nothing_more_of_a_dark_node() {
    let medium = medium(Phase::petzold3());
    let lamp = Vec3::new(-0.4, -0.3, 0.1);
    let dark = airlight(&medium, 16).lamp(&lamp, &Vec3::z(), 2.0, |_, _| 0.0);
    assert_eq!(dark, [0.0; 3]);
    // The near half and the far half make the whole.
    let part = |keep: fn(f64) -> bool| {
        airlight(&medium, 16).lamp(&lamp, &Vec3::z(), 2.0, |_, t| f64::from(u8::from(keep(t))))
    };
    let (near, far, all) = (part(|t| t < 0.5), part(|t| t >= 0.5), part(|_| true));
    for k in 0..3 {
        assert!((near[k] + far[k] - all[k]).abs() < 1e-15);
    }
}

/// The gain per metre is what a short stretch gains.
#[test]
fn airlight_per_metre_is_the_slope_of_the_airlight() {
    let medium = medium(Phase::petzold3());
    let airlight = airlight(&medium, 512);
    for (direction, lamp) in rays_and_lamps() {
        for distance_m in [0.3, 1.0, 4.0] {
            let step_m = 1e-3;
            let from_m = distance_m - step_m;
            let stretch = airlight.lamp(
                &(lamp - direction * from_m),
                &direction,
                2.0 * step_m,
                |_, _| 1.0,
            );
            let before = transmittance(&airlight.attenuation_per_m, from_m);
            let slope = stretch[1] * before[1] / (2.0 * step_m);
            let gain = airlight.lamp_per_m(&lamp, &direction, distance_m, |_, _| 1.0)[1];
            // Second order in the step: lamps are at least 0.1 m from the ray.
            assert!(
                (gain / slope - 1.0).abs() < 1e-3,
                "{distance_m} m: {gain:e} and {slope:e}"
            );
        }
    }
}
