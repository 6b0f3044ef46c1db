//! Statistics of many outcomes. Quantiles of χ² and of the binomial are statrs'.

use statrs::distribution::{Beta, ChiSquared, ContinuousCDF};

use crate::nees::Nees;

/// Of honest answers, one in so many is called wrong by [`is_wrong`].
const HONEST_PER_WRONG: f64 = 1e4;

/// The quantile at a share in [0, 1], linear between order statistics (type 7 of Hyndman and Fan 1996); `None` of nothing. Infinite
/// values count as largest; NaN has no place here.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    quantile_of_sorted(&sorted, share)
}

fn quantile_of_sorted(sorted: &[f64], share: f64) -> Option<f64> {
    let place = share.clamp(0.0, 1.0) * (sorted.len().checked_sub(1)? as f64);
    let (low, rest) = (place.floor() as usize, place - place.floor());
    let at = sorted[low];
    // Nothing is taken of the next one where it is not asked for: it may be infinite.
    Some(if rest > 0.0 {
        at + rest * (sorted[low + 1] - at)
    } else {
        at
    })
}

/// A number and the interval that holds the true one with some confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// The number itself.
    pub middle: f64,
    /// Upper end.
    pub high: f64,
}

/// The median and its percentile-bootstrap interval (Efron 1979) of a confidence in (0, 1), from so many resamples drawn by seed: the
/// same on every machine. `None` of nothing.
pub fn median_interval(
    values: &[f64],
    confidence: f64,
    resamples: usize,
    seed: u64,
) -> Option<Interval> {
    let middle = quantile(values, 0.5)?;
    let mut state = seed;
    let mut medians: Vec<f64> = (0..resamples.max(1))
        .filter_map(|_| {
            let drawn: Vec<f64> = values
                .iter()
                .map(|_| values[(next(&mut state) % values.len() as u64) as usize])
                .collect();
            quantile(&drawn, 0.5)
        })
        .collect();
    medians.sort_by(f64::total_cmp);
    let tail = 0.5 * (1.0 - confidence);
    Some(Interval {
        low: quantile_of_sorted(&medians, tail)?,
        middle,
        high: quantile_of_sorted(&medians, 1.0 - tail)?,
    })
}

/// `SplitMix64` (Steele, Lea and Flood 2014).
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// The average NEES per degree of freedom: 1 of honest answers, more of overconfident ones. `None` of nothing.
pub fn anees(all: &[Nees]) -> Option<f64> {
    let dof: usize = all.iter().map(|nees| nees.dof).sum();
    (dof > 0).then(|| all.iter().map(|nees| nees.value).sum::<f64>() / dof as f64)
}

/// The share of answers whose truth lies within the ellipsoid that they claim to hold it with a probability in (0, 1): that
/// probability itself of honest answers. `None` of nothing.
pub fn coverage(all: &[Nees], probability: f64) -> Option<f64> {
    let held = all.iter().filter(|nees| holds(nees, probability)).count();
    (!all.is_empty()).then(|| held as f64 / all.len() as f64)
}

/// Whether the truth lies within the ellipsoid of a probability.
pub fn holds(nees: &Nees, probability: f64) -> bool {
    chi_squared_quantile(nees.dof, probability).is_some_and(|limit| nees.value <= limit)
}

/// Whether an answer is farther off than one honest answer in ten thousand: with four degrees of freedom, NEES above 23.5.
pub fn is_wrong(nees: &Nees) -> bool {
    !holds(nees, 1.0 - 1.0 / HONEST_PER_WRONG)
}

/// What a χ² distributed number of some degrees of freedom stays below with a probability in (0, 1). `None` without degrees of
/// freedom.
pub fn chi_squared_quantile(dof: usize, probability: f64) -> Option<f64> {
    Some(ChiSquared::new(dof as f64).ok()?.inverse_cdf(probability))
}

/// The interval that holds a share of which `hits` of `of` were seen with a confidence in (0, 1), and never less often (Clopper and
/// Pearson 1934). Its upper end at a confidence of 0.9 is the one-sided bound of 95 %. `None` of nothing.
pub fn share_interval(hits: usize, of: usize, confidence: f64) -> Option<[f64; 2]> {
    if of == 0 || hits > of {
        return None;
    }
    let tail = 0.5 * (1.0 - confidence);
    let beta = |a: usize, b: usize, probability: f64| {
        Some(Beta::new(a as f64, b as f64).ok()?.inverse_cdf(probability))
    };
    let low = if hits == 0 {
        0.0
    } else {
        beta(hits, of - hits + 1, tail)?
    };
    let high = if hits == of {
        1.0
    } else {
        beta(hits + 1, of - hits, 1.0 - tail)?
    };
    Some([low, high])
}

/// Efficiency (limit/RMS)² of errors whose limits are known: mean Cramér–Rao variance over mean square error, 1 of the best that can
/// be. Of pairs of (error, limit), both of one unit; `None` of nothing.
pub fn efficiency(errors_and_limits: &[[f64; 2]]) -> Option<f64> {
    let sum = |k: usize| errors_and_limits.iter().map(|v| v[k] * v[k]).sum::<f64>();
    (!errors_and_limits.is_empty()).then(|| sum(1) / sum(0))
}

/// Risk against coverage (El-Yaniv and Wiener 2010): answers in order of their claimed spread, smallest first; after each, the share
/// of `of` scenes that is answered so far and the share of those answers that is lost. Of pairs of (claimed spread, lost).
pub fn risk_coverage(answers: &[(f64, bool)], of: usize) -> Vec<[f64; 2]> {
    let mut sorted = answers.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut lost = 0_u32;
    sorted
        .iter()
        .enumerate()
        .map(|(k, (_, is_lost))| {
            lost += u32::from(*is_lost);
            let answered = (k + 1) as f64;
            [answered / of.max(1) as f64, f64::from(lost) / answered]
        })
        .collect()
}
