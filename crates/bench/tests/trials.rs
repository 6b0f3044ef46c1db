//! Some of the scenes of `--example trials`, of every kind: what is called sure is right.

#[path = "../examples/asked/mod.rs"]
mod asked;
#[path = "../examples/painted/mod.rs"]
mod painted;

use asked::answer::Answer;
use painted::kinds::{KINDS, draw};
use rayon::prelude::*;
use rodsight_solver::{Method, Status};

/// Of each kind one scene.
const SEED: u64 = 100;

#[test]
fn what_is_called_sure_is_right() {
    let answers: Vec<(&str, Answer)> = KINDS
        .par_iter()
        .filter_map(|kind| {
            let trial = draw(kind, SEED)?;
            let answer = trial.answer(SEED, &trial.pair(), Method::Joint);
            Some((*kind, answer.expect("requests make sense")))
        })
        .collect();
    let mut sure = 0;
    for (kind, answer) in &answers {
        if answer.status() == Status::Ok {
            sure += 1;
            assert!(!answer.is_wrong(), "{kind}: {:?}", answer.errors);
        }
    }
    println!("{sure} of {} sure", answers.len());
    assert!(
        answers.len() == KINDS.len() && 2 * sure > answers.len(),
        "{sure}"
    );
}
