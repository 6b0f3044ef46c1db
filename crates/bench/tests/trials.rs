//! Some of the scenes of `--example trials`, of every kind: what is called sure is right.

#[path = "../../solver/tests/common/mod.rs"]
mod common;
#[path = "../examples/trials/drawn.rs"]
mod drawn;

use drawn::{KINDS, Trial, draw};
use nalgebra::Matrix6;
use rayon::prelude::*;
use rodsight_bench::nees;
use rodsight_geometry::Line3;
use rodsight_solver::{Method, PaperParams, Status, solve};

/// With four degrees of freedom one honest answer in ten thousand is farther off.
const WRONG_NEES: f64 = 23.5;
/// Of each kind one scene.
const SEED: u64 = 100;

#[test]
fn what_is_called_sure_is_right() {
    let outcomes: Vec<(&str, Status, Option<f64>)> = KINDS
        .par_iter()
        .filter_map(|kind| {
            let Trial {
                scene,
                request,
                believed,
                target,
            } = draw(kind, SEED)?;
            let mut pair = scene.pair();
            pair.rig = believed;
            let estimate = solve(&request.of(&pair), Method::Joint, &PaperParams::default());
            let estimate = estimate.expect("requests make sense");
            let off = estimate.axis.zip(target).and_then(|(axis, target)| {
                let here = Line3::new(axis.point_m?.into(), &axis.direction?.into());
                let rows = axis.covariance?;
                Some(nees(&here, &Matrix6::from_fn(|i, j| rows[i][j]), &target.axis).value)
            });
            Some((*kind, estimate.status, off))
        })
        .collect();
    let mut sure = 0;
    for (kind, status, off) in &outcomes {
        if *status == Status::Ok {
            sure += 1;
            let off = off.unwrap_or(f64::INFINITY);
            assert!(off < WRONG_NEES, "{kind}: NEES {off}");
        }
    }
    println!("{sure} of {} sure", outcomes.len());
    assert!(
        outcomes.len() == KINDS.len() && 2 * sure > outcomes.len(),
        "{sure}"
    );
}
