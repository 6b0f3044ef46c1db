//! Light under water: phase functions, attenuation and scattering as pure `f64` reference physics.
//!
//! A [`Medium`] is what water does to light per metre; [`Airlight`] is the light of one lamp that the water itself throws
//! into a camera ray; [`water`] is the table of published waters. Nothing here knows of images, scenes or files.
//!
//! Units: m, m⁻¹, sr⁻¹; radiance in W m⁻² sr⁻¹ per band. Scattering angle 0 = forward: light that keeps its direction.
//! No function here calls the system's maths library, so the same scene gives the same bytes on every machine.
//!
//! ```
//! use rodsight_geometry::Vec3;
//! use rodsight_optics::{Airlight, water};
//!
//! let water = water::by_name("IB").expect("a row of the table");
//! let medium = water.medium();
//! let airlight = Airlight { medium: &medium, attenuation_per_m: medium.transport_attenuation_per_m(), points: 16 };
//! // A lamp of 1 W/sr half a metre to the left of a camera that looks along +z at something 2 m away.
//! let veil = airlight.lamp(&Vec3::new(-0.5, 0.0, 0.0), &Vec3::z(), 2.0, |_, _| 1.0);
//! assert!(veil[2] > veil[0], "blue comes back, red is absorbed");
//! ```

mod airlight;
mod daylight;
mod exponential;
mod gloss;
mod medium;
mod nnls;
mod phase;
mod sphere;
pub mod water;
mod wells;

pub use airlight::{Airlight, EquiAngular, Node};
pub use daylight::Daylight;
pub use gloss::{Coat, Cosines};
pub use medium::{Medium, MediumError, transmittance};
pub use phase::{Lobe, Phase, PhaseError};
pub use sphere::sphere_share;
pub use wells::{ForwardLobe, Halo, Wells, width_px};

/// One value per band: red (600 nm), green (525 nm), blue (475 nm).
pub type Bands = [f64; 3];
