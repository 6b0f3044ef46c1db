// One ray through the centre of every pixel: geometry, truth channels, light from surfaces, and the key that finds edges.

/// Rays as near as half the grazing angle have the limb within half a diagonal of the pixel.
fn centre_limb(origin: vec3<f32>, direction: vec3<f32>) -> u32 {
    if !scene_grazes_a_limb(origin, direction, frame.graze_rad) {
        return 0u;
    }
    return select(KEY_BESIDE, KEY_WITHIN, scene_grazes_a_limb(origin, direction, 0.5 * frame.graze_rad));
}

@compute @workgroup_size(8, 8)
fn centre(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= tile.width || id.y >= tile.rows {
        return;
    }
    let pixels = tile.width * tile.rows;
    let pixel = id.y * tile.width + id.x;
    let corner = vec2<f32>(vec2<u32>(id.x, tile.first_row + id.y));
    let ray = eye_ray(corner, vec2<f32>(0.5));
    let hit = scene_hit(ray.origin_m, ray.direction);
    let sample = scene_light(ray, hit);

    keys[pixel] = hit.instance | select(0u, KEY_CAP, hit.cap) | centre_limb(ray.origin_m, ray.direction);
    keys[pixels + pixel] = scene_key(hit, sample.lit_by);
    keys[2u * pixels + pixel] = bitcast<u32>(hit.t_m);
    tile_store(0u, pixel, sample.direct);
    tile_store(6u, pixel, sample.clean);
    if MODE == MODE_FULL {
        tile_store(9u, pixel, scene_scattered(sample.wet, hit.t_m));
    }
    tile_store_surface(0u, pixel, sample.transmission);

    var tag = hit.instance;
    var disparity = 0.0;
    var depth = 0.0;
    if hit.instance != NOTHING {
        depth = dot(frame.eye.forward, hit.point_m);
        let there = eye_sight(hit.point_m);
        if there.is_seen {
            tag |= TAG_IN_VIEW;
            disparity = frame.disparity_sign * ((corner.x + 0.5) - there.pixel.x);
        }
        if !there.is_seen || !camera_contains(frame.other, there.pixel)
            || scene_is_hidden(hit, there.from_m) {
            tag |= TAG_OCCLUDED;
        }
    }
    tile_store_surface(3u, pixel, camera_from_rig(frame.eye, hit.normal));
    surface[6u * pixels + pixel] = depth;
    surface[7u * pixels + pixel] = hit.t_m;
    surface[8u * pixels + pixel] = disparity;
    surface[9u * pixels + pixel] = bitcast<f32>(tag);
    tile_check_loops();
}
