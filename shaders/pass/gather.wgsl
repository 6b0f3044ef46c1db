// The means over the cells of a width, of the image's light and of the overscan's. A cell is summed by as many invocations as its size
// is worth, each in order: nothing else changes the sum.

const INVOCATIONS: u32 = 64u;
/// Of them, how many sum a cell.
override LANES: u32 = 64u;

var<workgroup> parts: array<vec3<f32>, INVOCATIONS>;

/// Every `LANES`th part of a cell's light, from a lane on.
fn gather_part(cell: vec2<i32>, lane: u32) -> vec3<f32> {
    let its = halo.levels[level];
    let start = cell * its.side;
    let to = start + its.side;
    var sum = vec3<f32>(0.0);
    let inside = max(start, vec2<i32>(0));
    let size = max(min(to, halo.size) - inside, vec2<i32>(0));
    let run_px = i32(its.run_px);
    let across = (size.x + run_px - 1) / run_px;
    for (var i = i32(lane); i < across * size.y; i += i32(LANES)) {
        let row = inside.y + i / across;
        let run = 3u * (u32(row) * halo.runs + its.first_run + u32(inside.x / run_px + i % across));
        sum += vec3<f32>(runs[run], runs[run + 1u], runs[run + 2u]);
    }
    for (var s = 0u; s < 8u; s++) {
        let strip = halo.strips[s];
        let first = max(start, strip.at);
        let last = min(to, strip.at + strip.size);
        if any(first >= last) {
            continue;
        }
        let square = (first - strip.at) / strip.side;
        let squares = (last - 1 - strip.at) / strip.side + 1 - square;
        for (var i = i32(lane); i < squares.x * squares.y; i += i32(LANES)) {
            let here = square + vec2<i32>(i % squares.x, i / squares.x);
            let at = strip.at + here * strip.side;
            let overlap = min(at + strip.side, last) - max(at, first);
            let scattered = outside[strip.first + u32(here.y) * strip.columns + u32(here.x)];
            sum += f32(overlap.x * overlap.y) * halo_shared(level, scattered);
        }
    }
    return sum;
}

@compute @workgroup_size(INVOCATIONS)
fn gather(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) index: u32) {
    let its = halo.levels[level];
    let cell = vec2<i32>(vec2<u32>((group.x * INVOCATIONS + index) / LANES, group.y)) - MARGIN;
    let lane = index % LANES;
    let known = halo_known(cell);
    let is_there = cell.x < its.columns + MARGIN;
    var sum = vec3<f32>(0.0);
    if is_there && known > 0 {
        sum = gather_part(cell, lane);
    }
    if LANES > 1u {
        parts[index] = sum;
        workgroupBarrier();
    }
    if !is_there || lane != 0u {
        return;
    }
    for (var i = 1u; i < LANES; i++) {
        sum += parts[index + i];
    }
    let area = its.side * its.side;
    if known == area {
        halo_store_cell(cell, sum / f32(area));
        return;
    }
    let first = halo_cell(cell);
    let far = vec3<f32>(cells[first], cells[first + 1u], cells[first + 2u]);
    // Less than an eighth of a side: as the rest of the cell.
    let whole = select((sum + f32(area - known) * far) / f32(area), sum / f32(known), far.x < 0.0);
    halo_store_cell(cell, whole);
}
