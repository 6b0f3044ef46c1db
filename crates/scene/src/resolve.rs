//! From what was typed to a validated scene.

use std::path::Path;

use rodsight_geometry::{Eye, Rig, RigError, config, radians};
use rodsight_optics::{Lobe, Medium, MediumError, Phase, water};

use crate::check::{list, nearest_fibonacci};
use crate::error::{Complaints, with_key};
use crate::file::{
    EdgeEntry, ExposureEntry, LampEntry, PhaseEntry, SceneFile, SeabedEntry, SensorEntry,
    WaterEntry,
};
use crate::{
    EdgeSampling, Emva, Exposure, Lamp, Mode, Rod, Sampling, Scene, SceneError, Seabed, Sensor,
    Target,
};

impl Scene {
    /// Reads a scene file.
    ///
    /// # Errors
    /// A file that cannot be read or is no scene; the message names file, key, what was expected and what was found.
    pub fn load(path: &Path) -> Result<Self, SceneError> {
        Self::from_toml(&config::read_text(path)?, path)
    }

    /// Parses the text of a scene file; `path` is named in messages, and a `rig_file` is looked for beside it.
    ///
    /// # Errors
    /// As [`load`](Self::load).
    pub fn from_toml(text: &str, path: &Path) -> Result<Self, SceneError> {
        SceneFile::from_toml(text, path)?.to_scene(path)
    }
}

impl SceneFile {
    /// The version this code reads and writes.
    pub const SCHEMA: u32 = 1;

    /// Parses the text of a scene file without checking its numbers; `path` is only named in messages.
    ///
    /// # Errors
    /// Broken TOML, a missing key, a wrong type, or an unknown key (with the nearest known one).
    pub fn from_toml(text: &str, path: &Path) -> Result<Self, SceneError> {
        Ok(config::parse_toml(text, path).map_err(|error| with_key(text, error))?)
    }

    /// The scene this file describes, validated; `path` is named in messages, and a `rig_file` is looked for beside it.
    ///
    /// # Errors
    /// The first number out of range, the first thing that contradicts another.
    pub fn to_scene(&self, path: &Path) -> Result<Scene, SceneError> {
        let no = Complaints { path };
        if self.schema != Self::SCHEMA {
            return Err(no.value("schema", Self::SCHEMA.to_string(), self.schema));
        }
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
        if self.id.is_empty() || !self.id.chars().all(plain) {
            return Err(no.value(
                "id",
                "letters, digits, `_` and `-` (it becomes a file name)",
                format!("\"{}\"", self.id),
            ));
        }
        if i64::try_from(self.seed).is_err() {
            return Err(no.value("seed", "at most 9223372036854775807", self.seed));
        }
        if !matches!(self.bits, 8 | 16) {
            return Err(no.value("bits", "8 or 16", self.bits));
        }
        let ambient_radiance = no.not_negative_bands(
            "ambient_radiance_w_per_m2_sr",
            self.ambient_radiance_w_per_m2_sr,
        )?;
        if self.mode == Mode::Koschmieder && ambient_radiance == [0.0; 3] {
            return Err(no.value(
                "ambient_radiance_w_per_m2_sr",
                "> 0 in at least one band in mode \"koschmieder\", which knows no lamps",
                list(ambient_radiance),
            ));
        }
        let (water_label, medium) = self.medium(&no)?;
        let lamps = self
            .lamp
            .iter()
            .enumerate()
            .map(|(k, entry)| entry.to_lamp(&no, &format!("lamp[{k}]")))
            .collect::<Result<_, _>>()?;
        if self.rod.is_empty() {
            return Err(no.value("rod", "at least one rod", "none"));
        }
        let mut rods: Vec<Rod> = Vec::new();
        for (k, entry) in self.rod.iter().enumerate() {
            let rod = entry.to_rod(&no, &format!("rod[{k}]"))?;
            if let Some(first) = rods.iter().position(|other| other.id == rod.id) {
                return Err(no.value(
                    format!("rod[{k}].id"),
                    format!("a name that rod[{first}] does not have"),
                    format!("\"{}\" again", rod.id),
                ));
            }
            rods.push(rod);
        }
        let scene = Scene {
            id: self.id.clone(),
            seed: self.seed,
            rig: self.rig(path, &no)?,
            mode: self.mode,
            water_label,
            medium,
            ambient_radiance,
            background_radiance: no.not_negative_bands(
                "background_radiance_w_per_m2_sr",
                self.background_radiance_w_per_m2_sr,
            )?,
            lamps,
            seabed: self.seabed.map(|s| s.to_seabed(&no)).transpose()?,
            exposure: self.exposure.to_exposure(&no)?,
            sensor: self.sensor.to_sensor(&no)?,
            bits: self.bits,
            sampling: self.sampling(&no)?,
            target: self.target(&no, &rods)?,
            rods,
        };
        check_placement(&scene, &no)?;
        Ok(scene)
    }

