//! Locates a rod in a stereo pair.
//!
//! Enter a [`Request`] (two images and the rig that took them, optionally regions, the operator's pick and the radius);
//! leaves an [`Estimate`] of axis, radius and grasp point with covariances and a [`Status`] in everything the rig frame.
//! Methods:
//!
//! * [`Method::Paper`]: hue binarisation → Canny → Hough → gate and refit → average of the two limbs → intersection of
//!   two planes (Wang, Wang, Leng 2022; equation numbers in plain brackets are theirs), faults of the print mended;
//! * [`Method::PaperBisector`]: the same limbs, but the plane of the axis is the bisector of the tangent planes, which
//!   removes the paper's depth bias of −r²/Z;
//! * [`Method::Joint`]: limbs found without a threshold in all colours, then the likeliest rod of the pixels of both images: tenths to
//!   hundredths of a millimetre, bent rods, rigs behind ports, three limbs of four.
//!
//! What cannot be known is refused with a reason ([`Status::Refused`] is data); [`SolveError`] is only a request that
//! makes no sense. This crate sees images and calibration, never a scene: truth cannot leak into it.
//!
//! ```
//! use rodsight_geometry::{Image, Rig, Samples, StereoPair};
//! use rodsight_solver::{Method, PaperParams, Request, Status, solve};
//! let camera = "width_px = 64\nheight_px = 48\nfx_px = 50.0\nfy_px = 50.0\ncx_px = 32.0\ncy_px = 24.0\n";
//! let mount = |y: f64| format!("[X.rig_from_camera]\nrotation = [[0,0,1],[1,0,0],[0,1,0]]\ntranslation_m = [0.0, {y:?}, 0.0]\n");
//! let eye = |name: &str, y| format!("[{name}]\n{camera}{}", mount(y).replace('X', name));
//! let text = format!("schema = 1\n{}{}", eye("left", -0.5), eye("right", 0.5));
//! let rig = Rig::from_toml(&text, std::path::Path::new("rig.toml")).unwrap();
//! let blank = || Image::new(64, 48, 3, Samples::U8(vec![90; 64 * 48 * 3])).unwrap();
//! let pair = StereoPair::new(rig, blank(), blank()).unwrap();
//! let estimate = solve(&Request::new(&pair), Method::Paper, &PaperParams::default()).unwrap();
//! assert_eq!(estimate.status, Status::Refused);
//! ```

mod estimate;
mod joint;
mod moved;
pub mod paper;
mod request;
mod solve;

pub use estimate::{
    AxisEstimate, Centerlines, Estimate, EyeReport, GraspEstimate, Observability, Status, TimingMs,
};
pub use moved::{MoveSigma, MovedPair};
pub use paper::{
    EdgePoint, EyeTrace, HueWindow, PaperParams, Polarity, RefinedLine, SegmentationMode, Trace,
    VoteThreshold, VotedLine, Votes,
};
pub use request::{
    CalibrationSigma, Method, Pick, RadiusPrior, Request, Roi, SolveError, UnknownMethod,
};
pub use solve::{solve, solve_all, solve_traced};
