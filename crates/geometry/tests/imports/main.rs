//! Calibrations of other tools: that they are read right, and that wrong ones are refused with file, key, expected and found.
//!
//! `fixtures/opencv_cv2.yaml` was written by `cv2.FileStorage` 5.0.0; the pixels below are those of `cv2.projectPoints` with
//! the same numbers. `fixtures/opencv_samples.yml` and `fixtures/kalibr_camchain.yaml` follow the tools' own samples.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on panics")]

mod kalibr;
mod opencv;

use std::path::{Path, PathBuf};

use rodsight_geometry::{Mat3, Rig};

pub(crate) fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/fixtures")
        .join(name)
}

pub(crate) fn text(name: &str) -> String {
    std::fs::read_to_string(fixture(name)).unwrap()
}

/// The message with which a changed fixture is refused.
#[track_caller]
pub(crate) fn refused(name: &str, from: &str, to: &str) -> String {
    let original = text(name);
    assert!(original.contains(from), "{name} has no `{from}`");
    message(&original.replace(from, to))
}

#[track_caller]
pub(crate) fn message(text: &str) -> String {
    let error = Rig::from_yaml(text, Path::new("calib.yaml")).unwrap_err();
    let message = error.to_string();
    assert!(message.starts_with("calib.yaml"), "no file in: {message}");
    message
}

#[track_caller]
pub(crate) fn has(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "no `{part}` in: {message}");
    }
}

pub(crate) const CV2: &str = "opencv_cv2.yaml";
pub(crate) const SAMPLES: &str = "opencv_samples.yml";
pub(crate) const KALIBR: &str = "kalibr_camchain.yaml";

/// Camera axes in the vehicle's: x forward, y starboard, z down.
pub(crate) fn axes() -> Mat3 {
    Mat3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0)
}
