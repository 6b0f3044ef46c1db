//! Statistics against numbers computed by hand, closed forms and tables.

use nalgebra::Matrix6;
use rodsight_bench::statistics::{
    anees, chi_squared_quantile, coverage, efficiency, is_wrong, median_interval, quantile,
    risk_coverage, share_interval,
};
use rodsight_bench::{Located, Nees};
use rodsight_geometry::{Line3, Vec3};

#[track_caller]
fn close(found: Option<f64>, expected: f64, tolerance: f64) {
    let found = found.expect("a number");
    assert!(
        (found - expected).abs() <= tolerance,
        "{found} instead of {expected}"
    );
}

fn nees(value: f64, dof: usize) -> Nees {
    Nees { value, dof }
}

#[test]
fn quantiles_lie_between_order_statistics() {
    let values = [4.0, 1.0, 3.0, 2.0];
    for (share, expected) in [(0.0, 1.0), (0.5, 2.5), (0.95, 3.85), (1.0, 4.0)] {
        close(quantile(&values, share), expected, 1e-12);
    }
    // What is lost is largest, and spoils nothing below it.
    close(quantile(&[1.0, 2.0, f64::INFINITY], 0.5), 2.0, 0.0);
    assert_eq!(quantile(&[], 0.5), None);
}

#[test]
fn bootstrap_holds_the_median_as_often_as_it_says() {
    // Uniform numbers by the golden ratio's multiples, cut into samples of 41.
    let uniform = |k: u32| (f64::from(k) * 0.618_033_988_749_895).fract();
    let mut state = 7_u32;
    let mut random = || {
        state = state.wrapping_mul(1664525).wrapping_add(1013904223);
        uniform(state >> 8)
    };
    let samples: Vec<Vec<f64>> = (0..400)
        .map(|_| (0..41).map(|_| random()).collect())
        .collect();
    let held = samples
        .iter()
        .filter(|sample| {
            let interval = median_interval(sample, 0.95, 300, 1).expect("a median");
            assert!(interval.low <= interval.middle && interval.middle <= interval.high);
            interval.low <= 0.5 && 0.5 <= interval.high
        })
        .count();
    // Of 400 at 95 %, 380 ± 4.4; the percentile interval of a median is known to be a little short or long at such sizes.
    assert!((360..=396).contains(&held), "{held}");
    assert_eq!(
        median_interval(&samples[0], 0.95, 300, 3),
        median_interval(&samples[0], 0.95, 300, 3)
    );
    assert_eq!(median_interval(&[], 0.95, 300, 1), None);
}

#[test]
fn chi_squared_is_the_tables() {
    // Abramowitz and Stegun 1964, table 26.8.
    for (dof, probability, expected) in [
        (1, 0.95, 3.84146),
        (4, 0.5, 3.35670),
        (4, 0.95, 9.48773),
        (4, 0.9999, 23.5127),
    ] {
        close(chi_squared_quantile(dof, probability), expected, 1e-4);
    }
    assert_eq!(chi_squared_quantile(0, 0.5), None);
    assert!(is_wrong(&nees(23.6, 4)) && !is_wrong(&nees(23.4, 4)));
    // Certain of what is not so.
    assert!(is_wrong(&nees(f64::INFINITY, 4)) && is_wrong(&nees(0.0, 0)));
}

#[test]
fn honesty_is_counted_per_degree_of_freedom() {
    let all = [nees(2.0, 4), nees(10.0, 4), nees(3.0, 2), nees(5.0, 2)];
    close(anees(&all), 20.0 / 12.0, 1e-12);
    // Of χ² with 4 and 2 degrees of freedom 95 % are below 9.49 and 5.99.
    close(coverage(&all, 0.95), 0.75, 0.0);
    assert_eq!((anees(&[]), coverage(&[], 0.95)), (None, None));
}

#[test]
fn shares_are_bounded_as_published() {
    // None of n: 1 − (α/2)^{1/n}.
    let [low, high] = share_interval(0, 3000, 0.9).expect("a share");
    assert_eq!(low, 0.0);
    close(Some(high), 1.0 - libm::pow(0.05, 1.0 / 3000.0), 1e-9);
    // Ten of a hundred: 4.900 % to 17.622 %.
    let [low, high] = share_interval(10, 100, 0.95).expect("a share");
    close(Some(low), 0.049005, 1e-6);
    close(Some(high), 0.176223, 1e-6);
    let [low, high] = share_interval(100, 100, 0.95).expect("a share");
    close(Some(low), libm::pow(0.025, 0.01), 1e-9);
    assert_eq!(high, 1.0);
    assert_eq!(share_interval(0, 0, 0.95), None);
    assert_eq!(share_interval(2, 1, 0.95), None);
}

#[test]
fn efficiency_is_a_ratio_of_variances() {
    close(efficiency(&[[2.0, 1.0], [4.0, 3.0]]), 10.0 / 20.0, 1e-12);
    assert_eq!(efficiency(&[]), None);
}

#[test]
fn risk_rises_with_coverage_where_claims_are_worth_something() {
    let answers = [(3.0, true), (1.0, false), (2.0, false)];
    let curve = risk_coverage(&answers, 4);
    assert_eq!(curve, [[0.25, 0.0], [0.5, 0.0], [0.75, 1.0 / 3.0]]);
}

#[test]
fn claimed_offset_grows_along_the_axis() {
    // 3 mm in y, 4 mm in z; 0.01 rad in y; the point errs with the direction; along the axis it is anywhere.
    let mut covariance = Matrix6::zeros();
    covariance[(0, 0)] = 1.0;
    covariance[(0, 4)] = 0.1;
    covariance[(4, 0)] = 0.1;
    covariance[(1, 1)] = 9e-6;
    covariance[(2, 2)] = 16e-6;
    covariance[(4, 4)] = 1e-4;
    covariance[(1, 4)] = 1e-5;
    covariance[(4, 1)] = 1e-5;
    let located = Located {
        covariance: Some(covariance),
        ..Located::of_axis(Line3::new(Vec3::zeros(), &Vec3::x()))
    };
    close(
        located.claimed_offset_m(&Vec3::new(0.0, 0.2, 0.0)),
        0.005,
        1e-12,
    );
    // 25e-6 + 2·0.5·1e-5 + 0.25·1e-4.
    let farther = located.claimed_offset_m(&Vec3::new(0.5, 0.2, 0.0));
    close(farther, libm::sqrt(60e-6), 1e-12);
    assert_eq!(
        Located::of_axis(located.axis).claimed_offset_m(&Vec3::zeros()),
        None
    );
}
