//! Ranges of single numbers.

use rodsight_geometry::Vec3;

use crate::SceneError;
use crate::error::Complaints;

/// No scene is larger, m.
const LARGEST_M: f64 = 1e6;

impl Complaints<'_> {
    /// `accepts` must be false for NaN: written as a positive condition it is.
    pub(crate) fn number(
        &self,
        key: &str,
        value: f64,
        expected: &str,
        accepts: impl Fn(f64) -> bool,
    ) -> Result<f64, SceneError> {
        if value.is_finite() && accepts(value) {
            Ok(value)
        } else {
            Err(self.value(key, expected, value))
        }
    }

    pub(crate) fn positive(&self, key: &str, value: f64) -> Result<f64, SceneError> {
        self.number(key, value, "> 0 and finite", |v| v > 0.0)
    }

    /// A length of something: what is smaller or larger is a slip of units, and its square leaves the range of `f64`.
    pub(crate) fn extent(&self, key: &str, value: f64) -> Result<f64, SceneError> {
        self.positive(key, value)?;
        self.number(key, value, "between 1e-6 and 1e6", |v| {
            (1e-6..=LARGEST_M).contains(&v)
        })
    }

    pub(crate) fn not_negative(&self, key: &str, value: f64) -> Result<f64, SceneError> {
        self.number(key, value, ">= 0 and finite", |v| v >= 0.0)
    }

    pub(crate) fn bands(
        &self,
        key: &str,
        bands: [f64; 3],
        expected: &str,
        accepts: impl Fn(f64) -> bool,
    ) -> Result<[f64; 3], SceneError> {
        for (k, value) in bands.into_iter().enumerate() {
            self.number(&format!("{key}[{k}]"), value, expected, &accepts)?;
        }
        Ok(bands)
    }

    pub(crate) fn not_negative_bands(
        &self,
        key: &str,
        bands: [f64; 3],
    ) -> Result<[f64; 3], SceneError> {
        self.bands(key, bands, ">= 0 and finite", |v| v >= 0.0)
    }

    pub(crate) fn albedo(&self, key: &str, bands: [f64; 3]) -> Result<[f64; 3], SceneError> {
        self.bands(key, bands, "between 0 and 1", |v| (0.0..=1.0).contains(&v))
    }

    pub(crate) fn point(&self, key: &str, point: [f64; 3]) -> Result<Vec3, SceneError> {
        let expected = "finite and within -1e6 to 1e6";
        let inside = |v: f64| v.abs() <= LARGEST_M;
        Ok(self.bands(key, point, expected, inside)?.into())
    }

    pub(crate) fn direction(&self, key: &str, direction: [f64; 3]) -> Result<Vec3, SceneError> {
        self.bands(key, direction, "finite", |_| true)?;
        let mut vector = Vec3::from(direction);
        let largest = vector.amax();
        if largest == 0.0 {
            return Err(self.value(key, "a direction, not of zero length", list(direction)));
        }
        if !(1e-3..=1e3).contains(&largest) {
            // Or the squares would leave the range of `f64`.
            vector /= largest;
        }
        let norm = vector.norm();
        // What is a unit vector already stays as it is to the last bit: a resolved scene reads back as itself.
        if (norm - 1.0).abs() <= 4.0 * f64::EPSILON {
            Ok(vector)
        } else {
            Ok(vector / norm)
        }
    }
}

/// `[1, 2, 3]`, as it was typed.
pub(crate) fn list(values: [f64; 3]) -> String {
    format!("[{}, {}, {}]", values[0], values[1], values[2])
}

/// The Fibonacci number nearest to `n`, at least 1.
pub(crate) fn nearest_fibonacci(n: u32) -> u32 {
    let (mut low, mut high) = (1_u32, 2_u32);
    while high < n {
        match low.checked_add(high) {
            Some(next) => (low, high) = (high, next),
            None => return high,
        }
    }
    if n.saturating_sub(low) < high.abs_diff(n) {
        low
    } else {
        high
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fibonacci_nearest() {
        for (n, nearest) in [
            (0, 1),
            (1, 1),
            (2, 2),
            (4, 5),
            (64, 55),
            (88, 89),
            (89, 89),
            (144, 144),
        ] {
            assert_eq!(nearest_fibonacci(n), nearest, "{n}");
        }
        assert_eq!(nearest_fibonacci(u32::MAX), 2_971_215_073);
    }
}
