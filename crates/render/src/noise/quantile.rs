//! The standard normal distribution's quantile.
#![expect(clippy::excessive_precision, reason = "digits as they are published")]

use core::f64::consts::PI;
use std::sync::LazyLock;

/// Cells of the table, equally probable.
const CELLS: usize = 512;
/// Cells at either end in which the quantile is too steep for a cubic: 1.6 % of all draws.
const TAIL: usize = 4;

/// Cubics over the cells: coefficients of 1, s, s², s³ for s in [0, 1).
pub(crate) static CUBICS: LazyLock<Vec<[f64; 4]>> = LazyLock::new(|| {
    let h = 1.0 / CELLS as f64;
    let node = |i: usize| {
        let x = quantile(i as f64 * h);
        // dx/dp = 1/φ(x), over a cell.
        (x, h * (2.0 * PI).sqrt() * libm::exp(0.5 * x * x))
    };
    (0..CELLS)
        .map(|i| {
            if !(TAIL..CELLS - TAIL).contains(&i) {
                return [0.0; 4];
            }
            let ((a, slope_a), (b, slope_b)) = (node(i), node(i + 1));
            let rise = b - a;
            [
                a,
                slope_a,
                3.0 * rise - 2.0 * slope_a - slope_b,
                slope_a + slope_b - 2.0 * rise,
            ]
        })
        .collect()
});

/// The standard normal number of a random word: the quantile of (word + ½)/2³², by Hermite's cubic to 2e-5 and better, in the
/// tails to the last digits.
pub(crate) fn normal(word: u32) -> f64 {
    let cell = (word >> 23) as usize;
    if (TAIL..CELLS - TAIL).contains(&cell) {
        let s = (f64::from(word & 0x7F_FFFF) + 0.5) / 8_388_608.0;
        let [c0, c1, c2, c3] = CUBICS[cell];
        c0 + s * (c1 + s * (c2 + s * c3))
    } else {
        quantile((f64::from(word) + 0.5) / 4_294_967_296.0)
    }
}

/// x with Φ(x) = p for p in (0, 1), to 1e-16 relative: algorithm AS 241, PPND16 (Wichura 1988, Applied Statistics 37, 477).
fn quantile(p: f64) -> f64 {
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        return q * ratio(0.180625 - q * q, &CENTRE);
    }
    let r = (-libm::log(p.min(1.0 - p))).sqrt();
    let x = if r <= 5.0 {
        ratio(r - 1.6, &MIDDLE)
    } else {
        ratio(r - 5.0, &FAR)
    };
    if q < 0.0 { -x } else { x }
}

/// Coefficients of numerator and denominator from the constant up.
type Ratio = [[f64; 8]; 2];

fn ratio(x: f64, [above, below]: &Ratio) -> f64 {
    let polynomial = |c: &[f64; 8]| c.iter().rev().fold(0.0, |sum, c| sum * x + c);
    polynomial(above) / polynomial(below)
}

const CENTRE: Ratio = [
    [
        3.3871328727963666080,
        1.3314166789178437745e2,
        1.9715909503065514427e3,
        1.3731693765509461125e4,
        4.5921953931549871457e4,
        6.7265770927008700853e4,
        3.3430575583588128105e4,
        2.5090809287301226727e3,
    ],
    [
        1.0,
        4.2313330701600911252e1,
        6.8718700749205790830e2,
        5.3941960214247511077e3,
        2.1213794301586595867e4,
        3.9307895800092710610e4,
        2.8729085735721942674e4,
        5.2264952788528545610e3,
    ],
];

const MIDDLE: Ratio = [
    [
        1.42343711074968357734,
        4.63033784615654529590,
        5.76949722146069140550,
        3.64784832476320460504,
        1.27045825245236838258,
        2.41780725177450611770e-1,
        2.27238449892691845833e-2,
        7.74545014278341407640e-4,
    ],
    [
        1.0,
        2.05319162663775882187,
        1.67638483018380384940,
        6.89767334985100004550e-1,
        1.48103976427480074590e-1,
        1.51986665636164571966e-2,
        5.47593808499534494600e-4,
        1.05075007164441684324e-9,
    ],
];

const FAR: Ratio = [
    [
        6.65790464350110377720,
        5.46378491116411436990,
        1.78482653991729133580,
        2.96560571828504891230e-1,
        2.65321895265761230930e-2,
        1.24266094738807843860e-3,
        2.71155556874348757815e-5,
        2.01033439929228813265e-7,
    ],
    [
        1.0,
        5.99832206555887937690e-1,
        1.36929880922735805310e-1,
        1.48753612908506148525e-2,
        7.86869131145613259100e-4,
        1.84631831751005468180e-5,
        1.42151175831644588870e-7,
        2.04426310338993978564e-15,
    ],
];

#[cfg(test)]
mod tests {
    use super::*;

    /// The check values of AS 241, one on each branch.
    #[test]
    fn quantile_has_the_published_values() {
        for (p, x) in [
            (0.25, -0.674_489_750_196_081_7),
            (0.001, -3.090_232_306_167_813_5),
            (1e-20, -9.262_340_089_798_408),
        ] {
            assert!(
                (quantile(p) / x - 1.0).abs() < 1e-15,
                "{p}: {}",
                quantile(p)
            );
        }
    }

    #[test]
    fn table_agrees_with_the_quantile_in_every_cell() {
        let mut worst = 0.0_f64;
        for i in 0..1_u32 << 16 {
            let word = i << 16 | 0x5A5A;
            let exact = quantile((f64::from(word) + 0.5) / 4_294_967_296.0);
            worst = worst.max((normal(word) - exact).abs());
        }
        assert!(worst < 2e-5, "{worst}");
        assert_eq!(normal(0), -normal(u32::MAX));
    }
}
