// Lamps and surfaces: see cpu/light.rs.

/// A lamp; its place is from the centre of the eye that is rendered.
struct Lamp {
    position_m: vec3<f32>,
    cos_inner: f32,
    direction: vec3<f32>,
    cos_outer: f32,
    radiant_intensity_w_per_sr: vec3<f32>,
}

/// Fraction of the axial intensity that a lamp sends in a unit direction.
fn light_cone(lamp: Lamp, direction: vec3<f32>) -> f32 {
    let cos = max(dot(lamp.direction, direction), -1.0);
    if cos >= lamp.cos_inner {
        return 1.0;
    }
    if cos <= lamp.cos_outer {
        return 0.0;
    }
    let s = (cos - lamp.cos_outer) / (lamp.cos_inner - lamp.cos_outer);
    return s * s * (3.0 - 2.0 * s);
}
