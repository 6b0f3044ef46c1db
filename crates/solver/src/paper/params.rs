//! Every parameter of the paper's chain.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::SolveError;

/// How rod and background are told apart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SegmentationMode {
    /// By hue; by luminance (Otsu) for grey images and where rod and background do not differ in hue. The estimate says which.
    #[default]
    Auto,
    /// By hue, or refuse.
    Hue,
    /// By luminance (Otsu 1979).
    Otsu,
}

/// A range of HSV hues (hexagonal hue, red 0°, green 120°, blue 240°), from `from_deg` upwards to `to_deg`, across 360° if need be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct HueWindow {
    /// Start, degrees.
    pub from_deg: f64,
    /// End, degrees.
    pub to_deg: f64,
    /// Smallest saturation (max − min)/max, in [0, 1].
    #[serde(default)]
    pub min_saturation: f64,
    /// Smallest value max/full scale, in [0, 1].
    #[serde(default)]
    pub min_value: f64,
}

/// Which cells of the accumulator are lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum VoteThreshold {
    /// At least so many votes.
    Votes(u32),
    /// At least this fraction of the fullest cell's votes, in (0, 1].
    FractionOfMax(f64),
}

/// Parameters of [`Method::Paper`](crate::Method::Paper) and [`Method::PaperBisector`](crate::Method::PaperBisector). The
/// default is the paper's where it names a value: 2.5 px, 4.5°, 3 px, two refinements.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PaperParams {
    /// How rod and background are told apart.
    pub segmentation: SegmentationMode,
    /// Hues of the rod; absent: learned around the pick, or from the picture.
    pub hue_window: Option<HueWindow>,
    /// Radius of the disc around the pick from which the rod's hue is learned, px.
    pub learn_radius_px: f64,
    /// Width of the rim of the region from which the background's hue is learned, px.
    pub learn_rim_px: u32,
    /// A learned window reaches at least so far to both sides of the rod's hue, degrees.
    pub hue_half_width_min_deg: f64,
    /// A learned window reaches at most so far to both sides of the rod's hue, degrees.
    pub hue_half_width_max_deg: f64,
    /// Radius of the median that takes speckle off the binarised image, px; 0: none, as the paper says nothing of one.
    pub mask_median_radius_px: u32,
    /// Gaussian blur of the binarised image before Canny, px; 0: none.
    pub blur_sigma_px: f64,
    /// Canny's lower threshold on |gx| + |gy| of the 3×3 Sobel operator on 0…255.
    pub canny_low: f64,
    /// Canny's upper threshold, same unit.
    pub canny_high: f64,
    /// Δρ, px.
    pub hough_rho_step_px: f64,
    /// Δθ, degrees; rounded so that a whole number of steps makes 180°.
    pub hough_theta_step_deg: f64,
    /// Which cells are lines.
    pub hough_threshold: VoteThreshold,
    /// A line must be the fullest cell within so many cells to each side, in ρ and in θ.
    pub hough_suppress_bins: u32,
    /// At most so many coarse lines, fullest first.
    pub hough_max_lines: usize,
    /// Edge points nearer than this to a line belong to it: ε of (4), px.
    pub refine_threshold_px: f64,
    /// How many times points are collected and lines refitted.
    pub refine_iterations: u32,
    /// A point whose gradient deviates more than this from the line's normal belongs to something else, degrees.
    pub refine_gradient_tolerance_deg: f64,
    /// Lines nearer than this in the middle of their points are one, px.
    pub merge_rho_px: f64,
    /// Lines nearer than this in direction are one, degrees.
    pub merge_theta_deg: f64,
    /// A limb has at least so many edge points.
    pub min_support: usize,
    /// A limb has at least so many edge points per px of its length.
    pub min_coverage: f64,
    /// Root mean square distance of a limb's points to it, px, at most. Points without any line give ε/√3.
    pub max_rms_px: f64,
    /// Largest angle between two limbs of one rod, degrees.
    pub parallel_tolerance_deg: f64,
    /// Overlap of the two limbs' extents, as a fraction of the shorter, at least.
    pub min_overlap: f64,
    /// Fraction of the strip between the limbs that was taken for rod, at least.
    pub min_fill: f64,
    /// The pick may lie so far outside the strip, px.
    pub pick_margin_px: f64,
    /// The pick's ray may pass the axis at so many radii.
    pub pick_max_gap_radii: f64,
    /// Standard deviation of a shift of everything in both images alike, px: Canny on a binary image picks the first of two
    /// equal pixels, half a pixel off to the same side.
    pub common_floor_px: f64,
    /// Standard deviation of a shift of each limb by itself, px: where the threshold cuts a soft, shaded edge.
    pub limb_floor_px: f64,
    /// Standard deviation of the change of that shift from one end of a limb to the other, px.
    pub tilt_floor_px: f64,
    /// Refused above this standard deviation of the depth over the depth.
    pub max_relative_depth_sigma: f64,
    /// Refused below this angle between the two axis planes, degrees.
    pub min_plane_angle_deg: f64,
    /// Degraded when the radii of the two eyes, or the measured and the given one, differ by more than so many sigma.
    pub radius_mismatch_degraded_sigmas: f64,
    /// Refused when, beyond that, they differ by more than this fraction.
    pub radius_mismatch_refused: f64,
    /// Refused when the radii of the two eyes differ by more than so many sigma.
    pub radius_mismatch_refused_sigmas: f64,
    /// Degraded when the second-best rod has more than this fraction of the best one's score.
    pub runner_up_degraded: f64,
}

