//! The parts of a scene that need nothing but themselves: water, lamps, seabed, exposure, sensor.

use rodsight_geometry::radians;
use rodsight_optics::{Lobe, Medium, MediumError, Phase, water};

use crate::check::list;
use crate::error::Complaints;
use crate::file::{ExposureEntry, LampEntry, PhaseEntry, SeabedEntry, SensorEntry, WaterEntry};
use crate::{Emva, Exposure, Lamp, SceneError, Seabed, Sensor};

impl WaterEntry {
    pub(crate) fn to_medium(&self, no: &Complaints<'_>) -> Result<(String, Medium), SceneError> {
        let expected = "either name, or absorption_per_m and scattering_per_m";
        let (label, absorption, scattering, default_phase) =
            match (&self.name, self.absorption_per_m, self.scattering_per_m) {
                (Some(name), None, None) => {
                    if self.label.is_some() {
                        return Err(no.value(
                            "water.label",
                            "no label beside a name",
                            "both name and label",
                        ));
                    }
                    let Some(row) = water::by_name(name) else {
                        return Err(no.value(
                            "water.name",
                            format!("one of {}", water::names().join(", ")),
                            format!("\"{name}\""),
                        ));
                    };
                    let phase = row.phase();
                    (row.label, row.absorption_per_m, row.scattering_per_m, phase)
                }
                (None, Some(absorption), Some(scattering)) => (
                    self.label.clone().unwrap_or_else(|| "custom".to_owned()),
                    absorption,
                    scattering,
                    Phase::petzold3(),
                ),
                (Some(_), _, _) => {
                    return Err(no.value("water", expected, "a name and coefficients"));
                }
                (None, Some(_), None) => {
                    return Err(no.value("water", expected, "absorption_per_m only"));
                }
                (None, None, Some(_)) => {
                    return Err(no.value("water", expected, "scattering_per_m only"));
                }
                (None, None, None) => return Err(no.value("water", expected, "none of them")),
            };
        no.not_negative_bands("water.absorption_per_m", absorption)?;
        no.not_negative_bands("water.scattering_per_m", scattering)?;
        let phase = self
            .phase
            .as_ref()
            .map_or(default_phase, PhaseEntry::to_phase);
        let medium = Medium::new(absorption, scattering, phase).map_err(|error| {
            // The coefficients are checked already; what is left is the phase function's message: key, expected, found.
            let text = match &error {
                MediumError::Phase(inner) => inner.to_string(),
                other => other.to_string(),
            };
            let (key, rest) = text.split_once(": expected ").unwrap_or(("", &text));
            let key = self
                .phase
                .as_ref()
                .map_or(String::new(), |phase| phase.key(key));
            let (expected, found) = rest
                .split_once(", found ")
                .unwrap_or((rest, "something else"));
            no.value(format!("water.phase{key}"), expected, found)
        })?;
        Ok((label, medium))
    }
}

impl PhaseEntry {
    /// The key in the file of what the phase function calls `key`.
    fn key(&self, key: &str) -> String {
        match self {
            Self::HenyeyGreenstein(_) => key.replace("lobes[0]", ".henyey_greenstein"),
            Self::FournierForand(_) => format!(".fournier_forand.{key}"),
            _ => format!(".{key}"),
        }
    }

    pub(crate) fn to_phase(&self) -> Phase {
        match self {
            Self::Petzold3 => Phase::petzold3(),
            Self::Petzold4 => Phase::petzold4(),
            Self::Isotropic => Phase::Isotropic,
            Self::HenyeyGreenstein(entry) => Phase::HenyeyGreensteinSum(vec![Lobe {
                weight: 1.0,
                g: entry.g,
            }]),
            Self::Lobes(lobes) => Phase::HenyeyGreensteinSum(
                lobes
                    .iter()
                    .map(|lobe| Lobe {
                        weight: lobe.weight,
                        g: lobe.g,
                    })
                    .collect(),
            ),
            Self::FournierForand(entry) => Phase::FournierForand {
                refractive_index: entry.refractive_index,
                junge_slope: entry.junge_slope,
            },
        }
    }
}

