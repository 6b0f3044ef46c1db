// Prefiltered textures: see cpu/texture.rs.

const TEXTURE_REPEAT: u32 = 0u;
const TEXTURE_MIRROR: u32 = 1u;

/// The finer of the two levels for samples this many texels apart, and the share of the coarser one.
fn texture_level(footprint_px: f32, last: u32) -> vec2<f32> {
    let level = min(log2(max(footprint_px, 1.0)), f32(last));
    return vec2<f32>(floor(level), level - floor(level));
}

/// The texel that a coordinate beyond the image stands for.
fn texture_wrapped(at: f32, size: u32, wrap: u32) -> u32 {
    let n = f32(size);
    var inside = at;
    if wrap == TEXTURE_REPEAT {
        inside = at - n * floor(at / n);
    } else if wrap == TEXTURE_MIRROR {
        let back = at - 2.0 * n * floor(at / (2.0 * n));
        inside = select(2.0 * n - 1.0 - back, back, back < n);
    }
    return u32(clamp(inside, 0.0, n - 1.0));
}
