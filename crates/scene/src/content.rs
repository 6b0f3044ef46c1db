//! Checks of what stands in the water besides plain rods.

use std::path::Path;
use std::sync::Arc;

use rodsight_geometry::{MountEntry, Pose, RigFrame, radians};
use rodsight_optics::Bands;

use crate::check::list;
use crate::error::Complaints;
use crate::file::{
    BlockEntry, ClutterEntry, FoulingEntry, GlossEntry, GrainEntry, OccluderEntry, PropEntry,
    RipplesEntry, StripesEntry, SurfaceEntry,
};
use crate::{
    Clutter, Finish, Fouling, Gloss, Grain, Material, Mesh, Occluder, Prop, Ripples, SceneError,
    Shape, Stripes,
};

impl SurfaceEntry {
    pub(crate) fn to_finish(
        self,
        no: &Complaints<'_>,
        key: &str,
        material: Material,
    ) -> Result<Finish, SceneError> {
        let Material::Lambert(albedo) = material else {
            if self.stripes.is_some() || self.texture.is_some() || self.gloss.is_some() {
                let expected = "albedo instead of flat_radiance_w_per_m2_sr, which nothing lights";
                return Err(no.value(key, expected, "stripes, texture or gloss"));
            }
            return Ok(Finish::default());
        };
        let stripes = self
            .stripes
            .map(|s| s.to_stripes(no, &format!("{key}.stripes")));
        let stripes = stripes.transpose()?;
        let colours = [Some(albedo), stripes.map(|s| s.albedo)];
        let brightest = colours.into_iter().flatten().flatten().fold(0.0, f64::max);
        let grain = self
            .texture
            .map(|t| t.to_grain(no, &format!("{key}.texture"), brightest));
        let gloss = self.gloss.map(|g| g.to_gloss(no, &format!("{key}.gloss")));
        Ok(Finish {
            stripes,
            grain: grain.transpose()?,
            gloss: gloss.transpose()?,
        })
    }

    pub(crate) fn to_fouling(
        self,
        no: &Complaints<'_>,
        key: &str,
    ) -> Result<Option<Fouling>, SceneError> {
        let fouling = self
            .fouling
            .map(|f| f.to_fouling(no, &format!("{key}.fouling")));
        fouling.transpose()
    }
}

impl StripesEntry {
    fn to_stripes(self, no: &Complaints<'_>, key: &str) -> Result<Stripes, SceneError> {
        if self.starts > 1000 {
            return Err(no.value(format!("{key}.starts"), "0 to 1000", self.starts));
        }
        Ok(Stripes {
            period_m: no.extent(&format!("{key}.period_m"), self.period_m)?,
            albedo: no.albedo(&format!("{key}.albedo"), self.albedo)?,
            share: no.number(&format!("{key}.share"), self.share, "> 0 and < 1", |v| {
                v > 0.0 && v < 1.0
            })?,
            starts: self.starts,
        })
    }
}

impl GrainEntry {
    fn to_grain(self, no: &Complaints<'_>, key: &str, brightest: f64) -> Result<Grain, SceneError> {
        let expected = "> 0, at most 1, and no brighter than albedo 1 with it";
        Ok(Grain {
            contrast: no.number(&format!("{key}.contrast"), self.contrast, expected, |v| {
                v > 0.0 && v <= 1.0 && brightest * (1.0 + v) <= 1.0 + 1e-12
            })?,
            scale_m: no.extent(&format!("{key}.scale_m"), self.scale_m)?,
        })
    }
}

impl GlossEntry {
    fn to_gloss(self, no: &Complaints<'_>, key: &str) -> Result<Gloss, SceneError> {
        let roughness = format!("{key}.roughness");
        Ok(Gloss {
            roughness: no.number(&roughness, self.roughness, "between 0.05 and 1", |v| {
                (0.05..=1.0).contains(&v)
            })?,
            reflectance: no.albedo(&format!("{key}.reflectance"), self.reflectance)?,
        })
    }
}

impl FoulingEntry {
    fn to_fouling(self, no: &Complaints<'_>, key: &str) -> Result<Fouling, SceneError> {
        Ok(Fouling {
            cover: no.number(
                &format!("{key}.cover"),
                self.cover,
                "> 0 and at most 0.95",
                |v| v > 0.0 && v <= 0.95,
            )?,
            height_m: no.extent(&format!("{key}.height_m"), self.height_m)?,
            albedo: no.albedo(&format!("{key}.albedo"), self.albedo)?,
        })
    }
}

impl OccluderEntry {
    pub(crate) fn to_occluder(
        &self,
        no: &Complaints<'_>,
        key: &str,
    ) -> Result<Occluder, SceneError> {
        let sub = |name: &str| format!("{key}.{name}");
        let expected = "exactly one of sphere, capsule, block";
        let shape = match (self.sphere, self.capsule, self.block) {
            (Some(sphere), None, None) => Shape::Sphere {
                centre_m: no.point(&sub("sphere.centre_m"), sphere.centre_m)?,
                radius_m: no.extent(&sub("sphere.radius_m"), sphere.radius_m)?,
            },
            (None, Some(capsule), None) => {
                let from_m = no.point(&sub("capsule.from_m"), capsule.from_m)?;
                let to_m = no.point(&sub("capsule.to_m"), capsule.to_m)?;
                if !((to_m - from_m).norm() >= 1e-6) {
                    let expected = "a point other than from_m";
                    return Err(no.value(sub("capsule.to_m"), expected, list(capsule.to_m)));
                }
                Shape::Capsule {
                    from_m,
                    to_m,
                    radius_m: no.extent(&sub("capsule.radius_m"), capsule.radius_m)?,
                }
            }
            (None, None, Some(block)) => block.to_shape(no, &sub("block"))?,
            (None, None, None) => return Err(no.value(key, expected, "none")),
            _ => return Err(no.value(key, expected, "more than one")),
        };
        Ok(Occluder {
            id: self.id.clone(),
            shape,
            albedo: no.albedo(&sub("albedo"), self.albedo)?,
        })
    }
}

