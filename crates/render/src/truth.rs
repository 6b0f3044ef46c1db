//! The truth record: what is to be found in a pair, and how well it could be.

mod content;
mod places;
mod view;

use rodsight_geometry::{Eye, ImageLine, Line3, PaperGrasp, RigFile};
use rodsight_optics::Medium;
use rodsight_scene::{Mode, Rod, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cpu::arc::Arc;
use crate::cpu::rod::Rods;
use crate::cpu::solid::Ray;
use crate::cpu::world::World;
use crate::frame::Frame;
use crate::lens;
pub use content::{FoulingTruth, OccluderTruth, PropTruth, StonesTruth};
use view::EyeView;

/// All that is true of a rendered pair. Vectors are in the rig frame unless they say otherwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Truth {
    /// Version of this format: 1.
    pub schema: u32,
    /// Name and version of what wrote it.
    pub generator: String,
    /// The scene's id.
    pub scene: String,
    /// The scene's seed.
    pub seed: u64,
    /// Backend that rendered the pair.
    pub backend: String,
    /// What it ran on.
    pub adapter: String,
    /// What of the water was rendered.
    pub mode: Mode,
    /// The water.
    pub water: WaterTruth,
    /// Exposure: fraction of full scale per W m⁻² sr⁻¹.
    pub gain: f64,
    /// Gains of the bands after the sensor.
    pub white_balance: [f64; 3],
    /// How much of the images is beyond the model; null where nothing is.
    #[serde(default)]
    pub beyond_model: Option<BeyondModelTruth>,
    /// The rig.
    pub rig: RigFile,
    /// Every rod.
    pub rods: Vec<RodTruth>,
    /// Simple bodies that stand in the way.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub occluders: Vec<OccluderTruth>,
    /// Meshes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub props: Vec<PropTruth>,
    /// Stones on the seabed; null without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stones: Option<StonesTruth>,
    /// What is to be grasped.
    pub grasp: GraspTruth,
}

/// The water used, per band (600, 525, 475 nm).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[expect(missing_docs, reason = "the names say it")]
pub struct WaterTruth {
    pub label: String,
    pub absorption_per_m: [f64; 3],
    pub scattering_per_m: [f64; 3],
    pub mean_scattering_cosine: f64,
}

/// Where mode `full` is beyond what it is good for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BeyondModelTruth {
    /// Share of the left image's pixels, (0, 1].
    pub left_share: f64,
    /// Share of the right image's pixels.
    pub right_share: f64,
    /// What that means.
    pub meaning: String,
}

impl BeyondModelTruth {
    fn of(frame: &Frame) -> Option<Self> {
        let [left_share, right_share] = Eye::BOTH.map(|eye| frame.eye(eye).beyond_model_share());
        (left_share + right_share > 0.0).then(|| Self {
            left_share,
            right_share,
            meaning: format!(
                "surfaces behind an optical depth above {} in some band; against Monte Carlo they are too bright, \
                 by 10 to 15 % at first and by a third at 5.5",
                Medium::OPTICAL_DEPTH_LIMIT
            ),
        })
    }
}

/// A straight line in space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LineTruth {
    /// A point of the line, m.
    pub point_m: [f64; 3],
    /// Unit direction.
    pub direction: [f64; 3],
}

impl From<Line3> for LineTruth {
    fn from(line: Line3) -> Self {
        Self {
            point_m: line.point_m.into(),
            direction: line.direction.into(),
        }
    }
}

/// One rod.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RodTruth {
    /// Its name.
    pub id: String,
    /// Its number in the instance channel.
    pub instance: u16,
    /// Tangent of its axis at the middle (a straight rod: its axis).
    pub axis: LineTruth,
    /// Radius, m.
    pub radius_m: f64,
    /// The two ends of the axis, m.
    pub ends_m: [[f64; 3]; 2],
    /// Height of the arc over its chord, m; zero for a straight rod.
    pub sagitta_m: f64,
    /// What grows on it; null on a clean rod.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fouling: Option<FoulingTruth>,
    /// Angle between the axis and the baseline, rad, in [0, π/2].
    pub angle_to_baseline_rad: f64,
    /// What the left eye sees of it.
    pub left: EyeTruth,
    /// What the right eye sees of it.
    pub right: EyeTruth,
}

/// A rod in one image. `lines` are exact; `curves` are what they become where the lens or the rod is not straight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EyeTruth {
    /// The axis in the camera's frame.
    pub axis_in_camera: LineTruth,
    /// The two limbs and the axis as straight lines; null for a bent rod, a lens with distortion or a port.
    pub lines: Option<ConeTruth<ImageLine>>,
    /// The same as points along the rod, px, end to end, without what is behind the camera, so close that straight pieces between
    /// them are right to 1e-3 px in the image; in the green band behind a port. Null where `lines` is exact, where the rod is wholly
    /// behind, and where the camera looks along it from within its radius.
    pub curves: Option<ConeTruth<Vec<[f64; 2]>>>,
    /// Stretches of the axis, m from its middle, that are in the image with nothing before the surface over them; looked for at every
    /// pixel, so that what hides less may be missed.
    pub visible_m: Vec<[f64; 2]>,
    /// Pixels whose centre shows the rod.
    pub visible_px: u64,
    /// Contrast over noise on the plus and the minus limb: `√(Σ_bands (Δ/σ)²)`, Δ and σ on the encoded image 2.5 px to either
    /// side, root mean square over the visible limb; null without noise or where the limb is not seen.
    pub contrast_to_noise: [Option<f64>; 2],
}

