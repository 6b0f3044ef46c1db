// What a lens does to the light of a pixel: see lens.rs.

/// cos⁴θ (1 + v1 r² + v2 r⁴), not below 0.
fn lens_vignetting(lens: u32, camera: Camera, falloff: vec2<f32>, corner_px: vec2<f32>) -> f32 {
    let offset = corner_px - vec2<f32>(camera.cx_px, camera.cy_px) + 0.5;
    let r2 = dot(offset, offset) / (0.25 * dot(camera.size_px, camera.size_px));
    let cosine = camera_ray(lens, camera, corner_px, vec2<f32>(0.5)).z;
    let cos2 = cosine * cosine;
    return cos2 * cos2 * max(1.0 + r2 * (falloff.x + r2 * falloff.y), 0.0);
}
