//! The joint method on thousands of painted pairs drawn by seed, kind by kind: errors, honesty, refusals, time.
//!
//! `cargo run --release -p rodsight-bench --example trials -- [-n COUNT] [--show] [-o DIR] [--heave METRES] [KIND…]`
//!
//! With `--heave` there is a second pair of each rod, from so much higher.
//!
//! With `-o`, every outcome goes to `outcomes.csv`, how often each reason was given to `reasons.csv`, and risk against coverage and the
//! coverage of the claimed ellipsoids are drawn (`risk_coverage.svg`, `coverage.svg`).

#![expect(clippy::print_stdout, reason = "it is what it is for")]

#[path = "../asked/mod.rs"]
mod asked;
#[path = "../chart/mod.rs"]
mod chart;
mod files;
#[path = "../painted/mod.rs"]
mod painted;
mod plots;

use std::error::Error;
use std::path::PathBuf;

use asked::answer::Answer;
use painted::kinds::{KINDS, draw};
use rayon::prelude::*;
use rodsight_bench::statistics::{anees, quantile, share_interval};
use rodsight_geometry::{Mat3, Pose, Vec3};
use rodsight_solver::{Method, MovedPair, SolveError, Status};

/// The median of χ² with four degrees of freedom.
const MEDIAN_NEES: f64 = 3.357;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut count, mut shows, mut kinds, mut out) = (40, false, Vec::new(), None);
    let mut heave_m: Option<f64> = None;
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        match word.as_str() {
            "-n" => count = words.next().ok_or("-n asks for a number")?.parse()?,
            "-o" => out = Some(PathBuf::from(words.next().ok_or("-o asks for a folder")?)),
            "--show" => shows = true,
            "--heave" => {
                heave_m = Some(words.next().ok_or("--heave asks for metres")?.parse()?);
            }
            _ if KINDS.contains(&word.as_str()) => kinds.push(word),
            _ => return Err(format!("expected one of {KINDS:?}, found `{word}`").into()),
        }
    }
    if let Some(dir) = &out {
        std::fs::create_dir_all(dir)?;
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
    let mut all = Vec::new();
    for kind in KINDS {
        if !kinds.is_empty() && !kinds.iter().any(|k| k == kind) {
            continue;
        }
        let answers: Vec<Answer> = (0..count)
            .into_par_iter()
            .filter_map(|seed| answer(kind, seed, heave_m).transpose())
            .collect::<Result<_, _>>()?;
        summarise(kind, &answers);
        if shows {
            answers.iter().for_each(show);
        }
        all.push((kind, answers));
    }
    println!("{}", confidently_wrong(&all));
    if let Some(dir) = out {
        files::write(&dir, &all)?;
        plots::draw(&dir, &all)?;
    }
    Ok(())
}

/// `None` where the rod is not in all images.
fn answer(kind: &str, seed: u64, heave_m: Option<f64>) -> Result<Option<Answer>, SolveError> {
    let Some(trial) = draw(kind, seed) else {
        return Ok(None);
    };
    let pair = trial.pair();
    let Some(up_m) = heave_m else {
        return trial.answer(seed, &pair, Method::Joint).map(Some);
    };
    let rig_from_moved = Pose::new(Mat3::identity(), Vec3::new(0.0, 0.0, -up_m));
    let Some(higher) = trial.moved(&rig_from_moved) else {
        return Ok(None);
    };
    let second = higher.pair();
    let [roi_left, roi_right] = higher.request.regions;
    let more = [MovedPair {
        roi_left,
        roi_right,
        ..MovedPair::new(&second, rig_from_moved)
    }];
    trial
        .answer_all(seed, &pair, &more, Method::Joint)
        .map(Some)
}

fn with(answers: &[Answer], status: Status) -> impl Iterator<Item = &Answer> {
    answers.iter().filter(move |a| a.status() == status)
}

fn summarise(kind: &str, answers: &[Answer]) {
    let at = |values: &[f64], share: f64| quantile(values, share).unwrap_or(f64::NAN);
    let off: Vec<f64> = answers.iter().filter_map(Answer::offset_mm).collect();
    let angle: Vec<f64> = answers.iter().filter_map(Answer::angle_deg).collect();
    let all_nees: Vec<_> = answers.iter().filter_map(Answer::nees).collect();
    let nees: Vec<f64> = all_nees.iter().map(|nees| nees.value).collect();
    let times: Vec<f64> = answers.iter().map(|a| a.estimate.timing_ms.total).collect();
    let wrong = |status| with(answers, status).filter(|a| a.is_wrong()).count();
    println!(
        "{kind:<12} {:>5} {:>5} {:>5} {:>5} | {:8.4} {:8.3} {:8.4} {:8.4} | {:6.2} {:6.2} {:>5} {:>5} | {:6.0}",
        with(answers, Status::Ok).count(),
        with(answers, Status::Degraded).count(),
        with(answers, Status::Refused).count(),
        answers.len(),
        at(&off, 0.5),
        at(&off, 0.95),
        at(&angle, 0.5),
        at(&angle, 0.95),
        anees(&all_nees).unwrap_or(f64::NAN),
        at(&nees, 0.5) / MEDIAN_NEES,
        wrong(Status::Ok),
        wrong(Status::Degraded),
        at(&times, 0.5),
    );
}

/// How many of the answers that are called ok are wrong, and how many there may be; `everything` draws the others again.
fn confidently_wrong(all: &[(&str, Vec<Answer>)]) -> String {
    let answers = || all.iter().flat_map(|(_, answers)| answers);
    let ok = answers().filter(|a| a.status() == Status::Ok);
    let (of, wrong) = ok.fold((0, 0), |(of, wrong), a| {
        (of + 1, wrong + usize::from(a.is_wrong()))
    });
    let scenes = answers().count();
    let bound = |of: usize| {
        share_interval(wrong, of, 0.9).map_or("unknown".to_owned(), |[_, high]| {
            format!("{:.3} %", 100.0 * high)
        })
    };
    format!(
        "ok and wrong: {wrong} of {of} ok, below {} at 95 % confidence (Clopper–Pearson, one-sided); of {scenes} scenes, below {}",
        bound(of),
        bound(scenes),
    )
}

fn show(answer: &Answer) {
    println!(
        "  {:4} {:?} {:.4} mm of {:.4}, {:.4}°, NEES {:.1}, {}",
        answer.seed,
        answer.status(),
        answer.offset_mm().unwrap_or(f64::NAN),
        1e3 * answer.claimed_offset_m.unwrap_or(f64::NAN),
        answer.angle_deg().unwrap_or(f64::NAN),
        answer.nees().map_or(f64::NAN, |nees| nees.value),
        answer.estimate.reason.as_deref().unwrap_or_default()
    );
}
