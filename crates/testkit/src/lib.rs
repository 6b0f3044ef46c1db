//! For tests only: comparators that are known to fail when they should, golden tables, and seeds.
//!
//! ```
//! use rodsight_testkit::{Tolerance, compare_images};
//! let expected = [0.5_f32; 12]; // shape [height, width, channels]
//! let tolerance = Tolerance {
//!     max_rel: 1e-6,
//!     max_abs: 1e-9,
//!     bad_fraction: 0.0,
//!     bounded_by: "f32 rounding",
//! };
//! let report = compare_images(&expected, &expected, [2, 2, 3], tolerance).unwrap();
//! assert_eq!(report.worst_rel, 0.0);
//! ```
//!
//! Never a normal dependency of any crate, and dependent on none of ours: `tests/architecture.rs` sees to it.

mod golden;
mod image;
mod rng;

pub use golden::Golden;
pub use image::{Mismatch, Report, Tolerance, Worst, compare_images, load_reference};
pub use rng::{SplitMix64, seed};
