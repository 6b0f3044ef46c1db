// What water does to light per metre: see optics/src/medium.rs.

/// e^(-K s): what is left of a beam after a path of s metres.
fn medium_transmittance(attenuation_per_m: vec3<f32>, path_m: f32) -> vec3<f32> {
    return exp(-attenuation_per_m * path_m);
}
