// Triangles: see cpu/triangles.rs.

/// A ray turned to look along z: neighbours compute their common edge alike, so that no ray slips between them.
struct TrianglesRay {
    origin_m: vec3<f32>,
    /// Which axis becomes z, and whether x and y are exchanged.
    axis: u32,
    shear: vec3<f32>,
    is_mirrored: bool,
}

/// The axes of a vector in the order of a turned ray's.
fn triangles_turned(axis: u32, is_mirrored: bool, v: vec3<f32>) -> vec3<f32> {
    let cyclic = select(select(v.xyz, v.zxy, axis == 1u), v.yzx, axis == 0u);
    return select(cyclic, cyclic.yxz, is_mirrored);
}

fn triangles_ray(origin_m: vec3<f32>, direction: vec3<f32>) -> TrianglesRay {
    let size = abs(direction);
    let axis = select(select(2u, 1u, size.y >= size.z), 0u, size.x >= max(size.y, size.z));
    let is_mirrored = direction[axis] < 0.0;
    let d = triangles_turned(axis, is_mirrored, direction);
    return TrianglesRay(origin_m, axis, vec3<f32>(d.xy, 1.0) / d.z, is_mirrored);
}

/// p × q, from the same end of the edge whichever neighbour asks: a fused multiply and add is not antisymmetric.
fn triangles_edge(p: vec2<f32>, q: vec2<f32>) -> f32 {
    let backwards = p.x > q.x || (p.x == q.x && p.y > q.y);
    let a = select(p, q, backwards);
    let b = select(q, p, backwards);
    let turn = a.x * b.y - a.y * b.x;
    return select(turn, -turn, backwards);
}

/// Weights of the corners where a ray meets a triangle, and the distance; `SOLID_NONE_M` if it does not.
fn triangles_meet(ray: TrianglesRay, a_m: vec3<f32>, b_m: vec3<f32>, c_m: vec3<f32>) -> vec4<f32> {
    var turned = array<vec3<f32>, 3>(a_m, b_m, c_m);
    for (var k = 0; k < 3; k++) {
        let p = triangles_turned(ray.axis, ray.is_mirrored, turned[k] - ray.origin_m);
        turned[k] = vec3<f32>(p.xy - ray.shear.xy * p.z, ray.shear.z * p.z);
    }
    let edges = vec3<f32>(
        triangles_edge(turned[2].xy, turned[1].xy),
        triangles_edge(turned[0].xy, turned[2].xy),
        triangles_edge(turned[1].xy, turned[0].xy),
    );
    let sum = edges.x + edges.y + edges.z;
    if (any(edges < vec3<f32>(0.0)) && any(edges > vec3<f32>(0.0))) || sum == 0.0 {
        return vec4<f32>(0.0, 0.0, 0.0, SOLID_NONE_M);
    }
    let weights = edges / sum;
    let t = dot(weights, vec3<f32>(turned[0].z, turned[1].z, turned[2].z));
    return vec4<f32>(weights, select(SOLID_NONE_M, t, t > 0.0));
}

/// A facet's normal and the rounded one, towards where a ray comes from.
struct TrianglesNormals {
    facet: vec3<f32>,
    rounded: vec3<f32>,
}

/// From the facet's unit normal and the interpolated one, neither of which needs to look at the ray.
fn triangles_normals(facet: vec3<f32>, interpolated: vec3<f32>, direction: vec3<f32>) -> TrianglesNormals {
    let towards = select(facet, -facet, dot(facet, direction) > 0.0);
    let rounded = select(interpolated, -interpolated, dot(interpolated, towards) < 0.0);
    return TrianglesNormals(towards, solid_facing(rounded, direction, towards));
}

/// Matt albedo and reflectance at normal incidence of a metallic-roughness surface of a base colour.
struct TrianglesPaint {
    albedo: vec3<f32>,
    reflectance: vec3<f32>,
}

fn triangles_split(base: vec3<f32>, metallic: f32) -> TrianglesPaint {
    return TrianglesPaint(base * (1.0 - metallic), mix(vec3<f32>(0.0032), base, metallic));
}
