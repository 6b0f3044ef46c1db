//! What stands between radiance and the image files, beyond exposure and noise. What is typed is what is meant, so that these
//! types are those of the file and of the scene at once; the checks are here.

use rodsight_geometry::{MountedCamera, Vec3, radians};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::Complaints;
use crate::write::degrees_that_read_back;
use crate::{SceneError, Sensor};

/// A colour filter array over the sensor: each pixel sees one band.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Bayer {
    /// Filters of the first two rows, from the top-left pixel.
    pub pattern: BayerPattern,
    /// How the two missing bands are found.
    #[serde(default)]
    pub demosaic: Demosaic,
}

/// Filters of the first row, then of the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum BayerPattern {
    Rggb,
    Bggr,
    Grbg,
    Gbrg,
}

impl BayerPattern {
    /// Column and row, modulo 2, of the red pixels.
    pub fn red(self) -> [usize; 2] {
        match self {
            Self::Rggb => [0, 0],
            Self::Grbg => [1, 0],
            Self::Gbrg => [0, 1],
            Self::Bggr => [1, 1],
        }
    }
}

/// How a pixel's missing bands are found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Demosaic {
    /// The mean of the nearest samples of the band.
    Bilinear,
    /// The same, corrected by the curvature of the pixel's own band (Malvar, He and Cutler 2004).
    #[default]
    Malvar,
}

/// Checks a colour matrix: each row must keep white white, for that is the white balance's part.
pub(crate) fn colour_matrix(
    no: &Complaints<'_>,
    rows: [[f64; 3]; 3],
) -> Result<[[f64; 3]; 3], SceneError> {
    for (k, row) in rows.into_iter().enumerate() {
        let key = format!("colour_matrix[{k}]");
        no.bands(&key, row, "within -8 to 8", |v| v.abs() <= 8.0)?;
        let sum: f64 = row.iter().sum();
        if !((sum - 1.0).abs() <= 1e-3) {
            return Err(no.value(
                key,
                "three numbers that sum to 1",
                format!("a sum of {sum}"),
            ));
        }
    }
    Ok(rows)
}

/// The lens. Left out, it is perfect: a pinhole that is as bright as a lens.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Lens {
    /// Darker corners: cos⁴θ (1 + v1 r² + v2 r⁴) for `[v1, v2]`, θ the angle of the ray to the optical axis and r the distance from
    /// the principal point over half the image's diagonal. None if absent, not even cos⁴θ.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vignetting: Option<[f64; 2]>,
    /// Standard deviation of the lens's own blur, alike over the image.
    #[serde(skip_serializing_if = "is_zero")]
    pub psf_sigma_px: f64,
    /// The aperture, for depth of field and diffraction; none if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aperture: Option<Aperture>,
}

/// A thin lens. The size of a pixel follows from it: `focal_length_m / fx_px`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Aperture {
    /// Focal length over the diameter of the aperture.
    pub f_number: f64,
    /// Focal length.
    pub focal_length_m: f64,
    /// Depth (z in the camera's frame) of the plane that is sharp: behind a port, that of the point on the optical axis, in the water.
    pub focus_m: f64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde wants a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}

impl Lens {
    pub(crate) fn checked(self, no: &Complaints<'_>) -> Result<Self, SceneError> {
        if let Some([v1, v2]) = self.vignetting {
            let key = "lens.vignetting";
            no.bands(key, [v1, v2, 0.0], "within -10 to 10", |v| v.abs() <= 10.0)?;
            let brightness = |r2: f64| 1.0 + r2 * (v1 + r2 * v2);
            let darkest = (0..=64).map(|i| brightness(f64::from(i) / 64.0));
            let darkest = darkest.fold(f64::INFINITY, f64::min);
            if darkest < 0.0 {
                let expected = "1 + v1 r² + v2 r⁴ >= 0 for r up to 1";
                return Err(no.value(
                    key,
                    expected,
                    format!("[{v1}, {v2}], which comes to {darkest:.3}"),
                ));
            }
        }
        no.number(
            "lens.psf_sigma_px",
            self.psf_sigma_px,
            "between 0 and 100",
            |v| (0.0..=100.0).contains(&v),
        )?;
        if let Some(aperture) = self.aperture {
            let Aperture {
                f_number,
                focal_length_m,
                focus_m,
            } = aperture;
            no.number(
                "lens.aperture.f_number",
                f_number,
                "between 0.5 and 256",
                |v| (0.5..=256.0).contains(&v),
            )?;
            let key = "lens.aperture.focal_length_m";
            no.number(
                key,
                focal_length_m,
                "between 1e-4 and 1 (8 mm is 0.008)",
                |v| (1e-4..=1.0).contains(&v),
            )?;
            no.number(
                "lens.aperture.focus_m",
                focus_m,
                &format!("more than the focal length ({focal_length_m}) and at most 1e6"),
                |v| v > focal_length_m && v <= 1e6,
            )?;
        }
        Ok(self)
    }
}

