//! The truth record: what is to be found in a pair, and how well it could be.

use rodsight_geometry::{
    Cylinder, Eye, ImageLine, Line3, MountedCamera, PaperGrasp, Pixel, RigFile, Vec3, surface_foot,
};
use rodsight_scene::{Mode, Rod, Scene};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::cpu::solid::{Arc, Ray, RodSolid};
use crate::cpu::world::World;
use crate::develop::noise_sigma;
use crate::frame::{EyeFrame, Frame};
use crate::srgb::srgb_encode;

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
    /// The rig.
    pub rig: RigFile,
    /// Every rod.
    pub rods: Vec<RodTruth>,
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
    /// The two limbs and the axis as straight lines; null for a bent rod or a lens with distortion.
    pub lines: Option<ConeTruth<ImageLine>>,
    /// The same as points along the rod, px, end to end; null where `lines` is exact or the rod is wholly behind the camera.
    pub curves: Option<ConeTruth<Vec<[f64; 2]>>>,
    /// Stretches of the axis, m from its middle, whose surface is in the image and not hidden.
    pub visible_m: Vec<[f64; 2]>,
    /// Pixels whose centre shows the rod.
    pub visible_px: u64,
    /// Contrast over noise on the plus and the minus limb: `√(Σ_bands (Δ/σ)²)`; null without noise or where the limb is not seen.
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
            rig: RigFile::from_rig(&scene.rig),
            rods: scene
                .rods
                .iter()
                .enumerate()
                .map(|(index, rod)| rod_truth(&world, index, rod, frame, gain))
                .collect(),
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
    let wanted = arc.at(target.along_m);
    let eye = scene.rig.eye(target.pick_eye);
    let pick = eye.project(&wanted.point_m)?;
    let (origin_m, direction) = eye.ray(&pick)?;
    // On a bent rod both definitions act on the tangent at the grasp.
    let paper = PaperGrasp::new(&wanted, &origin_m, &direction).ok()?;
    let cylinder = Cylinder {
        axis: wanted,
        radius_m: rod.radius_m,
    };
    let point = if rod.bend.is_some() {
        let hit = RodSolid::new(rod).hit(&Ray {
            origin_m,
            direction,
        })?;
        arc.at(arc.parameter_of(&(origin_m + direction * hit.t_m)))
            .point_m
    } else {
        surface_foot(&cylinder, &origin_m, &direction)?
    };
    Some(GraspTruth {
        rod: target.rod,
        pick_eye: target.pick_eye,
        pick_px: pick.into(),
        point_m: point.into(),
        paper_point_m: paper.point_m.into(),
        axis: wanted.into(),
    })
}

fn rod_truth(world: &World<'_>, index: usize, rod: &Rod, frame: &Frame, gain: f64) -> RodTruth {
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
        }
        .truth(index, gain)
    };
    RodTruth {
        id: rod.id.clone(),
        instance: index as u16 + 2,
        axis: axis.into(),
        radius_m: rod.radius_m,
        ends_m: [-0.5, 0.5].map(|side| arc.at(side * rod.length_m).point_m.into()),
        sagitta_m: rod.bend.map_or(0.0, |bend| bend.sagitta_m),
        angle_to_baseline_rad: axis.angle_to(&baseline),
        left: eye_truth(Eye::Left),
        right: eye_truth(Eye::Right),
    }
}

/// One rod in one eye.
struct EyeView<'a> {
    world: &'a World<'a>,
    rod: &'a Rod,
    arc: Arc,
    mounted: &'a MountedCamera,
    frame: &'a EyeFrame,
}

/// Points along a curve of the truth.
const CURVE_POINTS: usize = 257;
/// Pixels from the limb at which contrast is measured, on either side: outside any blur, inside any rod worth grasping.
const CONTRAST_REACH_PX: f64 = 2.5;

