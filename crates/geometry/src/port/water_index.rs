//! The refractive index of sea water.

use super::Band;

/// Salinity, practical salinity units, for which the formula holds.
pub const SALINITY_PSU: core::ops::RangeInclusive<f64> = 0.0..=40.0;
/// Temperature, °C, for which the formula holds.
pub const TEMPERATURE_C: core::ops::RangeInclusive<f64> = 0.0..=30.0;

/// Index of sea water against air at 600, 525 and 475 nm, at atmospheric pressure (Quan & Fry 1995, Applied Optics 34, 3477, eq. 3).
/// A hundred metres of depth add 1.5e-4.
pub fn sea_water_index(salinity_psu: f64, temperature_c: f64) -> [f64; 3] {
    Band::ALL.map(|band| {
        let (s, t, l) = (salinity_psu, temperature_c, band.wavelength_nm());
        1.31405 + (1.779e-4 - 1.05e-6 * t + 1.6e-8 * t * t) * s - 2.02e-6 * t * t
            + (15.868 + 0.01155 * s - 0.00423 * t) / l
            - 4382.0 / (l * l)
            + 1.1455e6 / (l * l * l)
    })
}