impl Aperture {
    /// Diameter, m.
    pub fn diameter_m(&self) -> f64 {
        self.focal_length_m / self.f_number
    }

    /// Diameter of the circle of confusion of a point on the axis, px: A fx |1/z − 1/s|, with A the diameter of the aperture, z the
    /// depth of the point and s that in focus, as far as they seem to be in air. (A calibrated fx is that of the lens as it is focused.)
    pub fn blur_px(&self, mounted: &MountedCamera, depth_m: f64) -> f64 {
        let per_m = |depth_m: f64| -> f64 {
            let there = Some(depth_m).filter(|depth_m| depth_m.is_finite());
            let in_air_m = there.and_then(|depth_m| mounted.apparent_depth_m(depth_m));
            in_air_m.map_or(0.0, |depth_m| 1.0 / depth_m)
        };
        let off_per_m = (per_m(depth_m) - per_m(self.focus_m)).abs();
        self.diameter_m() * off_per_m * mounted.camera.intrinsics().fx_px
    }
}

/// How the rig, its cameras and lamps with it, moves while the shutter is open. The scene is as it stands in the middle of the exposure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MotionEntry {
    /// How long the shutter is open.
    pub exposure_s: f64,
    /// Velocity of the rig's origin.
    #[serde(default)]
    pub velocity_m_per_s: [f64; 3],
    /// Axis of the turn about the rig's origin, times its rate.
    #[serde(default)]
    pub turn_deg_per_s: [f64; 3],
}

/// The rig's motion, in its own frame in the middle of the exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// How long the shutter is open, s.
    pub exposure_s: f64,
    /// Velocity of the rig's origin, m/s.
    pub velocity_m_per_s: Vec3,
    /// Angular velocity, rad/s.
    pub turn_rad_per_s: Vec3,
}

impl MotionEntry {
    pub(crate) fn to_motion(self, no: &Complaints<'_>) -> Result<Motion, SceneError> {
        let limited = |key: &str, value, unit_limit: f64| {
            let expected = format!("within -{unit_limit} to {unit_limit}");
            no.bands(key, value, &expected, |v| v.abs() <= unit_limit)
        };
        let turn = limited("motion.turn_deg_per_s", self.turn_deg_per_s, 3600.0)?;
        Ok(Motion {
            exposure_s: no.number(
                "motion.exposure_s",
                self.exposure_s,
                "> 0 and at most 60",
                |v| v > 0.0 && v <= 60.0,
            )?,
            velocity_m_per_s: limited("motion.velocity_m_per_s", self.velocity_m_per_s, 100.0)?
                .into(),
            turn_rad_per_s: turn.map(radians).into(),
        })
    }

    pub(crate) fn from_motion(motion: &Motion) -> Self {
        Self {
            exposure_s: motion.exposure_s,
            velocity_m_per_s: motion.velocity_m_per_s.into(),
            turn_deg_per_s: motion.turn_rad_per_s.map(degrees_that_read_back).into(),
        }
    }
}

/// The image files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Output {
    /// Of `left` and `right`.
    pub format: ImageFormat,
    /// Quality of JPEG, 1 to 100.
    pub jpeg_quality: u8,
    /// Also write the converter's codes as they are, `left_raw.png` and `right_raw.png`: linear, 16 bits, one channel under colour
    /// filters and three without. For `[sensor.emva]`.
    pub raw: bool,
}

impl Default for Output {
    fn default() -> Self {
        Self {
            format: ImageFormat::Png,
            jpeg_quality: 90,
            raw: false,
        }
    }
}

/// Format of the images.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say it")]
pub enum ImageFormat {
    Png,
    Jpeg,
}

impl Output {
    pub(crate) fn checked(
        self,
        no: &Complaints<'_>,
        bits: u8,
        sensor: &Sensor,
    ) -> Result<Self, SceneError> {
        if !(1..=100).contains(&self.jpeg_quality) {
            return Err(no.value("output.jpeg_quality", "1 to 100", self.jpeg_quality));
        }
        if self.format == ImageFormat::Jpeg && bits != 8 {
            let expected = format!("\"png\" with bits = {bits}");
            return Err(no.value("output.format", expected, "\"jpeg\", which has 8 bits"));
        }
        if self.raw && !matches!(sensor, Sensor::Emva(_)) {
            let expected = "[sensor.emva] beside it, whose codes it writes";
            return Err(no.value("output.raw", expected, "[sensor.plain]"));
        }
        Ok(self)
    }
}
