//! Draws, renders and solves.

use std::error::Error;
use std::path::Path;

use rodsight_solver::{Method, SolveError};

use crate::asked::Failure;
use crate::asked::answer::Answer;
use crate::list::Sweep;
use crate::scenes::draft::Draft;
use crate::swept;
use crate::swept::rows::Row;

/// A row per value, seed and method.
pub(crate) fn solve_all(sweep: &Sweep, count: usize) -> Result<Vec<Row>, Box<dyn Error>> {
    let is_good = |value, seed| sweep.draft(value, seed).finish().is_some();
    swept::solve_all(&sweep.variable, count, is_good, |value, seed| {
        solve_one(sweep.draft(value.0, seed), value, seed)
    })
}

/// Writes the scenes that `joint` is wrong and sure about, for a closer look: `rodsight render` takes them, whole.
pub(crate) fn keep_wrong(
    dir: &Path,
    name: &str,
    rows: &[Row],
    draft: impl Fn(f64, u64) -> Draft,
) -> Result<(), Box<dyn Error>> {
    let wrong = |row: &&Row| row.method == "joint" && row.status == "ok" && row.is_wrong;
    for row in rows.iter().filter(wrong) {
        let file = dir.join(format!("{name}-{}-{}.toml", row.value, row.seed));
        std::fs::write(file, draft(row.value, row.seed).file.to_toml())?;
    }
    Ok(())
}

pub(crate) fn solve_one(draft: Draft, value: (f64, &str), seed: u64) -> Result<Vec<Row>, Failure> {
    let trial = draft
        .finish()
        .ok_or("seeds are of scenes that can be drawn")?;
    let shot = trial.shoot()?;
    Method::ALL
        .into_iter()
        .filter_map(|method| {
            match Answer::of(seed, &trial.asked, Some(&shot.target), &shot.pair, method) {
                // The paper's methods know no ports: they have no row.
                Err(SolveError::Port { .. }) => None,
                answer => Some(answer),
            }
        })
        .map(|answer| {
            let contrast = shot.contrast_to_noise;
            Ok(Row::new(value, &answer?, shot.limit.as_ref(), contrast))
        })
        .collect()
}
