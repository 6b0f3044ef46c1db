//! From a scene back to a file.

mod content;

use rodsight_geometry::{RigFile, degrees, radians};
use rodsight_optics::Phase;

use crate::file::{
    AutoExposureEntry, BendEntry, ClutterEntry, EdgeEntry, EmvaEntry, ExposureEntry,
    FournierForandEntry, LampEntry, LobeEntry, OccluderEntry, PhaseEntry, PlainSensorEntry,
    PropEntry, RipplesEntry, RodEntry, SamplingEntry, SceneFile, SeabedEntry, SensorEntry,
    SurfaceEntry, TargetEntry, WaterEntry,
};
use crate::{
    DaylightEntry, EdgeSampling, Exposure, Lamp, Material, MotionEntry, Rod, Scene, Sensor,
};

impl SceneFile {
    /// The file that describes a scene with nothing left to look up: the rig inline, the water by its numbers. A scene that
    /// was loaded comes back from it to the last bit, if each prop's mesh lies where
    /// [`Prop::written_file`](crate::Prop::written_file) says.
    pub fn from_scene(scene: &Scene) -> Self {
        Self {
            schema: Self::SCHEMA,
            id: scene.id.clone(),
            seed: scene.seed,
            mode: scene.mode,
            bits: scene.bits,
            ambient_radiance_w_per_m2_sr: scene.ambient_radiance,
            daylight: scene.daylight.map(DaylightEntry::from_daylight),
            background_radiance_w_per_m2_sr: scene.background_radiance,
            rig_file: None,
            rig: Some(RigFile::from_rig(&scene.rig)),
            water: Some(WaterEntry {
                name: None,
                absorption_per_m: Some(scene.medium.absorption_per_m()),
                scattering_per_m: Some(scene.medium.scattering_per_m()),
                label: Some(scene.water_label.clone()),
                phase: Some(PhaseEntry::from_phase(scene.medium.phase())),
            }),
            lamp: scene.lamps.iter().map(LampEntry::from_lamp).collect(),
            rod: scene.rods.iter().map(RodEntry::from_rod).collect(),
            occluder: scene
                .occluders
                .iter()
                .map(OccluderEntry::from_occluder)
                .collect(),
            prop: scene.props.iter().map(PropEntry::from_prop).collect(),
            seabed: scene.seabed.map(|seabed| SeabedEntry {
                z_m: seabed.z_m,
                albedo: seabed.albedo,
                texture_contrast: seabed.texture_contrast,
                texture_scale_m: seabed.texture_scale_m,
                ripples: seabed.ripples.map(RipplesEntry::from_ripples),
                clutter: seabed.clutter.map(ClutterEntry::from_clutter),
            }),
            snow: scene.snow,
            target: TargetEntry {
                rod: scene.rods[scene.target.rod].id.clone(),
                along_m: Some(scene.target.along_m),
                near_m: None,
                pick_eye: scene.target.pick_eye,
            },
            exposure: match scene.exposure {
                Exposure::Fixed(gain) => ExposureEntry::Gain(gain),
                Exposure::Auto { quantile, level } => {
                    ExposureEntry::Auto(AutoExposureEntry { quantile, level })
                }
            },
            lens: scene.lens,
            motion: scene.motion.as_ref().map(MotionEntry::from_motion),
            output: scene.output,
            white_balance: scene.white_balance,
            colour_matrix: scene.colour_matrix,
            sensor: match scene.sensor {
                Sensor::Plain { noise_sigma_dn } => {
                    SensorEntry::Plain(PlainSensorEntry { noise_sigma_dn })
                }
                Sensor::Emva(emva) => SensorEntry::Emva(EmvaEntry {
                    full_well_e: emva.full_well_e,
                    read_noise_e: emva.read_noise_e,
                    dark_e: emva.dark_e,
                    prnu: emva.prnu,
                    dsnu_e: emva.dsnu_e,
                    adc_bits: emva.adc_bits,
                    pattern_seed: emva.pattern_seed,
                    bayer: emva.bayer,
                }),
            },
            sampling: SamplingEntry {
                edge: match scene.sampling.edge {
                    EdgeSampling::Fibonacci { points } => EdgeEntry::Fibonacci(points),
                    EdgeSampling::Grid { side } => EdgeEntry::Grid(side),
                },
                airlight_points: scene.sampling.airlight_points,
            },
        }
    }

    /// The text of the file.
    pub fn to_toml(&self) -> String {
        toml::to_string(self).expect("plain numbers, strings and paths always serialise")
    }
}

impl PhaseEntry {
    fn from_phase(phase: &Phase) -> Self {
        match phase {
            Phase::Isotropic => Self::Isotropic,
            named if *named == Phase::petzold3() => Self::Petzold3,
            named if *named == Phase::petzold4() => Self::Petzold4,
            Phase::HenyeyGreensteinSum(lobes) => Self::Lobes(
                lobes
                    .iter()
                    .map(|lobe| LobeEntry {
                        weight: lobe.weight,
                        g: lobe.g,
                    })
                    .collect(),
            ),
            &Phase::FournierForand {
                refractive_index,
                junge_slope,
            } => Self::FournierForand(FournierForandEntry {
                refractive_index,
                junge_slope,
            }),
        }
    }
}

impl LampEntry {
    fn from_lamp(lamp: &Lamp) -> Self {
        Self {
            position_m: lamp.position_m.into(),
            direction: Some(lamp.direction.into()),
            aim_at_m: None,
            radiant_intensity_w_per_sr: lamp.radiant_intensity_w_per_sr,
            inner_half_angle_deg: degrees_that_read_back(lamp.inner_half_angle_rad),
            outer_half_angle_deg: degrees_that_read_back(lamp.outer_half_angle_rad),
        }
    }
}

impl RodEntry {
    fn from_rod(rod: &Rod) -> Self {
        let (albedo, flat_radiance_w_per_m2_sr) = match rod.material {
            Material::Lambert(albedo) => (Some(albedo), None),
            Material::Flat(radiance) => (None, Some(radiance)),
        };
        Self {
            id: rod.id.clone(),
            from_m: None,
            to_m: None,
            centre_m: Some(rod.centre_m.into()),
            direction: Some(rod.direction.into()),
            length_m: Some(rod.length_m),
            radius_m: rod.radius_m,
            bend: rod.bend.map(|bend| BendEntry {
                sagitta_m: bend.sagitta_m,
                towards: bend.towards.into(),
            }),
            albedo,
            flat_radiance_w_per_m2_sr,
            surface: SurfaceEntry::from_rod(rod),
        }
    }
}

/// The degrees that [`radians`] takes to exactly this angle, if the angle came from degrees: rounding may need the
/// neighbour, and the shortest decimal is what was typed.
pub(crate) fn degrees_that_read_back(angle_rad: f64) -> f64 {
    let near = degrees(angle_rad);
    let rounded = (near * 1e9).round() / 1e9;
    [rounded, near, near.next_up(), near.next_down()]
        .into_iter()
        .find(|&angle_deg| radians(angle_deg) == angle_rad)
        .unwrap_or(near)
}
