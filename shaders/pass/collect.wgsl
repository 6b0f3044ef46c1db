// The light of a tile, but for what is still to be spread: radiance as frame.rs sums it.

@compute @workgroup_size(8, 8)
fn collect(@builtin(global_invocation_id) id: vec3<u32>) {
    let row = tile.kept_from + id.y;
    if id.x >= tile.width || row >= tile.kept_to {
        return;
    }
    let at = row * tile.width + id.x;
    var sum = tile_light(0u, at) + tile_light(3u, at);
    if tile.has_snow != 0u {
        sum += tile_light(12u, at);
    }
    film_store((tile.first_row + row) * tile.width + id.x, sum);
}
