//! Light under water: phase functions, attenuation and scattering as pure `f64` reference physics.
//!
//! Units: m, m⁻¹, sr⁻¹; radiance in W m⁻² sr⁻¹ per band. Scattering angle 0 = forward.

mod airlight;
mod medium;
mod phase;
pub mod water;

pub use airlight::{Airlight, EquiAngular};
pub use medium::Medium;
pub use phase::{Lobe, Phase};

/// One value per band: red (600 nm), green (525 nm), blue (475 nm).
pub type Bands = [f64; 3];
