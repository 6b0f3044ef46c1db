//! Canny's edges (1986) of a binarised image.

use rodsight_geometry::Pixel;

use crate::Roi;
use crate::paper::PaperParams;

/// A pixel on an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgePoint {
    /// Centre of the pixel, px from the top-left corner of the whole image.
    pub pixel: Pixel,
    /// Sobel gradient (u, v) on 0…255: towards the brighter side, which in a mask is the rod.
    pub gradient: [i16; 2],
}

/// A local maximum of the gradient, before hysteresis.
struct Candidate {
    /// In the padded state map.
    index: u32,
    gradient: [i16; 2],
}

const WEAK: u8 = 1;
const STRONG: u8 = 2;

/// Blur (if any), Sobel, non-maximum suppression, hysteresis over all eight neighbours; points in raster order.
///
/// Magnitude is |gx| + |gy|, as `OpenCV`'s default. Suppression compares with the magnitude interpolated along the gradient,
/// in whole numbers. Of two equal pixels, the two sides of a binary step, the upper or left one survives, as in `OpenCV`:
/// both limbs of a rod shift alike by half a pixel, which moves the rod but not its depth.
pub fn canny(mask: &[u8], roi: &Roi, params: &PaperParams) -> Vec<EdgePoint> {
    let (width, height) = (roi.width_px as usize, roi.height_px as usize);
    if width < 3 || height < 3 || mask.len() != width * height {
        return Vec::new();
    }
    let blurred;
    let image = if params.blur_sigma_px > 0.0 {
        blurred = blur(mask, width, params.blur_sigma_px);
        &blurred
    } else {
        mask
    };
    let stride = width + 2;
    let mut state = vec![0_u8; stride * (height + 2)];
    let candidates = suppress(image, width, height, params, &mut state);

    let mut stack: Vec<u32> = candidates
        .iter()
        .filter(|c| state[c.index as usize] == STRONG)
        .map(|c| c.index)
        .collect();
    while let Some(index) = stack.pop() {
        let index = index as usize;
        for row in [index - stride, index, index + stride] {
            for neighbour in [row - 1, row, row + 1] {
                if state[neighbour] == WEAK {
                    state[neighbour] = STRONG;
                    stack.push(neighbour as u32);
                }
            }
        }
    }
    candidates
        .iter()
        .filter(|c| state[c.index as usize] == STRONG)
        .map(|c| {
            let (row, column) = (c.index as usize / stride - 1, c.index as usize % stride - 1);
            EdgePoint {
                pixel: Pixel::new(
                    f64::from(roi.x_px) + column as f64 + 0.5,
                    f64::from(roi.y_px) + row as f64 + 0.5,
                ),
                gradient: c.gradient,
            }
        })
        .collect()
}

/// Gradient and magnitude of one row, padded by one zero on each side.
struct GradientRow {
    x: Vec<i16>,
    y: Vec<i16>,
    magnitude: Vec<i16>,
    /// Nothing but zeros: most rows of most masks.
    flat: bool,
}

fn suppress(
    image: &[u8],
    width: usize,
    height: usize,
    params: &PaperParams,
    state: &mut [u8],
) -> Vec<Candidate> {
    // |gx| + |gy| reaches 2040, so any larger threshold means "none".
    let limit = |threshold: f64| threshold.min(4000.0) as i16;
    let (low, high) = (limit(params.canny_low), limit(params.canny_high));
    let row_of = |y: usize| &image[y * width..(y + 1) * width];
    let uniform: Vec<bool> = (0..height)
        .map(|y| row_of(y)[1..] == row_of(y)[..width - 1])
        .collect();
    let zeros = || GradientRow {
        x: vec![0; width + 2],
        y: vec![0; width + 2],
        magnitude: vec![0; width + 2],
        flat: true,
    };
    let mut rows = [zeros(), zeros(), zeros()];
    let (mut sums, mut differences) = (vec![0_i16; width + 2], vec![0_i16; width + 2]);
    let mut candidates = Vec::new();
    for y in 0..=height {
        let next = &mut rows[y % 3];
        let clamped = [y.saturating_sub(1), y, (y + 1).min(height - 1)];
        let is_flat = y == height || {
            let first = clamped.map(|y| row_of(y)[0]);
            clamped.iter().all(|&y| uniform[y]) && first[0] == first[1] && first[1] == first[2]
        };
        if is_flat {
            if !next.flat {
                next.magnitude.fill(0);
                next.flat = true;
            }
        } else {
            let three = clamped.map(row_of);
            sobel_row(three, &mut sums, &mut differences, next);
        }
        if y > 0 {
            let around = [(y + 1) % 3, (y - 1) % 3, y % 3].map(|i| &rows[i]);
            if !around[1].flat {
                suppress_row(around, y - 1, width, [low, high], state, &mut candidates);
            }
        }
    }
    candidates
}

