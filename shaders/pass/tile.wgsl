// A tile: some rows of an eye's image, with one more row on either side where there is one, so that edges show.
// Every channel is a plane of its own: channel * pixels + pixel.

struct Tile {
    width: u32,
    /// The first row of the tile in the image.
    first_row: u32,
    rows: u32,
    /// Of its rows, those whose pixels are kept.
    kept_from: u32,
    kept_to: u32,
    has_snow: u32,
}

/// What must be alike in neighbouring pixels for one sample to do: instance, cap (`key`), lamps, range.
const KEY_CAP: u32 = 0x10000u;
/// A limb is beside the pixel, or perhaps within it too.
const KEY_BESIDE: u32 = 0x20000u;
const KEY_WITHIN: u32 = 0x40000u;
const KEY_LIMB: u32 = KEY_BESIDE | KEY_WITHIN;

/// Bits of the last channel of `surface`, above the instance.
const TAG_IN_VIEW: u32 = 0x10000u;
const TAG_OCCLUDED: u32 = 0x20000u;

@group(1) @binding(0) var<uniform> tile: Tile;
/// key, lamps, range (bits of f32), place among the edges, counted from 1.
@group(1) @binding(1) var<storage, read_write> keys: array<u32>;
/// direct, backscatter, clean, then in mode `full` what arrives scattered, before it is spread, then snow: three bands each; and the
/// share of the pixel that snow covers.
@group(1) @binding(2) var<storage, read_write> light: array<f32>;
/// transmission (3), normal (3), depth, range, disparity, tag (bits of u32).
@group(1) @binding(3) var<storage, read_write> surface: array<f32>;
/// Pixels at edges, in no order.
@group(1) @binding(4) var<storage, read_write> edges: array<u32>;
/// A dispatch has at most 65535 workgroups a dimension; more pixels than this make another row of them.
const REFINE_ACROSS: u32 = 32768u;
/// In mode `full`: of every pixel at an edge, what arrives scattered of each thing in it, and its range, m; less than 0 ends them.
@group(1) @binding(5) var<storage, read_write> sources: array<vec4<f32>>;

@group(1) @binding(9) var<storage, read_write> tile_loops: Loops;

/// Things told apart in a pixel at an edge; what is beyond the last place shares its mean distance.
const THINGS: u32 = 8u;

/// Where the loops of an invocation end.
fn tile_check_loops() {
    if loops_are_cut(tile_loops.steps) {
        tile_loops.are_cut = 1u;
    }
}

fn tile_store(first: u32, pixel: u32, value: vec3<f32>) {
    let pixels = tile.width * tile.rows;
    light[first * pixels + pixel] = value.x;
    light[(first + 1u) * pixels + pixel] = value.y;
    light[(first + 2u) * pixels + pixel] = value.z;
}

fn tile_store_surface(first: u32, pixel: u32, value: vec3<f32>) {
    let pixels = tile.width * tile.rows;
    surface[first * pixels + pixel] = value.x;
    surface[(first + 1u) * pixels + pixel] = value.y;
    surface[(first + 2u) * pixels + pixel] = value.z;
}

fn tile_light(first: u32, pixel: u32) -> vec3<f32> {
    let pixels = tile.width * tile.rows;
    return vec3<f32>(
        light[first * pixels + pixel],
        light[(first + 1u) * pixels + pixel],
        light[(first + 2u) * pixels + pixel],
    );
}
