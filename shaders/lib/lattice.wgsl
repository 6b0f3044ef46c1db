// Where samples lie in a pixel: see lattice.rs.

/// PCG-RXS-M-XS, 32 bits, as a hash (Jarzynski and Olano, JCGT 2020).
fn lattice_pcg(value: u32) -> u32 {
    let state = value * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

/// The shift of a pixel's samples, each in [0, 1].
fn lattice_pixel_shift(column: u32, row: u32) -> vec2<f32> {
    let first = lattice_pcg(column + lattice_pcg(row));
    return vec2<f32>(f32(first), f32(lattice_pcg(first))) / 4294967296.0;
}

/// A sample's place in its pixel, from the top-left corner: offset plus shift, modulo 1.
fn lattice_place(offset: vec2<f32>, shift: vec2<f32>) -> vec2<f32> {
    let sum = offset + shift;
    return select(sum, sum - 1.0, sum >= vec2<f32>(1.0));
}
