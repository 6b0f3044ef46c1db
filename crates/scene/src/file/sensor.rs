//! What was typed of the sensor.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Bayer;

/// The sensor's noise: `[sensor.plain]` or `[sensor.emva]`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SensorEntry {
    /// Gaussian noise on the encoded image.
    Plain(PlainSensorEntry),
    /// EMVA 1288 linear model.
    Emva(EmvaEntry),
}

impl Default for SensorEntry {
    fn default() -> Self {
        Self::Plain(PlainSensorEntry {
            noise_sigma_dn: 0.0,
        })
    }
}

/// Gaussian noise on the encoded image.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlainSensorEntry {
    /// Standard deviation in digital numbers of 255, whatever the bits; 0 is none.
    pub noise_sigma_dn: f64,
}

/// EMVA 1288 parameters in electrons; the defaults are those of a 3.45 µm machine-vision sensor.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct EmvaEntry {
    /// Full well.
    pub full_well_e: f64,
    /// Read noise.
    pub read_noise_e: f64,
    /// Dark signal of the exposure.
    pub dark_e: f64,
    /// Photo-response non-uniformity, relative.
    pub prnu: f64,
    /// Dark-signal non-uniformity.
    pub dsnu_e: f64,
    /// Bits of the converter; full scale = full well.
    pub adc_bits: u8,
    /// Which specimen of the sensor: its fixed pattern (prnu, dsnu) stays the same whatever the scene's seed.
    pub pattern_seed: u64,
    /// Colour filters over the pixels, one band each: `{ pattern = "rggb", demosaic = "malvar" }`. Without, every pixel has all
    /// three bands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bayer: Option<Bayer>,
}

impl Default for EmvaEntry {
    fn default() -> Self {
        Self {
            full_well_e: 10_500.0,
            read_noise_e: 2.5,
            dark_e: 0.2,
            prnu: 0.006,
            dsnu_e: 1.0,
            adc_bits: 12,
            pattern_seed: 0,
            bayer: None,
        }
    }
}