impl BlockEntry {
    fn to_shape(self, no: &Complaints<'_>, key: &str) -> Result<Shape, SceneError> {
        let size = self.size_m.into_iter().enumerate();
        for (k, edge_m) in size {
            no.extent(&format!("{key}.size_m[{k}]"), edge_m)?;
        }
        no.point(&format!("{key}.centre_m"), self.centre_m)?;
        let mount = MountEntry {
            rotation: self.rotation,
            rpy_deg: self.rpy_deg,
            quaternion_wxyz: self.quaternion_wxyz,
            translation_m: self.centre_m,
        };
        let pose: Pose<RigFrame, ()> = placed(mount, no, key)?;
        Ok(Shape::Block {
            centre_m: pose.origin_m(),
            half_m: self.size_m.map(|edge_m| 0.5 * edge_m).into(),
            rotation: *pose.rotation(),
        })
    }
}

impl PropEntry {
    /// `meshes` are those that earlier props were given, by their file: one file is read once.
    pub(crate) fn to_prop(
        &self,
        no: &Complaints<'_>,
        key: &str,
        meshes: &mut Vec<(std::path::PathBuf, Arc<Mesh>)>,
    ) -> Result<Prop, SceneError> {
        let position = format!("{key}.position_m");
        no.point(&position, self.position_m)?;
        let mount = MountEntry {
            rotation: self.rotation,
            rpy_deg: self.rpy_deg,
            quaternion_wxyz: self.quaternion_wxyz,
            translation_m: self.position_m,
        };
        let rig_from_prop = placed(mount, no, key)?;
        let scale = no.extent(&format!("{key}.scale"), self.scale)?;
        let file = no.path.parent().unwrap_or(Path::new("")).join(&self.file);
        let known = meshes.iter().find(|(known, _)| *known == file);
        let mesh = if let Some((_, mesh)) = known {
            Arc::clone(mesh)
        } else {
            let mesh = Arc::new(Mesh::load(&file)?);
            meshes.push((file, Arc::clone(&mesh)));
            mesh
        };
        Ok(Prop {
            id: self.id.clone(),
            mesh,
            rig_from_prop,
            scale,
        })
    }
}

/// Turned as a mount says; not at all if it says nothing.
fn placed<From>(
    mut mount: MountEntry,
    no: &Complaints<'_>,
    key: &str,
) -> Result<Pose<RigFrame, From>, SceneError> {
    if mount.rotation.is_none() && mount.rpy_deg.is_none() && mount.quaternion_wxyz.is_none() {
        mount.rpy_deg = Some([0.0; 3]);
    }
    mount
        .to_pose()
        .map_err(|(name, expected, found)| no.value(format!("{key}.{name}"), expected, found))
}

impl RipplesEntry {
    pub(crate) fn to_ripples(self, no: &Complaints<'_>) -> Result<Ripples, SceneError> {
        let wavelength_m = no.extent("seabed.ripples.wavelength_m", self.wavelength_m)?;
        let limit_m = 0.25 * wavelength_m;
        let heading = "seabed.ripples.heading_deg";
        Ok(Ripples {
            wavelength_m,
            // Sand does not lie steeper than about 35°: π h/λ = 0.79 at this limit.
            height_m: no.number(
                "seabed.ripples.height_m",
                self.height_m,
                &format!("> 0 and at most a quarter of the wavelength ({limit_m})"),
                |v| v > 0.0 && v <= limit_m,
            )?,
            heading_rad: radians(no.number(
                heading,
                self.heading_deg,
                "within -360 to 360",
                |v| v.abs() <= 360.0,
            )?),
        })
    }
}

impl ClutterEntry {
    /// With their tree they take a hundred megabytes.
    const MOST_STONES: f64 = 300_000.0;

    pub(crate) fn to_clutter(self, no: &Complaints<'_>) -> Result<Clutter, SceneError> {
        let key = |name: &str| format!("seabed.clutter.{name}");
        let [smallest, largest] = self.diameter_m;
        let reach_m = no.extent(&key("reach_m"), self.reach_m)?;
        let area_m2 = core::f64::consts::PI * reach_m * reach_m;
        let most = Self::MOST_STONES / area_m2;
        let brightest = |albedo: Bands| albedo.into_iter().fold(0.0, f64::max);
        if brightest(self.albedo) > 1.0 / 1.5 {
            let expected = "at most 2/3: the brightest stones have half as much again";
            return Err(no.value(key("albedo"), expected, list(self.albedo)));
        }
        Ok(Clutter {
            stones_per_m2: no.number(
                &key("stones_per_m2"),
                self.stones_per_m2,
                &format!(
                    "> 0 and at most {most:.1}, which is {} stones",
                    Self::MOST_STONES
                ),
                |v| v > 0.0 && v <= most,
            )?,
            diameter_m: [
                no.extent(&key("diameter_m[0]"), smallest)?,
                no.number(
                    &key("diameter_m[1]"),
                    largest,
                    &format!("between diameter_m[0] ({smallest}) and 100"),
                    |v| v >= smallest && v <= 100.0,
                )?,
            ],
            albedo: no.albedo(&key("albedo"), self.albedo)?,
            reach_m,
        })
    }
}
