//! Random numbers, photons, colour filters, sRGB.

use rodsight_geometry::Eye;
use rodsight_scene::{Bayer, BayerPattern, Demosaic, Emva};

use super::{grid, random, steps};
use crate::develop::bayer::{filter, mirrored};
use crate::develop::emva::Chip;
use crate::gpu::shader_parity::Row;
use crate::noise::Philox;
use crate::noise::quantile::{CUBICS, normal};
use crate::srgb::srgb_encode;

/// What `emva_expose` and `noise_poisson` are given: a rounding error in it must not change a whole number.
const HAIR: f64 = 3e-6;

/// Numbers of 16 bits, two a word, the higher first.
fn halves(words: &[u32]) -> Vec<f32> {
    let halves = words.iter().flat_map(|word| [word >> 16, word & 0xffff]);
    halves.map(|half| half as f32).collect()
}

fn word(x: &[f64], at: usize) -> u32 {
    (x[2 * at] as u32) << 16 | x[2 * at + 1] as u32
}

/// Rows of so many words, the extremes among them.
fn words(rows: u32, columns: u32) -> Vec<Vec<f32>> {
    let row = |i: u32| {
        let of = |k: u32| match i {
            0 => 0,
            1 => u32::MAX,
            _ => Philox::new(50).words([i, k, 0, 0])[0],
        };
        halves(&(0..columns).map(of).collect::<Vec<_>>())
    };
    (0..rows).map(row).collect()
}

macro_rules! with_words {
    ($body:literal) => {
        concat!(
            "let h = array(vec2<u32>(v(0u).xy), vec2<u32>(v(2u).xy)); ",
            "let a = (h[0].x << 16u) | h[0].y; let b = (h[1].x << 16u) | h[1].y;\n",
            $body
        )
    };
}

fn split(words: &[u32]) -> Vec<f64> {
    halves(words).into_iter().map(f64::from).collect()
}

/// Words of the tails' cells, from the very ends inwards.
fn tails() -> Vec<Vec<f32>> {
    let low = (0..2000_u32).map(|i| if i < 300 { i } else { i * i * 8 });
    let low = low.filter(|word| *word < 1 << 25);
    low.flat_map(|word| [word, !word])
        .map(|word| halves(&[word, 0]))
        .collect()
}

fn cells() -> Vec<Vec<f32>> {
    let row = |i: u32| {
        let word = i << 18 | Philox::new(51).words([i, 0, 0, 0])[0] >> 14;
        let cubic = CUBICS[(word >> 23) as usize].map(|c| c as f32);
        [halves(&[word, 0]), cubic.to_vec()].concat()
    };
    (0..1 << 14).map(row).collect()
}

const SEED: u64 = 0x1234_5678_9ABC_DEF0;

fn poisson(x: &[f64], mean: f64) -> f64 {
    Philox::new(SEED).poisson(mean, x[1], [x[2] as u32, 1, 0x103, 0])
}

/// Means from none to the full well, below and above 30.
fn means() -> Vec<Vec<f32>> {
    let few = grid(&[
        &[0.0, 0.02, 0.3, 2.0, 8.0, 17.0, 29.9],
        &[0.0],
        &steps(0.0, 499.0, 500),
    ]);
    let many = random(52, 4000, 2).into_iter().map(|r| {
        let mean = 30.0 + 10_000.0 * r[0].abs();
        vec![mean, 4.0 * r[1], 0.0]
    });
    let rows = few.into_iter().chain(many);
    let is_clear = |row: &Vec<f32>| {
        let x: Vec<f64> = row.iter().map(|v| f64::from(*v)).collect();
        let at = |share: f64| poisson(&x, x[0] * (1.0 + share));
        at(HAIR) == at(-HAIR)
    };
    let rows: Vec<_> = rows.filter(is_clear).collect();
    assert!(rows.len() > 6500, "{}", rows.len());
    rows
}

/// A sensor of numbers that `f32` holds.
const SENSOR: Emva = Emva {
    full_well_e: 10_500.0,
    read_noise_e: 2.5,
    dark_e: 0.25,
    prnu: 0.007_812_5,
    dsnu_e: 1.0,
    adc_bits: 12,
    pattern_seed: 0,
    bayer: None,
};

fn code(x: &[f64], share: f64) -> u16 {
    let few_photons = [x[5] as u32, 1, 0x103, 0];
    let signal = x[0] * (1.0 + share) / SENSOR.full_well_e;
    Chip::new(&SENSOR, SEED, Eye::Right).expose(signal, [x[1], x[2]], [x[3], x[4]], few_photons)
}

/// Electrons, four normal numbers, a pixel.
fn exposures() -> Vec<Vec<f32>> {
    let rows = random(53, 6000, 6).into_iter().map(|r| {
        // Many of few.
        let light_e = 14_000.0 * r[0].abs().powi(4);
        let pixel = (1e4 * r[5].abs()).floor();
        vec![
            light_e,
            4.0 * r[1],
            4.0 * r[2],
            4.0 * r[3],
            4.0 * r[4],
            pixel,
        ]
    });
    let is_clear = |row: &Vec<f32>| {
        let x: Vec<f64> = row.iter().map(|v| f64::from(*v)).collect();
        code(&x, HAIR) == code(&x, -HAIR)
    };
    let rows: Vec<_> = rows.filter(is_clear).collect();
    assert!(rows.len() > 5500, "{}", rows.len());
    rows
}

