// The planes of the halo before they are blurred.

/// Of each knot and width.
@group(3) @binding(0) var<storage, read> shares: array<vec4<f32>>;
/// The squares of the overscan: light and range.
@group(3) @binding(1) var<storage, read_write> outside: array<vec4<f32>>;
@group(3) @binding(2) var<storage, read_write> unspread: array<f32>;
/// With a margin.
@group(3) @binding(3) var<storage, read_write> one_px: array<f32>;
@group(3) @binding(4) var<storage, read_write> two_px: array<f32>;
@group(3) @binding(5) var<storage, read_write> runs: array<f32>;
/// Means over the cells of a width, with a margin.
@group(3) @binding(6) var<storage, read_write> cells: array<f32>;

@group(3) @binding(7) var<storage, read_write> halo_loops: Loops;

/// Where the loops of an invocation end.
fn halo_check_loops() {
    if loops_are_cut(halo_loops.steps) {
        halo_loops.are_cut = 1u;
    }
}

/// The share of a width between a knot and the next.
fn halo_share(at: u32, knot: u32, along: f32) -> vec3<f32> {
    let first = knot * LEVELS + at;
    return mix(shares[first].xyz, shares[first + LEVELS].xyz, along);
}

/// The part of some light that a width has.
fn halo_shared(at: u32, scattered: vec4<f32>) -> vec3<f32> {
    let place = halo_place(scattered.w, halo.longest_m, halo.knots - 1u);
    let knot = min(u32(place), halo.knots - 2u);
    return scattered.xyz * halo_share(at, knot, place - f32(knot));
}

/// Sets a pixel of a fine width; those of the margin are negative or beyond the size.
fn halo_store_fine(at: u32, pixel: vec2<i32>, value: vec3<f32>) {
    if at == 0u {
        let first = 3u * u32(pixel.y * halo.size.x + pixel.x);
        unspread[first] = value.x;
        unspread[first + 1u] = value.y;
        unspread[first + 2u] = value.z;
        return;
    }
    let first = 3u * u32((pixel.y + MARGIN) * (halo.size.x + 2 * MARGIN) + pixel.x + MARGIN);
    if at == 1u {
        one_px[first] = value.x;
        one_px[first + 1u] = value.y;
        one_px[first + 2u] = value.z;
    } else {
        two_px[first] = value.x;
        two_px[first + 1u] = value.y;
        two_px[first + 2u] = value.z;
    }
}

fn halo_cell(cell: vec2<i32>) -> u32 {
    return 3u * u32((cell.y + MARGIN) * (halo.levels[level].columns + 2 * MARGIN) + cell.x + MARGIN);
}

fn halo_store_cell(cell: vec2<i32>, value: vec3<f32>) {
    let first = halo_cell(cell);
    cells[first] = value.x;
    cells[first + 1u] = value.y;
    cells[first + 2u] = value.z;
}

/// The area of a cell within the overscan, px².
fn halo_known(cell: vec2<i32>) -> i32 {
    let side = halo.levels[level].side;
    let start = max(cell * side, vec2<i32>(-halo.overscan));
    let to = min(cell * side + side, halo.size + halo.overscan);
    let known = max(to - start, vec2<i32>(0));
    return known.x * known.y;
}
