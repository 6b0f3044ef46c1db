// Daylight in the water: see optics/src/daylight.rs.

/// E_d at a depth, of that at depth 0.
fn daylight_downwelling(irradiance: vec3<f32>, diffuse_attenuation_per_m: vec3<f32>, depth_m: f32) -> vec3<f32> {
    return irradiance * medium_transmittance(diffuse_attenuation_per_m, depth_m);
}

/// What of E_d falls on a plane, by the upward part of its normal.
fn daylight_face_share(normal_up: f32) -> f32 {
    return 0.5 * (1.0 + normal_up);
}

/// B∞ (1 - e^(-K_h t)), B∞ = b E_d/(2π)/K_h, K_h = K + K_d times the downward part of the ray's direction, at least K/4. `here` is E_d
/// where the ray begins.
fn daylight_veil(here: vec3<f32>, attenuation_per_m: vec3<f32>, scattering_per_m: vec3<f32>,
    diffuse_attenuation_per_m: vec3<f32>, down: f32, distance_m: f32) -> vec3<f32> {
    let along = max(attenuation_per_m + down * diffuse_attenuation_per_m, 0.25 * attenuation_per_m);
    let source = scattering_per_m * here * (0.5 / 3.14159265358979);
    let veil = source / max(along, vec3<f32>(1e-30)) * maths_rise(along * min(distance_m, 1e30));
    return select(vec3<f32>(0.0), veil, source > vec3<f32>(0.0));
}
