// Rays outside the image: see cpu/overscan.rs.

/// The ray of a place outside the image. A lens with distortion or a port has none there that is sure: its rays turn on as they do at
/// the border.
fn beyond_ray(place: vec2<f32>) -> EyeRay {
    if EYE_LENS == CAMERA_PINHOLE && EYE_PORT == PORT_NONE {
        return eye_ray(place, vec2<f32>(0.0));
    }
    let border = clamp(place, vec2<f32>(0.0), frame.eye.size_px);
    let out = place - border;
    let there = eye_ray(border, vec2<f32>(0.0));
    let across = there.direction - eye_ray(border, vec2<f32>(-sign(out.x), 0.0)).direction;
    let down = there.direction - eye_ray(border, vec2<f32>(0.0, -sign(out.y))).direction;
    let direction = normalize(there.direction + across * abs(out.x) + down * abs(out.y));
    return EyeRay(there.origin_m, direction, there.gain);
}

/// What arrives scattered from there, and its range.
fn beyond_scattered(place: vec2<f32>) -> vec4<f32> {
    let ray = beyond_ray(place);
    let hit = scene_hit(ray.origin_m, ray.direction);
    return vec4<f32>(scene_scattered(scene_light(ray, hit).wet, hit.t_m), hit.t_m);
}
