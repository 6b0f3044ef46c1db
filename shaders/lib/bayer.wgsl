// Colour filters: see develop/bayer.rs.

/// The band (0 red, 1 green, 2 blue) of a pixel; `red` is the column and row, modulo 2, of the red ones.
fn bayer_filter(red: vec2<u32>, pixel: vec2<u32>) -> u32 {
    let parity = (pixel ^ red) & vec2<u32>(1u);
    return parity.x + parity.y;
}

/// An index beside the image, mirrored in the first and the last.
fn bayer_mirrored(at: i32, size: i32) -> i32 {
    let there = abs(at);
    return select(max(2 * (size - 1) - there, 0), there, there < size);
}
