// The convolution along columns, and what the wider widths have: 3/4 of the cell a value lies in and 1/4 of the next nearest, on both
// axes. Fine widths add theirs to the image.

fn blur_coarser(column: i32, row: i32, band: i32) -> f32 {
    return coarser[3 * ((row + 1) * halo.levels[level].coarser_columns + column + 1) + band];
}

@compute @workgroup_size(64)
fn blur_columns(@builtin(global_invocation_id) id: vec3<u32>) {
    let its = halo.levels[level];
    let stride = halo_stride(its.border);
    let at = vec2<i32>(id.xy);
    if at.x >= stride || at.y >= its.rows + 2 * its.border {
        return;
    }
    let start = (at.y + its.reach) * stride + at.x;
    var sum = halo_kernel(0) * source[start];
    for (var shift = 1; shift <= its.reach; shift++) {
        sum += halo_kernel(shift) * (source[start - shift * stride] + source[start + shift * stride]);
    }
    if its.coarser_columns > 0 {
        let column = halo_parents(at.x / 3 - its.border);
        let row = halo_parents(at.y - its.border);
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
