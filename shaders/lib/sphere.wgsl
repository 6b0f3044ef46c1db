// A matt sphere: see optics/src/sphere.rs.

/// Mean radiance of its disc over ρ E/π, for the cosine of the angle between lamp and eye.
fn sphere_share(cos_alpha: f32) -> f32 {
    let cos = clamp(cos_alpha, -1.0, 1.0);
    let sin = sqrt((1.0 - cos) * (1.0 + cos));
    let alpha = maths_atan2(sin, cos);
    return (2.0 / 3.0) / 3.14159265358979 * (sin + (3.14159265358979 - alpha) * cos);
}