    fn rig(&self, path: &Path, no: &Complaints<'_>) -> Result<Rig, SceneError> {
        match (&self.rig, &self.rig_file) {
            (Some(rig), None) => rig.to_rig(path).map_err(|error| {
                let path = path.display().to_string();
                let message = match error {
                    RigError::Camera { camera, source, .. } => format!("{camera}.{source}"),
                    RigError::Value {
                        key,
                        expected,
                        found,
                        ..
                    } => format!("{key}: expected {expected}, found {found}"),
                    other => return other.into(),
                };
                SceneError::InlineRig { path, message }
            }),
            (None, Some(file)) => {
                let beside = path.parent().unwrap_or(Path::new(""));
                Ok(Rig::load(&beside.join(file))?)
            }
            (Some(_), Some(_)) => Err(no.value("rig", "either [rig] or rig_file", "both")),
            (None, None) => Err(no.value("rig", "either [rig] or rig_file", "neither")),
        }
    }

    fn medium(&self, no: &Complaints<'_>) -> Result<(String, Medium), SceneError> {
        match &self.water {
            Some(water) => water.to_medium(no),
            None if self.mode == Mode::Air => Ok(("none".to_owned(), Medium::vacuum())),
            None => Err(no.value("water", "a table [water] in every mode but \"air\"", "none")),
        }
    }

    fn sampling(&self, no: &Complaints<'_>) -> Result<Sampling, SceneError> {
        let airlight_points = self.sampling.airlight_points;
        if !(1..=4096).contains(&airlight_points) {
            return Err(no.value("sampling.airlight_points", "1 to 4096", airlight_points));
        }
        let edge = match self.sampling.edge {
            EdgeEntry::Fibonacci(points) => {
                let nearest = nearest_fibonacci(points).min(10_946);
                if points != nearest {
                    return Err(no.value(
                        "sampling.edge.fibonacci",
                        format!("a Fibonacci number up to 10946 (the nearest is {nearest})"),
                        points,
                    ));
                }
                EdgeSampling::Fibonacci { points }
            }
            EdgeEntry::Grid(side) => {
                if !(1..=64).contains(&side) {
                    return Err(no.value("sampling.edge.grid", "1 to 64", side));
                }
                EdgeSampling::Grid { side }
            }
        };
        Ok(Sampling {
            edge,
            airlight_points,
        })
    }

    fn target(&self, no: &Complaints<'_>, rods: &[Rod]) -> Result<Target, SceneError> {
        let entry = &self.target;
        let Some(index) = rods.iter().position(|rod| rod.id == entry.rod) else {
            let ids: Vec<String> = rods.iter().map(|rod| format!("\"{}\"", rod.id)).collect();
            return Err(no.value(
                "target.rod",
                format!("the id of a rod: {}", ids.join(", ")),
                format!("\"{}\"", entry.rod),
            ));
        };
        let rod = &rods[index];
        let half_m = 0.5 * rod.length_m;
        let on_rod = format!("within the rod's length, -{half_m} to {half_m}");
        let (key, along_m) = match (entry.along_m, entry.near_m) {
            (Some(_), Some(_)) => {
                return Err(no.value("target", "at most one of along_m, near_m", "both"));
            }
            (along_m, None) => ("target.along_m", along_m.unwrap_or(0.0)),
            (None, Some(near_m)) => {
                let near_m = no.point("target.near_m", near_m)?;
                let along_m = rod.nearest_along_m(&near_m);
                ("target.near_m", along_m)
            }
        };
        if !(along_m.abs() <= half_m) {
            let found = if key.ends_with("near_m") {
                format!("the foot of that point at {along_m}")
            } else {
                along_m.to_string()
            };
            return Err(no.value(key, on_rod, found));
        }
        Ok(Target {
            rod: index,
            along_m,
            pick_eye: entry.pick_eye,
        })
    }
}

impl WaterEntry {
    fn to_medium(&self, no: &Complaints<'_>) -> Result<(String, Medium), SceneError> {
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
            let (expected, found) = rest
                .split_once(", found ")
                .unwrap_or((rest, "something else"));
            no.value(format!("water.phase.{key}"), expected, found)
        })?;
        Ok((label, medium))
    }
}