impl Default for PaperParams {
    fn default() -> Self {
        Self {
            segmentation: SegmentationMode::Auto,
            hue_window: None,
            learn_radius_px: 4.0,
            learn_rim_px: 4,
            hue_half_width_min_deg: 8.0,
            hue_half_width_max_deg: 60.0,
            mask_median_radius_px: 1,
            blur_sigma_px: 0.0,
            canny_low: 100.0,
            canny_high: 200.0,
            hough_rho_step_px: 2.5,
            hough_theta_step_deg: 4.5,
            hough_threshold: VoteThreshold::FractionOfMax(0.04),
            hough_suppress_bins: 1,
            hough_max_lines: 128,
            refine_threshold_px: 3.0,
            refine_iterations: 2,
            refine_gradient_tolerance_deg: 60.0,
            merge_rho_px: 1.5,
            merge_theta_deg: 1.0,
            min_support: 30,
            min_coverage: 0.3,
            max_rms_px: 1.2,
            parallel_tolerance_deg: 20.0,
            min_overlap: 0.4,
            min_fill: 0.6,
            pick_margin_px: 10.0,
            pick_max_gap_radii: 1.5,
            common_floor_px: 0.5,
            limb_floor_px: 0.5,
            tilt_floor_px: 0.25,
            max_relative_depth_sigma: 0.05,
            min_plane_angle_deg: 0.2,
            radius_mismatch_degraded_sigmas: 3.0,
            radius_mismatch_refused: 0.6,
            radius_mismatch_refused_sigmas: 25.0,
            runner_up_degraded: 0.6,
        }
    }
}

