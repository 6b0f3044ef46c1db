//! One band a pixel, and the other two guessed from its neighbours.

use rayon::prelude::*;
use rodsight_scene::{Bayer, Demosaic};

/// Demosaiced values are whole numbers of a code's sixteenth: all weights are.
pub(crate) const PARTS: u16 = 16;

/// A weighted neighbour: columns to the right, rows down, weight in sixteenths.
pub(crate) type Tap = (isize, isize, i32);

/// Missing bands as the mean of the nearest samples that have them.
mod bilinear {
    use super::Tap;

    pub(super) const CROSS: &[Tap] = &[(0, -1, 4), (-1, 0, 4), (1, 0, 4), (0, 1, 4)];
    pub(super) const ROW: &[Tap] = &[(-1, 0, 8), (1, 0, 8)];
    pub(super) const DIAGONAL: &[Tap] = &[(-1, -1, 4), (1, -1, 4), (-1, 1, 4), (1, 1, 4)];
}

/// The same, corrected by the curvature of the band that is there (Malvar, He and Cutler, ICASSP 2004, figure 2).
mod malvar {
    use super::Tap;

    /// Green at red or blue.
    pub(super) const CROSS: &[Tap] = &[
        (0, 0, 8),
        (0, -1, 4),
        (-1, 0, 4),
        (1, 0, 4),
        (0, 1, 4),
        (0, -2, -2),
        (-2, 0, -2),
        (2, 0, -2),
        (0, 2, -2),
    ];
    /// Red or blue at green, its own samples left and right.
    pub(super) const ROW: &[Tap] = &[
        (0, 0, 10),
        (-1, 0, 8),
        (1, 0, 8),
        (-1, -1, -2),
        (1, -1, -2),
        (-1, 1, -2),
        (1, 1, -2),
        (-2, 0, -2),
        (2, 0, -2),
        (0, -2, 1),
        (0, 2, 1),
    ];
    /// Red at blue or blue at red.
    pub(super) const DIAGONAL: &[Tap] = &[
        (0, 0, 12),
        (-1, -1, 4),
        (1, -1, 4),
        (-1, 1, 4),
        (1, 1, 4),
        (0, -2, -3),
        (-2, 0, -3),
        (2, 0, -3),
        (0, 2, -3),
    ];
}

/// The band (0 red, 1 green, 2 blue) of a pixel.
pub(crate) fn filter(bayer: Bayer, column: usize, row: usize) -> usize {
    let [red_column, red_row] = bayer.pattern.red();
    match (column % 2 == red_column, row % 2 == red_row) {
        (true, true) => 0,
        (false, false) => 2,
        _ => 1,
    }
}

/// Green at red or blue, red or blue at green, red at blue or blue at red.
pub(crate) fn kernels(demosaic: Demosaic) -> [&'static [Tap]; 3] {
    match demosaic {
        Demosaic::Bilinear => [bilinear::CROSS, bilinear::ROW, bilinear::DIAGONAL],
        Demosaic::Malvar => [malvar::CROSS, malvar::ROW, malvar::DIAGONAL],
    }
}

/// All three bands of every pixel, in sixteenths of a code; may overshoot the codes. At the borders the image is mirrored in the
/// outermost pixels, which keeps the pattern.
pub(super) fn demosaic(bayer: Bayer, codes: &[u16], width: usize) -> Vec<[i32; 3]> {
    let height = codes.len() / width;
    let [cross, along, diagonal] = kernels(bayer.demosaic);
    let rows = (0..height).into_par_iter();
    rows.flat_map_iter(|row| {
        (0..width).map(move |column| {
            let sum = |taps: &[Tap], upright: bool| -> i32 {
                let taps = taps.iter().map(|&(du, dv, weight)| {
                    let (du, dv) = if upright { (dv, du) } else { (du, dv) };
                    let (u, v) = (mirrored(column, du, width), mirrored(row, dv, height));
                    weight * i32::from(codes[v * width + u])
                });
                taps.sum()
            };
            let own = i32::from(PARTS) * i32::from(codes[row * width + column]);
            match filter(bayer, column, row) {
                0 => [own, sum(cross, false), sum(diagonal, false)],
                2 => [sum(diagonal, false), sum(cross, false), own],
                _ => {
                    // Red lies left and right of this green in the rows that have red.
                    let red_beside = row % 2 == bayer.pattern.red()[1];
                    [sum(along, !red_beside), own, sum(along, red_beside)]
                }
            }
        })
    })
    .collect()
}

/// The index `step` away, mirrored in the first and the last.
pub(crate) fn mirrored(index: usize, step: isize, size: usize) -> usize {
    let last = size - 1;
    let there = index
        .checked_add_signed(step)
        .unwrap_or_else(|| step.unsigned_abs() - index);
    if there <= last {
        there
    } else {
        (2 * last).saturating_sub(there)
    }
}
