//! The exponential of several numbers at once.
//!
//! The scattering integral is little else than exponentials, and `libm::exp` takes them one by one with branches. Here they
//! go through additions and multiplications side by side, which every machine rounds alike.

/// 1.5 · 2⁵²: adding it rounds a small number to an integer, which is then in the low bits of the sum.
const ROUND: f64 = 6_755_399_441_055_744.0;
/// ln 2 in two pieces; the first has 32 significant bits, so that its product with an exponent is exact.
const LN_2_HIGH: f64 = 6.931_471_803_691_238e-1;
const LN_2_LOW: f64 = 1.908_214_929_270_587_7e-10;

/// e^x of each, within 1e-15 of itself; below −708, where `f64` ends, it is as if x were −708 (3e-308). Only daylight above the rig
/// has x > 0; beyond 709 it is meaningless.
///
///   x = k ln 2 + r, |r| ≤ ½ ln 2;  e^x = 2^k Σ rⁿ/n!
#[inline]
pub(crate) fn exp<const N: usize>(x: &[f64; N]) -> [f64; N] {
    let mut y = *x;
    for value in &mut y {
        *value = exp_1(*value);
    }
    y
}

#[inline]
fn exp_1(x: f64) -> f64 {
    let x = if x < -708.0 { -708.0 } else { x };
    let shifted = x * core::f64::consts::LOG2_E + ROUND;
    let k = shifted - ROUND;
    let r = (x - k * LN_2_HIGH) - k * LN_2_LOW;
    let r2 = r * r;
    let r4 = r2 * r2;
    // In pairs, not in a chain: half as long to wait for.
    let low = (1.0 + r) + r2 * (1.0 / 2.0 + r * (1.0 / 6.0));
    let middle = (1.0 / 24.0 + r * (1.0 / 120.0)) + r2 * (1.0 / 720.0 + r * (1.0 / 5040.0));
    let high = (1.0 / 40_320.0 + r * (1.0 / 362_880.0))
        + r2 * (1.0 / 3_628_800.0 + r * (1.0 / 39_916_800.0));
    let polynomial = low + r4 * (middle + r4 * (high + r4 * (1.0 / 479_001_600.0)));
    // The integer k sits in the low bits of `shifted`; moved to the exponent it is 2^k.
    let power = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1.0_f64.to_bits()));
    polynomial * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exp_agrees_with_libm() {
        let mut worst: f64 = 0.0;
        for k in 0..700_000 {
            let x = -f64::from(k) * 1e-3 - f64::from(k % 7) * 1.234e-5;
            let exact = libm::exp(x);
            worst = worst.max((exp(&[x, x, x])[k as usize % 3] - exact).abs() / exact);
        }
        assert!(worst < 1e-15, "{worst:e}");
        assert_eq!(exp(&[0.0, -0.0, -1e-300]), [1.0; 3]);
        for k in 0..70_000 {
            let x = f64::from(k) * 1e-2 + f64::from(k % 7) * 1.234e-5;
            let relative = exp(&[x])[0] / libm::exp(x) - 1.0;
            assert!(relative.abs() < 1e-15, "{x}: {relative:e}");
        }
        let deep = exp(&[-1e4, f64::NEG_INFINITY, -708.0]);
        assert!(
            deep.iter().all(|&value| value > 0.0 && value < 1e-307),
            "{deep:?}"
        );
        assert!(
            exp(&[f64::NAN, 0.0, 0.0])[0].is_nan(),
            "NaN must not pass for a number"
        );
    }
}