impl PaperParams {
    /// Checks every range.
    ///
    /// # Errors
    /// The first parameter out of its range: its name, what was expected, what was found.
    pub fn validate(&self) -> Result<(), SolveError> {
        let check = |name, expected, found: f64, good: bool| {
            if good && found.is_finite() {
                return Ok(());
            }
            Err(SolveError::Parameter {
                name,
                expected,
                found,
            })
        };
        let positive = |name, found: f64| check(name, "a positive number", found, found > 0.0);
        let not_negative = |name, found: f64| check(name, "zero or more", found, found >= 0.0);
        let unit = |name, found: f64| check(name, "0 to 1", found, (0.0..=1.0).contains(&found));
        let acute = |name, found: f64| {
            check(
                name,
                "above 0 and up to 90",
                found,
                found > 0.0 && found <= 90.0,
            )
        };
        if let Some(window) = &self.hue_window {
            check(
                "hue_window.from_deg",
                "a finite number",
                window.from_deg,
                true,
            )?;
            check("hue_window.to_deg", "a finite number", window.to_deg, true)?;
            unit("hue_window.min_saturation", window.min_saturation)?;
            unit("hue_window.min_value", window.min_value)?;
        }
        let radius = self.learn_radius_px;
        check(
            "learn_radius_px",
            "0 to 1000",
            radius,
            (0.0..=1000.0).contains(&radius),
        )?;
        check(
            "learn_rim_px",
            "1 or more",
            f64::from(self.learn_rim_px),
            self.learn_rim_px >= 1,
        )?;
        let (least, most) = (self.hue_half_width_min_deg, self.hue_half_width_max_deg);
        check(
            "hue_half_width_max_deg",
            "above 0, below 180",
            most,
            most > 0.0 && most < 180.0,
        )?;
        check(
            "hue_half_width_min_deg",
            "above 0, up to hue_half_width_max_deg",
            least,
            least > 0.0 && least <= most,
        )?;
        let radius = self.mask_median_radius_px;
        check(
            "mask_median_radius_px",
            "0 to 50",
            f64::from(radius),
            radius <= 50,
        )?;
        let blur = self.blur_sigma_px;
        check(
            "blur_sigma_px",
            "0 to 50",
            blur,
            (0.0..=50.0).contains(&blur),
        )?;
        positive("canny_low", self.canny_low)?;
        check(
            "canny_high",
            "canny_low or more",
            self.canny_high,
            self.canny_high >= self.canny_low,
        )?;
        let step = self.hough_rho_step_px;
        check(
            "hough_rho_step_px",
            "0.05 to 100",
            step,
            (0.05..=100.0).contains(&step),
        )?;
        let step = self.hough_theta_step_deg;
        check(
            "hough_theta_step_deg",
            "0.02 to 45",
            step,
            (0.02..=45.0).contains(&step),
        )?;
        match self.hough_threshold {
            VoteThreshold::Votes(votes) => {
                positive("hough_threshold.votes", f64::from(votes))?;
            }
            VoteThreshold::FractionOfMax(fraction) => check(
                "hough_threshold.fraction_of_max",
                "above 0 and up to 1",
                fraction,
                fraction > 0.0 && fraction <= 1.0,
            )?,
        }
        let bins = f64::from(self.hough_suppress_bins);
        check("hough_suppress_bins", "0 to 100", bins, bins <= 100.0)?;
        let lines = self.hough_max_lines;
        check(
            "hough_max_lines",
            "2 to 1000",
            lines as f64,
            (2..=1000).contains(&lines),
        )?;
        positive("refine_threshold_px", self.refine_threshold_px)?;
        let rounds = self.refine_iterations;
        check(
            "refine_iterations",
            "1 to 1000",
            f64::from(rounds),
            (1..=1000).contains(&rounds),
        )?;
        acute(
            "refine_gradient_tolerance_deg",
            self.refine_gradient_tolerance_deg,
        )?;
        not_negative("merge_rho_px", self.merge_rho_px)?;
        not_negative("merge_theta_deg", self.merge_theta_deg)?;
        check(
            "min_support",
            "2 or more",
            self.min_support as f64,
            self.min_support >= 2,
        )?;
        not_negative("min_coverage", self.min_coverage)?;
        positive("max_rms_px", self.max_rms_px)?;
        acute("parallel_tolerance_deg", self.parallel_tolerance_deg)?;
        unit("min_overlap", self.min_overlap)?;
        unit("min_fill", self.min_fill)?;
        not_negative("pick_margin_px", self.pick_margin_px)?;
        not_negative("pick_max_gap_radii", self.pick_max_gap_radii)?;
        not_negative("common_floor_px", self.common_floor_px)?;
        not_negative("limb_floor_px", self.limb_floor_px)?;
        not_negative("tilt_floor_px", self.tilt_floor_px)?;
        positive("max_relative_depth_sigma", self.max_relative_depth_sigma)?;
        not_negative("min_plane_angle_deg", self.min_plane_angle_deg)?;
        positive(
            "radius_mismatch_degraded_sigmas",
            self.radius_mismatch_degraded_sigmas,
        )?;
        positive(
            "radius_mismatch_refused_sigmas",
            self.radius_mismatch_refused_sigmas,
        )?;
        positive("radius_mismatch_refused", self.radius_mismatch_refused)?;
        unit("runner_up_degraded", self.runner_up_degraded)
    }
}
