//! Colour filters: what demosaicing must leave alone, and its published kernels by hand. Read through the raw image and the matrix.

#![allow(
    clippy::unwrap_used,
    clippy::needless_range_loop,
    clippy::allow_attributes,
    reason = "helpers of tests may panic, and bands are counted 0 to 2; not every test binary needs each"
)]

mod common;

use rodsight_geometry::{Image, Samples};
use rodsight_render::{Developed, EyeFrame, Frame, PixelTruth, develop, srgb_decode};
use rodsight_scene::{Bayer, BayerPattern, Demosaic, Emva, Output, Scene, Sensor};

const PATTERNS: [(BayerPattern, [usize; 4]); 4] = [
    (BayerPattern::Rggb, [0, 1, 1, 2]),
    (BayerPattern::Bggr, [2, 1, 1, 0]),
    (BayerPattern::Grbg, [1, 0, 2, 1]),
    (BayerPattern::Gbrg, [1, 2, 0, 1]),
];

/// No noise but the photons'; of those so many that the codes are the light.
fn silent(bayer: Option<Bayer>) -> Sensor {
    Sensor::Emva(Emva {
        full_well_e: 1e12,
        read_noise_e: 0.0,
        dark_e: 0.0,
        prnu: 0.0,
        dsnu_e: 0.0,
        adc_bits: 12,
        pattern_seed: 0,
        bayer,
    })
}

const SIZE: [u32; 2] = [12, 10];

/// Light by a function of column, row and band, in codes.
fn lit(code: impl Fn(u32, u32, usize) -> f64) -> Frame {
    let [width_px, height_px] = SIZE;
    let pixels = (0..width_px * height_px).map(|i| PixelTruth {
        radiance: [0, 1, 2].map(|k| (code(i % width_px, i / width_px, k) / 4095.0) as f32),
        ..PixelTruth::default()
    });
    let eye = EyeFrame {
        width_px,
        height_px,
        pixels: pixels.collect(),
    };
    Frame {
        left: eye.clone(),
        right: eye,
        backend: "test",
        adapter: String::new(),
    }
}

/// An image of the codes that a function of column, row and band says.
fn taken(bayer: Option<Bayer>, code: impl Fn(u32, u32, usize) -> f64) -> Developed {
    let scene = Scene {
        sensor: silent(bayer),
        output: Output {
            raw: true,
            ..Output::default()
        },
        ..common::empty(16)
    };
    develop(&lit(code), &scene).unwrap()
}

/// Codes, back from the 16-bit image: to a tenth of a code.
fn codes(image: &Image, column: u32, row: u32) -> [f64; 3] {
    let Samples::U16(values) = image.samples() else {
        panic!("16 bits")
    };
    let at = 3 * (row * image.width_px() + column) as usize;
    [0, 1, 2].map(|k| srgb_decode(f64::from(values[at + k]) / 65535.0) * 4095.0)
}

fn methods() -> impl Iterator<Item = (Bayer, [usize; 4])> {
    PATTERNS.into_iter().flat_map(|(pattern, filters)| {
        [Demosaic::Bilinear, Demosaic::Malvar]
            .map(|demosaic| (Bayer { pattern, demosaic }, filters))
    })
}

#[test]
fn raw_image_has_the_filter_s_band_in_every_pixel() {
    for (bayer, filters) in methods() {
        let developed = taken(Some(bayer), |_, _, k| [100.0, 200.0, 300.0][k]);
        let [left, _] = developed.raw.unwrap();
        assert_eq!((left.channels(), left.width_px()), (1, SIZE[0]));
        let Samples::U16(codes) = left.samples() else {
            panic!("16 bits")
        };
        for (i, &code) in codes.iter().enumerate() {
            let (column, row) = (i % SIZE[0] as usize, i / SIZE[0] as usize);
            let band = filters[column % 2 + 2 * (row % 2)];
            assert_eq!(code, [100, 200, 300][band], "{bayer:?} {column} {row}");
        }
    }
}

