// What every pass that casts rays shares: the prepared scene and its light. See cpu/world.rs and cpu/light.rs.
// All points are from the centre of the eye that is rendered, in the axes of the rig: what is near has its digits.

const MODE_AIR: u32 = 0u;
const MODE_KOSCHMIEDER: u32 = 1u;
const MODE_FULL: u32 = 3u;

// Compiled in: where all lanes walk through both sides of a branch, those that no frame takes are not free.
override MODE: u32 = 2u;
override EYE_LENS: u32 = 0u;
override OTHER_LENS: u32 = 0u;
override HAS_SEABED: bool = true;
/// Whether the phase function is a table, not a few lobes.
override PHASE_TABLE: bool = false;
/// Whether the airlight is a table, not a sum over each ray.
override AIRLIGHT_TABLE: bool = true;

const NOTHING: u32 = 0u;
const SEABED: u32 = 1u;

/// Lengths of rays that end at a surface end this much short of it, relative and absolute: a rounding error of f32 more.
const GAP: f32 = 1e-5;
/// A rod does not shade itself nearer than this fraction of its radius: facing the lamp decides there.
const OWN_GAP: f32 = 0.25;
/// Stretches of a ray shorter than this send no light worth a sum, m.
const MIN_STRETCH_M: f32 = 1e-6;

struct Frame {
    eye: Camera,
    other: Camera,
    eye_port: Port,
    other_port: Port,
    ripples: SeabedRipples,
    /// c, between surfaces and the camera.
    attenuation_per_m: vec3<f32>,
    horizon_m: f32,
    /// K, of lamps' light and of what the water scatters back: c but in mode `full`.
    lamp_attenuation_per_m: vec3<f32>,
    /// Of ambient light that is scattered into a ray: b, or b(1 - <cos>) in mode `full`.
    veil_scattering_per_m: vec3<f32>,
    scattering_per_m: vec3<f32>,
    graze_rad: f32,
    ambient_radiance: vec3<f32>,
    footprint_rad: f32,
    background_radiance: vec3<f32>,
    airlight_points: u32,
    seabed_albedo: vec3<f32>,
    seabed_z_m: f32,
    /// The eye's centre in the rig's frame: the texture lies still whichever eye looks.
    rig_from_eye_m: vec3<f32>,
    seabed_contrast: f32,
    seabed_scale_m: f32,
    seabed_seed: u32,
    /// Where the nodes of the rods' tree end, of the bodies' after them, and of the meshes'.
    nodes: u32,
    body_nodes: u32,
    mesh_nodes: u32,
    lamps: u32,
    /// Casters of each lamp.
    casters: u32,
    /// Of a pixel at an outline; and where there is none, which come after these in `offsets`.
    samples: u32,
    inner_samples: u32,
    /// Whether every pixel shifts its samples: the lattice does, the grid does not.
    shifts: u32,
    /// Nodes of the table of the phase function.
    phase_nodes: u32,
    /// Corners of the table of airlight.
    grid_columns: u32,
    grid_rows: u32,
    /// Steps from the camera to infinity, and the distance of half of them.
    grid_steps: u32,
    grid_half_way_m: f32,
    /// Cells per pixel.
    grid_scale: vec2<f32>,
    /// Lobes of the phase function; those that it has not have no amplitude.
    lobes: array<vec4<f32>, 4>,
    /// Two forward lobes each: shares of all of them, and half their widths.
    soft_lobes: array<vec4<f32>, 7>,
    /// Of c, what the halo gives back.
    regained_per_m: vec3<f32>,
    snow_albedo: vec3<f32>,
    /// E_d at the rig, and K_d; without daylight zero.
    daylight_w_per_m2: vec3<f32>,
    daylight_attenuation_per_m: vec3<f32>,
    /// 1 for the left eye, -1 for the right one: disparity is left minus right.
    disparity_sign: f32,
}

