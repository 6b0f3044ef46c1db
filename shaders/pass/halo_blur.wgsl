// What the two passes of a blur bind.

@group(1) @binding(0) var<storage, read> source: array<f32>;
@group(1) @binding(1) var<storage, read> coarser: array<f32>;
@group(1) @binding(2) var<storage, read_write> blurred: array<f32>;

fn halo_kernel(shift: i32) -> f32 {
    return halo.levels[level].kernel[shift / 4][shift % 4];
}

/// Floats of a row with a border.
fn halo_stride(border: i32) -> i32 {
    return 3 * (halo.levels[level].columns + 2 * border);
}
