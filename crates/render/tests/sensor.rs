//! The sensor: EMVA 1288 photon transfer (V13 of the validation plan), plain noise, clipping, bits, balance, exposure.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use rodsight_geometry::{Image, Samples};
use rodsight_render::{Developed, EyeFrame, Frame, PixelTruth, develop, srgb_decode, srgb_encode};
use rodsight_scene::{Bayer, BayerPattern, Demosaic, Emva, Exposure, Scene, Sensor};

const SENSOR: Emva = Emva {
    full_well_e: 10_500.0,
    read_noise_e: 2.5,
    dark_e: 4.0,
    prnu: 0.006,
    dsnu_e: 1.0,
    adc_bits: 12,
    pattern_seed: 0,
    bayer: None,
};

/// A pair of flat images of the given radiance.
fn flat(radiance: [f32; 3], width_px: u32, height_px: u32) -> Frame {
    let pixel = PixelTruth {
        radiance,
        ..PixelTruth::default()
    };
    let eye = EyeFrame {
        width_px,
        height_px,
        pixels: vec![pixel; (width_px * height_px) as usize],
    };
    Frame {
        left: eye.clone(),
        right: eye,
        backend: "test",
        adapter: String::new(),
    }
}

fn scene(sensor: Sensor, bits: u8) -> Scene {
    Scene {
        sensor,
        bits,
        ..common::empty(16)
    }
}

/// All samples of an image as fractions of full scale.
fn fractions(image: &Image) -> Vec<f64> {
    match image.samples() {
        Samples::U8(values) => values.iter().map(|v| f64::from(*v) / 255.0).collect(),
        Samples::U16(values) => values.iter().map(|v| f64::from(*v) / 65535.0).collect(),
    }
}

fn mean_and_variance(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    (mean, squares / (n - 1.0))
}

/// The raw codes of both eyes.
fn raw_codes(developed: &Developed) -> Vec<f64> {
    let images = developed.raw.iter().flatten();
    let codes = images.flat_map(|image| match image.samples() {
        Samples::U16(values) => values.iter().map(|v| f64::from(*v)),
        Samples::U8(_) => panic!("raw images have 16 bits"),
    });
    codes.collect()
}

/// Mean and variance, in digital numbers of the converter, over flat frames at a level: both eyes, all channels.
fn transfer(emva: Emva, level: f32) -> (f64, f64) {
    let mut scene = scene(Sensor::Emva(emva), 16);
    scene.output.raw = true;
    let developed = develop(&flat([level; 3], 200, 150), &scene).unwrap();
    mean_and_variance(&raw_codes(&developed))
}

/// What the image says of the codes is what the raw image says.
#[test]
fn image_and_raw_image_are_one_exposure() {
    let mut scene = scene(Sensor::Emva(SENSOR), 16);
    scene.output.raw = true;
    let developed = develop(&flat([0.05, 0.3, 0.7], 60, 40), &scene).unwrap();
    let dark = SENSOR.dark_e / SENSOR.full_well_e * 4095.0;
    let images = fractions(&developed.left)
        .into_iter()
        .chain(fractions(&developed.right));
    for (value, code) in images.zip(raw_codes(&developed)) {
        let found = srgb_decode(value) * 4095.0 + dark;
        assert!((found - code).abs() < 0.2, "{found} for {code}");
    }
    scene.output.raw = false;
    let plain = develop(&flat([0.05, 0.3, 0.7], 60, 40), &scene).unwrap();
    assert!(plain.raw.is_none() && plain.left == developed.left);
}

/// Least-squares line: slope and intercept.
fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let (mx, my) = (
        points.iter().map(|p| p.0).sum::<f64>() / n,
        points.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let sxy: f64 = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum();
    let sxx: f64 = points.iter().map(|p| (p.0 - mx) * (p.0 - mx)).sum();
    (sxy / sxx, my - mx * sxy / sxx)
}

