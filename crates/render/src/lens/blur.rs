//! Gaussian blur of an image.

use rayon::prelude::*;

/// Blurs each band by a standard deviation of its own; 0 leaves it to the last bit. Beyond its border the image is taken to go on
/// as its outermost pixels are.
pub(super) fn gaussian(light: &mut Vec<[f32; 3]>, width: usize, sigma_px: [f64; 3]) {
    if sigma_px == [0.0; 3] {
        return;
    }
    let kernels = sigma_px.map(kernel);
    let height = light.len() / width;
    let rows = blurred(light, &kernels, |index, step| {
        let (column, row) = (index % width, index / width);
        row * width + clamped(column, step, width)
    });
    *light = blurred(&rows, &kernels, |index, step| {
        let (column, row) = (index % width, index / width);
        clamped(row, step, height) * width + column
    });
}

fn clamped(index: usize, step: isize, size: usize) -> usize {
    index.saturating_add_signed(step).min(size - 1)
}

fn blurred(
    from: &[[f32; 3]],
    kernels: &[Vec<f64>; 3],
    neighbour: impl Fn(usize, isize) -> usize + Sync,
) -> Vec<[f32; 3]> {
    let pixels = (0..from.len()).into_par_iter().map(|index| {
        [0, 1, 2].map(|k| {
            let there = |step: isize| f64::from(from[neighbour(index, step)][k]);
            let sides = kernels[k].iter().zip(0_isize..).skip(1);
            let sum: f64 = sides
                .map(|(w, step)| w * (there(-step) + there(step)))
                .sum();
            (kernels[k][0] * there(0) + sum) as f32
        })
    });
    pixels.collect()
}

/// Weights at 0, 1, 2, … px: the discrete Gaussian e^(−t) Iₙ(t), t = σ² (Lindeberg 1990). Its variance is σ² at any σ, where a
/// sampled Gaussian of less than half a pixel has none. By Miller's backward recurrence Iₙ₋₁ = Iₙ₊₁ + 2n/t Iₙ.
pub(crate) fn kernel(sigma_px: f64) -> Vec<f64> {
    if sigma_px == 0.0 {
        return vec![1.0];
    }
    let t = sigma_px * sigma_px;
    let reach = libm::ceil(6.0 * sigma_px) as usize + 5;
    let mut values = vec![0.0; reach + 16];
    let last = values.len() - 1;
    values[last - 1] = 1e-300;
    for n in (1..last).rev() {
        values[n - 1] = values[n + 1] + 2.0 * n as f64 / t * values[n];
        if values[n - 1] > 1e200 {
            values[n - 1..].iter_mut().for_each(|v| *v *= 1e-250);
        }
    }
    values.truncate(reach);
    let sum = values[0] + 2.0 * values[1..].iter().sum::<f64>();
    values.iter().map(|v| v / sum).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernel_sums_to_one_with_the_variance_asked_for() {
        for sigma_px in [0.05, 0.2, 0.5, 1.0, 3.0, 20.0] {
            let weights = kernel(sigma_px);
            let moment = |power: i32| -> f64 {
                let terms = weights.iter().enumerate().skip(1);
                terms.map(|(n, w)| 2.0 * w * (n as f64).powi(power)).sum()
            };
            assert!((weights[0] + moment(0) - 1.0).abs() < 1e-14, "{sigma_px}");
            let variance = moment(2) / (sigma_px * sigma_px);
            assert!((variance - 1.0).abs() < 1e-6, "{sigma_px}: {variance}");
        }
    }

    /// The edge spread of a Gaussian is the error function, at pixel centres half a pixel from the edge.
    #[test]
    fn an_edge_becomes_the_error_function_and_stays_where_it_is() {
        let (width, sigma_px) = (41, 1.5);
        let mut light: Vec<[f32; 3]> = (0..width * 3)
            .map(|i| {
                if i % width < 20 {
                    [0.0; 3]
                } else {
                    [1.0, 2.0, 3.0]
                }
            })
            .collect();
        gaussian(&mut light, width, [sigma_px; 3]);
        for column in 0..width {
            let distance_px = column as f64 + 0.5 - 20.0;
            let expected = 0.5 + 0.5 * libm::erf(distance_px / (sigma_px * 2.0_f64.sqrt()));
            let found = f64::from(light[width + column][1]) / 2.0;
            // The pixel's own width is in the closed form but for a twelfth of the variance.
            assert!(
                (found - expected).abs() < 0.02,
                "{column}: {found} {expected}"
            );
        }
        let mass: f64 = light[width..2 * width]
            .iter()
            .map(|p| f64::from(p[0]))
            .sum();
        assert!(
            (mass - 21.0).abs() < 1e-5,
            "the edge has moved by {}",
            mass - 21.0
        );
    }
}