impl LampEntry {
    pub(crate) fn to_lamp(self, no: &Complaints<'_>, key: &str) -> Result<Lamp, SceneError> {
        let position_m = no.point(&format!("{key}.position_m"), self.position_m)?;
        let expected = "either direction or aim_at_m";
        let direction = match (self.direction, self.aim_at_m) {
            (Some(direction), None) => no.direction(&format!("{key}.direction"), direction)?,
            (None, Some(aim)) => {
                let aim_key = format!("{key}.aim_at_m");
                let beam = no.point(&aim_key, aim)? - position_m;
                if !(beam.norm() > 1e-9) {
                    return Err(no.value(aim_key, "a point other than position_m", list(aim)));
                }
                beam.normalize()
            }
            (Some(_), Some(_)) => return Err(no.value(key, expected, "both")),
            (None, None) => return Err(no.value(key, expected, "neither")),
        };
        let inner = no.number(
            &format!("{key}.inner_half_angle_deg"),
            self.inner_half_angle_deg,
            "at least 0.001 and < 180",
            |v| (0.001..180.0).contains(&v),
        )?;
        let outer = no.number(
            &format!("{key}.outer_half_angle_deg"),
            self.outer_half_angle_deg,
            &format!("at least inner_half_angle_deg ({inner}) and < 180"),
            |v| v >= inner && v < 180.0,
        )?;
        Ok(Lamp {
            position_m,
            direction,
            radiant_intensity_w_per_sr: no.not_negative_bands(
                &format!("{key}.radiant_intensity_w_per_sr"),
                self.radiant_intensity_w_per_sr,
            )?,
            inner_half_angle_rad: radians(inner),
            outer_half_angle_rad: radians(outer),
        })
    }
}

impl SeabedEntry {
    pub(crate) fn to_seabed(self, no: &Complaints<'_>) -> Result<Seabed, SceneError> {
        let albedo = no.albedo("seabed.albedo", self.albedo)?;
        let brightest = albedo.into_iter().fold(0.0, f64::max);
        Ok(Seabed {
            z_m: no.number("seabed.z_m", self.z_m, "within -1e6 to 1e6", |v| {
                v.abs() <= 1e6
            })?,
            albedo,
            texture_contrast: no.number(
                "seabed.texture_contrast",
                self.texture_contrast,
                "between 0 and 1, and no brighter than albedo 1 with it",
                |v| (0.0..1.0).contains(&v) && brightest * (1.0 + v) <= 1.0 + 1e-12,
            )?,
            texture_scale_m: no.extent("seabed.texture_scale_m", self.texture_scale_m)?,
            ripples: self.ripples.map(|r| r.to_ripples(no)).transpose()?,
            clutter: self.clutter.map(|c| c.to_clutter(no)).transpose()?,
        })
    }
}

impl ExposureEntry {
    pub(crate) fn to_exposure(self, no: &Complaints<'_>) -> Result<Exposure, SceneError> {
        let share =
            |key: &str, value| no.number(key, value, "> 0 and at most 1", |v| v > 0.0 && v <= 1.0);
        Ok(match self {
            Self::Gain(gain) => Exposure::Fixed(no.positive("exposure.gain_m2_sr_per_w", gain)?),
            Self::Auto(auto) => Exposure::Auto {
                quantile: share("exposure.auto.quantile", auto.quantile)?,
                level: share("exposure.auto.level", auto.level)?,
            },
        })
    }
}

impl SensorEntry {
    pub(crate) fn to_sensor(self, no: &Complaints<'_>) -> Result<Sensor, SceneError> {
        Ok(match self {
            Self::Plain(plain) => Sensor::Plain {
                noise_sigma_dn: no.number(
                    "sensor.plain.noise_sigma_dn",
                    plain.noise_sigma_dn,
                    "between 0 and 255",
                    |v| (0.0..=255.0).contains(&v),
                )?,
            },
            Self::Emva(emva) => {
                if !(8..=16).contains(&emva.adc_bits) {
                    return Err(no.value("sensor.emva.adc_bits", "8 to 16", emva.adc_bits));
                }
                let full_well_e = no.positive("sensor.emva.full_well_e", emva.full_well_e)?;
                let dark_e = no.number(
                    "sensor.emva.dark_e",
                    emva.dark_e,
                    &format!("at least 0 and less than the full well ({full_well_e})"),
                    |v| v >= 0.0 && v < full_well_e,
                )?;
                Sensor::Emva(Emva {
                    full_well_e,
                    read_noise_e: no.not_negative("sensor.emva.read_noise_e", emva.read_noise_e)?,
                    dark_e,
                    prnu: no.number("sensor.emva.prnu", emva.prnu, "between 0 and 0.5", |v| {
                        (0.0..=0.5).contains(&v)
                    })?,
                    dsnu_e: no.not_negative("sensor.emva.dsnu_e", emva.dsnu_e)?,
                    adc_bits: emva.adc_bits,
                    pattern_seed: emva.pattern_seed,
                    bayer: emva.bayer,
                })
            }
        })
    }
}
