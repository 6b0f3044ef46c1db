// One ray for every square of the overscan: kept for the cells, and put into the margins of the fine widths.

@compute @workgroup_size(64)
fn overscan(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= halo.patches {
        return;
    }
    var strip = halo.strips[0];
    for (var i = 1u; i < 8u && halo.strips[i].first <= id.x; i++) {
        strip = halo.strips[i];
    }
    let square = id.x - strip.first;
    let at = strip.at + vec2<i32>(vec2<u32>(square % strip.columns, square / strip.columns)) * strip.side;
    let end = min(at + strip.side, strip.at + strip.size);
    let scattered = beyond_scattered(0.5 * vec2<f32>(at + end));
    outside[id.x] = scattered;
    let one = halo_shared(1u, scattered);
    let two = halo_shared(2u, scattered);
    let last = min(end, halo.size + MARGIN);
    for (var y = max(at.y, -MARGIN); y < last.y; y++) {
        for (var x = max(at.x, -MARGIN); x < last.x; x++) {
            halo_store_fine(1u, vec2<i32>(x, y), one);
            halo_store_fine(2u, vec2<i32>(x, y), two);
        }
    }
    halo_check_loops();
}