impl EyeView<'_> {
    fn truth(&self, index: usize, gain: f64) -> EyeTruth {
        let camera_from_rig = self.mounted.rig_from_camera.inverse();
        let axis = self.arc.at(0.0);
        let straight = self.rod.bend.is_none() && self.mounted.camera.is_pinhole();
        let lines = straight
            .then(|| {
                let cylinder = Cylinder {
                    axis,
                    radius_m: self.rod.radius_m,
                };
                cylinder.image_lines(&self.mounted.camera, &self.mounted.rig_from_camera)
            })
            .flatten()
            .map(|[plus_limb, minus_limb, axis]| ConeTruth {
                plus_limb,
                minus_limb,
                axis,
            });
        let visible_m = self.visible_stretches(index);
        let instance = index as u16 + 2;
        EyeTruth {
            axis_in_camera: Line3 {
                point_m: camera_from_rig.point(&axis.point_m),
                direction: camera_from_rig.direction(&axis.direction),
            }
            .into(),
            curves: if lines.is_some() { None } else { self.curves() },
            lines,
            contrast_to_noise: [1.0, -1.0]
                .map(|side| self.contrast_to_noise(side, &visible_m, gain)),
            visible_m,
            visible_px: self
                .frame
                .pixels
                .iter()
                .filter(|pixel| pixel.instance == instance)
                .count() as u64,
        }
    }

    /// Point of a limb (side ±1) or of the axis (0) at arc length s: the surface point whose tangent plane holds the camera.
    fn contour_point(&self, s_m: f64, side: f64) -> Option<Vec3> {
        let axis = self.arc.at(s_m);
        if side == 0.0 {
            return Some(axis.point_m);
        }
        let cylinder = Cylinder {
            axis,
            radius_m: self.rod.radius_m,
        };
        let planes = cylinder.tangent_planes(&self.mounted.rig_from_camera.origin_m())?;
        let normal = if side > 0.0 {
            planes.plus
        } else {
            planes.minus
        };
        Some(axis.point_m - normal * (side * self.rod.radius_m))
    }

    fn curves(&self) -> Option<ConeTruth<Vec<[f64; 2]>>> {
        let curve = |side: f64| -> Option<Vec<[f64; 2]>> {
            let points: Vec<[f64; 2]> = (0..CURVE_POINTS)
                .map(|i| self.rod.length_m * (i as f64 / (CURVE_POINTS - 1) as f64 - 0.5))
                .filter_map(|s_m| self.mounted.project(&self.contour_point(s_m, side)?))
                .map(Into::into)
                .collect();
            (points.len() > 1).then_some(points)
        };
        Some(ConeTruth {
            plus_limb: curve(1.0)?,
            minus_limb: curve(-1.0)?,
            axis: curve(0.0)?,
        })
    }

    /// Whether the surface over the axis point at s is in the image and nothing hides it.
    fn is_visible(&self, s_m: f64, index: usize) -> bool {
        let origin_m = self.mounted.rig_from_camera.origin_m();
        let axis_point = self.arc.at(s_m).point_m;
        let inside = self
            .mounted
            .project(&axis_point)
            .is_some_and(|pixel| self.mounted.camera.contains(&pixel));
        let ray = Ray {
            origin_m,
            direction: (axis_point - origin_m).normalize(),
        };
        inside
            && self
                .world
                .hit(&ray)
                .is_some_and(|hit| hit.thing == crate::cpu::world::Thing::Rod(index))
    }

    fn visible_stretches(&self, index: usize) -> Vec<[f64; 2]> {
        let half = self.rod.length_m / 2.0;
        // A hair inside the ends: a ray to the very end may slip past the cap.
        let at =
            |i: usize| (2.0 * i as f64 / (CURVE_POINTS - 1) as f64 - 1.0) * half * (1.0 - 1e-9);
        let mut stretches = Vec::new();
        let mut begin = self.is_visible(at(0), index).then_some(-half);
        for i in 1..CURVE_POINTS {
            let (mut a, mut b) = (at(i - 1), at(i));
            let was = begin.is_some();
            if self.is_visible(b, index) == was {
                continue;
            }
            for _ in 0..40 {
                let middle = 0.5 * (a + b);
                if self.is_visible(middle, index) == was {
                    a = middle;
                } else {
                    b = middle;
                }
            }
            match begin.take() {
                Some(start) => stretches.push([start, b]),
                None => begin = Some(b),
            }
        }
        stretches.extend(begin.map(|start| [start, half]));
        stretches
    }

    /// Mean over the visible limb of the noise-free encoded difference across it, over the noise there.
    fn contrast_to_noise(&self, side: f64, visible_m: &[[f64; 2]], gain: f64) -> Option<f64> {
        const STEPS: usize = 64;
        let scene = self.world.scene;
        let (mut difference, mut noise, mut count) = ([0.0; 3], [0.0; 3], 0.0);
        for [from, to] in visible_m {
            for i in 0..STEPS {
                let s_m = from + (to - from) * (i as f64 + 0.5) / STEPS as f64;
                let Some([inside, outside]) = self.across_limb(s_m, side) else {
                    continue;
                };
                for k in 0..3 {
                    let [a, b] = [inside[k], outside[k]].map(|light| gain * f64::from(light));
                    let balance = scene.white_balance[k];
                    difference[k] += srgb_encode(balance * a) - srgb_encode(balance * b);
                    let [sigma_a, sigma_b] =
                        [a, b].map(|signal| noise_sigma(&scene.sensor, signal, balance));
                    noise[k] += libm::sqrt((sigma_a * sigma_a + sigma_b * sigma_b) / 2.0);
                }
                count += 1.0;
            }
        }
        if count == 0.0 || noise.contains(&0.0) {
            return None;
        }
        let squares = (0..3)
            .map(|k| difference[k] / noise[k])
            .map(|ratio| ratio * ratio);
        Some(libm::sqrt(squares.sum::<f64>()))
    }

    /// Radiance just inside and just outside a limb at s.
    fn across_limb(&self, s_m: f64, side: f64) -> Option<[[f32; 3]; 2]> {
        let limb = self.mounted.project(&self.contour_point(s_m, side)?)?;
        let axis = self.mounted.project(&self.arc.at(s_m).point_m)?;
        let inwards = (axis - limb).try_normalize(1e-9)?;
        let radiance = |pixel: Pixel| {
            self.mounted.camera.contains(&pixel).then(|| {
                let column = (pixel.x as u32).min(self.frame.width_px - 1);
                let row = (pixel.y as u32).min(self.frame.height_px - 1);
                self.frame.at(column, row).radiance
            })
        };
        Some([
            radiance(limb + inwards * CONTRAST_REACH_PX)?,
            radiance(limb - inwards * CONTRAST_REACH_PX)?,
        ])
    }
}
