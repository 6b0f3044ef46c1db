// What the two passes of a blur bind.

@group(1) @binding(0) var<storage, read> source: array<f32>;
@group(1) @binding(1) var<storage, read> coarser: array<f32>;
@group(1) @binding(2) var<storage, read_write> blurred: array<f32>;

/// Floats of a row with a border.
fn halo_stride(border: i32) -> i32 {
    return 3 * (halo.levels[level].columns + 2 * border);
}

fn halo_both(start: i32, apart: i32) -> f32 {
    return source[start - apart] + source[start + apart];
}

/// The convolution along a direction; written out, as graphics cards and drivers are slow to index a kernel.
fn halo_convolved(start: i32, step: i32) -> f32 {
    let near = halo.levels[level].kernel[0];
    let far = halo.levels[level].kernel[1];
    return near.x * source[start] + near.y * halo_both(start, step) + near.z * halo_both(start, 2 * step)
        + near.w * halo_both(start, 3 * step) + far.x * halo_both(start, 4 * step) + far.y * halo_both(start, 5 * step)
        + far.z * halo_both(start, 6 * step) + far.w * halo_both(start, 7 * step)
        + halo.levels[level].farthest * halo_both(start, REACH * step);
}
