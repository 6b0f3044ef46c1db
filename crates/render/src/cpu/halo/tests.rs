//! V9 and V17: the halo's pyramid against closed forms.

use rodsight_optics::{water, width_px};

use super::*;

const WIDTH: usize = 150;
const HEIGHT: usize = 100;
const RANGE_M: f32 = 2.0;
const GREEN: usize = 1;

fn halo() -> Halo {
    Halo::new(&water::by_name("1C").unwrap().medium(), 196.0)
}

fn lit(light: f32) -> Scattered {
    Scattered {
        light: [light; 3],
        range_m: RANGE_M,
    }
}

/// The halo of what is lit in the image and around it.
fn spread(light: impl Fn(f64, f64) -> f32 + Sync) -> Plane {
    let pixels: Vec<PixelTruth> = (0..WIDTH * HEIGHT)
        .map(|i| PixelTruth {
            forward: [light((i % WIDTH) as f64 + 0.5, (i / WIDTH) as f64 + 0.5); 3],
            range_m: RANGE_M,
            ..PixelTruth::NOTHING
        })
        .collect();
    Sources {
        width: WIDTH,
        pixels: &pixels,
        mixed: &vec![Mixed::new(); HEIGHT],
        beyond: |place: &Pixel| lit(light(place.x, place.y)),
        overscan: 32,
    }
    .spread(&halo())
}

/// V9, V17: a plane that shines everywhere stays as it is, from corner to corner, although most of its light comes from outside.
#[test]
fn uniform_light_stays_uniform() {
    for pixel in spread(|_, _| 3.0).pixels() {
        for value in pixel {
            assert!((value / 3.0 - 1.0).abs() < 1e-5, "{value}");
        }
    }
}

/// V17: half planes, upright and level, lit across the whole overscan, against the edge spread of the sum of Gaussians.
#[test]
fn half_plane_has_the_edge_spread() {
    let halo = halo();
    let shares = halo.shares(RANGE_M)[GREEN];
    let edge = |x_px: f64| -> f64 {
        let part = |level: usize| {
            let x = x_px / (core::f64::consts::SQRT_2 * width_px(level));
            f64::from(shares[level]) * 0.5 * (1.0 + libm::erf(x))
        };
        (0..halo.levels()).map(part).sum()
    };
    // On the border of cells of all sizes, and across them. A patch of the overscan that the edge crosses has one ray for both
    // sides, which shows in the outermost pixels.
    for (at_px, inside, at_border) in [(0.0, 0.003, 0.003), (51.0, 0.015, 0.035)] {
        let upright = spread(|x, _| f32::from(u8::from(x > at_px)));
        let level = spread(|_, y| f32::from(u8::from(y > at_px)));
        for (i, (a, b)) in upright.pixels().iter().zip(level.pixels()).enumerate() {
            let (x, y) = ((i % WIDTH) as f64 + 0.5, (i / WIDTH) as f64 + 0.5);
            for (found, distance_px) in [(a[GREEN], x - at_px), (b[GREEN], y - at_px)] {
                let error = f64::from(found) - edge(distance_px);
                let to_border = x.min(y).min(WIDTH as f64 - x).min(HEIGHT as f64 - y);
                let tolerance = if to_border < 8.0 { at_border } else { inside };
                assert!(error.abs() < tolerance, "{distance_px} px: {error}");
            }
        }
    }
}

/// V17: one bright pixel against the direct sum of Gaussians, relative to what is there, out to where hardly anything is.
#[test]
fn point_spread_is_the_sum_of_gaussians() {
    let levels = halo().levels();
    let shares = halo().shares(RANGE_M)[GREEN];
    for (u, v) in [(75_u16, 50_u16), (76, 50), (41, 37), (3, 97)] {
        let (u, v) = (f64::from(u), f64::from(v));
        let at = (u + 0.5, v + 0.5);
        let found = spread(|x, y| f32::from(u8::from((x, y) == at)));
        let integral = |from: f64, sigma: f64| {
            let phi = |x: f64| libm::erf(x / (core::f64::consts::SQRT_2 * sigma));
            0.5 * (phi(from + 0.5) - phi(from - 0.5))
        };
        for (i, pixel) in found.pixels().iter().enumerate() {
            let (dx, dy) = ((i % WIDTH) as f64 - u, (i / WIDTH) as f64 - v);
            let expected: f64 = (1..levels)
                .map(|level| {
                    let sigma = width_px(level);
                    f64::from(shares[level]) * integral(dx, sigma) * integral(dy, sigma)
                })
                .sum::<f64>()
                + if dx == 0.0 && dy == 0.0 {
                    f64::from(shares[0])
                } else {
                    0.0
                };
            let error = f64::from(pixel[GREEN]) / expected - 1.0;
            // Cells show in the tails of each width, where there is least of it: at 20 px 1e-4 of the light of a pixel.
            let near = dx * dx + dy * dy < 400.0;
            let tolerance = if near { 0.2 } else { 0.4 };
            assert!(
                error.abs() < tolerance,
                "({u}, {v}) + ({dx}, {dy}): {error} of {expected}"
            );
        }
    }
}

/// A pixel of two distances counts as the sum of both, wherever it lies.
#[test]
fn mixed_pixels_count_as_their_parts() {
    let mut mixed = vec![Mixed::new(); HEIGHT];
    let mut pixels = vec![PixelTruth::NOTHING; WIDTH * HEIGHT];
    mixed[33] = vec![(149, lit(0.25)), (149, lit(0.75))];
    let sources = |pixels: &[PixelTruth], mixed: &[Mixed]| {
        Sources {
            width: WIDTH,
            pixels,
            mixed,
            beyond: |_: &Pixel| Scattered::default(),
            overscan: 32,
        }
        .spread(&halo())
    };
    let parts = sources(&pixels, &mixed);
    pixels[33 * WIDTH + 149].forward = [1.0; 3];
    pixels[33 * WIDTH + 149].range_m = RANGE_M;
    let whole = sources(&pixels, &vec![Mixed::new(); HEIGHT]);
    for (a, b) in parts.pixels().iter().zip(whole.pixels()) {
        assert!(
            (a[GREEN] - b[GREEN]).abs() <= 1e-6 * b[GREEN],
            "{a:?} {b:?}"
        );
    }
    assert!(whole.pixels()[33 * WIDTH + 140][GREEN] > 0.0);
}
