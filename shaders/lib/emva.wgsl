// The sensor after EMVA 1288: see develop/emva.rs.

struct Emva {
    full_well_e: f32,
    read_noise_e: f32,
    dark_e: f32,
    prnu: f32,
    dsnu_e: f32,
    /// The converter's highest code.
    steps: f32,
}

/// The code of some light, e; normals of photons and read-out, and of response and offset; the counter of few photons.
fn emva_expose(
    emva: Emva,
    exposure: vec2<u32>,
    light_e: f32,
    noise: vec2<f32>,
    pattern: vec2<f32>,
    few_photons: vec4<u32>,
) -> u32 {
    // More than this fills any well that is counted here, noise or not.
    let mean_e = min(light_e * max(1.0 + emva.prnu * pattern.x, 0.0) + emva.dark_e, 67108864.0);
    let collected_e = min(noise_poisson(exposure, mean_e, noise.x, few_photons), emva.full_well_e);
    let read_e = collected_e + emva.read_noise_e * noise.y + emva.dsnu_e * pattern.y;
    return u32(clamp(floor(read_e / emva.full_well_e * emva.steps + 0.5), 0.0, emva.steps));
}