fn noise() -> Vec<Row> {
    vec![
        Row {
            name: "noise_mulhi",
            body: with_words!(
                "let m = noise_mulhi(a, b); y(0u, f32(m >> 16u)); y(1u, f32(m & 0xffffu));"
            ),
            inputs: words(2000, 2),
            twin: Box::new(|x| {
                let product = u64::from(word(x, 0)) * u64::from(word(x, 1));
                split(&[(product >> 32) as u32])
            }),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "integers",
        },
        Row {
            name: "noise_words",
            body: "var w: array<u32, 6>; for (var i = 0u; i < 6u; i++) { w[i] = (u32(x(2u * i)) << 16u) | u32(x(2u * i + 1u)); }
                let r = noise_words(vec2<u32>(w[0], w[1]), vec4<u32>(w[2], w[3], w[4], w[5]));
                for (var i = 0u; i < 4u; i++) { y(2u * i, f32(r[i] >> 16u)); y(2u * i + 1u, f32(r[i] & 0xffffu)); }",
            inputs: words(2000, 6),
            twin: Box::new(|x| {
                let [k0, k1, c0, c1, c2, c3] = core::array::from_fn(|i| word(x, i));
                split(&Philox { key: [k0, k1] }.words([c0, c1, c2, c3]))
            }),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "integers",
        },
        Row {
            name: "noise_tail",
            body: with_words!("y(0u, noise_tail(a));"),
            inputs: tails(),
            twin: Box::new(|x| vec![normal(word(x, 0))]),
            relative: 6e-7,
            absolute: 0.0,
            bounded_by: "a logarithm and two polynomials of positive terms",
        },
        Row {
            name: "noise_normal",
            body: with_words!("y(0u, noise_normal(vec4<f32>(v(4u), x(7u)), a));"),
            inputs: cells(),
            twin: Box::new(|x| vec![normal(word(x, 0))]),
            relative: 6e-7,
            absolute: 1e-7,
            bounded_by: "noise_tail; else a cubic of numbers up to 2.4",
        },
        Row {
            name: "noise_poisson",
            body: "let key = vec2<u32>(0x9abcdef0u, 0x12345678u);
                y(0u, noise_poisson(key, x(0u), x(1u), vec4<u32>(u32(x(2u)), 1u, 0x103u, 0u)));",
            inputs: means(),
            twin: Box::new(|x| vec![poisson(x, x[0])]),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "whole numbers, where rounding decides none",
        },
    ]
}

pub(super) fn rows() -> Vec<Row> {
    let mut rows = noise();
    rows.extend([
        Row {
            name: "emva_expose",
            body: "let emva = Emva(10500.0, 2.5, 0.25, 0.0078125, 1.0, 4095.0); let key = vec2<u32>(0x9abcdef0u, 0x12345678u);
                let few = vec4<u32>(u32(x(5u)), 1u, 0x103u, 0u);
                y(0u, f32(emva_expose(emva, key, x(0u), v(1u).xy, v(3u).xy, few)));",
            inputs: exposures(),
            twin: Box::new(|x| vec![code(x, 0.0).into()]),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "whole numbers, where rounding decides none",
        },
        Row {
            name: "bayer_filter",
            body: "y(0u, f32(bayer_filter(vec2<u32>(v(0u).xy), vec2<u32>(v(2u).xy))));",
            inputs: grid(&[&[0.0, 1.0], &[0.0, 1.0], &[0.0, 1.0, 6.0], &[0.0, 1.0, 7.0]]),
            twin: Box::new(|x| {
                let pattern = match [x[0] as usize, x[1] as usize] {
                    [0, 0] => BayerPattern::Rggb,
                    [1, 0] => BayerPattern::Grbg,
                    [0, 1] => BayerPattern::Gbrg,
                    _ => BayerPattern::Bggr,
                };
                let demosaic = Demosaic::Bilinear;
                vec![filter(Bayer { pattern, demosaic }, x[2] as usize, x[3] as usize) as f64]
            }),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "whole numbers",
        },
        Row {
            name: "bayer_mirrored",
            body: "y(0u, f32(bayer_mirrored(i32(x(0u) + x(1u)), i32(x(2u)))));",
            inputs: grid(&[&[0.0], &[-2.0, -1.0, 0.0, 1.0, 2.0, 3.0], &[1.0, 2.0, 3.0, 7.0]]),
            twin: Box::new(|x| vec![mirrored(x[0] as usize, x[1] as isize, x[2] as usize) as f64]),
            relative: 0.0,
            absolute: 1e-9,
            bounded_by: "whole numbers",
        },
        Row {
            name: "srgb_encode",
            body: "y(0u, srgb_encode(x(0u)));",
            inputs: grid(&[&[&steps(-0.1, 1.1, 4001)[..], &steps(0.0, 0.02, 1001)].concat()]),
            twin: Box::new(|x| vec![srgb_encode(x[0])]),
            relative: 0.0,
            absolute: 3e-7,
            bounded_by: "rounding of sums near 1: a fiftieth of a digit of 16 bits",
        },
    ]);
    rows
}
