//! Every way in which an image can be wrong must be found. A comparator that passes one of these has been worthless.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

use rodsight_testkit::{
    Golden, Mismatch, SplitMix64, Tolerance, compare_images, load_reference, seed,
};

const SHAPE: [usize; 3] = [9, 12, 3];
const TOLERANCE: Tolerance = Tolerance {
    max_rel: 1e-3,
    max_abs: 1e-6,
    bad_fraction: 0.0,
    bounded_by: "the negative controls, which differ by 1 %",
};

/// A textured image; the right eye sees it 2 px further left.
fn eye(shift: usize) -> Vec<f32> {
    let [height, width, channels] = SHAPE;
    let mut rng = SplitMix64::new(seed(7, "texture", 0));
    let wide: Vec<f32> = (0..height * (width + 4) * channels)
        .map(|_| rng.between(0.1, 0.9) as f32)
        .collect();
    (0..height)
        .flat_map(|row| {
            let start = (row * (width + 4) + shift) * channels;
            wide[start..start + width * channels].to_vec()
        })
        .collect()
}

#[test]
fn comparator_passes_the_same_image_and_rounding() {
    let image = eye(0);
    let report = compare_images(&image, &image, SHAPE, TOLERANCE).unwrap();
    assert_eq!(
        (report.worst_abs, report.bad_pixels, report.pixels),
        (0.0, 0, 108)
    );
    let rounded: Vec<f32> = image.iter().map(|v| v * 1.0001).collect();
    let report = compare_images(&rounded, &image, SHAPE, TOLERANCE).unwrap();
    assert!(
        report.worst_rel > 5e-5 && report.worst_rel < 2e-4,
        "{report:?}"
    );
}

#[test]
fn comparator_fails_on_a_shift_of_one_pixel() {
    let shifted = compare_images(&eye(1), &eye(0), SHAPE, TOLERANCE).unwrap_err();
    assert!(matches!(shifted, Mismatch::Differ { bad_pixels, .. } if bad_pixels > 100));
}

#[test]
fn comparator_fails_on_one_percent_gain() {
    let image = eye(0);
    let brighter: Vec<f32> = image.iter().map(|v| v * 1.01).collect();
    let mismatch = compare_images(&brighter, &image, SHAPE, TOLERANCE).unwrap_err();
    assert!(matches!(
        mismatch,
        Mismatch::Differ {
            bad_pixels: 108,
            ..
        }
    ));
}

#[test]
fn comparator_fails_on_exchanged_eyes() {
    let pair = [eye(0), eye(2)].concat();
    let exchanged = [eye(2), eye(0)].concat();
    let shape = [SHAPE[0] * 2, SHAPE[1], SHAPE[2]];
    assert!(compare_images(&pair, &pair, shape, TOLERANCE).is_ok());
    assert!(compare_images(&exchanged, &pair, shape, TOLERANCE).is_err());
}

#[test]
fn comparator_fails_on_one_value_that_is_not_finite_even_in_both() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let image = eye(0);
        let mut spoilt = image.clone();
        spoilt[SHAPE[1] * SHAPE[2] + 2 * SHAPE[2] + 1] = bad;
        let lenient = Tolerance {
            bad_fraction: 0.5,
            ..TOLERANCE
        };
        for (actual, expected, named) in [
            (&spoilt, &image, "actual"),
            (&image, &spoilt, "expected"),
            (&spoilt, &spoilt, "actual"),
        ] {
            let mismatch = compare_images(actual, expected, SHAPE, lenient).unwrap_err();
            assert!(
                matches!(mismatch, Mismatch::NotFinite { which, row: 1, column: 2, channel: 1, count: 1, .. } if which == named),
                "{mismatch}"
            );
        }
    }
}

#[test]
fn comparator_fails_on_a_wrong_size_and_on_nothing() {
    let image = eye(0);
    let short = &image[..image.len() - 1];
    for (actual, expected) in [(short, &image[..]), (&image[..], short), (&[], &image[..])] {
        assert!(matches!(
            compare_images(actual, expected, SHAPE, TOLERANCE),
            Err(Mismatch::Size { .. })
        ));
    }
    assert!(matches!(
        compare_images(&[], &[], [0, 12, 3], TOLERANCE),
        Err(Mismatch::Empty { .. })
    ));
}

