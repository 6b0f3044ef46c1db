//! Speckle off the binarised image: each pixel becomes what most of its neighbourhood is.

use crate::Roi;

/// The median of a 0/255 image over (2 radius + 1)², the neighbourhood cut off at the border of the region. A straight edge stays
/// where it is; isolated pixels, of which noise in a nearly colourless background makes thousands, go. Ties keep the pixel.
pub fn majority(mask: &[u8], roi: &Roi, radius_px: u32) -> Vec<u8> {
    let (width, height) = (roi.width_px as usize, roi.height_px as usize);
    let radius = radius_px as usize;
    if radius == 0 || mask.is_empty() {
        return mask.to_vec();
    }
    let row = |y: usize| &mask[y * width..(y + 1) * width];
    // Per column, set pixels of the rows in reach, with `radius` zeros on either side so that every window is whole.
    let mut columns = vec![0_u16; width + 2 * radius];
    let mut sums = vec![0_u16; width];
    let mut result = vec![0_u8; mask.len()];
    for y in 0..radius.min(height) {
        add(&mut columns[radius..radius + width], row(y));
    }
    // Columns whose window the border of the region cuts off.
    let (left, right) = (
        radius.min(width),
        width.saturating_sub(radius).max(radius.min(width)),
    );
    for (y, out) in result.chunks_exact_mut(width).enumerate() {
        if y + radius < height {
            add(&mut columns[radius..radius + width], row(y + radius));
        }
        if y > radius {
            subtract(&mut columns[radius..radius + width], row(y - radius - 1));
        }
        sums.copy_from_slice(&columns[..width]);
        for shift in 1..=2 * radius {
            for (sum, column) in sums.iter_mut().zip(&columns[shift..shift + width]) {
                *sum += column;
            }
        }
        let rows_in_reach = (y + radius + 1).min(height) - y.saturating_sub(radius);
        let here = row(y);
        // Away from the border the area is the same for all: a loop without branches.
        let area = (rows_in_reach * (2 * radius + 1)) as u16;
        let inside = sums[left..right].iter().zip(&here[left..right]);
        for (out, (&sum, &here)) in out[left..right].iter_mut().zip(inside) {
            *out = decide(sum, area, here);
        }
        for x in (0..left).chain(right..width) {
            let in_reach = (x + radius + 1).min(width) - x.saturating_sub(radius);
            out[x] = decide(sums[x], (rows_in_reach * in_reach) as u16, here[x]);
        }
    }
    result
}

/// The majority of `area` pixels of which `sum` are set; a tie keeps the pixel.
fn decide(sum: u16, area: u16, here: u8) -> u8 {
    let more = u8::from(2 * sum > area).wrapping_neg();
    let tie = u8::from(2 * sum == area).wrapping_neg();
    more | (tie & here)
}

fn add(columns: &mut [u16], row: &[u8]) {
    for (column, &pixel) in columns.iter_mut().zip(row) {
        *column += u16::from(pixel & 1);
    }
}

fn subtract(columns: &mut [u16], row: &[u8]) {
    for (column, &pixel) in columns.iter_mut().zip(row) {
        *column -= u16::from(pixel & 1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn region(width_px: u32, height_px: u32) -> Roi {
        Roi {
            x_px: 0,
            y_px: 0,
            width_px,
            height_px,
        }
    }

    /// Written the slow way.
    fn by_definition(mask: &[u8], roi: &Roi, radius: i64) -> Vec<u8> {
        let (width, height) = (i64::from(roi.width_px), i64::from(roi.height_px));
        let mut result = Vec::new();
        for y in 0..height {
            for x in 0..width {
                let (mut set, mut all) = (0, 0);
                for v in (y - radius).max(0)..=(y + radius).min(height - 1) {
                    for u in (x - radius).max(0)..=(x + radius).min(width - 1) {
                        all += 1;
                        set += i64::from(mask[(v * width + u) as usize] > 0);
                    }
                }
                let here = mask[(y * width + x) as usize];
                result.push(match (2 * set).cmp(&all) {
                    core::cmp::Ordering::Less => 0,
                    core::cmp::Ordering::Equal => here,
                    core::cmp::Ordering::Greater => 255,
                });
            }
        }
        result
    }

    #[test]
    fn majority_is_the_median_at_every_radius_and_border() {
        let roi = region(23, 17);
        let mut state = 9_u32;
        let mask: Vec<u8> = (0..23 * 17)
            .map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                if state >> 31 == 1 { 255 } else { 0 }
            })
            .collect();
        for radius in [1, 2, 5, 20] {
            let radius_i64 = i64::from(radius);
            assert_eq!(
                majority(&mask, &roi, radius),
                by_definition(&mask, &roi, radius_i64),
                "radius {radius}"
            );
        }
        assert_eq!(majority(&mask, &roi, 0), mask);
    }

    #[test]
    fn speckle_goes_and_an_edge_stays() {
        let roi = region(40, 40);
        let rod = |x: usize| (12..25).contains(&x);
        let clean: Vec<u8> = (0..1600)
            .map(|i| if rod(i % 40) { 255 } else { 0 })
            .collect();
        let mut speckled = clean.clone();
        for (x, y) in [(3, 3), (30, 20), (18, 9), (39, 39), (20, 0)] {
            speckled[y * 40 + x] ^= 255;
        }
        assert_eq!(majority(&speckled, &roi, 1), clean);
    }
}
