//! V8 and V9: the small-angle transfer function against its limits, and the sum of Gaussians against it.

use core::f64::consts::PI;

use rodsight_optics::{Halo, Lobe, Medium, Phase, Wells, water, width_px};

/// Of the founding camera.
const PX_PER_RAD: f64 = 1566.5776;
const GREEN: usize = 1;

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!(
        (found - expected).abs() <= tolerance,
        "{what}: {found} for {expected}"
    );
}

#[test]
fn mtf_has_the_limits_of_wells() {
    let medium = water::by_name("1C").unwrap().medium();
    let (a, b, c) = (
        medium.absorption_per_m()[GREEN],
        medium.scattering_per_m()[GREEN],
        medium.beam_attenuation_per_m()[GREEN],
    );
    let green = &Wells::of(&medium)[GREEN];
    for z in [0.0, 0.5, 2.0, 4.0] {
        // All that is scattered forwards arrives; nothing of it does at the finest detail.
        close(
            green.mtf(0.0, z),
            libm::exp(-(a + 0.0028 * b) * z),
            1e-6,
            "ψ = 0",
        );
        close(green.mtf(1e9, z), libm::exp(-c * z), 1e-6, "ψ = ∞");
        let mut last = 1.0;
        for k in 0..60 {
            let now = green.mtf(libm::exp2(f64::from(k) / 4.0 - 4.0), z);
            assert!(now <= last, "contrast falls with frequency");
            last = now;
        }
    }
    // Light scattered once: the mean of the lobes' (1 − e^(−u))/u.
    let lobes = medium.phase().forward_lobes();
    let psi = 7.0;
    let once: f64 = lobes
        .iter()
        .map(|lobe| {
            let u = 2.0 * PI * lobe.width_rad * psi;
            lobe.share * (1.0 - libm::exp(-u)) / u
        })
        .sum();
    let shares: f64 = lobes.iter().map(|lobe| lobe.share).sum();
    close(green.halo_mtf(psi, 0.0), once / shares, 1e-12, "z → 0");
    close(green.halo_mtf(psi, 1e-6), once / shares, 1e-6, "z → 0");
    // Both forms of the quotient meet.
    close(
        green.halo_mtf(psi, 30.0 / 0.43 * 0.999),
        green.halo_mtf(psi, 30.0 / 0.43 * 1.01),
        1e-2,
        "z → ∞",
    );
}

/// Widths as optics.md 1.6 and its Monte Carlo have them: 18 and 199 px at f = 1566 px.
#[test]
fn lobes_have_the_published_widths() {
    let lobes = Phase::petzold3().forward_lobes();
    assert_eq!(lobes.len(), 2, "the backward lobe is none");
    close(lobes[0].width_rad, 0.01165, 5e-6, "narrow");
    close(lobes[1].width_rad, 0.1271, 5e-5, "wide");
    assert!(Phase::Isotropic.forward_lobes().is_empty());
    let ring = Phase::lobes(vec![Lobe {
        weight: 1.0,
        g: 0.0,
    }])
    .unwrap();
    assert!(ring.forward_lobes().is_empty());
}

/// The edge-spread function of a half plane after petzold3 water, against the Monte Carlo of 2026 in optics.md 1.6: fraction of the
/// unattenuated plateau 0.46° on the bright and 1.07° on the dark side. Wells is good for 2 % there up to c z = 1.6.
#[test]
fn edge_spread_follows_the_monte_carlo() {
    for (name, z, bright, dark) in [
        ("IB", 3.0, 0.762, 0.068),
        ("III", 2.0, 0.710, 0.099),
        ("1C", 1.0, 0.794, 0.083),
        ("1C", 2.0, 0.640, 0.131),
        ("3C", 2.0, 0.538, 0.162),
    ] {
        let green = &Wells::of(&water::by_name(name).unwrap().medium())[GREEN];
        for (angle_deg, expected) in [(0.46, bright), (-1.07, dark)] {
            close(
                edge_by_quadrature(green, z, angle_deg * PI / 180.0),
                expected,
                0.02,
                name,
            );
        }
    }
}

/// ESF(x) = ½ MTF(0) + (1/π) ∫ MTF(ψ) sin(2π ψ x)/ψ dψ; the unscattered part apart, as its integral does not converge.
fn edge_by_quadrature(band: &Wells, range_m: f64, x_rad: f64) -> f64 {
    let sharp = band.mtf(1e12, range_m);
    let step = 2e-3 / x_rad.abs();
    let integral: f64 = (0..200_000)
        .map(|k| {
            let psi = step * (f64::from(k) + 0.5);
            (band.mtf(psi, range_m) - sharp) * libm::sin(2.0 * PI * psi * x_rad) / psi * step
        })
        .sum();
    let step = if x_rad > 0.0 { sharp } else { 0.0 };
    step + 0.5 * (band.mtf(0.0, range_m) - sharp) + integral / PI
}

