//! Draws, paints and solves the scenes of a sweep.

use std::error::Error;

use rodsight_solver::Method;

use crate::asked::Failure;
use crate::list::Sweep;
use crate::painted::draft::{Draft, Trial};
use crate::painted::kinds::draft;
use crate::painted::limbs::Limbs;
use crate::swept;
use crate::swept::rows::Row;

/// A row per value, seed and method.
pub(crate) fn solve_all(sweep: &Sweep, count: usize) -> Result<Vec<Row>, Box<dyn Error>> {
    let is_seen = |value, seed| placed(sweep, value, seed).seen_at().is_some();
    swept::solve_all(&sweep.variable, count, is_seen, |value, seed| {
        solve_one(sweep, value, seed)
    })
}

fn placed(sweep: &Sweep, value: f64, seed: u64) -> Draft {
    let mut draft = draft("clean", seed);
    (sweep.place)(&mut draft, value);
    draft
}

fn trial(sweep: &Sweep, value: f64, seed: u64) -> Option<Trial> {
    let mut trial = placed(sweep, value, seed).finish()?;
    (sweep.dress)(&mut trial, value);
    Some(trial)
}

fn solve_one(sweep: &Sweep, value: (f64, &str), seed: u64) -> Result<Vec<Row>, Failure> {
    let Some(trial) = trial(sweep, value.0, seed) else {
        unreachable!("seeds are of scenes that can be drawn");
    };
    let limbs = Limbs::of(&trial.scene);
    let contrast = limbs.contrast_to_noise();
    // The limit is of the images; what the solver is told wrongly of the cameras is not in it.
    let limit = (trial.believed == trial.scene.rig)
        .then(|| limbs.limit(&trial.scene))
        .flatten();
    let pair = trial.pair();
    Method::ALL
        .into_iter()
        .map(|method| {
            let answer = trial.answer(seed, &pair, method)?;
            Ok(Row::new(value, &answer, limit.as_ref(), contrast))
        })
        .collect()
}
