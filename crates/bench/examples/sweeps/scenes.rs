//! Draws, paints and solves the scenes of a sweep.

use std::error::Error;

use rayon::prelude::*;
use rodsight_solver::{Method, SolveError};

use crate::list::Sweep;
use crate::painted::answer::Answer;
use crate::painted::draft::Trial;
use crate::painted::kinds::draft;
use crate::painted::limbs::Limbs;
use crate::rows::Row;

/// A row per value, seed and method.
pub(crate) fn solve_all(sweep: &Sweep, count: usize) -> Result<Vec<Row>, Box<dyn Error>> {
    let values = sweep.values();
    let seeds = seeds(sweep, count)?;
    let scenes: Vec<(&(f64, String), u64)> = values
        .iter()
        .flat_map(|value| seeds.iter().map(move |seed| (value, *seed)))
        .collect();
    let rows: Vec<Vec<Row>> = scenes
        .par_iter()
        .map(|((value, name), seed)| solve_one(sweep, (*value, name), *seed))
        .collect::<Result<_, _>>()?;
    Ok(rows.concat())
}

/// The first seeds whose rod is in both images at every value: what is compared is the same scenes.
fn seeds(sweep: &Sweep, count: usize) -> Result<Vec<u64>, String> {
    let is_seen = |seed: &u64| {
        sweep.values().iter().all(|(value, _)| {
            let mut draft = draft("clean", *seed);
            (sweep.place)(&mut draft, *value);
            draft.seen_at().is_some()
        })
    };
    let tried = 100 * count as u64;
    let found: Vec<u64> = (0..tried).filter(is_seen).take(count).collect();
    if found.len() < count {
        return Err(format!(
            "{}: expected {count} scenes whose rod is in both images at every value, found {} of {tried}",
            sweep.name,
            found.len()
        ));
    }
    Ok(found)
}

fn trial(sweep: &Sweep, value: f64, seed: u64) -> Option<Trial> {
    let mut draft = draft("clean", seed);
    (sweep.place)(&mut draft, value);
    let mut trial = draft.finish()?;
    (sweep.dress)(&mut trial, value);
    Some(trial)
}

fn solve_one(sweep: &Sweep, value: (f64, &str), seed: u64) -> Result<Vec<Row>, SolveError> {
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
            let answer = Answer::of(seed, &trial, &pair, method)?;
            Ok(Row::new(value, &answer, limit.as_ref(), contrast))
        })
        .collect()
}
