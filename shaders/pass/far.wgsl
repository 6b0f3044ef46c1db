// The mean light of what a cell has beyond the overscan; negative where too little of it lies there for a ray. A lane casts a ray, the
// first sums them in order.

const CELLS: u32 = 4u;

var<workgroup> far_light: array<vec4<f32>, CELLS * RAYS * RAYS>;

/// A ray's light, and 1; of one within the overscan nothing.
fn far_ray(cell: vec2<i32>, ray: u32) -> vec4<f32> {
    let side = halo.levels[level].side;
    let apart = f32(side) / f32(RAYS);
    let place = vec2<f32>(cell * side) + (vec2<f32>(vec2<u32>(ray % RAYS, ray / RAYS)) + 0.5) * apart;
    if all(place >= vec2<f32>(f32(-halo.overscan))) && all(place <= vec2<f32>(halo.size + halo.overscan)) {
        return vec4<f32>(0.0);
    }
    return vec4<f32>(halo_shared(level, beyond_scattered(place)), 1.0);
}

@compute @workgroup_size(RAYS * RAYS, CELLS)
fn far(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_id) local: vec3<u32>) {
    let its = halo.levels[level];
    let cell = vec2<i32>(vec2<u32>(group.x, group.y * CELLS + local.y)) - MARGIN;
    let first = local.y * RAYS * RAYS;
    let is_far = cell.x < its.columns + MARGIN && cell.y < its.rows + MARGIN && halo_known(cell) != its.side * its.side;
    if is_far {
        far_light[first + local.x] = far_ray(cell, local.x);
        halo_check_loops();
    }
    workgroupBarrier();
    if !is_far || local.x != 0u {
        return;
    }
    var sum = vec4<f32>(0.0);
    for (var ray = 0u; ray < RAYS * RAYS; ray++) {
        sum += far_light[first + ray];
    }
    halo_store_cell(cell, select(vec3<f32>(-1.0), sum.xyz / sum.w, sum.w > 0.0));
}