impl PhaseEntry {
    fn to_phase(&self) -> Phase {
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
    fn to_lamp(self, no: &Complaints<'_>, key: &str) -> Result<Lamp, SceneError> {
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
            "> 0 and < 180",
            |v| v > 0.0 && v < 180.0,
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
    fn to_seabed(self, no: &Complaints<'_>) -> Result<Seabed, SceneError> {
        let albedo = no.albedo("seabed.albedo", self.albedo)?;
        let brightest = albedo.into_iter().fold(0.0, f64::max);
        Ok(Seabed {
            z_m: no.number("seabed.z_m", self.z_m, "a finite number", |_| true)?,
            albedo,
            texture_contrast: no.number(
                "seabed.texture_contrast",
                self.texture_contrast,
                "between 0 and 1, and no brighter than albedo 1 with it",
                |v| (0.0..1.0).contains(&v) && brightest * (1.0 + v) <= 1.0 + 1e-12,
            )?,
            texture_scale_m: no.positive("seabed.texture_scale_m", self.texture_scale_m)?,
        })
    }
}

impl ExposureEntry {
    fn to_exposure(self, no: &Complaints<'_>) -> Result<Exposure, SceneError> {
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
    fn to_sensor(self, no: &Complaints<'_>) -> Result<Sensor, SceneError> {
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
                Sensor::Emva(Emva {
                    full_well_e: no.positive("sensor.emva.full_well_e", emva.full_well_e)?,
                    read_noise_e: no.not_negative("sensor.emva.read_noise_e", emva.read_noise_e)?,
                    dark_e: no.not_negative("sensor.emva.dark_e", emva.dark_e)?,
                    prnu: no.number("sensor.emva.prnu", emva.prnu, "between 0 and 0.5", |v| {
                        (0.0..=0.5).contains(&v)
                    })?,
                    dsnu_e: no.not_negative("sensor.emva.dsnu_e", emva.dsnu_e)?,
                    adc_bits: emva.adc_bits,
                })
            }
        })
    }
}

/// What only the whole scene can tell: rods behind the cameras, cameras and lamps where they cannot be.
fn check_placement(scene: &Scene, no: &Complaints<'_>) -> Result<(), SceneError> {
    for (k, rod) in scene.rods.iter().enumerate() {
        for eye in Eye::BOTH {
            if rod.contains(&scene.rig.eye(eye).rig_from_camera.origin_m()) {
                return Err(no.value(
                    format!("rod[{k}]"),
                    "no camera inside a rod",
                    format!("the {} camera inside \"{}\"", eye.name(), rod.id),
                ));
            }
        }
        if let Some(lamp) = scene.lamps.iter().position(|l| rod.contains(&l.position_m)) {
            return Err(no.value(
                format!("lamp[{lamp}].position_m"),
                "no lamp inside a rod",
                format!("it inside rod[{k}] (\"{}\")", rod.id),
            ));
        }
        // How far the rod reaches in front of a camera; 64 points and the radius bound a bent one closely enough.
        let reach_m = Eye::BOTH.map(|eye| {
            let camera_from_rig = scene.rig.eye(eye).rig_from_camera.inverse();
            (0..=64)
                .map(|j| {
                    let along_m = rod.length_m * (f64::from(j) / 64.0 - 0.5);
                    camera_from_rig.point(&rod.axis_at(along_m).0).z + rod.radius_m
                })
                .fold(f64::NEG_INFINITY, f64::max)
        });
        if reach_m.iter().all(|&z| z <= 0.0) {
            return Err(no.value(
                format!("rod[{k}]"),
                "a rod in front of at least one camera",
                format!(
                    "\"{}\" wholly behind both: its foremost point at z = {:.3} m of the left camera, {:.3} m of the right",
                    rod.id, reach_m[0], reach_m[1]
                ),
            ));
        }
    }
    if let Some(seabed) = scene.seabed {
        for eye in Eye::BOTH {
            let z_m = scene.rig.eye(eye).rig_from_camera.origin_m().z;
            if z_m >= seabed.z_m {
                return Err(no.value(
                    "seabed.z_m",
                    format!("below the {} camera, > {z_m}", eye.name()),
                    seabed.z_m,
                ));
            }
        }
        let z_m = scene.rods[scene.target.rod]
            .axis_at(scene.target.along_m)
            .0
            .z;
        if z_m >= seabed.z_m {
            return Err(no.value(
                "target",
                format!("a grasp above the seabed, z < {}", seabed.z_m),
                format!("z = {z_m}"),
            ));
        }
    }
    Ok(())
}
