// What stands in the water besides plain rods: finishes, bodies, meshes, ripples. See cpu/bodies.rs, cpu/triangles.rs and the
// looks of cpu/world.rs.

/// Whether rods have stripes, grain or gloss.
override HAS_FINISH: bool = false;
/// Whether there is growth, stones or occluders.
override HAS_BODIES: bool = false;
override HAS_MESH: bool = false;
override HAS_RIPPLES: bool = false;

/// What a hit's `index` counts.
const KIND_PLAIN: u32 = 0u;
const KIND_BODY: u32 = 1u;
const KIND_TRIANGLE: u32 = 2u;

/// Growth, a stone, a piece of an occluder.
struct Body {
    lump: Lump,
    /// The side of a capsule, in place of the lump.
    side: Solid,
    albedo: vec3<f32>,
    instance: u32,
    /// Solids of one instance that make one convex body have the same.
    part: u32,
    is_side: u32,
}

/// A corner of triangles.
struct Vertex {
    position_m: vec3<f32>,
    u: f32,
    normal: vec3<f32>,
    v: f32,
}

struct Triangle {
    a: u32,
    b: u32,
    c: u32,
    /// The smooth patch: edges between patches are creases.
    part: u32,
    paint: u32,
    /// How fast the interpolated normal turns at most.
    curvature_per_m: f32,
    texels_per_m: f32,
}

struct Paint {
    /// Linear base colour.
    base: vec3<f32>,
    metallic: f32,
    roughness: f32,
    instance: u32,
    /// The texture: its first texel, its levels (0 for none), its size, and how it goes on beyond its edges.
    first: u32,
    levels: u32,
    width: u32,
    height: u32,
    wrap_u: u32,
    wrap_v: u32,
}

@group(0) @binding(9) var<storage, read> bodies: array<Body>;
@group(0) @binding(10) var<storage, read> vertices: array<Vertex>;
@group(0) @binding(11) var<storage, read> triangles: array<Triangle>;
@group(0) @binding(12) var<storage, read> paints: array<Paint>;
/// Red, green and blue of every texel of every level.
@group(0) @binding(13) var<storage, read> texels: array<f32>;

fn content_body_t_m(body: u32, origin_m: vec3<f32>, direction: vec3<f32>) -> f32 {
    if bodies[body].is_side != 0u {
        return solid_hit(bodies[body].side, origin_m, direction).t_m;
    }
    return lump_hit(bodies[body].lump, origin_m, direction).w;
}

/// The hit, or one on a body that is nearer.
fn content_nearer_body(before: Hit, origin_m: vec3<f32>, direction: vec3<f32>) -> Hit {
    var hit = before;
    let per_direction = bvh_per_direction(direction);
    var n = frame.nodes;
    while n < frame.body_nodes {
        let node = nodes[n];
        n++;
        if !bvh_meets(node, origin_m, per_direction, 0.0, hit.t_m) {
            n = select(n, node.first, node.count == 0u);
            continue;
        }
        for (var i = node.first; i < node.first + node.count; i++) {
            let t = content_body_t_m(i, origin_m, direction);
            if t < hit.t_m {
                hit.t_m = t;
                hit.kind = KIND_BODY;
                hit.index = i;
            }
        }
    }
    if hit.kind == KIND_BODY {
        let body = bodies[hit.index];
        hit.instance = body.instance;
        hit.part = body.part;
        hit.cap = false;
        if body.is_side != 0u {
            let side = Segment(body.side, vec3<f32>(0.0), 0.0, vec3<f32>(0.0), 0u, 0u);
            hit.normal = solid_normal(side, origin_m + direction * hit.t_m);
        } else {
            hit.normal = lump_normal(body.lump, lump_hit(body.lump, origin_m, direction).xyz);
        }
        hit.face_normal = hit.normal;
    }
    return hit;
}

/// Weights of the corners of a triangle where a ray meets it, and the distance.
fn content_meet(ray: TrianglesRay, index: u32) -> vec4<f32> {
    let triangle = triangles[index];
    return triangles_meet(ray, vertices[triangle.a].position_m, vertices[triangle.b].position_m, vertices[triangle.c].position_m);
}

/// The hit, or one on a triangle that is nearer.
fn content_nearer_triangle(before: Hit, origin_m: vec3<f32>, direction: vec3<f32>) -> Hit {
    var hit = before;
    let per_direction = bvh_per_direction(direction);
    let ray = triangles_ray(origin_m, direction);
    var n = frame.body_nodes;
    while n < frame.mesh_nodes {
        let node = nodes[n];
        n++;
        if !bvh_meets(node, origin_m, per_direction, 0.0, hit.t_m) {
            n = select(n, node.first, node.count == 0u);
            continue;
        }
        for (var i = node.first; i < node.first + node.count; i++) {
            let there = content_meet(ray, i);
            if there.w < hit.t_m {
                hit.t_m = there.w;
                hit.kind = KIND_TRIANGLE;
                hit.index = i;
                hit.weights = there.xyz;
            }
        }
    }
    if hit.kind == KIND_TRIANGLE {
        let triangle = triangles[hit.index];
        let a = vertices[triangle.a];
        let b = vertices[triangle.b];
        let c = vertices[triangle.c];
        let facet = normalize(cross(b.position_m - a.position_m, c.position_m - a.position_m));
        let interpolated = a.normal * hit.weights.x + b.normal * hit.weights.y + c.normal * hit.weights.z;
        let normals = triangles_normals(facet, interpolated, direction);
        hit.instance = paints[triangle.paint].instance;
        hit.part = triangle.part;
        hit.cap = false;
        hit.normal = normals.rounded;
        hit.face_normal = normals.facet;
    }
    return hit;
}

