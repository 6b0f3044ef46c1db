// Glossy coats: see optics/src/gloss.rs.

/// A coat of microfacets over a matt body.
struct GlossCoat {
    /// Reflectance at normal incidence.
    reflectance: vec3<f32>,
    /// α² of GGX; 0 for no coat.
    width2: f32,
}

struct GlossCosines {
    light: f32,
    eye: f32,
    /// sin² between the half vector and the normal, where the twin has the cosine: 1 - cos² would cancel in narrow lobes.
    half_sin2: f32,
    ray_half: f32,
}

fn gloss_coat(roughness: f32, reflectance: vec3<f32>, turn_rad: f32) -> GlossCoat {
    let alpha = roughness * roughness;
    return GlossCoat(reflectance, min(alpha * alpha + min(0.5 * turn_rad * turn_rad, 0.18), 1.0));
}

/// Reflectance of microfacets at an angle to them, after Schlick.
fn gloss_schlick(reflectance: vec3<f32>, cos: f32) -> vec3<f32> {
    let rest = 1.0 - cos;
    let rest2 = rest * rest;
    return reflectance + (1.0 - reflectance) * (rest2 * rest2 * rest);
}

/// π times the reflection function.
fn gloss_reflection(coat: GlossCoat, albedo: vec3<f32>, at: GlossCosines) -> vec3<f32> {
    // 1 + cos² (α² - 1)
    let spread = coat.width2 + at.half_sin2 * (1.0 - coat.width2);
    let light = at.eye * sqrt(at.light * at.light * (1.0 - coat.width2) + coat.width2);
    let eye = at.light * sqrt(at.eye * at.eye * (1.0 - coat.width2) + coat.width2);
    let lobe = coat.width2 / (spread * spread) * 0.5 / (light + eye);
    let matt = albedo * (1.0 - gloss_schlick(coat.reflectance, at.light)) * (1.0 - gloss_schlick(coat.reflectance, at.eye));
    return matt + lobe * gloss_schlick(coat.reflectance, at.ray_half);
}