/// A rod's surface: an albedo, or the radiance it sends by itself.
struct Rod {
    value: vec3<f32>,
    is_flat: u32,
    arc: Arc,
    finish: Finish,
    reflectance: vec3<f32>,
    /// Of its coat; 0 for none.
    roughness: f32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> segments: array<Segment>;
@group(0) @binding(2) var<storage, read> rods: array<Rod>;
@group(0) @binding(3) var<storage, read> lamps: array<Lamp>;
@group(0) @binding(4) var<storage, read> casters: array<Caster>;
@group(0) @binding(5) var<storage, read> offsets: array<vec2<f32>>;
@group(0) @binding(6) var<storage, read> phase: array<f32>;
@group(0) @binding(7) var<storage, read> nodes: array<BvhNode>;
/// At each corner and step the airlight of the ray up to there and its slope, per step.
@group(0) @binding(8) var<storage, read> airlight: array<vec4<f32>>;

struct Hit {
    t_m: f32,
    instance: u32,
    /// As light sees it: ripples and rounded meshes turn it away from the surface's own.
    normal: vec3<f32>,
    /// Of the surface itself.
    face_normal: vec3<f32>,
    cap: bool,
    point_m: vec3<f32>,
    /// Different where two smooth surfaces of one thing meet in a crease.
    part: u32,
    kind: u32,
    /// Of the body or the triangle.
    index: u32,
    /// Of a triangle's corners.
    weights: vec3<f32>,
}

fn scene_seabed_hit(origin_m: vec3<f32>, direction: vec3<f32>) -> f32 {
    if !HAS_SEABED || direction.z == 0.0 {
        return SOLID_NONE_M;
    }
    let t = (frame.seabed_z_m - origin_m.z) / direction.z;
    return select(SOLID_NONE_M, t, t > 0.0 && t < SOLID_NONE_M);
}

/// The first surface on a ray.
fn scene_hit(origin_m: vec3<f32>, direction: vec3<f32>) -> Hit {
    var hit: Hit;
    hit.t_m = scene_seabed_hit(origin_m, direction);
    if hit.t_m < SOLID_NONE_M {
        hit.instance = SEABED;
        hit.normal = vec3<f32>(0.0, 0.0, -sign(direction.z));
    }
    let per_direction = bvh_per_direction(direction);
    var nearest = 0u;
    var n = 0u;
    while n < frame.nodes {
        let node = nodes[n];
        n++;
        if !bvh_meets(node, origin_m, per_direction, 0.0, hit.t_m) {
            n = select(n, node.first, node.count == 0u);
            continue;
        }
        for (var i = node.first; i < node.first + node.count; i++) {
            let there = solid_hit(segments[i].solid, origin_m, direction);
            if there.t_m < hit.t_m {
                hit.t_m = there.t_m;
                hit.cap = there.cap;
                hit.instance = segments[i].instance;
                nearest = i;
            }
        }
    }
    if hit.instance >= 2u {
        let segment = segments[nearest];
        let rate = dot(segment.solid.direction, direction);
        if hit.cap && solid_is_end(segment, rate) {
            hit.normal = segment.solid.direction * -sign(rate);
        } else {
            hit.cap = false;
            hit.normal = solid_normal(segment, origin_m + direction * hit.t_m);
        }
    }
    hit.face_normal = hit.normal;
    if HAS_BODIES {
        hit = content_nearer_body(hit, origin_m, direction);
    }
    if HAS_MESH {
        hit = content_nearer_triangle(hit, origin_m, direction);
    }
    hit.point_m = origin_m + direction * hit.t_m;
    if HAS_RIPPLES && hit.instance == SEABED && direction.z > 0.0 {
        let at_m = hit.point_m.xy + frame.rig_from_eye_m.xy;
        hit.normal = seabed_rippled_normal(frame.ripples, at_m, direction, scene_along_floor_m(direction, hit.t_m));
    }
    return hit;
}

/// Whether anything but the seabed meets the first `length_m` of a ray: of what the ray is cast for, at a surface of `own`, only
/// what stands well before the end.
fn scene_is_blocked(origin_m: vec3<f32>, direction: vec3<f32>, length_m: f32, own: Hit) -> bool {
    return scene_rods_block(origin_m, direction, length_m, own) || scene_bodies_block(origin_m, direction, length_m, own);
}

fn scene_bodies_block(origin_m: vec3<f32>, direction: vec3<f32>, length_m: f32, own: Hit) -> bool {
    let reach = length_m * (1.0 - GAP) - GAP;
    return (HAS_BODIES && content_body_blocks(origin_m, direction, reach, own))
        || (HAS_MESH && content_triangle_blocks(origin_m, direction, reach, own));
}

fn scene_rods_block(origin_m: vec3<f32>, direction: vec3<f32>, length_m: f32, own: Hit) -> bool {
    let reach = length_m * (1.0 - GAP) - GAP;
    let per_direction = bvh_per_direction(direction);
    var n = 0u;
    while n < frame.nodes {
        let node = nodes[n];
        n++;
        if !bvh_meets(node, origin_m, per_direction, 0.0, reach) {
            n = select(n, node.first, node.count == 0u);
            continue;
        }
        for (var i = node.first; i < node.first + node.count; i++) {
            let own_gap = select(0.0, OWN_GAP * segments[i].solid.radius_m, segments[i].instance == own.instance);
            if solid_hit(segments[i].solid, origin_m, direction).t_m < reach - own_gap {
                return true;
            }
        }
    }
    return false;
}

/// Share of a lamp's scattered light that reaches a place, from the lamp; a rod stops none of its own.
fn scene_soft_share(lamp: u32, point_m: vec3<f32>, own: Hit) -> f32 {
    var passed = 1.0;
    var stopped = 0.0;
    let first = lamp * frame.casters;
    for (var i = first; i < first + frame.casters; i++) {
        if i > first && casters[i].instance != casters[i - 1u].instance {
            passed *= max(1.0 - stopped, 0.0);
            stopped = 0.0;
        }
        if casters[i].instance == own.instance {
            continue;
        }
        let rectangle = penumbra_rectangle(casters[i].solid, point_m);
        if rectangle.across.x >= rectangle.across.y {
            continue;
        }
        for (var k = 0u; k < 7u; k++) {
            let lobes = frame.soft_lobes[k];
            if lobes.x == 0.0 {
                break;
            }
            stopped += lobes.x * penumbra_share(rectangle, lobes.y);
            if lobes.z > 0.0 {
                stopped += lobes.z * penumbra_share(rectangle, lobes.w);
            }
        }
    }
    return passed * max(1.0 - stopped, 0.0);
}

/// Whether anything hides what a ray hit from a place.
fn scene_is_hidden(hit: Hit, from_m: vec3<f32>) -> bool {
    let to_point = hit.point_m - from_m;
    // Triangles have two sides; all else hides its back.
    if hit.kind != KIND_TRIANGLE && dot(hit.face_normal, to_point) >= 0.0 {
        return true;
    }
    let distance = length(to_point);
    let direction = to_point / distance;
    return (hit.instance != SEABED && scene_seabed_hit(from_m, direction) < distance * (1.0 - GAP) - GAP)
        || scene_is_blocked(from_m, direction, distance, hit);
}

fn scene_grazes_a_limb(origin: vec3<f32>, direction: vec3<f32>, footprint_rad: f32) -> bool {
    let per_direction = bvh_per_direction(direction);
    var n = 0u;
    while n < frame.nodes {
        let node = nodes[n];
        n++;
        if !bvh_meets(node, origin, per_direction, footprint_rad, SOLID_NONE_M) {
            n = select(n, node.first, node.count == 0u);
            continue;
        }
        for (var i = node.first; i < node.first + node.count; i++) {
            if solid_grazes(segments[i].solid, origin, direction, footprint_rad) {
                return true;
            }
        }
    }
    return false;
}

/// Light that leaves a surface towards the camera, and which lamps reach it.
struct Surface {
    wet: vec3<f32>,
    dry: vec3<f32>,
    lit_by: u32,
}

/// What a surface does with light.
struct Look {
    /// Of the matt surface, or the radiance of a flat one.
    albedo: vec3<f32>,
    is_flat: bool,
    /// Over the matt surface.
    coat: GlossCoat,
}

/// Distance between samples on the floor, m.
fn scene_along_floor_m(direction: vec3<f32>, t_m: f32) -> f32 {
    return t_m * frame.footprint_rad / max(abs(direction.z), 1e-3);
}

fn scene_look(direction: vec3<f32>, hit: Hit) -> Look {
    var look = Look(vec3<f32>(0.0), false, GlossCoat(vec3<f32>(0.0), 0.0));
    if HAS_MESH && hit.kind == KIND_TRIANGLE {
        return content_mesh_look(direction, hit);
    }
    if HAS_BODIES && hit.kind == KIND_BODY {
        look.albedo = bodies[hit.index].albedo;
    } else if hit.instance == SEABED {
        let factor = seabed_factor(frame.seabed_seed, frame.seabed_contrast, frame.seabed_scale_m,
            hit.point_m.xy + frame.rig_from_eye_m.xy, scene_along_floor_m(direction, hit.t_m));
        look.albedo = min(frame.seabed_albedo * factor, vec3<f32>(1.0));
    } else {
        let rod = rods[hit.instance - 2u];
        if HAS_FINISH && rod.is_flat == 0u {
            return content_rod_look(rod, direction, hit);
        }
        look.albedo = rod.value;
        look.is_flat = rod.is_flat != 0u;
    }
    return look;
}

/// The cosines of a coat's reflection; light and ray look at the surface.
fn scene_cosines(normal: vec3<f32>, light: vec3<f32>, direction: vec3<f32>) -> GlossCosines {
    let half = -normalize(light + direction);
    let across = cross(normal, half);
    return GlossCosines(
        -dot(normal, light),
        max(-dot(normal, direction), 1e-4),
        min(dot(across, across), 1.0),
        clamp(-dot(half, direction), 0.0, 1.0),
    );
}

/// The radiance of a white matt surface in ambient light and daylight, by the upward part of its normal: in the water, and without any
/// as bright as at the rig. Nothing throws a shadow in either.
fn scene_ambient_on(point_m: vec3<f32>, normal_up: f32) -> Surface {
    let share = daylight_face_share(normal_up) / 3.14159265358979;
    let dry = frame.ambient_radiance + share * frame.daylight_w_per_m2;
    if MODE == MODE_AIR {
        return Surface(dry, dry, 0u);
    }
    let depth_m = point_m.z + frame.rig_from_eye_m.z;
    let there = daylight_downwelling(frame.daylight_w_per_m2, frame.daylight_attenuation_per_m, depth_m);
    return Surface(frame.ambient_radiance + share * there, dry, 0u);
}

/// Lambert, coated or not: L = Σ ρ/π · I cos θ / r² · e^(-K r) + ρ L_ambient; a flat surface sends its own radiance.
fn scene_surface(direction: vec3<f32>, hit: Hit) -> Surface {
    let look = scene_look(direction, hit);
    if look.is_flat {
        return Surface(look.albedo, look.albedo, 0u);
    }
    let ambient = scene_ambient_on(hit.point_m, -hit.normal.z);
    var surface = Surface(look.albedo * ambient.wet, look.albedo * ambient.dry, 0u);
    if MODE == MODE_KOSCHMIEDER {
        return surface;
    }
    for (var i = 0u; i < frame.lamps; i++) {
        let lamp = lamps[i];
        let to_point = hit.point_m - lamp.position_m;
        let r2 = dot(to_point, to_point);
        let r = sqrt(r2);
        let towards = to_point / r;
        let cos = -dot(hit.normal, towards);
        let beam = light_cone(lamp, towards);
        let lit = cos > 0.0 && dot(hit.face_normal, towards) < 0.0;
        if !lit || beam == 0.0 || scene_bodies_block(lamp.position_m, towards, r, hit) {
            continue;
        }
        let sharp = !scene_rods_block(lamp.position_m, towards, r, hit);
        if !sharp && MODE != MODE_FULL {
            continue;
        }
        surface.lit_by ^= select(0u, lattice_pcg(i), sharp);
        var reflection = look.albedo;
        if (HAS_FINISH || HAS_MESH) && look.coat.width2 > 0.0 {
            reflection = gloss_reflection(look.coat, look.albedo, scene_cosines(hit.normal, towards, direction));
        }
        let dry = reflection * lamp.radiant_intensity_w_per_sr * (beam * cos / (3.14159265358979 * r2));
        surface.dry += select(vec3<f32>(0.0), dry, sharp);
        var arriving = medium_transmittance(frame.lamp_attenuation_per_m, r);
        if MODE == MODE_FULL {
            // Where more is scattered back than on, K is the larger: nothing is soft then.
            let straight = min(medium_transmittance(frame.attenuation_per_m, r), arriving);
            let soft = scene_soft_share(i, to_point, hit) * (arriving - straight);
            arriving = select(soft, straight + soft, sharp);
        }
        surface.wet += dry * arriving;
    }
    return surface;
}

/// What must be alike in neighbouring pixels besides their instance: lamps and patch of surface, in one word.
fn scene_key(hit: Hit, lit_by: u32) -> u32 {
    if HAS_BODIES || HAS_MESH {
        return lit_by ^ lattice_pcg(hit.part);
    }
    return lit_by;
}

/// What one ray brings from a surface, after its way to the camera.
struct Sample {
    direct: vec3<f32>,
    /// Before its way.
    wet: vec3<f32>,
    clean: vec3<f32>,
    transmission: vec3<f32>,
    lit_by: u32,
}

fn scene_light(ray: EyeRay, hit: Hit) -> Sample {
    if hit.instance == NOTHING {
        let background = ray.gain * select(vec3<f32>(0.0), frame.background_radiance, MODE == MODE_AIR);
        return Sample(background, vec3<f32>(0.0), background, vec3<f32>(0.0), 0u);
    }
    let surface = scene_surface(ray.direction, hit);
    let transmission = medium_transmittance(frame.attenuation_per_m, hit.t_m);
    let wet = ray.gain * surface.wet;
    return Sample(wet * transmission, wet, ray.gain * surface.dry, transmission, surface.lit_by);
}

/// The part of a surface's light that arrives scattered.
fn scene_scattered(wet: vec3<f32>, range_m: f32) -> vec3<f32> {
    return wet * halo_total(frame.attenuation_per_m, frame.regained_per_m, range_m);
}