/// Whether a body stands in the first `reach_m` of a ray, other than the convex one that it is cast for.
fn content_body_blocks(origin_m: vec3<f32>, direction: vec3<f32>, reach_m: f32, own: Hit) -> bool {
    let per_direction = bvh_per_direction(direction);
    var n = frame.nodes;
    while n < frame.body_nodes {
        let node = nodes[n];
        n++;
        if !bvh_meets(node, origin_m, per_direction, 0.0, reach_m) {
            n = select(n, node.first, node.count == 0u);
            continue;
        }
        for (var i = node.first; i < node.first + node.count; i++) {
            let is_own = own.kind == KIND_BODY && own.instance == bodies[i].instance && own.part == bodies[i].part;
            if !is_own && content_body_t_m(i, origin_m, direction) < reach_m {
                return true;
            }
        }
    }
    return false;
}

/// Whether a triangle stands in the first `reach_m` of a ray, other than the one that it is cast for.
fn content_triangle_blocks(origin_m: vec3<f32>, direction: vec3<f32>, reach_m: f32, own: Hit) -> bool {
    let per_direction = bvh_per_direction(direction);
    let ray = triangles_ray(origin_m, direction);
    var n = frame.body_nodes;
    while n < frame.mesh_nodes {
        let node = nodes[n];
        n++;
        if !bvh_meets(node, origin_m, per_direction, 0.0, reach_m) {
            n = select(n, node.first, node.count == 0u);
            continue;
        }
        for (var i = node.first; i < node.first + node.count; i++) {
            let is_own = own.kind == KIND_TRIANGLE && own.index == i;
            if !is_own && content_meet(ray, i).w < reach_m {
                return true;
            }
        }
    }
    return false;
}

/// Cosine between a surface and what looks at it, kept away from zero.
fn content_grazing(direction: vec3<f32>, hit: Hit) -> f32 {
    return max(abs(dot(hit.face_normal, direction)), 1e-3);
}

/// What a rod's surface does with light; its ends are plain.
fn content_rod_look(rod: Rod, direction: vec3<f32>, hit: Hit) -> Look {
    var look = Look(rod.value, false, GlossCoat(vec3<f32>(0.0), 0.0));
    let footprint_m = hit.t_m * frame.footprint_rad;
    if !hit.cap {
        let place = finish_place(rod.arc, hit.point_m, hit.normal, direction, footprint_m);
        look.albedo = finish_albedo(rod.finish, rod.value, place);
    }
    if rod.roughness > 0.0 {
        let curvature_per_m = select(1.0 / rod.finish.radius_m, 0.0, hit.cap);
        look.coat = gloss_coat(rod.roughness, rod.reflectance, curvature_per_m * footprint_m / content_grazing(direction, hit));
    }
    return look;
}

/// The colour of a texture's level, linear between its texels.
fn content_bilinear(paint: Paint, at: vec2<f32>, level: u32) -> vec3<f32> {
    var first = paint.first;
    var width = paint.width;
    var height = paint.height;
    for (var i = 0u; i < level; i++) {
        first += width * height;
        width = (width + 1u) / 2u;
        height = (height + 1u) / 2u;
    }
    let place = at * vec2<f32>(f32(width), f32(height)) - 0.5;
    let corner = floor(place);
    let share = place - corner;
    var rows: array<vec3<f32>, 2>;
    for (var j = 0u; j < 2u; j++) {
        let row = first + width * texture_wrapped(corner.y + f32(j), height, paint.wrap_v);
        let left = content_texel(row + texture_wrapped(corner.x, width, paint.wrap_u));
        let right = content_texel(row + texture_wrapped(corner.x + 1.0, width, paint.wrap_u));
        rows[j] = mix(left, right, share.x);
    }
    return mix(rows[0], rows[1], share.y);
}

fn content_texel(index: u32) -> vec3<f32> {
    return vec3<f32>(texels[3u * index], texels[3u * index + 1u], texels[3u * index + 2u]);
}

/// What a mesh's surface does with light.
fn content_mesh_look(direction: vec3<f32>, hit: Hit) -> Look {
    let triangle = triangles[hit.index];
    let paint = paints[triangle.paint];
    let footprint_m = hit.t_m * frame.footprint_rad / content_grazing(direction, hit);
    var base = paint.base;
    if paint.levels > 0u {
        let a = vertices[triangle.a];
        let b = vertices[triangle.b];
        let c = vertices[triangle.c];
        let at = vec2<f32>(a.u, a.v) * hit.weights.x + vec2<f32>(b.u, b.v) * hit.weights.y + vec2<f32>(c.u, c.v) * hit.weights.z;
        let level = texture_level(footprint_m * triangle.texels_per_m, paint.levels - 1u);
        let coarser = min(u32(level.x) + 1u, paint.levels - 1u);
        base *= mix(content_bilinear(paint, at, u32(level.x)), content_bilinear(paint, at, coarser), level.y);
    }
    let split = triangles_split(base, paint.metallic);
    let coat = gloss_coat(max(paint.roughness, 0.05), split.reflectance, triangle.curvature_per_m * footprint_m);
    return Look(split.albedo, false, coat);
}
