// The light of the water in every pixel, along the ray through its centre.

@compute @workgroup_size(8, 8)
fn backscatter(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= tile.width || id.y >= tile.rows {
        return;
    }
    let pixel = id.y * tile.width + id.x;
    let corner = vec2<f32>(vec2<u32>(id.x, tile.first_row + id.y));
    let ray = eye_ray(corner, vec2<f32>(0.5));
    let range = surface[7u * tile.width * tile.rows + pixel];
    tile_store(3u, pixel, water_backscatter(ray, corner + 0.5, range));
    tile_check_loops();
}