#[test]
fn comparator_counts_bad_pixels_against_the_fraction() {
    let image = eye(0);
    let mut one_bad = image.clone();
    // Two channels of one pixel are one bad pixel.
    one_bad[0] += 0.1;
    one_bad[1] += 0.1;
    let allowing = |bad_fraction| Tolerance {
        bad_fraction,
        ..TOLERANCE
    };
    let report = compare_images(&one_bad, &image, SHAPE, allowing(1.0 / 108.0)).unwrap();
    assert_eq!(report.bad_pixels, 1);
    assert!(compare_images(&one_bad, &image, SHAPE, allowing(0.9 / 108.0)).is_err());
}

#[test]
fn comparator_fails_on_a_value_where_zero_was_expected() {
    let black = vec![0.0; 108 * 3];
    let mut lit = black.clone();
    lit[5] = 2e-6;
    assert!(compare_images(&lit, &black, SHAPE, TOLERANCE).is_err());
}

#[test]
fn tolerance_that_passes_everything_is_refused() {
    let image = eye(0);
    for tolerance in [
        Tolerance {
            bad_fraction: 1.0,
            ..TOLERANCE
        },
        Tolerance {
            max_rel: f64::NAN,
            ..TOLERANCE
        },
        Tolerance {
            max_abs: f64::INFINITY,
            ..TOLERANCE
        },
        Tolerance {
            max_rel: -1.0,
            ..TOLERANCE
        },
    ] {
        assert!(matches!(
            compare_images(&image, &image, SHAPE, tolerance),
            Err(Mismatch::BadTolerance { .. })
        ));
    }
}

#[test]
fn reference_that_is_missing_empty_or_short_fails() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("reference.f32");
    let missing = load_reference(&path, SHAPE).unwrap_err();
    assert!(matches!(missing, Mismatch::MissingReference { .. }));
    assert!(missing.to_string().contains("reference.f32"), "{missing}");
    for bytes in [vec![], vec![0_u8; 12]] {
        std::fs::write(&path, bytes).unwrap();
        assert!(matches!(
            load_reference(&path, SHAPE),
            Err(Mismatch::BadReference { .. })
        ));
    }
    let image = eye(0);
    let bytes: Vec<u8> = image.iter().flat_map(|v| v.to_le_bytes()).collect();
    std::fs::write(&path, bytes).unwrap();
    assert_eq!(load_reference(&path, SHAPE).unwrap(), image);
}

#[test]
fn mismatch_tells_a_human_where_and_how_much() {
    let expected = vec![0.5; 108 * 3];
    let mut actual = expected.clone();
    actual[(4 * 12 + 7) * 3 + 2] = 0.75;
    let message = compare_images(&actual, &expected, SHAPE, TOLERANCE)
        .unwrap_err()
        .to_string();
    assert_eq!(
        message,
        "1 of 108 pixels differ (0 may): worst at row 4, column 7, channel 2: 0.75 instead of 0.5 (|difference| 2.500e-1, relative 5.000e-1; allowed 1.000e-6 or relative 1.000e-3, bounded by the negative controls, which differ by 1 %)"
    );
}

fn golden() -> Golden {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("golden.toml");
    std::fs::write(&path, "[a]\nb = 1.5\nc = [1, 2.5]\n[[t]]\nx = [3.0, 4.0]\n").unwrap();
    Golden::load(path)
}

#[test]
fn golden_finds_numbers_by_path() {
    let golden = golden();
    assert_eq!(golden.f64("a.b"), 1.5);
    assert_eq!(golden.array("a.c"), [1.0, 2.5]);
    assert_eq!(golden.f64("t.0.x.1"), 4.0);
    assert_eq!(golden.len("t"), 1);
}

#[test]
#[should_panic(expected = "no `d` in `a.d`")]
fn golden_panics_with_the_path_that_is_missing() {
    golden().f64("a.d");
}

#[test]
#[should_panic(expected = "expected 3 numbers, found 2")]
fn golden_panics_on_a_wrong_length() {
    let _: [f64; 3] = golden().array("a.c");
}
