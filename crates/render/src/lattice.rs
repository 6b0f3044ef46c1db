//! Where samples lie in a pixel.

use rodsight_scene::EdgeSampling;

/// Offsets of the samples from the pixel's top-left corner, each in (0, 1)².
///
/// The Fibonacci lattice of N = F(k) points has (i + ½)/N for i = 0..N as its projection on either axis, so that even an upright
/// edge, which every row cuts at the same place, is placed to 1/N px. A regular n × n grid has only n different columns.
pub fn edge_offsets(pattern: EdgeSampling) -> Vec<[f64; 2]> {
    match pattern {
        EdgeSampling::Fibonacci { points } => {
            let (mut before, mut n) = (1_u64, 1_u64);
            while n < u64::from(points) {
                (before, n) = (n, before + n);
            }
            let offset = |numerator: u64| (numerator as f64 + 0.5) / n as f64;
            (0..n)
                .map(|i| [offset(i), offset(i * before % n)])
                .collect()
        }
        EdgeSampling::Grid { side } => {
            let offset = |i: u32| (f64::from(i) + 0.5) / f64::from(side);
            (0..side * side)
                .map(|i| [offset(i % side), offset(i / side)])
                .collect()
        }
    }
}

/// About a fifth as many offsets, for pixels in which no outline runs but the light changes, or one smooth piece of a thing meets the
/// next: no truth hangs on where a shadow ends. They also find out whether an outline runs there.
pub(crate) fn inner_offsets(pattern: EdgeSampling) -> Vec<[f64; 2]> {
    edge_offsets(match pattern {
        EdgeSampling::Fibonacci { points } => EdgeSampling::Fibonacci {
            points: points.div_ceil(5),
        },
        EdgeSampling::Grid { side } => EdgeSampling::Grid {
            side: side.div_ceil(2),
        },
    })
}

/// The shift of a pixel's samples, each in [0, 1): added to the offsets modulo 1 (Cranley and Patterson 1976).
///
/// The same pattern in every pixel would make one lattice over the whole image, and an edge along one of its directions would be
/// off by the same amount in every row: 0.04 px at 45° with 144 points. A shift of its own in each pixel turns that into noise that
/// a line averages away, and keeps the projections uniform. The regular grid stays as it is: it is there to be wrong.
pub(crate) fn pixel_shift(pattern: EdgeSampling, column: u32, row: u32) -> [f64; 2] {
    match pattern {
        EdgeSampling::Grid { .. } => [0.0; 2],
        EdgeSampling::Fibonacci { .. } => {
            let first = pcg(column.wrapping_add(pcg(row)));
            [first, pcg(first)].map(|word| f64::from(word) / 4294967296.0)
        }
    }
}

/// PCG-RXS-M-XS, 32 bits, as a hash (Jarzynski and Olano, JCGT 2020).
pub(crate) fn pcg(value: u32) -> u32 {
    let state = value.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lattice_projections_are_uniform_on_both_axes_and_the_grids_are_not() {
        let distinct = |pattern, axis: usize| {
            let mut values: Vec<_> = edge_offsets(pattern)
                .iter()
                .map(|o| o[axis].to_bits())
                .collect();
            values.sort_unstable();
            values.dedup();
            values.len()
        };
        for axis in [0, 1] {
            assert_eq!(distinct(EdgeSampling::Fibonacci { points: 233 }, axis), 233);
            assert_eq!(distinct(EdgeSampling::Grid { side: 12 }, axis), 12);
        }
        for (points, inner) in [(233, 55), (55, 13), (1, 1)] {
            let pattern = EdgeSampling::Fibonacci { points };
            assert_eq!(inner_offsets(pattern).len(), inner);
        }
    }
}