/// 3×3 Sobel of the middle row; borders repeat.
fn sobel_row(
    [above, here, below]: [&[u8]; 3],
    sums: &mut [i16],
    differences: &mut [i16],
    out: &mut GradientRow,
) {
    let width = here.len();
    let inner = sums[1..=width].iter_mut().zip(&mut differences[1..=width]);
    for (((sum, difference), a), (h, b)) in inner.zip(above).zip(here.iter().zip(below)) {
        let (a, h, b) = (i16::from(*a), i16::from(*h), i16::from(*b));
        *sum = a + 2 * h + b;
        *difference = b - a;
    }
    for buffer in [&mut *sums, &mut *differences] {
        buffer[0] = buffer[1];
        buffer[width + 1] = buffer[width];
    }
    let (sums, differences) = (&sums[..width + 2], &differences[..width + 2]);
    let (xs, ys, magnitudes) = (
        &mut out.x[1..=width],
        &mut out.y[1..=width],
        &mut out.magnitude[1..=width],
    );
    for i in 0..width {
        let gx = sums[i + 2] - sums[i];
        let gy = differences[i] + 2 * differences[i + 1] + differences[i + 2];
        xs[i] = gx;
        ys[i] = gy;
        magnitudes[i] = gx.abs() + gy.abs();
    }
    out.flat = false;
}

fn suppress_row(
    [above, here, below]: [&GradientRow; 3],
    y: usize,
    width: usize,
    [low, high]: [i16; 2],
    state: &mut [u8],
    candidates: &mut Vec<Candidate>,
) {
    const CHUNK: usize = 32;
    let at = |row: &GradientRow, i: usize| i32::from(row.magnitude[i]);
    let mut start = 1;
    while start <= width {
        let end = (start + CHUNK).min(width + 1);
        let fullest = here.magnitude[start..end].iter().fold(0, |m, v| m.max(*v));
        if fullest > low {
            for i in start..end {
                let magnitude = here.magnitude[i];
                if magnitude <= low {
                    continue;
                }
                let (gx, gy) = (here.x[i], here.y[i]);
                let (ax, ay) = (i32::from(gx.abs()), i32::from(gy.abs()));
                let down_right = (gx > 0) == (gy > 0);
                // The gradient's line leaves the 3×3 square between two neighbours on each side.
                let (before, after) = if ax >= ay {
                    let (left, right) = if down_right {
                        (above, below)
                    } else {
                        (below, above)
                    };
                    (
                        at(here, i - 1) * (ax - ay) + at(left, i - 1) * ay,
                        at(here, i + 1) * (ax - ay) + at(right, i + 1) * ay,
                    )
                } else {
                    let (up, down) = if down_right {
                        (i - 1, i + 1)
                    } else {
                        (i + 1, i - 1)
                    };
                    (
                        at(above, i) * (ay - ax) + at(above, up) * ax,
                        at(below, i) * (ay - ax) + at(below, down) * ax,
                    )
                };
                let value = i32::from(magnitude) * ax.max(ay);
                if value > before && value >= after {
                    let index = (y + 1) * (width + 2) + i;
                    state[index] = if magnitude > high { STRONG } else { WEAK };
                    candidates.push(Candidate {
                        index: index as u32,
                        gradient: [gx, gy],
                    });
                }
            }
        }
        start = end;
    }
}

/// Separable Gaussian, borders repeat, kernel cut at three sigma.
fn blur(image: &[u8], width: usize, sigma_px: f64) -> Vec<u8> {
    let reach = libm::ceil(3.0 * sigma_px) as usize;
    let mut kernel: Vec<f32> = (0..=2 * reach)
        .map(|i| {
            let t = (i as f64 - reach as f64) / sigma_px;
            libm::exp(-0.5 * t * t) as f32
        })
        .collect();
    let total: f32 = kernel.iter().sum();
    for weight in &mut kernel {
        *weight /= total;
    }
    let height = image.len() / width;
    let mut across = vec![0.0_f32; image.len()];
    let mut padded = vec![0.0_f32; width + 2 * reach];
    for (row, out) in image
        .chunks_exact(width)
        .zip(across.chunks_exact_mut(width))
    {
        for (i, p) in padded.iter_mut().enumerate() {
            *p = f32::from(row[i.saturating_sub(reach).min(width - 1)]);
        }
        for (k, weight) in kernel.iter().enumerate() {
            for (o, p) in out.iter_mut().zip(&padded[k..]) {
                *o += weight * p;
            }
        }
    }
    let mut blurred = vec![0_u8; image.len()];
    let mut sum = vec![0.0_f32; width];
    for (y, out) in blurred.chunks_exact_mut(width).enumerate() {
        sum.fill(0.5);
        for (k, weight) in kernel.iter().enumerate() {
            let from = (y + k).saturating_sub(reach).min(height - 1) * width;
            for (s, a) in sum.iter_mut().zip(&across[from..from + width]) {
                *s += weight * a;
            }
        }
        for (o, s) in out.iter_mut().zip(&sum) {
            *o = *s as u8;
        }
    }
    blurred
}

