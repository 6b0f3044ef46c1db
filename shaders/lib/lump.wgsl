// Balls and cubes under linear maps: see cpu/lump.rs.

/// The unit ball, or the cube from -1 to 1, under a linear map about a centre.
struct Lump {
    centre_m: vec3<f32>,
    is_cube: u32,
    /// Rows of the map to the unit ball's (or cube's) space.
    to_unit_x: vec3<f32>,
    to_unit_y: vec3<f32>,
    to_unit_z: vec3<f32>,
}

/// The normal in the unit ball's space where a line first meets it, and how far along; `SOLID_NONE_M` if it does not.
fn lump_ball(start: vec3<f32>, along: vec3<f32>) -> vec4<f32> {
    let along2 = dot(along, along);
    let middle = -dot(start, along) / along2;
    let nearest = start + along * middle;
    let chord2 = 1.0 - dot(nearest, nearest);
    if chord2 <= 0.0 {
        return vec4<f32>(vec3<f32>(0.0), SOLID_NONE_M);
    }
    let back = sqrt(chord2 / along2);
    return vec4<f32>(nearest - along * back, middle - back);
}

/// The same for the cube.
fn lump_cube(start: vec3<f32>, along: vec3<f32>) -> vec4<f32> {
    var enter = -SOLID_NONE_M;
    var leave = SOLID_NONE_M;
    var normal = vec3<f32>(0.0);
    for (var k = 0u; k < 3u; k++) {
        if along[k] == 0.0 {
            if abs(start[k]) > 1.0 {
                return vec4<f32>(normal, SOLID_NONE_M);
            }
            continue;
        }
        let side = -sign(along[k]);
        let near = (side - start[k]) / along[k];
        leave = min(leave, (-side - start[k]) / along[k]);
        if near > enter {
            enter = near;
            normal = vec3<f32>(0.0);
            normal[k] = side;
        }
    }
    return vec4<f32>(normal, select(SOLID_NONE_M, enter, enter < leave));
}

/// The first point of the surface on a ray: the normal in the unit's space, and the distance; `SOLID_NONE_M` also from inside.
fn lump_hit(lump: Lump, origin_m: vec3<f32>, direction: vec3<f32>) -> vec4<f32> {
    let w = origin_m - lump.centre_m;
    let start = vec3<f32>(dot(lump.to_unit_x, w), dot(lump.to_unit_y, w), dot(lump.to_unit_z, w));
    let along = vec3<f32>(dot(lump.to_unit_x, direction), dot(lump.to_unit_y, direction), dot(lump.to_unit_z, direction));
    var hit: vec4<f32>;
    if lump.is_cube != 0u {
        hit = lump_cube(start, along);
    } else {
        hit = lump_ball(start, along);
    }
    return vec4<f32>(hit.xyz, select(SOLID_NONE_M, hit.w, hit.w > 0.0));
}

/// The unit normal of the surface for one in the unit's space.
fn lump_normal(lump: Lump, in_unit: vec3<f32>) -> vec3<f32> {
    return normalize(lump.to_unit_x * in_unit.x + lump.to_unit_y * in_unit.y + lump.to_unit_z * in_unit.z);
}
