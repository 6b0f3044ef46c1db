//! Why no answer is given.

/// Reasons of a refusal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum Refusal {
    #[error(
        "{eye} image: no two edges pair up as the limbs of a rod (opposite steps of one colour, nearly parallel)"
    )]
    NoPair { eye: &'static str },
    #[error("pick is off the rod: no rod is seen around it in the {eye} image")]
    PickOffStrip { eye: &'static str },
    #[error("no edges of the left and the right image fit one rod in front of both cameras")]
    NoRod,
    #[error("the limbs cannot be followed through the pixels")]
    Lost,
    #[error(
        "too few limbs: of {number} {unseen} not seen where the others put them, {soft} lost in the rod's own shadow; three are enough, or one in each image and the radius"
    )]
    Unseen {
        number: String,
        unseen: usize,
        soft: usize,
    },
    #[error("no rod fits the pixels: the fit does not come to rest")]
    Restless,
    #[error(
        "{percent:.0} % of the limbs are not those of a straight round rod: hidden, overgrown, bent, or no rod at all"
    )]
    Misfit { percent: f64 },
    #[error(
        "pick is off the rod: its ray passes the axis at {gap_m:.3} m, {radii:.1} radii of the rod"
    )]
    PickOffRod { gap_m: f64, radii: f64 },
    #[error("pick names no point of the rod: {detail}")]
    PickUnusable { detail: String },
    #[error(
        "rod (nearly) parallel to the baseline, or in one plane with it: its depth is not seen; give the radius, move one camera or add a pair from where the rig moved across it"
    )]
    ParallelToBaseline,
    #[error(
        "the radius of {given_mm:.2} mm that was given contradicts the images, which show {seen_mm:.2} ± {sigma_mm:.2} mm: another rod, or leave it out"
    )]
    RadiusContradicts {
        given_mm: f64,
        seen_mm: f64,
        sigma_mm: f64,
    },
    #[error(
        "the pairs contradict each other: what pair {number} shows by itself is not where all together put the rod (χ² = {chi2:.0} of 4): a wrong move, or another rod"
    )]
    Astray { number: usize, chi2: f64 },
    #[error("the depth is uncertain by {relative_percent:.0} %: too short, too faint or too far")]
    DepthUncertain { relative_percent: f64 },
    #[error(
        "the limbs contradict each other: no one rod explains them (χ² = {chi2:.0} of {redundancies} redundancies)"
    )]
    Contradiction { chi2: f64, redundancies: usize },
}

impl Refusal {
    /// Short fixed name.
    pub(crate) fn code(&self) -> &'static str {
        match self {
            Self::NoPair { .. } => "no_pair",
            Self::PickOffStrip { .. } | Self::PickOffRod { .. } => "pick_off_rod",
            Self::NoRod => "no_rod",
            Self::Lost => "lost",
            Self::Unseen { .. } => "unseen",
            Self::Restless => "restless",
            Self::Misfit { .. } => "misfit",
            Self::PickUnusable { .. } => "pick_unusable",
            Self::ParallelToBaseline => "parallel_to_baseline",
            Self::RadiusContradicts { .. } => "radius_contradicts",
            Self::DepthUncertain { .. } => "depth_uncertain",
            Self::Astray { .. } => "pairs_contradict",
            Self::Contradiction { .. } => "contradiction",
        }
    }
}
