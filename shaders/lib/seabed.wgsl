// The sea floor's texture and ripples: see cpu/seabed.rs.

const SEABED_TURN_RAD: f32 = 6.28318530717959;
/// How far crests wander, of their phase.
const SEABED_WANDER_RAD: f32 = 0.8;

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

/// Waves of the sand.
struct SeabedRipples {
    wavelength_m: f32,
    /// Trough to crest.
    height_m: f32,
    /// Cosine and sine of the direction across the crests.
    heading: vec2<f32>,
}

/// Sine and cosine of a phase in periods.
fn seabed_wave(periods: f32) -> vec2<f32> {
    return maths_sincos(SEABED_TURN_RAD * (periods - round(periods)));
}

/// The normal of rippled sand; ripples finer than two samples are left out.
fn seabed_rippled_normal(ripples: SeabedRipples, at_m: vec2<f32>, direction: vec3<f32>, footprint_m: f32) -> vec3<f32> {
    let fade = clamp(ripples.wavelength_m / (2.0 * footprint_m) - 1.0, 0.0, 1.0);
    let heading = ripples.heading;
    let u = dot(at_m, heading) / ripples.wavelength_m;
    let v = (at_m.y * heading.x - at_m.x * heading.y) / ripples.wavelength_m;
    let bend = seabed_wave(0.2 * v);
    let crest = seabed_wave(u + SEABED_WANDER_RAD / SEABED_TURN_RAD * bend.x).x;
    let steepness = -0.5 * ripples.height_m * (SEABED_TURN_RAD / ripples.wavelength_m) * fade * crest;
    let along = steepness * vec2<f32>(1.0, 0.2 * SEABED_WANDER_RAD * bend.y);
    let slope = vec2<f32>(along.x * heading.x - along.y * heading.y, along.x * heading.y + along.y * heading.x);
    return solid_facing(vec3<f32>(-slope, -1.0), direction, vec3<f32>(0.0, 0.0, -1.0));
}
