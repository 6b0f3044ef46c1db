//! Units of noise: what sums of channels are to be divided by.

use nalgebra::{Matrix3, Vector3};

use super::sums::Colours;

/// Turns sums of channels into independent ones of unit variance.
pub(crate) struct Whitening(pub(crate) Matrix3<f64>);

impl Whitening {
    /// From values of each channel, largest ones cut off: edges are few. `floor` is noise below which nothing is measured.
    pub(crate) fn of(values: &[Vec<f64>], floor: f64) -> Self {
        let channels = values.len();
        let cuts: Vec<f64> = values
            .iter()
            .map(|values| {
                let mut sizes: Vec<f64> = values.iter().map(|v| v.abs()).collect();
                if sizes.is_empty() {
                    return floor;
                }
                let middle = sizes.len() / 2;
                let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
                (1.4826 * *median).max(floor)
            })
            .collect();
        let count = values.first().map_or(1, |v| v.len().max(1)) as f64;
        let covariance = Matrix3::from_fn(|i, j| {
            if i >= channels || j >= channels {
                return f64::from(u8::from(i == j));
            }
            let cut = |v: f64, cut: f64| v.clamp(-3.0 * cut, 3.0 * cut);
            let sum: f64 = (values[i].iter().zip(&values[j]))
                .map(|(a, b)| cut(*a, cuts[i]) * cut(*b, cuts[j]))
                .sum();
            let least = floor * floor + 1e-4 * cuts[i] * cuts[i];
            sum / count + if i == j { least } else { 0.0 }
        });
        // A covariance whose diagonal was added to has a factor, and the factor an inverse.
        let factor = covariance.cholesky().map(|factor| factor.l());
        let inverse = factor.and_then(Matrix3::try_inverse);
        Self(inverse.unwrap_or_else(|| {
            Matrix3::from_diagonal(&covariance.diagonal().map(|v| 1.0 / v.sqrt()))
        }))
    }

    /// Of a step its best axis: wᵀ I is what its whitened colours have in common with those of I (Fisher's discriminant).
    pub(crate) fn axis(&self, step: &Colours) -> [f64; 3] {
        let axis = self.0.tr_mul(&Vector3::from(step.map(f64::from)));
        axis.normalize().into()
    }
}
