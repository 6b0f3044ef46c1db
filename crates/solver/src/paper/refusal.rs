//! Why no answer is given, in words for a person and a short name for counting.

/// Reasons of a refusal.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say it")]
pub enum Refusal {
    #[error(
        "{eye} image: hue does not tell the rod from the background ({detail}); try luminance or give the hue window"
    )]
    HueNotDistinct {
        eye: &'static str,
        detail: &'static str,
    },
    #[error("{eye} image: no region looks like the rod ({rule})")]
    NoRegion { eye: &'static str, rule: String },
    #[error("{eye} image: the region has no edges: it is all rod or all background ({rule})")]
    NoEdges { eye: &'static str, rule: String },
    #[error("{eye} image: no straight line among {edges} edge points")]
    NoLines { eye: &'static str, edges: usize },
    #[error(
        "{eye} image: none of {lines} lines pair up as the two sides of a rod (opposite edges, nearly parallel, rod between)"
    )]
    NoPair { eye: &'static str, lines: usize },
    #[error("pick is off the rod: the nearest rod in the {eye} image is {distance_px:.0} px away")]
    PickOffStrip { eye: &'static str, distance_px: f64 },
    #[error(
        "pick is off the rod: its ray passes the axis at {gap_m:.3} m, {radii:.1} radii of the rod"
    )]
    PickOffRod { gap_m: f64, radii: f64 },
    #[error("pick names no point of the rod: {detail}")]
    PickUnusable { detail: String },
    #[error(
        "the two centre lines meet behind the cameras: not the same rod, or left and right exchanged"
    )]
    Behind,
    #[error(
        "the radius is {left_m:.4} m by the left eye and {right_m:.4} m by the right: not the same rod"
    )]
    RadiiDisagree { left_m: f64, right_m: f64 },
    #[error(
        "the limbs give a radius of {measured_m:.4} m, not {given_m:.4} m: another rod, or another radius"
    )]
    RadiusContradicted { measured_m: f64, given_m: f64 },
    #[error(
        "rod (nearly) parallel to the baseline, or in one plane with it: the baseline is {off_baseline_deg:.1}° off the planes of the axis and the depth is uncertain by {relative_percent:.0} %; give the radius (paper-bisector), move one camera or add a view"
    )]
    ParallelToBaseline {
        off_baseline_deg: f64,
        relative_percent: f64,
    },
    #[error(
        "the depth is uncertain by {relative_percent:.0} % (limit {limit_percent:.0} %): too short, too ragged or too far"
    )]
    DepthUncertain {
        relative_percent: f64,
        limit_percent: f64,
    },
}

impl Refusal {
    /// Short fixed name.
    pub fn code(&self) -> &'static str {
        match self {
            Self::HueNotDistinct { .. } => "hue_not_distinct",
            Self::NoRegion { .. } => "no_region",
            Self::NoEdges { .. } => "no_edges",
            Self::NoLines { .. } => "no_lines",
            Self::NoPair { .. } => "no_pair",
            Self::PickOffStrip { .. } | Self::PickOffRod { .. } => "pick_off_rod",
            Self::PickUnusable { .. } => "pick_unusable",
            Self::Behind => "behind",
            Self::RadiiDisagree { .. } => "radii_disagree",
            Self::RadiusContradicted { .. } => "radius_contradicted",
            Self::ParallelToBaseline { .. } => "parallel_to_baseline",
            Self::DepthUncertain { .. } => "depth_uncertain",
        }
    }
}
