//! What a solver is asked, and what makes a request senseless.

use core::fmt;
use core::str::FromStr;

use rodsight_geometry::{Eye, Image, Pixel, StereoPair};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::MovedPair;

/// A region of an image: the pixels `x_px..x_px + width_px`, `y_px..y_px + height_px`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Roi {
    /// First column.
    pub x_px: u32,
    /// First row.
    pub y_px: u32,
    /// Columns.
    pub width_px: u32,
    /// Rows.
    pub height_px: u32,
}

impl Roi {
    /// The whole image.
    pub fn whole(image: &Image) -> Self {
        Self {
            x_px: 0,
            y_px: 0,
            width_px: image.width_px(),
            height_px: image.height_px(),
        }
    }

    /// Number of pixels.
    pub fn area_px(&self) -> usize {
        self.width_px as usize * self.height_px as usize
    }

    /// Centre, px from the image's top-left corner.
    pub fn centre_px(&self) -> Pixel {
        Pixel::new(
            f64::from(self.x_px) + 0.5 * f64::from(self.width_px),
            f64::from(self.y_px) + 0.5 * f64::from(self.height_px),
        )
    }
}

impl fmt::Display for Roi {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            x_px,
            y_px,
            width_px,
            height_px,
        } = self;
        write!(f, "{x_px},{y_px},{width_px},{height_px}")
    }
}

/// Where the operator pointed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pick {
    /// px from the top-left corner of the image as taken (not undistorted).
    pub pixel: Pixel,
    /// In which image.
    pub eye: Eye,
}

/// What is known of the rod's radius.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RadiusPrior {
    /// m.
    pub radius_m: f64,
    /// Standard deviation, m; absent: known exactly.
    #[serde(default)]
    pub sigma_m: Option<f64>,
}

/// How well the cameras are known: what is added to what an answer is not sure of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CalibrationSigma {
    /// Standard deviation of where an eye sees anything, across and down, px: of the principal point and of pointing together.
    pub pixel_px: f64,
    /// Standard deviation of an eye's roll, rad.
    #[serde(default)]
    pub roll_rad: f64,
}

/// One pair to solve, or several of one rod.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Images and rig.
    pub pair: &'a StereoPair,
    /// Region of the left image; absent: all of it.
    pub roi_left: Option<Roi>,
    /// Region of the right image; absent: all of it.
    pub roi_right: Option<Roi>,
    /// Absent: the axis is located, no grasp point.
    pub pick: Option<Pick>,
    /// Absent: the radius is measured.
    pub radius: Option<RadiusPrior>,
    /// Absent: the rig is exact.
    pub calibration: Option<CalibrationSigma>,
    /// More pairs of the same rod, of which only `joint` knows what to make. The answer stays in the frame of `pair`'s rig, and the
    /// pick in one of its images.
    pub more: &'a [MovedPair<'a>],
}

impl<'a> Request<'a> {
    /// Whole images, no pick, unknown radius.
    pub fn new(pair: &'a StereoPair) -> Self {
        Self {
            pair,
            roi_left: None,
            roi_right: None,
            pick: None,
            radius: None,
            calibration: None,
            more: &[],
        }
    }

    /// The image of an eye.
    pub fn image(&self, eye: Eye) -> &'a Image {
        match eye {
            Eye::Left => &self.pair.left,
            Eye::Right => &self.pair.right,
        }
    }

    /// The region of an eye: what was asked for, or the whole image.
    pub fn roi(&self, eye: Eye) -> Roi {
        match eye {
            Eye::Left => self.roi_left,
            Eye::Right => self.roi_right,
        }
        .unwrap_or_else(|| Roi::whole(self.image(eye)))
    }

    /// Checks the request against its own images.
    ///
    /// # Errors
    /// A region or a pick outside its image, a radius that is no length, or a move that is none.
    pub fn validate(&self) -> Result<(), SolveError> {
        for eye in Eye::BOTH {
            let (image, roi) = (self.image(eye), self.roi(eye));
            let end = |start: u32, length: u32| u64::from(start) + u64::from(length);
            let fits = roi.width_px > 0
                && roi.height_px > 0
                && end(roi.x_px, roi.width_px) <= u64::from(image.width_px())
                && end(roi.y_px, roi.height_px) <= u64::from(image.height_px());
            if !fits {
                return Err(SolveError::RoiOutside {
                    eye: eye.name(),
                    width_px: image.width_px(),
                    height_px: image.height_px(),
                    found: roi,
                });
            }
        }
        if let Some(pick) = &self.pick
            && !self.pair.rig.eye(pick.eye).camera.contains(&pick.pixel)
        {
            let image = self.image(pick.eye);
            return Err(SolveError::PickOutside {
                eye: pick.eye.name(),
                width_px: image.width_px(),
                height_px: image.height_px(),
                u_px: pick.pixel.x,
                v_px: pick.pixel.y,
            });
        }
        if let Some(calibration) = &self.calibration {
            let CalibrationSigma { pixel_px, roll_rad } = *calibration;
            for (name, found) in [("pixel_px", pixel_px), ("roll_rad", roll_rad)] {
                if !(found.is_finite() && found >= 0.0) {
                    return Err(SolveError::Calibration { name, found });
                }
            }
        }
        for (index, moved) in self.more.iter().enumerate() {
            moved.validate().map_err(|fault| SolveError::InPair {
                number: index + 2,
                fault: Box::new(fault),
            })?;
        }
        let Some(prior) = &self.radius else {
            return Ok(());
        };
        for (name, value) in [
            ("radius_m", Some(prior.radius_m)),
            ("radius sigma_m", prior.sigma_m),
        ] {
            if let Some(found) = value
                && !(found.is_finite() && found > 0.0)
            {
                return Err(SolveError::Radius { name, found });
            }
        }
        Ok(())
    }
}