/// V13: variance against mean is a line whose slope is the gain and whose intercept is the dark noise. Under colour filters, too;
/// and a gain that is one part in twenty off would be found out.
#[test]
fn photon_transfer_has_the_gain_as_slope_and_the_dark_noise_as_intercept() {
    let filters = Bayer {
        pattern: BayerPattern::Rggb,
        demosaic: Demosaic::Malvar,
    };
    for bayer in [None, Some(filters)] {
        // Without the response's non-uniformity, whose variance grows with the square.
        let emva = Emva {
            prnu: 0.0,
            read_noise_e: 12.0,
            bayer,
            ..SENSOR
        };
        let gain = 4095.0 / emva.full_well_e;
        let levels = [0.02_f32, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6];
        let points: Vec<(f64, f64)> = levels.iter().map(|&level| transfer(emva, level)).collect();
        for (&level, (mean, _)) in levels.iter().zip(&points) {
            let expected = f64::from(level) * 4095.0 + gain * emva.dark_e;
            assert!(
                (mean / expected - 1.0).abs() < 2e-3,
                "level {level}: {mean} for {expected}"
            );
        }
        let (slope, intercept) = line(&points);
        // Dark electrons are in mean and variance alike: the line meets the axis without them.
        let dark_e2 = emva.read_noise_e * emva.read_noise_e + emva.dsnu_e * emva.dsnu_e;
        let expected = gain * gain * dark_e2 + 1.0 / 12.0;
        assert!(
            (slope / gain - 1.0).abs() < 0.02,
            "slope {slope}, gain {gain}"
        );
        assert!(
            (intercept - expected).abs() < 0.1 * expected,
            "intercept {intercept}, expected {expected}"
        );
        let off = Emva {
            full_well_e: emva.full_well_e / 1.05,
            ..emva
        };
        let points: Vec<(f64, f64)> = levels.iter().map(|&level| transfer(off, level)).collect();
        assert!((line(&points).0 / gain - 1.0).abs() > 0.02, "no control");
    }
}

/// V13: what the non-uniformities add to the variance is their own.
#[test]
fn non_uniformities_are_recovered() {
    let variance = |prnu: f64, dsnu_e: f64, level: f32| {
        let emva = Emva {
            prnu,
            dsnu_e,
            ..SENSOR
        };
        transfer(emva, level).1
    };
    let gain = 4095.0 / SENSOR.full_well_e;
    let response = (variance(0.02, 0.0, 0.5) - variance(0.0, 0.0, 0.5)).sqrt() / (0.5 * 4095.0);
    assert!((response / 0.02 - 1.0).abs() < 0.05, "PRNU {response}");
    let offset_e = (variance(0.0, 20.0, 0.1) - variance(0.0, 0.0, 0.1)).sqrt() / gain;
    assert!((offset_e / 20.0 - 1.0).abs() < 0.05, "DSNU {offset_e}");
}

#[test]
fn response_is_a_pixel_s_own_and_differs_between_eyes() {
    let emva = Emva {
        prnu: 0.05,
        ..SENSOR
    };
    let image = |level: f32| {
        let developed = develop(&flat([level; 3], 100, 80), &scene(Sensor::Emva(emva), 16));
        let developed = developed.unwrap();
        [developed.left, developed.right].map(|image| {
            let linear: Vec<f64> = fractions(&image).into_iter().map(srgb_decode).collect();
            linear
        })
    };
    let correlation = |a: &[f64], b: &[f64]| {
        let ((ma, va), (mb, vb)) = (mean_and_variance(a), mean_and_variance(b));
        let products = a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb));
        products.sum::<f64>() / (a.len() as f64 * (va * vb).sqrt())
    };
    let ([left, right], [brighter, _]) = (image(0.3), image(0.6));
    assert!(correlation(&left, &brighter) > 0.9);
    assert!(correlation(&left, &right).abs() < 0.03);
}

#[test]
fn plain_noise_has_the_sigma_asked_for() {
    for (bits, sigma_dn) in [(8, 2.0), (16, 2.0), (16, 0.5), (8, 12.0)] {
        let sensor = Sensor::Plain {
            noise_sigma_dn: sigma_dn,
        };
        let developed = develop(&flat([0.2; 3], 200, 150), &scene(sensor, bits)).unwrap();
        let values: Vec<f64> = fractions(&developed.left)
            .into_iter()
            .map(|v| v * 255.0)
            .collect();
        let (mean, variance) = mean_and_variance(&values);
        let rounding = if bits == 8 { 1.0 / 12.0 } else { 0.0 };
        let found = (variance - rounding).sqrt();
        // Four standard errors of 90 000 samples.
        assert!(
            (found / sigma_dn - 1.0).abs() < 4.0 / (2.0 * values.len() as f64).sqrt(),
            "{bits} bits: {found} for {sigma_dn}"
        );
        let expected = srgb_encode(f64::from(0.2_f32)) * 255.0;
        assert!((mean - expected).abs() < 4.0 * sigma_dn / (values.len() as f64).sqrt() + 0.01);
    }
}

/// On black, half of the noise is cut off; it must not be before it is added.
#[test]
fn plain_noise_is_clipped_after_it_is_added() {
    let sensor = Sensor::Plain {
        noise_sigma_dn: 4.0,
    };
    let developed = develop(&flat([0.0; 3], 100, 80), &scene(sensor, 16)).unwrap();
    let values = fractions(&developed.left);
    let black = values.iter().filter(|v| **v == 0.0).count() as f64 / values.len() as f64;
    assert!((black - 0.5).abs() < 0.02, "{black}");
}

