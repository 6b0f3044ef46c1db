//! A prepared scene as the shaders take it: all points from the centre of one eye, in `f32`.

use encase::ShaderType;
use encase::internal::WriteInto;
use rodsight_geometry::port::{Band, PortShape};
use rodsight_geometry::{Distortion, Eye, MountedCamera, Vec3};
use rodsight_optics::{Daylight, Phase, Wells};
use rodsight_scene::{EdgeSampling, Finish, Mode};

use super::content;
use super::layout::{self, Vec2f, Vec4f};
use super::passes::Variant;
use crate::bvh::Bvh;
use crate::cpu::airlight_grid::{AirlightGrid, STEPS};
use crate::cpu::rod::Rods;
use crate::cpu::solid::Capped;
use crate::cpu::world::{World, graze_rad};
use crate::lattice::{edge_offsets, inner_offsets};

/// Nodes of the table of a phase function that is no sum of four lobes: linear between them it is 1e-5 off.
const PHASE_NODES: u32 = 2048;

/// The contents of the buffers of an eye, in the order of their bindings.
pub(super) struct Upload {
    pub(super) variant: Variant,
    pub(super) frame: Vec<u8>,
    pub(super) storage: Vec<(&'static str, Vec<u8>)>,
}

impl Upload {
    /// The scene as one band of light shows it to an eye.
    pub(super) fn new(world: &World<'_>, eye: Eye, band: Band, grid: &AirlightGrid) -> Self {
        let mounted = &world.scene.rig.eye(eye).in_band(band);
        let origin_m = world.scene.rig.eye(eye).rig_from_camera.origin_m();
        let rods = 0..world.scene.rods.len();
        let rods: Vec<layout::Rod> = rods
            .map(|index| content::rod(world, index, &origin_m))
            .collect();
        let lamps: Vec<layout::Lamp> = world
            .lamps
            .iter()
            .map(|light| layout::Lamp {
                position_m: (light.lamp.position_m - origin_m).into(),
                cos_inner: light.cos_inner as f32,
                direction: light.lamp.direction.into(),
                cos_outer: light.cos_outer as f32,
                radiant_intensity_w_per_sr: light.lamp.radiant_intensity_w_per_sr.into(),
            })
            .collect();
        let casters: Vec<layout::Caster> = world
            .lamps
            .iter()
            .flat_map(|light| {
                light
                    .shadows
                    .casters
                    .iter()
                    .map(move |caster| (light, caster))
            })
            .map(|(light, caster)| {
                let [plus, minus] = caster.touching_m.unwrap_or_default();
                layout::Caster {
                    solid: solid(&caster.piece, &light.lamp.position_m),
                    touching_plus_m: plus.into(),
                    touching_minus_m: minus.into(),
                    touches: caster.touching_m.is_some().into(),
                    instance: caster.rod as u32 + 2,
                }
            })
            .collect();
        let (outline, inner) = (
            edge_offsets(world.scene.sampling.edge),
            inner_offsets(world.scene.sampling.edge),
        );
        let (lobes, phase) = phase(world.scene.medium.phase());
        let airlight: Vec<Vec4f> = grid
            .knots
            .iter()
            .flatten()
            .map(|&[r, g, b]| [r, g, b, 0.0].into())
            .collect();
        let triangles = &world.bodies.triangles;
        let mut nodes = Vec::new();
        let trees = [&world.rods.tree, &world.bodies.tree, &triangles.tree];
        let [rod_nodes, body_nodes, mesh_nodes] = trees.map(|tree| {
            thread(tree, &origin_m, &mut nodes);
            nodes.len() as u32
        });
        let bodies = content::bodies(world, &origin_m);
        let (paints, texels) = content::paints(world);
        let frame = layout::Frame {
            nodes: rod_nodes,
            body_nodes,
            mesh_nodes,
            lamps: lamps.len() as u32,
            casters: (casters.len() / lamps.len().max(1)) as u32,
            samples: outline.len() as u32,
            inner_samples: inner.len() as u32,
            lobes: lobes.unwrap_or_default(),
            phase_nodes: phase.len() as u32,
            grid_columns: grid.columns as u32,
            grid_rows: grid.rows as u32,
            grid_steps: STEPS as u32,
            grid_half_way_m: grid.half_way_m as f32,
            grid_scale: grid.scale.into(),
            eye_port: port(mounted),
            ..frame(world, eye)
        };
        let mut bytes = encase::UniformBuffer::new(Vec::new());
        bytes.write(&frame).expect("a vector grows");
        Self {
            variant: Variant {
                has_phase_table: lobes.is_none(),
                has_airlight_table: !grid.knots.is_empty(),
                ..variant(world, eye)
            },
            frame: bytes.into_inner(),
            storage: vec![
                ("segments", storage(segments(&world.rods, &origin_m))),
                ("rods", storage(rods)),
                ("lamps", storage(lamps)),
                ("casters", storage(casters)),
                (
                    "offsets",
                    storage(
                        outline
                            .into_iter()
                            .chain(inner)
                            .map(Vec2f::from)
                            .collect::<Vec<_>>(),
                    ),
                ),
                ("phase", storage(phase)),
                ("nodes", storage(nodes)),
                ("airlight", storage(airlight)),
                ("bodies", storage(bodies)),
                ("vertices", storage(content::vertices(triangles, &origin_m))),
                ("triangles", storage(content::triangles(triangles))),
                ("paints", storage(paints)),
                ("texels", storage(texels)),
            ],
        }
    }
}

/// A buffer of at least one element: an empty one cannot be bound.
pub(super) fn storage<T: ShaderType + WriteInto + Default>(mut elements: Vec<T>) -> Vec<u8>
where
    Vec<T>: ShaderType + WriteInto,
{
    if elements.is_empty() {
        elements.push(T::default());
    }
    let mut bytes = encase::StorageBuffer::new(Vec::new());
    bytes.write(&elements).expect("a vector grows");
    bytes.into_inner()
}

/// Which formula a lens has; see `camera.wgsl`.
pub(super) fn lens(mounted: &MountedCamera) -> u32 {
    match mounted.camera.distortion() {
        Distortion::None => 0,
        Distortion::BrownConrady(_) => 1,
        Distortion::KannalaBrandt(_) => 2,
    }
}

/// Everything of the variant but the tables.
fn variant(world: &World<'_>, eye: Eye) -> Variant {
    let scene = world.scene;
    let lens = |eye| lens(scene.rig.eye(eye));
    let glass = |eye| match scene.rig.eye(eye).port.map(|port| *port.shape()) {
        None => 0,
        Some(PortShape::Flat(_)) => 1,
        Some(PortShape::Dome(_)) => 2,
    };
    Variant {
        mode: match scene.mode {
            Mode::Air => 0,
            Mode::Koschmieder => 1,
            Mode::Single => 2,
            Mode::Full => 3,
        },
        eye_lens: lens(eye),
        other_lens: lens(eye.other()),
        eye_port: glass(eye),
        other_port: glass(eye.other()),
        has_seabed: scene.seabed.is_some(),
        has_finish: scene.rods.iter().any(|rod| rod.finish != Finish::default()),
        has_bodies: !world.bodies.solids.is_empty(),
        has_mesh: !world.bodies.triangles.corners.is_empty(),
        has_ripples: scene.seabed.is_some_and(|s| s.ripples.is_some()),
        ..Variant::default()
    }
}

/// Everything of the frame but the lengths of the buffers.
fn frame(world: &World<'_>, eye: Eye) -> layout::Frame {
    let scene = world.scene;
    let (mounted, other) = (scene.rig.eye(eye), scene.rig.eye(eye.other()));
    let origin_m = mounted.rig_from_camera.origin_m();
    let seabed = scene.seabed.as_ref();
    let daylight = scene.daylight.unwrap_or(Daylight {
        irradiance_w_per_m2: [0.0; 3],
        diffuse_attenuation_per_m: [0.0; 3],
    });
    layout::Frame {
        eye: camera(mounted, &origin_m),
        other: camera(other, &origin_m),
        other_port: port(other),
        ripples: seabed
            .and_then(|s| s.ripples.as_ref())
            .map_or_else(Default::default, content::ripples),
        attenuation_per_m: world.attenuation_per_m.into(),
        horizon_m: world.horizon_m as f32,
        lamp_attenuation_per_m: world.lamp_attenuation_per_m.into(),
        veil_scattering_per_m: world.scattering_per_m.into(),
        scattering_per_m: scene.medium.scattering_per_m().into(),
        graze_rad: graze_rad(mounted) as f32,
        ambient_radiance: scene.ambient_radiance.into(),
        footprint_rad: world.footprint_rad as f32,
        background_radiance: scene.background_radiance.into(),
        airlight_points: scene.sampling.airlight_points,
        seabed_albedo: seabed.map_or([0.0; 3], |s| s.albedo).into(),
        seabed_z_m: seabed.map_or(0.0, |s| s.z_m - origin_m.z) as f32,
        rig_from_eye_m: origin_m.into(),
        seabed_contrast: seabed.map_or(0.0, |s| s.texture_contrast) as f32,
        seabed_scale_m: seabed.map_or(1.0, |s| s.texture_scale_m) as f32,
        seabed_seed: crate::cpu::seabed::seed_word(scene.seed),
        shifts: matches!(scene.sampling.edge, EdgeSampling::Fibonacci { .. }).into(),
        daylight_w_per_m2: daylight.irradiance_w_per_m2.into(),
        daylight_attenuation_per_m: daylight.diffuse_attenuation_per_m.into(),
        snow_albedo: scene.snow.map_or([0.0; 3], |snow| snow.albedo).into(),
        disparity_sign: match eye {
            Eye::Left => 1.0,
            Eye::Right => -1.0,
        },
        soft_lobes: soft_lobes(world),
        regained_per_m: match scene.mode {
            Mode::Full => Wells::of(&scene.medium).map(|band| band.regained_per_m(0.0)),
            _ => [0.0; 3],
        }
        .into(),
        ..layout::Frame::default()
    }
}

/// Two lobes a vector.
fn soft_lobes(world: &World<'_>) -> [Vec4f; Phase::MOST_LOBES / 2] {
    let pair = |k: usize| {
        let lobe = |i: usize| {
            let lobe = world.soft_lobes.get(i);
            lobe.map_or([0.0; 2], |lobe| [lobe.share, lobe.width_rad])
        };
        let [a, b] = [lobe(2 * k), lobe(2 * k + 1)];
        [a[0], a[1], b[0], b[1]].into()
    };
    core::array::from_fn(pair)
}

pub(super) fn camera(mounted: &MountedCamera, from_m: &Vec3) -> layout::Camera {
    let i = mounted.camera.intrinsics();
    let pose = &mounted.rig_from_camera;
    let (k, p) = match *mounted.camera.distortion() {
        Distortion::None => ([0.0; 4], [0.0; 2]),
        Distortion::BrownConrady([k1, k2, p1, p2, k3]) => ([k1, k2, k3, 0.0], [p1, p2]),
        Distortion::KannalaBrandt(k) => (k, [0.0; 2]),
    };
    layout::Camera {
        right: pose.direction(&Vec3::x()).into(),
        fx_px: i.fx_px as f32,
        down: pose.direction(&Vec3::y()).into(),
        fy_px: i.fy_px as f32,
        forward: pose.direction(&Vec3::z()).into(),
        cx_px: i.cx_px as f32,
        origin_m: (pose.origin_m() - from_m).into(),
        cy_px: i.cy_px as f32,
        k: k.into(),
        p: p.into(),
        fold: mounted.camera.fold().min(1e30) as f32,
        size_px: [f64::from(i.width_px), f64::from(i.height_px)].into(),
        shift: <[f64; 2]>::from(*mounted.camera.shift()).into(),
    }
}

/// The glass before a camera, in green; all zero without one.
fn port(mounted: &MountedCamera) -> layout::Port {
    let Some(port) = &mounted.port else {
        return layout::Port::default();
    };
    let (axis, inner_m, thickness_m) = match *port.shape() {
        PortShape::Flat(flat) => (flat.normal, flat.distance_m, flat.thickness_m),
        PortShape::Dome(dome) => (dome.centre_m, dome.inner_radius_m, dome.thickness_m),
    };
    layout::Port {
        axis: axis.into(),
        inner_m: inner_m as f32,
        thickness_m: thickness_m as f32,
        glass_index: port.glass_index() as f32,
        water_index: port.water_index()[Band::Green.index()] as f32,
    }
}

pub(super) fn solid(piece: &Capped, from_m: &Vec3) -> layout::Solid {
    let axis = &piece.cylinder.axis;
    layout::Solid {
        centre_m: (axis.point_m - from_m).into(),
        half_length_m: piece.half_length_m as f32,
        direction: axis.direction.into(),
        radius_m: piece.cylinder.radius_m as f32,
    }
}

/// The pieces of all rods in the order of the tree's leaves.
pub(super) fn segments(rods: &Rods, from_m: &Vec3) -> Vec<layout::Segment> {
    let pieces = rods.tree.order.iter().map(|&piece| {
        let (rod, index) = rods.pieces[piece as usize];
        let (arc, all) = (&rods.solids[rod].arc, &rods.solids[rod].segments);
        let piece = &all[index];
        // The arc's point whose tangent is the piece's direction.
        let at = arc.at(arc.parameter_of(&piece.cylinder.axis.point_m));
        layout::Segment {
            solid: solid(piece, from_m),
            arc_m: (at.point_m - piece.cylinder.axis.point_m).into(),
            curvature_per_m: arc.curvature_per_m as f32,
            inward: arc.inward(&at.direction).into(),
            instance: rod as u32 + 2,
            ends: u32::from(index == 0) | u32::from(index + 1 == all.len()) << 1,
        }
    });
    pieces.collect()
}

/// A node to visit, or an inner one to close now that all that it holds is there.
enum Step {
    Visit(u32),
    Close(usize),
}

/// Adds the nodes of a tree in the order of a walk that goes into every box, those nearer to the eye first. `first` of an inner node
/// is the node after its last descendant: where to go on if its box is missed. Boxes grow by what rounding to `f32` may move a ray.
fn thread(tree: &Bvh, from_m: &Vec3, nodes: &mut Vec<layout::BvhNode>) {
    let mut stack: Vec<Step> = tree
        .nodes
        .first()
        .map(|_| Step::Visit(0))
        .into_iter()
        .collect();
    while let Some(step) = stack.pop() {
        match step {
            Step::Close(node) => {
                let after: u32 = nodes.len() as u32;
                let node: &mut layout::BvhNode = &mut nodes[node];
                node.first = after;
            }
            Step::Visit(index) => {
                let node = &tree.nodes[index as usize];
                let edge = |bound: [f32; 3], sign: f64| {
                    core::array::from_fn::<f64, 3, _>(|k| {
                        let from_eye = f64::from(bound[k]) - from_m[k];
                        from_eye + sign * (1e-6 + 1e-6 * from_eye.abs())
                    })
                };
                if node.count == 0 {
                    let mut children = [node.first + 1, node.first];
                    let [other, first] = children.map(|child| {
                        let node = &tree.nodes[child as usize];
                        distance2_m2(node.min_m, node.max_m, from_m)
                    });
                    if other < first {
                        children.reverse();
                    }
                    stack.push(Step::Close(nodes.len()));
                    stack.extend(children.map(Step::Visit));
                }
                nodes.push(layout::BvhNode {
                    min_m: edge(node.min_m, -1.0).into(),
                    first: node.first,
                    max_m: edge(node.max_m, 1.0).into(),
                    count: node.count,
                });
            }
        }
    }
}

/// From a point to the nearest of a box, squared.
fn distance2_m2(min_m: [f32; 3], max_m: [f32; 3], from_m: &Vec3) -> f64 {
    let gap = |k: usize| {
        let (low, high) = (f64::from(min_m[k]), f64::from(max_m[k]));
        from_m[k] - from_m[k].clamp(low, high)
    };
    (0..3).map(|k| gap(k) * gap(k)).sum()
}

/// Up to four lobes as (amplitude, (1 − g)², 2g, 0), or else a table of logarithms.
fn phase(phase: &Phase) -> (Option<[Vec4f; 4]>, Vec<f32>) {
    const PI: f64 = core::f64::consts::PI;
    let mut four = [[0.0, 1.0, 0.0, 0.0]; 4];
    match phase {
        Phase::Isotropic => four[0][0] = 0.25 / PI,
        Phase::HenyeyGreensteinSum(lobes) if lobes.len() <= four.len() => {
            for (lobe, constants) in lobes.iter().zip(&mut four) {
                let (rest, amplitude) = (1.0 - lobe.g, 1.0 - lobe.g * lobe.g);
                *constants = [
                    lobe.weight * amplitude / (4.0 * PI),
                    rest * rest,
                    2.0 * lobe.g,
                    0.0,
                ];
            }
        }
        Phase::HenyeyGreensteinSum(_) | Phase::FournierForand { .. } => {
            let node = |i: u32| {
                // 1 − cos θ = 2 y⁸.
                let y = f64::from(i) / f64::from(PHASE_NODES - 1);
                let y4 = y * y * y * y;
                libm::log(phase.value_per_sr(1.0 - 2.0 * y4 * y4)) as f32
            };
            return (None, (0..PHASE_NODES).map(node).collect());
        }
    }
    (Some(four.map(Vec4f::from)), Vec::new())
}
