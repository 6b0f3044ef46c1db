// The convolution along rows: of all rows that the one along columns asks for, with the border's columns.

@compute @workgroup_size(64)
fn blur_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    let its = halo.levels[level];
    let stride = halo_stride(its.border);
    let at = vec2<i32>(id.xy);
    if at.x >= stride || at.y >= its.rows + 2 * (its.border + its.reach) {
        return;
    }
    let lost = MARGIN - its.border;
    let start = (at.y + lost - its.reach) * halo_stride(MARGIN) + 3 * lost + at.x;
    var sum = halo_kernel(0) * source[start];
    for (var shift = 1; shift <= its.reach; shift++) {
        sum += halo_kernel(shift) * (source[start - 3 * shift] + source[start + 3 * shift]);
    }
    blurred[at.y * stride + at.x] = sum;
}