/// V8: 1 % of the plateau, at every distance from one pixel to a thousand, from clear to turbid water, for a wide and a coarse camera.
#[test]
fn sum_of_gaussians_has_the_edge_spread_of_the_mtf() {
    for (name, range_m) in [
        ("IB", 3.0),
        ("1C", 2.0),
        ("3C", 2.0),
        ("5C", 2.0),
        ("5C", 0.01),
    ] {
        let medium = water::by_name(name).unwrap().medium();
        for px_per_rad in [PX_PER_RAD, 196.0] {
            let halo = Halo::new(&medium, px_per_rad);
            let shares = halo.shares(range_m as f32);
            let total = halo.total(range_m);
            for (k, band) in Wells::of(&medium).iter().enumerate() {
                let plateau = band.mtf(0.0, range_m);
                for x_px in [1.0, 3.0, 8.0, 20.0, 60.0, 200.0, 600.0, 1000.0] {
                    let gaussians: f64 = (0..halo.levels())
                        .map(|j| {
                            let share = f64::from(shares[k][j]);
                            let x = x_px / (core::f64::consts::SQRT_2 * width_px(j));
                            share * 0.5 * (1.0 + libm::erf(x))
                        })
                        .sum();
                    let sum = libm::exp(-medium.beam_attenuation_per_m()[k] * range_m)
                        + total[k] * gaussians;
                    let exact = edge_by_quadrature(band, range_m, x_px / px_per_rad);
                    close(
                        sum,
                        exact,
                        0.01 * plateau,
                        &format!("{name} {range_m} m, {x_px} px"),
                    );
                }
            }
        }
    }
}

/// V9: no light is lost or made, whatever the range: 1e-6 is f32.
#[test]
fn halo_holds_all_that_is_scattered_forwards() {
    let ff = Phase::FournierForand {
        refractive_index: 1.10,
        junge_slope: 3.5835,
    };
    for phase in [Phase::petzold3(), Phase::petzold4(), ff] {
        let medium = Medium::new([0.25, 0.1, 0.12], [0.42, 0.43, 0.0], phase).unwrap();
        let halo = Halo::new(&medium, PX_PER_RAD);
        for range_m in [1e-3, 0.3, 1.7, 2.0, 5.0, 40.0, 1e3] {
            let total = halo.total(range_m);
            for (k, (shares, band)) in halo
                .shares(range_m as f32)
                .iter()
                .zip(Wells::of(&medium))
                .enumerate()
            {
                assert!(shares.iter().all(|&share| share >= 0.0), "{shares:?}");
                close(f64::from(shares.iter().sum::<f32>()), 1.0, 1e-6, "shares");
                let sharp = libm::exp(-medium.beam_attenuation_per_m()[k] * range_m);
                close(total[k], band.mtf(0.0, range_m) - sharp, 1e-12, "total");
            }
            assert_eq!(total[2], 0.0, "b = 0 scatters nothing");
        }
        assert_eq!(halo.total(0.0), [0.0; 3], "z = 0 scatters nothing");
        // Beyond the widths in use there are none, and the widest holds a rad.
        assert!(width_px(halo.levels() - 1) >= PX_PER_RAD);
        assert_eq!(halo.shares(1.0)[0][halo.levels()], 0.0);
    }
}

#[test]
fn fournier_forand_is_followed_by_lobes() {
    let phase = Phase::FournierForand {
        refractive_index: 1.10,
        junge_slope: 3.5835,
    };
    let lobes = phase.forward_lobes();
    let forward: f64 = lobes.iter().map(|lobe| lobe.share).sum();
    close(
        forward,
        1.0 - phase.backscatter_fraction(),
        1e-12,
        "all but backscatter",
    );
    for angle_deg in [0.01, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 60.0, 90.0] {
        let q = 2.0 * libm::sin(angle_deg * PI / 360.0);
        let sum: f64 = lobes
            .iter()
            .map(|lobe| {
                let x = lobe.width_rad * lobe.width_rad + q * q;
                lobe.share * lobe.width_rad / (2.0 * PI * x * x.sqrt())
            })
            .sum();
        let p = phase.value_per_sr(libm::cos(angle_deg * PI / 180.0));
        // The tails of the lobes beyond 90° are taken from below it.
        close(sum / p, 1.0, 0.07, &format!("{angle_deg}°"));
    }
}
