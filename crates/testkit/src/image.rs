//! Comparing images of linear radiance, depth or ids, value by value. No perceptual metric: a shift of one pixel is the very
//! bug that stereo tests look for.

use std::path::{Path, PathBuf};

/// How far two images may differ, and why so far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Largest |actual − expected| / |expected|.
    pub max_rel: f64,
    /// A difference up to this is never bad, whatever it is relative to: the unit of the image.
    pub max_abs: f64,
    /// Fraction of pixels, in [0, 1), that may be bad: silhouettes. Values that are not finite never may.
    pub bad_fraction: f64,
    /// What bounds it: the reason, in words.
    pub bounded_by: &'static str,
}

/// The pixel that differs most.
#[derive(Clone, Copy, Debug, PartialEq)]
#[expect(missing_docs, reason = "the names say it")]
pub struct Worst {
    pub row: usize,
    pub column: usize,
    pub channel: usize,
    pub actual: f32,
    pub expected: f32,
}

/// How well two images that agree do agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report {
    /// Largest |actual − expected|.
    pub worst_abs: f64,
    /// Largest |actual − expected| / |expected| among differences above `max_abs`.
    pub worst_rel: f64,
    /// Pixels with a bad channel, within `bad_fraction`.
    pub bad_pixels: usize,
    /// All pixels.
    pub pixels: usize,
}

/// Why two images do not agree.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum Mismatch {
    #[error("no reference{}: a test without one tests nothing", .path.as_ref().map(|p| format!(" at {}", p.display())).unwrap_or_default())]
    MissingReference { path: Option<PathBuf> },
    #[error("the reference {}: {message}", .path.display())]
    BadReference { path: PathBuf, message: String },
    #[error("the {which} image: expected {expected} values for shape {shape:?}, found {found}")]
    Size {
        which: &'static str,
        shape: [usize; 3],
        expected: usize,
        found: usize,
    },
    #[error("the shape {shape:?} has no pixels")]
    Empty { shape: [usize; 3] },
    #[error("the tolerance {key} = {found}: expected {expected}")]
    BadTolerance {
        key: &'static str,
        expected: &'static str,
        found: f64,
    },
    #[error(
        "the {which} image is not finite at row {row}, column {column}, channel {channel} ({value}); {count} values in all"
    )]
    NotFinite {
        which: &'static str,
        row: usize,
        column: usize,
        channel: usize,
        value: f32,
        count: usize,
    },
    #[error(
        "{bad_pixels} of {pixels} pixels differ ({allowed} may): worst at row {}, column {}, channel {}: {} instead of {} (|difference| {worst_abs:.3e}, relative {worst_rel:.3e}; allowed {:.3e} or relative {:.3e}, bounded by {})",
        .worst.row, .worst.column, .worst.channel, .worst.actual, .worst.expected,
        .tolerance.max_abs, .tolerance.max_rel, .tolerance.bounded_by
    )]
    Differ {
        bad_pixels: usize,
        allowed: usize,
        pixels: usize,
        worst: Worst,
        worst_abs: f64,
        worst_rel: f64,
        tolerance: Tolerance,
    },
}

/// Compares two images of shape `[height, width, channels]`, row-major.
///
/// # Errors
/// A wrong number of values, no pixels, a value that is not finite in either image, or too many bad pixels.
pub fn compare_images(
    actual: &[f32],
    expected: &[f32],
    shape: [usize; 3],
    tolerance: Tolerance,
) -> Result<Report, Mismatch> {
    check_tolerance(&tolerance)?;
    let [height, width, channels] = shape;
    let pixels = height * width;
    let count = pixels * channels;
    if count == 0 {
        return Err(Mismatch::Empty { shape });
    }
    let place = |i: usize| (i / channels / width, i / channels % width, i % channels);
    for (which, image) in [("actual", actual), ("expected", expected)] {
        if image.len() != count {
            return Err(Mismatch::Size {
                which,
                shape,
                expected: count,
                found: image.len(),
            });
        }
        if let Some(first) = image.iter().position(|v| !v.is_finite()) {
            let (row, column, channel) = place(first);
            return Err(Mismatch::NotFinite {
                which,
                row,
                column,
                channel,
                value: image[first],
                count: image.iter().filter(|v| !v.is_finite()).count(),
            });
        }
    }
    let (mut worst_abs, mut worst_rel, mut bad_pixels) = (0.0_f64, 0.0_f64, 0);
    // The worst is the one that exceeds its own allowance by most.
    let (mut worst, mut worst_excess) = (0, 0.0);
    for pixel in 0..pixels {
        let mut bad = false;
        for i in pixel * channels..(pixel + 1) * channels {
            let (a, e) = (f64::from(actual[i]), f64::from(expected[i]));
            let difference = (a - e).abs();
            worst_abs = worst_abs.max(difference);
            if difference > tolerance.max_abs {
                worst_rel = worst_rel.max(difference / e.abs());
            }
            let excess = difference - tolerance.max_abs.max(tolerance.max_rel * e.abs());
            if excess > 0.0 {
                bad = true;
            }
            if excess > worst_excess {
                (worst, worst_excess) = (i, excess);
            }
        }
        bad_pixels += usize::from(bad);
    }
    let allowed = (tolerance.bad_fraction * pixels as f64) as usize;
    if bad_pixels > allowed {
        let (row, column, channel) = place(worst);
        return Err(Mismatch::Differ {
            bad_pixels,
            allowed,
            pixels,
            worst: Worst {
                row,
                column,
                channel,
                actual: actual[worst],
                expected: expected[worst],
            },
            worst_abs,
            worst_rel,
            tolerance,
        });
    }
    Ok(Report {
        worst_abs,
        worst_rel,
        bad_pixels,
        pixels,
    })
}

/// A tolerance that would pass anything is a mistake.
fn check_tolerance(tolerance: &Tolerance) -> Result<(), Mismatch> {
    for (key, found) in [
        ("max_rel", tolerance.max_rel),
        ("max_abs", tolerance.max_abs),
        ("bad_fraction", tolerance.bad_fraction),
    ] {
        if !(found >= 0.0 && found.is_finite()) {
            return Err(Mismatch::BadTolerance {
                key,
                expected: "a finite number, not negative",
                found,
            });
        }
    }
    if tolerance.bad_fraction >= 1.0 {
        return Err(Mismatch::BadTolerance {
            key: "bad_fraction",
            expected: "less than 1",
            found: tolerance.bad_fraction,
        });
    }
    Ok(())
}

/// Reads a reference image: little-endian `f32` values, row-major, nothing else. A missing or empty file is an error, never a
/// reason to pass.
///
/// # Errors
/// A file that is missing, empty, unreadable, or not of the shape.
pub fn load_reference(path: &Path, shape: [usize; 3]) -> Result<Vec<f32>, Mismatch> {
    let bytes = std::fs::read(path).map_err(|error| {
        if error.kind() == std::io::ErrorKind::NotFound {
            Mismatch::MissingReference {
                path: Some(path.to_owned()),
            }
        } else {
            Mismatch::BadReference {
                path: path.to_owned(),
                message: error.to_string(),
            }
        }
    })?;
    let expected = shape.iter().product::<usize>() * 4;
    if bytes.is_empty() || bytes.len() != expected {
        return Err(Mismatch::BadReference {
            path: path.to_owned(),
            message: format!(
                "expected {expected} bytes for shape {shape:?}, found {}",
                bytes.len()
            ),
        });
    }
    let (values, _) = bytes.as_chunks::<4>();
    Ok(values.iter().map(|v| f32::from_le_bytes(*v)).collect())
}