impl Request<'_> {
    /// Checks that limbs are straight lines once the lens is undone.
    ///
    /// # Errors
    /// A rig with ports.
    pub(crate) fn refuse_ports(&self) -> Result<(), SolveError> {
        let behind = |eye: &Eye| self.pair.rig.eye(*eye).port.is_some();
        match Eye::BOTH.into_iter().find(behind) {
            Some(eye) => Err(SolveError::Port { eye: eye.name() }),
            None => Ok(()),
        }
    }

    /// Checks that there is one pair.
    ///
    /// # Errors
    /// More pairs.
    pub(crate) fn refuse_more(&self) -> Result<(), SolveError> {
        match self.more.len() {
            0 => Ok(()),
            more => Err(SolveError::More { more }),
        }
    }
}

/// Why a request cannot be worked on: it is malformed. A rod that cannot be found is no error but a refused estimate.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum SolveError {
    #[error(
        "{eye} region: expected x,y,width,height inside the image of {width_px}×{height_px} px and not empty, found {found}"
    )]
    RoiOutside {
        eye: &'static str,
        width_px: u32,
        height_px: u32,
        found: Roi,
    },
    #[error(
        "pick: expected a pixel of the {eye} image, 0,0 to {width_px},{height_px}, found {u_px},{v_px}"
    )]
    PickOutside {
        eye: &'static str,
        width_px: u32,
        height_px: u32,
        u_px: f64,
        v_px: f64,
    },
    /// The paper's methods take limbs for straight lines once the lens is undone.
    #[error(
        "rig: expected cameras with one centre of projection, found {eye}.port: behind glass straight rods are seen bent; leave the port out and calibrate focal length and distortion in water (exact at one distance only)"
    )]
    Port { eye: &'static str },
    #[error(
        "more pairs: expected none, found {more}: only joint fits one rod to several pairs of images"
    )]
    More { more: usize },
    /// Pairs count from 1, the first.
    #[error("pair {number}: {fault}")]
    InPair { number: usize, fault: Box<Self> },
    #[error("move: expected {expected}, found {found}")]
    Move { expected: &'static str, found: f64 },
    #[error("{name}: expected a positive number of metres, found {found}")]
    Radius { name: &'static str, found: f64 },
    #[error("calibration {name}: expected a standard deviation, 0 or more, found {found}")]
    Calibration { name: &'static str, found: f64 },
    #[error("parameter {name}: expected {expected}, found {found}")]
    Parameter {
        name: &'static str,
        expected: &'static str,
        found: f64,
    },
}

/// How to locate the rod.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// The paper's chain, faults of the print mended: the centre line averages the limbs.
    Paper,
    /// The same, but the axis plane bisects the tangent planes.
    PaperBisector,
    /// The likeliest rod of all pixels around its limbs in both images.
    Joint,
}

impl Method {
    /// Every method.
    pub const ALL: [Self; 3] = [Self::Paper, Self::PaperBisector, Self::Joint];

    /// As on the command line and in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::PaperBisector => "paper-bisector",
            Self::Joint => "joint",
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A method that does not exist.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("method: expected one of paper, paper-bisector, joint, found `{found}`")]
pub struct UnknownMethod {
    /// What was asked for.
    pub found: String,
}

impl FromStr for Method {
    type Err = UnknownMethod;

    fn from_str(text: &str) -> Result<Self, UnknownMethod> {
        Self::ALL
            .into_iter()
            .find(|method| method.name() == text)
            .ok_or_else(|| UnknownMethod {
                found: text.to_owned(),
            })
    }
}
