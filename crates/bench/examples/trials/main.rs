//! The joint method on thousands of painted pairs drawn by seed, kind by kind: errors, honesty, refusals, time.
//!
//! `cargo run --release -p rodsight-bench --example trials -- [-n COUNT] [--show] [KIND…]`
//!
//! The painter is that of the solver's tests, not the renderer: other code, other shading, other anti-aliasing.

#![expect(clippy::print_stdout, reason = "it is what it is for")]

#[path = "../../../solver/tests/common/mod.rs"]
mod common;
mod drawn;

use std::error::Error;

use drawn::{KINDS, Trial, draw};
use nalgebra::Matrix6;
use rayon::prelude::*;
use rodsight_bench::nees;
use rodsight_geometry::{Line3, angle_between, degrees};
use rodsight_solver::{Estimate, Method, PaperParams, Status, solve};

/// One in ten thousand honest answers is farther off, with four degrees of freedom.
const WRONG_NEES: f64 = 23.5;

/// What became of a trial.
struct Outcome {
    seed: u64,
    estimate: Estimate,
    /// Axis offset in mm, angle in degrees, NEES, claimed offset in mm.
    errors: Option<[f64; 4]>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let (mut count, mut shows, mut kinds) = (40, false, Vec::new());
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "-n" => count = words.next().ok_or("-n asks for a number")?.parse()?,
            "--show" => shows = true,
            _ => kinds.push(word),
        }
    }
    println!(
        "{:<12} {:>5} {:>5} {:>5} {:>5} | {:>8} {:>8} {:>8} {:>8} | {:>6} {:>6} {:>5} {:>5} | {:>6}",
        "kind",
        "ok",
        "degr",
        "refus",
        "n",
        "med mm",
        "p95 mm",
        "med °",
        "p95 °",
        "ANEES",
        "medNE",
        "wrong",
        "wrDeg",
        "ms"
    );
    for kind in KINDS {
        if !kinds.is_empty() && !kinds.iter().any(|k| k == kind) {
            continue;
        }
        let seeds: Vec<u64> = (0..count).collect();
        let outcomes: Vec<Outcome> = seeds
            .par_iter()
            .filter_map(|seed| outcome(kind, *seed))
            .collect();
        summarise(kind, &outcomes);
        if shows {
            for outcome in &outcomes {
                show(outcome);
            }
        }
    }
    Ok(())
}

fn outcome(kind: &str, seed: u64) -> Option<Outcome> {
    let Trial {
        scene,
        request,
        believed,
        target,
    } = draw(kind, seed)?;
    let mut pair = scene.pair();
    pair.rig = believed;
    let estimate = solve(&request.of(&pair), Method::Joint, &PaperParams::default()).ok()?;
    let errors = estimate.axis.and_then(|axis| {
        let here = Line3::new(axis.point_m?.into(), &axis.direction?.into());
        let there = target?.axis;
        let rows = axis.covariance?;
        let covariance = Matrix6::from_fn(|i, j| rows[i][j]);
        let angle = angle_between(&here.direction, &there.direction);
        let angle = angle.min(core::f64::consts::PI - angle);
        let nees = nees(&here, &covariance, &there).value;
        let claimed = (0..3).map(|k| rows[k][k]).sum::<f64>().sqrt();
        Some([
            1e3 * here.distance_m(&there.point_m),
            degrees(angle),
            nees,
            1e3 * claimed,
        ])
    });
    // An answer where there is no rod is wrong.
    let errors = errors.or_else(|| {
        let invented = target.is_none() && estimate.status != Status::Refused;
        invented.then_some([f64::INFINITY; 4])
    });
    Some(Outcome {
        seed,
        estimate,
        errors,
    })
}

fn summarise(kind: &str, outcomes: &[Outcome]) {
    let status = |status: Status| {
        let all = outcomes.iter().filter(|o| o.estimate.status == status);
        all.count()
    };
    let answered = |o: &&Outcome| o.estimate.status != Status::Refused;
    let column = |k: usize| {
        let all = outcomes.iter().filter(answered);
        let mut values: Vec<f64> = all.filter_map(|o| Some(o.errors?[k])).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let quantile = |values: &[f64], share: f64| {
        let place = (share * values.len() as f64) as usize;
        values
            .get(place.min(values.len().saturating_sub(1)))
            .copied()
            .unwrap_or(f64::NAN)
    };
    let wrong = |status: Status| {
        let all = outcomes.iter().filter(|o| o.estimate.status == status);
        all.filter(|o| o.errors.is_some_and(|e| e[2] > WRONG_NEES))
            .count()
    };
    let (off, angle, nees) = (column(0), column(1), column(2));
    let anees = nees.iter().sum::<f64>() / 4.0 / nees.len().max(1) as f64;
    let mut times: Vec<f64> = outcomes
        .iter()
        .map(|o| o.estimate.timing_ms.total)
        .collect();
    times.sort_by(f64::total_cmp);
    println!(
        "{kind:<12} {:>5} {:>5} {:>5} {:>5} | {:8.4} {:8.3} {:8.4} {:8.4} | {:6.2} {:6.2} {:>5} {:>5} | {:6.0}",
        status(Status::Ok),
        status(Status::Degraded),
        status(Status::Refused),
        outcomes.len(),
        quantile(&off, 0.5),
        quantile(&off, 0.95),
        quantile(&angle, 0.5),
        quantile(&angle, 0.95),
        anees,
        quantile(&nees, 0.5) / 3.357,
        wrong(Status::Ok),
        wrong(Status::Degraded),
        quantile(&times, 0.5),
    );
}

fn show(outcome: &Outcome) {
    let [off, angle, nees, claimed] = outcome.errors.unwrap_or([f64::NAN; 4]);
    println!(
        "  {:4} {:?} {off:.4} mm of {claimed:.4}, {angle:.4}°, NEES {nees:.1}, {}",
        outcome.seed,
        outcome.estimate.status,
        outcome.estimate.reason.as_deref().unwrap_or_default()
    );
}
