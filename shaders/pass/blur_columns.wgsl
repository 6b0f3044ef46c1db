// The convolution along columns, and what the wider widths have: 3/4 of the cell a value lies in and 1/4 of the next nearest, on both
// axes. Fine widths add theirs to the image.

fn blur_coarser(column: i32, row: i32, band: i32) -> f32 {
    return coarser[3 * ((row + 1) * halo.levels[level].coarser_columns + column + 1) + band];
}

@compute @workgroup_size(64)
fn blur_columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let border = halo.levels[level].border;
    let stride = halo_stride(border);
    let at = vec2<i32>(id.xy);
    if at.x >= stride || at.y >= halo.levels[level].rows + 2 * border {
        return;
    }
    var sum = halo_convolved((at.y + REACH) * stride + at.x, stride);
    if halo.levels[level].coarser_columns > 0 {
        let column = halo_parents(at.x / 3 - border);
        let row = halo_parents(at.y - border);
        let band = at.x % 3;
        let near = 0.75 * blur_coarser(column.x, row.x, band) + 0.25 * blur_coarser(column.x, row.y, band);
        let next = 0.75 * blur_coarser(column.y, row.x, band) + 0.25 * blur_coarser(column.y, row.y, band);
        sum += 0.75 * near + 0.25 * next;
    }
    let place = at.y * stride + at.x;
    if level < FINE {
        sum += blurred[place];
    }
    blurred[place] = sum;
}