#[test]
fn light_beyond_the_full_well_is_white() {
    for bits in [8, 16] {
        let developed = develop(&flat([3.0; 3], 40, 30), &scene(Sensor::Emva(SENSOR), bits));
        let darkest = fractions(&developed.unwrap().left)
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        // Read noise and the dark level come after the full well: a few electrons of ten thousand.
        assert!(darkest > 0.999, "{bits} bits: {darkest}");
    }
}

#[test]
fn eight_and_sixteen_bits_are_one_image() {
    let radiance = [0.05, 0.3, 0.7];
    for sensor in [
        Sensor::Emva(SENSOR),
        Sensor::Plain {
            noise_sigma_dn: 3.0,
        },
    ] {
        let image = |bits: u8| {
            let developed = develop(&flat(radiance, 60, 40), &scene(sensor, bits)).unwrap();
            fractions(&developed.right)
        };
        for (coarse, fine) in image(8).into_iter().zip(image(16)) {
            assert!(
                (coarse - fine).abs() <= 0.501 / 255.0,
                "{coarse} and {fine}"
            );
        }
    }
}

/// A gain after the sensor makes the noise larger, too.
#[test]
fn white_balance_acts_on_signal_and_noise() {
    let relative_noise = |balance: f64| {
        let scene = Scene {
            white_balance: [balance; 3],
            ..scene(Sensor::Emva(SENSOR), 16)
        };
        let developed = develop(&flat([0.1; 3], 200, 150), &scene).unwrap();
        let linear: Vec<f64> = fractions(&developed.left)
            .into_iter()
            .map(srgb_decode)
            .collect();
        let (mean, variance) = mean_and_variance(&linear);
        assert!(
            (mean / (0.1 * balance) - 1.0).abs() < 2e-3,
            "{mean} at {balance}"
        );
        variance.sqrt() / mean
    };
    let (one, two) = (relative_noise(1.0), relative_noise(2.0));
    assert!((two / one - 1.0).abs() < 1e-3, "{one} and {two}");
}

#[test]
fn automatic_exposure_brings_the_quantile_to_its_level() {
    let mut frame = flat([0.0; 3], 100, 100);
    for eye in [&mut frame.left, &mut frame.right] {
        for (i, pixel) in eye.pixels.iter_mut().enumerate() {
            pixel.radiance = [i as f32 * 1e-3; 3];
        }
    }
    let scene = Scene {
        exposure: Exposure::Auto {
            quantile: 0.9,
            level: 0.6,
        },
        ..scene(
            Sensor::Plain {
                noise_sigma_dn: 0.0,
            },
            16,
        )
    };
    let developed = develop(&frame, &scene).unwrap();
    let values = fractions(&developed.left);
    let below = values.iter().filter(|v| srgb_decode(**v) <= 0.6).count();
    let share = below as f64 / values.len() as f64;
    assert!((share - 0.9).abs() < 1e-3, "{share}");
    assert!((developed.gain * 9.0 / 0.6 - 1.0).abs() < 1e-3);
    let dark = develop(&flat([0.0; 3], 4, 4), &scene);
    assert!(
        matches!(dark, Err(rodsight_render::RenderError::Dark { .. })),
        "{dark:?}"
    );
}

/// The fixed pattern belongs to the specimen: it is common to frames of different seeds, and another specimen has another.
#[test]
fn fixed_pattern_stays_when_the_seed_changes() {
    let codes = |seed: u64, pattern_seed: u64| -> Vec<f64> {
        let emva = Emva {
            prnu: 0.02,
            pattern_seed,
            ..SENSOR
        };
        let scene = Scene {
            seed,
            ..scene(Sensor::Emva(emva), 16)
        };
        let developed = develop(&flat([0.5; 3], 200, 150), &scene).unwrap();
        let left = fractions(&developed.left).into_iter();
        left.map(srgb_decode).collect()
    };
    let covariance = |a: &[f64], b: &[f64]| {
        let ((mean_a, _), (mean_b, _)) = (mean_and_variance(a), mean_and_variance(b));
        let products = a.iter().zip(b).map(|(x, y)| (x - mean_a) * (y - mean_b));
        products.sum::<f64>() / (a.len() - 1) as f64
    };
    let pattern_variance = (0.02_f64 * 0.5) * (0.02 * 0.5);
    let common = covariance(&codes(1, 7), &codes(2, 7));
    assert!(
        (common / pattern_variance - 1.0).abs() < 0.05,
        "{common} for {pattern_variance}"
    );
    let apart = covariance(&codes(1, 7), &codes(2, 8));
    assert!(apart.abs() < 0.05 * pattern_variance, "{apart}");
}
