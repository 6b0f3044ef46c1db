//! From what was typed to a validated scene.

use std::path::Path;

use rodsight_geometry::{Rig, RigError, config};
use rodsight_optics::Medium;

use crate::camera;
use crate::check::{list, nearest_fibonacci};
use crate::error::{Complaints, with_key};
use crate::file::{EdgeEntry, SceneFile};
use crate::placement::check_placement;
use crate::{EdgeSampling, Mesh, Mode, Occluder, Prop, Rod, Sampling, Scene, SceneError, Target};

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
        if !matches!(self.bits, 8 | 16) {
            return Err(no.value("bits", "8 or 16", self.bits));
        }
        let ambient_radiance = no.not_negative_bands(
            "ambient_radiance_w_per_m2_sr",
            self.ambient_radiance_w_per_m2_sr,
        )?;
        let dark = ambient_radiance == [0.0; 3] && self.daylight.is_none();
        if self.mode == Mode::Koschmieder && dark {
            return Err(no.value(
                "ambient_radiance_w_per_m2_sr",
                "> 0 in at least one band, or [daylight], in mode \"koschmieder\", which knows no lamps",
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
        let (occluders, props) = self.bodies(&no, &rods)?;
        let sensor = self.sensor.to_sensor(&no)?;
        let scene = Scene {
            id: self.id.clone(),
            seed: self.seed,
            rig: self.rig(path, &no)?,
            mode: self.mode,
            water_label,
            daylight: self
                .daylight
                .map(|daylight| daylight.to_daylight(&no, &medium))
                .transpose()?,
            medium,
            ambient_radiance,
            background_radiance: no.not_negative_bands(
                "background_radiance_w_per_m2_sr",
                self.background_radiance_w_per_m2_sr,
            )?,
            lamps,
            occluders,
            props,
            seabed: self.seabed.map(|s| s.to_seabed(&no)).transpose()?,
            snow: self.snow.map(|snow| snow.checked(&no)).transpose()?,
            exposure: self.exposure.to_exposure(&no)?,
            white_balance: no.bands(
                "white_balance",
                self.white_balance,
                "between 1 and 16",
                |gain| (1.0..=16.0).contains(&gain),
            )?,
            colour_matrix: self
                .colour_matrix
                .map(|rows| camera::colour_matrix(&no, rows))
                .transpose()?,
            lens: self.lens.checked(&no)?,
            motion: self.motion.map(|m| m.to_motion(&no)).transpose()?,
            sensor,
            output: self.output.checked(&no, self.bits, &sensor)?,
            bits: self.bits,
            sampling: self.sampling(&no)?,
            target: self.target(&no, &rods)?,
            rods,
        };
        check_placement(&scene, &no)?;
        Ok(scene)
    }

    /// What is neither rod nor seabed, under names that nothing else has.
    fn bodies(
        &self,
        no: &Complaints<'_>,
        rods: &[Rod],
    ) -> Result<(Vec<Occluder>, Vec<Prop>), SceneError> {
        let mut names: Vec<String> = rods.iter().map(|rod| rod.id.clone()).collect();
        let mut claim = |key: String, id: &str| {
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if id.is_empty() || !id.chars().all(plain) {
                let expected = "letters, digits, `_` and `-`";
                return Err(no.value(key, expected, format!("\"{id}\"")));
            }
            if names.iter().any(|name| name == id) {
                let expected = "a name that nothing else has";
                return Err(no.value(key, expected, format!("\"{id}\" again")));
            }
            names.push(id.to_owned());
            Ok(())
        };
        let mut occluders = Vec::new();
        for (k, entry) in self.occluder.iter().enumerate() {
            claim(format!("occluder[{k}].id"), &entry.id)?;
            occluders.push(entry.to_occluder(no, &format!("occluder[{k}]"))?);
        }
        let (mut props, mut meshes) = (Vec::new(), Vec::new());
        let mut triangles = 0;
        for (k, entry) in self.prop.iter().enumerate() {
            claim(format!("prop[{k}].id"), &entry.id)?;
            let prop = entry.to_prop(no, &format!("prop[{k}]"), &mut meshes)?;
            // Every prop has its own copy in the tree of triangles.
            triangles += prop.mesh.triangle_count();
            if triangles > Mesh::MOST_TRIANGLES {
                let most = Mesh::MOST_TRIANGLES;
                let expected = format!("at most {most} triangles in all props up to this one");
                return Err(no.value(format!("prop[{k}].file"), expected, triangles));
            }
            props.push(prop);
        }
        // Each has a number of 16 bits in the instance channel, rods one more for what grows on them.
        let count = 2 * rods.len() + occluders.len() + props.len();
        if count > 65_000 {
            let expected = "at most 65000 of rods (twice), occluders and props together";
            return Err(no.value("rod", expected, count));
        }
        Ok((occluders, props))
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