/// The three lines of a cylinder in a view.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[expect(missing_docs, reason = "the names say it")]
pub struct ConeTruth<T> {
    pub plus_limb: T,
    pub minus_limb: T,
    pub axis: T,
}

/// The grasp the scene asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct GraspTruth {
    /// Index of the rod.
    pub rod: usize,
    /// The eye in which the operator picks.
    pub pick_eye: Eye,
    /// The picked pixel: where the grasp's axis point is seen.
    pub pick_px: [f64; 2],
    /// Foot on the axis of the first point where the pick ray meets the rod, m: the primary grasp point.
    pub point_m: [f64; 3],
    /// Point of the axis nearest to the pick ray, m: the paper's.
    pub paper_point_m: [f64; 3],
    /// Tangent of the axis at the grasp.
    pub axis: LineTruth,
}

impl Truth {
    /// The version this code writes.
    pub const SCHEMA: u32 = 1;

    /// Writes down the truth of a rendered scene; `gain` as [`develop`](crate::develop) returned it. `None` if the scene's grasp
    /// cannot be seen by the eye it is picked in, which a validated scene rules out.
    pub fn of(scene: &Scene, frame: &Frame, gain: f64) -> Option<Self> {
        let world = World::new(scene);
        let light = Eye::BOTH.map(|eye| lens::on_sensor(frame.eye(eye), scene, eye));
        Some(Self {
            schema: Self::SCHEMA,
            generator: concat!("rodsight ", env!("CARGO_PKG_VERSION")).to_owned(),
            scene: scene.id.clone(),
            seed: scene.seed,
            backend: frame.backend.to_owned(),
            adapter: frame.adapter.clone(),
            mode: scene.mode,
            water: WaterTruth {
                label: scene.water_label.clone(),
                absorption_per_m: scene.medium.absorption_per_m(),
                scattering_per_m: scene.medium.scattering_per_m(),
                mean_scattering_cosine: scene.medium.phase().mean_cosine(),
            },
            gain,
            white_balance: scene.white_balance,
            beyond_model: BeyondModelTruth::of(frame),
            rig: RigFile::from_rig(&scene.rig),
            rods: scene
                .rods
                .iter()
                .enumerate()
                .map(|(index, rod)| rod_truth(&world, index, rod, frame, &light, gain))
                .collect(),
            occluders: content::occluders(scene),
            props: content::props(scene),
            stones: content::stones(&world),
            grasp: grasp_truth(scene)?,
        })
    }

    /// The rod that is to be grasped.
    pub fn target(&self) -> &RodTruth {
        &self.rods[self.grasp.rod]
    }
}

fn grasp_truth(scene: &Scene) -> Option<GraspTruth> {
    let target = scene.target;
    let rod = &scene.rods[target.rod];
    let arc = Arc::of(rod);
    let half_m = rod.length_m / 2.0;
    // A hair inside the ends: a ray to the very end may slip past the cap.
    let inner_m = half_m * (1.0 - 1e-9);
    let wanted = arc.at(target.along_m.clamp(-inner_m, inner_m));
    let eye = scene.rig.eye(target.pick_eye);
    let pick = eye.project(&wanted.point_m)?;
    let (origin_m, direction) = eye.ray(&pick)?;
    // On a bent rod both definitions act on the tangent at the grasp.
    // A ray along the rod is nearest to all of its axis.
    let paper = PaperGrasp::new(&wanted, &origin_m, &direction);
    let paper_point_m = paper.map_or(wanted.point_m, |paper| paper.point_m);
    // The finite rod: near an end the ray may meet the cap.
    let (_, hit) = Rods::new(core::slice::from_ref(rod)).hit(&Ray {
        origin_m,
        direction,
    })?;
    let along_m = arc.parameter_of(&(origin_m + direction * hit.t_m));
    let point = arc.at(along_m.clamp(-half_m, half_m)).point_m;
    Some(GraspTruth {
        rod: target.rod,
        pick_eye: target.pick_eye,
        pick_px: pick.into(),
        point_m: point.into(),
        paper_point_m: paper_point_m.into(),
        axis: wanted.into(),
    })
}

fn rod_truth(
    world: &World<'_>,
    index: usize,
    rod: &Rod,
    frame: &Frame,
    light: &[Vec<[f32; 3]>; 2],
    gain: f64,
) -> RodTruth {
    let rig = &world.scene.rig;
    let arc = Arc::of(rod);
    let axis = arc.at(0.0);
    let baseline = Line3::new(rig.left.rig_from_camera.origin_m(), &rig.baseline());
    let eye_truth = |eye: Eye| {
        EyeView {
            world,
            rod,
            arc,
            mounted: rig.eye(eye),
            frame: frame.eye(eye),
            light: &light[eye as usize],
        }
        .truth(index, gain)
    };
    RodTruth {
        id: rod.id.clone(),
        instance: world.scene.rod_instance(index),
        axis: axis.into(),
        radius_m: rod.radius_m,
        ends_m: [-0.5, 0.5].map(|side| arc.at(side * rod.length_m).point_m.into()),
        sagitta_m: rod.bend.map_or(0.0, |bend| bend.sagitta_m),
        fouling: content::fouling(world, index),
        angle_to_baseline_rad: axis.angle_to(&baseline),
        left: eye_truth(Eye::Left),
        right: eye_truth(Eye::Right),
    }
}
