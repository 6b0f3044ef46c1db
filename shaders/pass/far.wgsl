// The mean light of what a cell has beyond the overscan; negative where too little of it lies there for a ray.

@compute @workgroup_size(8, 8)
fn far(@builtin(global_invocation_id) id: vec3<u32>) {
    let its = halo.levels[level];
    let cell = vec2<i32>(id.xy) - MARGIN;
    if cell.x >= its.columns + MARGIN || cell.y >= its.rows + MARGIN || halo_known(cell) == its.side * its.side {
        return;
    }
    let start = vec2<f32>(cell * its.side);
    let apart = f32(its.side) / f32(RAYS);
    let first = vec2<f32>(f32(-halo.overscan));
    let last = vec2<f32>(halo.size + halo.overscan);
    var light = vec3<f32>(0.0);
    var rays = 0.0;
    for (var i = 0u; i < RAYS * RAYS; i++) {
        let place = start + (vec2<f32>(vec2<u32>(i % RAYS, i / RAYS)) + 0.5) * apart;
        if any(place < first) || any(place > last) {
            light += halo_shared(level, beyond_scattered(place));
            rays += 1.0;
        }
    }
    halo_store_cell(cell, select(vec3<f32>(-1.0), light / rays, rays > 0.0));
}
