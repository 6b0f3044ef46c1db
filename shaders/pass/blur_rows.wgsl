// The convolution along rows: of all rows that the one along columns asks for, with the border's columns.

@compute @workgroup_size(64)
fn blur_rows(@builtin(global_invocation_id) id: vec3<u32>) {
    let border = halo.levels[level].border;
    let stride = halo_stride(border);
    let at = vec2<i32>(id.xy);
    if at.x >= stride || at.y >= halo.levels[level].rows + 2 * (border + REACH) {
        return;
    }
    let lost = MARGIN - border;
    let start = (at.y + lost - REACH) * halo_stride(MARGIN) + 3 * lost + at.x;
    blurred[at.y * stride + at.x] = halo_convolved(start, 3);
}
