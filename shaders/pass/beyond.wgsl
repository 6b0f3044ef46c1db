// Rays outside the image: see cpu/overscan.rs.

/// The ray of a place outside the image. A lens with distortion has none there that is sure: its rays turn on as they do at the border.
fn beyond_direction(place: vec2<f32>) -> vec3<f32> {
    if EYE_LENS == CAMERA_PINHOLE {
        return camera_to_rig(frame.eye, camera_ray(EYE_LENS, frame.eye, place, vec2<f32>(0.0)));
    }
    let border = clamp(place, vec2<f32>(0.0), frame.eye.size_px);
    let out = place - border;
    let at_border = camera_ray(EYE_LENS, frame.eye, border, vec2<f32>(0.0));
    let across = at_border - camera_ray(EYE_LENS, frame.eye, border, vec2<f32>(-sign(out.x), 0.0));
    let down = at_border - camera_ray(EYE_LENS, frame.eye, border, vec2<f32>(0.0, -sign(out.y)));
    return camera_to_rig(frame.eye, normalize(at_border + across * abs(out.x) + down * abs(out.y)));
}

/// What arrives scattered from there, and its range.
fn beyond_scattered(place: vec2<f32>) -> vec4<f32> {
    let direction = beyond_direction(place);
    let hit = scene_hit(vec3<f32>(0.0), direction);
    return vec4<f32>(scene_scattered(scene_light(direction, hit).wet, hit.t_m), hit.t_m);
}
