// The sea floor's distance and texture: see cpu/seabed.rs.

/// A number in [-1, 1) for a node.
fn seabed_hash(seed: u32, octave: u32, i: i32, j: i32) -> f32 {
    let word = lattice_pcg(u32(j) + lattice_pcg(u32(i) + lattice_pcg(octave + seed)));
    return f32(word >> 8u) / 8388608.0 - 1.0;
}

/// Smooth noise in [-1, 1] with a node at every integer.
fn seabed_value_noise(seed: u32, octave: u32, at: vec2<f32>) -> f32 {
    let node = floor(at);
    let s = at - node;
    let smooth_s = s * s * s * (s * (6.0 * s - 15.0) + 10.0);
    let i = i32(node.x);
    let j = i32(node.y);
    let above = mix(seabed_hash(seed, octave, i, j), seabed_hash(seed, octave, i + 1, j), smooth_s.x);
    let below = mix(seabed_hash(seed, octave, i, j + 1), seabed_hash(seed, octave, i + 1, j + 1), smooth_s.x);
    return mix(above, below, smooth_s.y);
}

/// What the texture multiplies the floor's albedo by, seen with samples `footprint_m` apart.
fn seabed_factor(seed: u32, contrast: f32, scale_m: f32, at_m: vec2<f32>, footprint_m: f32) -> f32 {
    var relief = 0.0;
    var wavelength = scale_m;
    var amplitude = 0.5;
    for (var octave = 0u; octave < 8u; octave++) {
        let fade = clamp(wavelength / (2.0 * footprint_m) - 1.0, 0.0, 1.0);
        if fade == 0.0 {
            break;
        }
        relief += fade * amplitude * seabed_value_noise(seed, octave, at_m / wavelength);
        wavelength *= 0.5;
        amplitude *= 0.6;
    }
    return max(1.0 + contrast * relief, 0.0);
}
