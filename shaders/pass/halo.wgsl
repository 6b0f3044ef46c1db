// What the passes of the halo share: see cpu/halo.rs. Light is weighted by the shares of the widths first and blurred after: widths
// of 0, 1 and 2 px as they are, each wider one on cells of half its size. Everything here is of the whole image of an eye.

/// Widths that are blurred at full resolution.
const FINE: u32 = 3u;
/// Cells, or pixels of the fine widths, around the image.
const MARGIN: i32 = 9;
/// Cells to either side that a Gaussian takes part in.
const REACH: i32 = 8;
/// Widths at most.
const LEVELS: u32 = 16u;
/// Rays for a side of a cell beyond the overscan.
const RAYS: u32 = 4u;

/// A rectangle of the overscan, row by row of squares of a side; the last are cut.
struct HaloStrip {
    at: vec2<i32>,
    size: vec2<i32>,
    side: i32,
    /// Squares across.
    columns: u32,
    /// The place of its first square.
    first: u32,
}

/// A width and its cells.
struct HaloLevel {
    /// Cells of the image.
    columns: i32,
    rows: i32,
    side: i32,
    /// Cells of the next wider one across, with its border; 0 if it is not to be added.
    coarser_columns: i32,
    /// Pixels of a row that are summed first, and where a row's first sum is.
    run_px: u32,
    first_run: u32,
    /// Cells around the image that are kept of the margin.
    border: i32,
    /// Of the Gaussian, from its middle outwards.
    kernel: array<vec4<f32>, 2>,
    farthest: f32,
}

struct Halo {
    size: vec2<i32>,
    overscan: i32,
    /// Squares of the overscan.
    patches: u32,
    longest_m: f32,
    knots: u32,
    /// Widths in use, the fine ones at least.
    count: u32,
    /// Sums of a row, of all widths.
    runs: u32,
    strips: array<HaloStrip, 8>,
    levels: array<HaloLevel, LEVELS>,
}

@group(2) @binding(0) var<uniform> halo: Halo;
/// The width that a pass is about.
@group(2) @binding(1) var<uniform> level: u32;