/// Weights that do not sum to one, or a band taken for another, would show here; borders included.
#[test]
fn a_flat_field_stays_flat() {
    for (bayer, _) in methods() {
        let developed = taken(Some(bayer), |_, _, k| [700.0, 1500.0, 2900.0][k]);
        for (row, column) in (0..SIZE[1]).flat_map(|r| (0..SIZE[0]).map(move |c| (r, c))) {
            let found = codes(&developed.left, column, row);
            for (found, expected) in found.into_iter().zip([700.0, 1500.0, 2900.0]) {
                assert!((found - expected).abs() < 0.2, "{bayer:?}: {found}");
            }
        }
    }
}

/// All kernels are symmetric: a slope is exact but for a border of two pixels, where it is mirrored.
#[test]
fn a_slope_stays_a_slope() {
    for (bayer, _) in methods() {
        let light = |c: u32, r: u32, k: usize| {
            500.0 + 60.0 * f64::from(c) + 90.0 * f64::from(r) + 300.0 * k as f64
        };
        let developed = taken(Some(bayer), light);
        for (row, column) in (2..SIZE[1] - 2).flat_map(|r| (2..SIZE[0] - 2).map(move |c| (r, c))) {
            let found = codes(&developed.left, column, row);
            for k in 0..3 {
                let expected = light(column, row, k);
                assert!((found[k] - expected).abs() < 0.3, "{bayer:?} {found:?}");
            }
        }
    }
}

/// Offset from the bright sample, band, eighths.
type Shown = (i32, i32, usize, f64);

/// One bright sample in the dark, in a field of 800 so that nothing is cut off: what the kernels of Malvar, He and Cutler 2004,
/// figure 2, printed in eighths, give its neighbours. The pattern is RGGB, red at even columns and rows.
#[test]
fn malvar_has_its_published_kernels() {
    const STEP: f64 = 1600.0;
    let bayer = Bayer {
        pattern: BayerPattern::Rggb,
        demosaic: Demosaic::Malvar,
    };
    // Where the bright sample is, and where it shows.
    let cases: [((u32, u32), &[Shown]); 3] = [
        // A red sample.
        (
            (4, 4),
            &[
                (0, 0, 0, 8.0),
                (0, 0, 1, 4.0), // green here: centre of the cross
                (0, 0, 2, 6.0), // blue here: centre of the diagonal kernel
                (1, 0, 0, 4.0), // red at the green beside it
                (0, 1, 0, 4.0),
                (1, 1, 0, 2.0),  // red at the blue across
                (2, 0, 1, -1.0), // green at the next red
                (2, 0, 2, -1.5), // blue at the next red
                (0, 2, 1, -1.0),
                (1, 0, 1, 0.0), // green at green is its own
                (1, 0, 2, 0.0), // blue at green asks no red
            ],
        ),
        // A green sample in a row of reds.
        (
            (5, 4),
            &[
                (0, 0, 1, 8.0),
                (0, 0, 0, 5.0), // red and blue here
                (0, 0, 2, 5.0),
                (1, 0, 1, 2.0),  // green at the red beside it
                (0, 1, 1, 2.0),  // green at the blue below it
                (2, 0, 0, -1.0), // red at the next green of the row: along its reds
                (0, 2, 0, 0.5),  // and of the column: across them
                (2, 0, 2, 0.5),  // blue there: the other way round
                (0, 2, 2, -1.0),
                (1, 1, 0, -1.0), // at the green across, in a row of blues
                (1, 1, 2, -1.0),
                (1, 0, 2, 0.0), // blue at red asks no green
            ],
        ),
        // A blue sample.
        (
            (5, 5),
            &[
                (0, 0, 2, 8.0),
                (0, 0, 1, 4.0),
                (0, 0, 0, 6.0),
                (1, 0, 2, 4.0),
                (0, 1, 2, 4.0),
                (1, 1, 2, 2.0),
                (0, 2, 0, -1.5),
            ],
        ),
    ];
    for (bright, shown) in cases {
        let developed = taken(Some(bayer), |c, r, _| {
            if (c, r) == bright {
                800.0 + STEP
            } else {
                800.0
            }
        });
        for &(du, dv, band, eighths) in shown {
            let (column, row) = (
                bright.0.wrapping_add_signed(du),
                bright.1.wrapping_add_signed(dv),
            );
            let found = codes(&developed.left, column, row)[band] - 800.0;
            let expected = STEP * eighths / 8.0;
            assert!(
                (found - expected).abs() < 0.3,
                "{bright:?} {du} {dv} band {band}: {found} for {expected}"
            );
        }
    }
}

