//! Daylight in scene files.

use rodsight_optics::{Bands, Daylight, Medium};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::SceneError;
use crate::error::Complaints;

/// Daylight that comes evenly from above.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DaylightEntry {
    /// Irradiance on a level surface per band (red, green, blue).
    pub irradiance_w_per_m2: [f64; 3],
    /// How deep under the place of that irradiance the rig's origin lies; 0 means it is the irradiance at the rig.
    /// What is higher is brighter, by e^(`K_d` h), and nothing ends that at the water's surface.
    #[serde(default)]
    pub depth_m: f64,
    /// Diffuse attenuation `K_d` per band; √(a² + 0.256 a b) if absent (Kirk 1981).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub diffuse_attenuation_per_m: Option<[f64; 3]>,
}

impl DaylightEntry {
    pub(crate) fn to_daylight(
        self,
        no: &Complaints<'_>,
        medium: &Medium,
    ) -> Result<Daylight, SceneError> {
        no.not_negative_bands("daylight.irradiance_w_per_m2", self.irradiance_w_per_m2)?;
        no.number(
            "daylight.depth_m",
            self.depth_m,
            "between 0 and 1000",
            |d| (0.0..=1000.0).contains(&d),
        )?;
        let key = "daylight.diffuse_attenuation_per_m";
        let diffuse_attenuation_per_m = match self.diffuse_attenuation_per_m {
            Some(bands) => no.not_negative_bands(key, bands)?,
            None => Daylight::kirk_attenuation_per_m(medium),
        };
        let daylight = Daylight {
            irradiance_w_per_m2: self.irradiance_w_per_m2,
            diffuse_attenuation_per_m,
        };
        let irradiance_w_per_m2: Bands = if self.depth_m == 0.0 {
            self.irradiance_w_per_m2
        } else {
            daylight.downwelling(self.depth_m)
        };
        Ok(Daylight {
            irradiance_w_per_m2,
            ..daylight
        })
    }

    /// With the irradiance at the rig.
    pub(crate) fn from_daylight(daylight: Daylight) -> Self {
        Self {
            irradiance_w_per_m2: daylight.irradiance_w_per_m2,
            depth_m: 0.0,
            diffuse_attenuation_per_m: Some(daylight.diffuse_attenuation_per_m),
        }
    }
}