#[cfg(test)]
mod tests {
    use super::*;

    fn roi(width_px: u32, height_px: u32) -> Roi {
        Roi {
            x_px: 0,
            y_px: 0,
            width_px,
            height_px,
        }
    }

    /// A half plane, 255 where `n · p > ρ`.
    fn step(size: u32, angle_deg: f64, rho: f64) -> Vec<u8> {
        let (sin, cos) = libm::sincos(rodsight_geometry::radians(angle_deg));
        let at = |i: u32| {
            let (x, y) = (f64::from(i % size) + 0.5, f64::from(i / size) + 0.5);
            if x * cos + y * sin > rho { 255 } else { 0 }
        };
        (0..size * size).map(at).collect()
    }

    #[test]
    fn canny_finds_a_step_at_every_angle() {
        for angle_deg in [
            0.0, 7.0, 12.3, 30.0, 45.0, 60.0, 80.0, 90.0, 135.0, 170.0, 200.0, 315.0,
        ] {
            let (sin, cos) = libm::sincos(rodsight_geometry::radians(angle_deg));
            let rho = 50.0 * (cos + sin) + 0.2;
            let edges = canny(
                &step(100, angle_deg, rho),
                &roi(100, 100),
                &PaperParams::default(),
            );
            // One point per row or column of the edge, whichever are more; corners of the stairs give one more, and an exact
            // diagonal two, as its two equal pixels do not lie along the gradient.
            let length = 100.0;
            assert!(
                edges.len() as f64 > 0.9 * length && (edges.len() as f64) < 2.05 * length,
                "{angle_deg}: {}",
                edges.len()
            );
            for edge in &edges {
                let off = edge.pixel.x * cos + edge.pixel.y * sin - rho;
                assert!(off.abs() < 1.3, "{angle_deg}: {off}");
                let along = f64::from(edge.gradient[0]) * cos + f64::from(edge.gradient[1]) * sin;
                let norm = libm::hypot(f64::from(edge.gradient[0]), f64::from(edge.gradient[1]));
                assert!(along > 0.85 * norm, "{angle_deg}: {:?}", edge.gradient);
            }
        }
    }

    #[test]
    fn canny_of_two_equal_pixels_keeps_the_upper_left_on_both_polarities() {
        // Columns 20..=39 are rod: both edges sit on the pixel left of the step.
        let mask: Vec<u8> = (0..60 * 40)
            .map(|i| if (20..40).contains(&(i % 60)) { 255 } else { 0 })
            .collect();
        let edges = canny(&mask, &roi(60, 40), &PaperParams::default());
        assert_eq!(edges.len(), 80);
        for edge in &edges {
            let expected = if edge.gradient[0] > 0 { 19.5 } else { 39.5 };
            assert_eq!(edge.pixel.x, expected);
        }
    }

    #[test]
    fn canny_hysteresis_follows_all_eight_neighbours_and_drops_the_lonely() {
        // A chain of weak points leaves a strong one in each of the eight directions in turn.
        for (dx, dy) in [
            (-1, -1),
            (0, -1),
            (1, -1),
            (-1, 0),
            (1, 0),
            (-1, 1),
            (0, 1),
            (1, 1),
        ] {
            let mut image = vec![0_u8; 41 * 41];
            let centre = (20_i32, 20_i32);
            for k in 0..8 {
                let (x, y) = (centre.0 + dx * k, centre.1 + dy * k);
                image[(y * 41 + x) as usize] = if k == 0 { 255 } else { 70 };
            }
            let params = PaperParams {
                canny_low: 60.0,
                canny_high: 600.0,
                ..PaperParams::default()
            };
            let edges = canny(&image, &roi(41, 41), &params);
            let reach = edges
                .iter()
                .map(|e| (e.pixel.x - 20.5) * f64::from(dx) + (e.pixel.y - 20.5) * f64::from(dy))
                .fold(f64::MIN, f64::max);
            assert!(reach >= 6.0, "{dx},{dy}: {reach}");
            image[20 * 41 + 20] = 70;
            assert!(canny(&image, &roi(41, 41), &params).is_empty(), "{dx},{dy}");
        }
    }

    #[test]
    fn canny_of_flat_images_and_their_borders_is_empty() {
        for value in [0, 255] {
            assert!(canny(&vec![value; 900], &roi(30, 30), &PaperParams::default()).is_empty());
        }
        assert!(canny(&[255; 4], &roi(2, 2), &PaperParams::default()).is_empty());
    }

    #[test]
    fn canny_blur_keeps_a_step_and_removes_a_speck() {
        let mut mask = step(60, 0.0, 30.0);
        mask[10 * 60 + 10] = 255;
        let params = PaperParams {
            blur_sigma_px: 1.5,
            ..PaperParams::default()
        };
        let edges = canny(&mask, &roi(60, 60), &params);
        assert!(edges.iter().all(|e| (e.pixel.x - 29.5).abs() < 1.1));
        assert!(edges.len() >= 58, "{}", edges.len());
    }
}