/// A step from 400 to 2000 between columns 5 and 6, grey, by hand: the zipper that bilinear interpolation is known for.
#[test]
fn bilinear_makes_its_zipper_at_an_edge() {
    let bayer = Bayer {
        pattern: BayerPattern::Rggb,
        demosaic: Demosaic::Bilinear,
    };
    let developed = taken(Some(bayer), |c, _, _| if c < 6 { 400.0 } else { 2000.0 });
    let at = |column, row, band: usize| codes(&developed.left, column, row)[band];
    // Column 5 of an even row is green between reds of 400 and 2000; of an odd row blue, its greens 400, 400, 400, 2000.
    for (column, row, band, expected) in [
        (5, 4, 0, 1200.0),
        (5, 5, 1, 800.0),
        (5, 4, 1, 400.0),
        (6, 4, 1, 1600.0),
    ] {
        assert!(
            (at(column, row, band) - expected).abs() < 0.3,
            "{column} {row} {band}"
        );
    }
}

#[test]
fn colour_matrix_mixes_balanced_bands() {
    let scene = Scene {
        sensor: Sensor::Plain {
            noise_sigma_dn: 0.0,
        },
        white_balance: [2.0, 1.0, 1.0],
        colour_matrix: Some([[1.5, -0.5, 0.0], [-0.25, 1.5, -0.25], [0.0, -0.75, 1.75]]),
        ..common::empty(16)
    };
    let emva = Scene {
        sensor: silent(None),
        ..scene.clone()
    };
    for scene in [scene, emva] {
        let pixel = PixelTruth {
            radiance: [0.1, 0.3, 0.4],
            ..PixelTruth::default()
        };
        let eye = EyeFrame {
            width_px: 2,
            height_px: 1,
            pixels: vec![pixel; 2],
        };
        let frame = Frame {
            left: eye.clone(),
            right: eye,
            backend: "test",
            adapter: String::new(),
        };
        let found = codes(&develop(&frame, &scene).unwrap().right, 1, 0).map(|code| code / 4095.0);
        // 1.5·0.2 − 0.5·0.3; −0.25·0.2 + 1.5·0.3 − 0.25·0.4; −0.75·0.3 + 1.75·0.4
        for (found, expected) in found.into_iter().zip([0.15, 0.3, 0.475]) {
            assert!((found - expected).abs() < 4e-4, "{found} for {expected}");
        }
    }
}

/// Darkness is taken off all codes, so that those above a full well are not yet white.
#[test]
fn overshoots_are_the_same_with_a_matrix_that_does_nothing() {
    let bayer = methods().map(|(bayer, _)| bayer);
    let bayer = bayer.filter(|bayer| bayer.demosaic == Demosaic::Malvar);
    for bayer in bayer {
        let Sensor::Emva(silent) = silent(Some(bayer)) else {
            unreachable!("silent is EMVA")
        };
        let frame = lit(|column, _, _| if column < 6 { 819.0 } else { 6142.0 });
        let mut scene = Scene {
            sensor: Sensor::Emva(Emva {
                dark_e: 0.1 * silent.full_well_e,
                ..silent
            }),
            ..common::empty(16)
        };
        let without = develop(&frame, &scene).unwrap();
        scene.colour_matrix = Some([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(without, develop(&frame, &scene).unwrap());
        let [columns, rows] = SIZE;
        let places = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        let brightest = places.flat_map(|(column, row)| codes(&without.left, column, row));
        let brightest = brightest.fold(0.0, f64::max);
        assert!(brightest > 4090.0, "an overshoot is white: {brightest}");
    }
}
