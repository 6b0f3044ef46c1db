// Marine snow as an eye sees it: see cpu/snow.rs.

/// A particle.
struct Flake {
    centre_m: vec3<f32>,
    range_m: f32,
    /// Where the line of sight begins.
    from_m: vec3<f32>,
    /// Of the disc: 1, or less where blur has widened it; 0 once it is known to be hidden.
    opacity: f32,
    /// Of the axes of the disc across the view the first.
    aside: vec3<f32>,
    gain: f32,
    /// From steps of a column and of a row to units of the disc's radius.
    disc_per_px: vec4<f32>,
    /// The pixel of its centre, and where in it.
    pixel: vec2<i32>,
    inside_px: vec2<f32>,
    /// Smaller than a pixel, so that one ray tells whether it is hidden.
    is_small: u32,
    /// Seen to be round.
    is_round: u32,
    /// How much of its light is shaded as a ball's.
    shading: f32,
    /// Where its light comes from, in the disc's axes and towards the eye: a unit vector.
    lit_from: vec3<f32>,
    /// Mean radiance of the disc at the lens that came unscattered, and what came scattered.
    direct: vec3<f32>,
    scattered: vec3<f32>,
}

/// A particle in a pixel.
struct SnowPair {
    flake: u32,
    /// What is seen of it there, shaded, over its mean radiance.
    lit: f32,
}

@group(1) @binding(6) var<storage, read_write> flakes: array<Flake>;
/// Of each pixel of the image its first pair, nearest first, and where the last one's end.
@group(1) @binding(7) var<storage, read_write> snow_first: array<u32>;
@group(1) @binding(8) var<storage, read_write> snow_pairs: array<SnowPair>;

/// The pairs of a pixel: the first, and where they end.
fn snow_of(column: u32, image_row: u32) -> vec2<u32> {
    if tile.has_snow == 0u {
        return vec2<u32>(0u);
    }
    let pixel = image_row * tile.width + column;
    return vec2<u32>(snow_first[pixel], snow_first[pixel + 1u]);
}
