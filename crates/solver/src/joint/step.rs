//! The steps of a climb: of the rod, which all pairs share, and of what each pair has of its own.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::drift::{DRIFT, Drift};
use super::state::{ROD, State, UNKNOWNS};

/// What a pair has of its own: blurs and shadows.
const OWN: usize = UNKNOWNS - ROD;

/// What a pair says of its unknowns.
pub(crate) type Normal = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
pub(crate) type Score = SVector<f64, UNKNOWNS>;

/// How likelihood changes with all unknowns: the rod's, then each pair's own, then the drifts.
#[derive(Clone, Debug)]
pub(crate) struct Slopes {
    pub(crate) normal: DMatrix<f64>,
    pub(crate) score: DVector<f64>,
}

/// Where the unknowns of all pairs are.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    pairs: usize,
    /// Of each pair how its rod's unknowns change with its drift, and where that begins.
    drifts: Vec<Option<(usize, SMatrix<f64, ROD, DRIFT>)>>,
    len: usize,
}

impl Layout {
    pub(crate) fn new<'a>(pairs: impl Iterator<Item = (&'a State, Option<&'a Drift>)>) -> Self {
        let all: Vec<_> = pairs.collect();
        let mut len = ROD + OWN * all.len();
        let drifts = all.iter().map(|(state, drift)| {
            let place = drift.map(|drift| (len, drift.of_rod(state)));
            len += place.map_or(0, |_| DRIFT);
            place
        });
        Self {
            drifts: drifts.collect(),
            pairs: all.len(),
            len,
        }
    }

    /// Where an unknown of a pair is among all.
    pub(crate) fn place(pair: usize, k: usize) -> usize {
        if k < ROD { k } else { k + pair * OWN }
    }

    /// The sums of what all pairs say.
    pub(crate) fn gathered(&self, pairs: &[(Normal, Score)]) -> Slopes {
        let mut all = Slopes {
            normal: DMatrix::zeros(self.len, self.len),
            score: DVector::zeros(self.len),
        };
        for (pair, (normal, score)) in pairs.iter().enumerate() {
            let place = |k| Self::place(pair, k);
            for i in 0..UNKNOWNS {
                all.score[place(i)] += score[i];
                for j in 0..UNKNOWNS {
                    all.normal[(place(i), place(j))] += normal[(i, j)];
                }
            }
            let Some((first, by)) = &self.drifts[pair] else {
                continue;
            };
            let of_rod = normal.fixed_columns::<ROD>(0) * by;
            let own = by.transpose() * of_rod.fixed_rows::<ROD>(0);
            let of_score = by.transpose() * score.fixed_rows::<ROD>(0);
            for k in 0..DRIFT {
                all.score[first + k] += of_score[k];
                for i in 0..UNKNOWNS {
                    all.normal[(place(i), first + k)] += of_rod[(i, k)];
                    all.normal[(first + k, place(i))] += of_rod[(i, k)];
                }
                for l in 0..DRIFT {
                    all.normal[(first + k, first + l)] += own[(k, l)];
                }
            }
        }
        all
    }

    /// Adds what is known of drifts.
    pub(crate) fn add_drifts<'a>(
        &self,
        all: &mut Slopes,
        drifts: impl Iterator<Item = Option<&'a Drift>>,
    ) {
        for (drift, place) in drifts.zip(&self.drifts) {
            let (Some(drift), Some((first, _))) = (drift, place) else {
                continue;
            };
            for k in 0..DRIFT {
                let weight = 1.0 / (drift.sigmas[k] * drift.sigmas[k]);
                all.normal[(first + k, first + k)] += weight;
                all.score[first + k] -= weight * drift.by[k];
            }
        }
    }

    /// The step of a pair's unknowns, its rod's as it sees it.
    pub(crate) fn of_pair(&self, step: &DVector<f64>, pair: usize) -> Score {
        let mut own = Score::from_fn(|k, _| step[Self::place(pair, k)]);
        if let Some((first, by)) = &self.drifts[pair] {
            let moved = by * step.fixed_rows::<DRIFT>(*first);
            let mut rod = own.fixed_rows_mut::<ROD>(0);
            rod += moved;
        }
        own
    }

    /// The step of a pair's drift.
    pub(crate) fn of_drift(&self, step: &DVector<f64>, pair: usize) -> SVector<f64, DRIFT> {
        self.drifts[pair].map_or_else(SVector::zeros, |(first, _)| {
            step.fixed_rows::<DRIFT>(first).into()
        })
    }

    /// The least and the most that a step may be.
    pub(crate) fn bounds<'a>(&self, states: impl Iterator<Item = &'a State>) -> [DVector<f64>; 2] {
        let mut ends = [f64::NEG_INFINITY, f64::INFINITY].map(|end| DVector::repeat(self.len, end));
        for (pair, state) in states.enumerate().take(self.pairs) {
            for (all, own) in ends.iter_mut().zip(state.bounds()) {
                for k in 0..UNKNOWNS {
                    all[Self::place(pair, k)] = own[k];
                }
            }
        }
        ends
    }
}

impl Slopes {
    /// Damped as Levenberg and Marquardt have it.
    pub(crate) fn damped(&self, damping: f64) -> Self {
        let mut damped = self.clone();
        for k in 0..self.score.len() {
            damped.normal[(k, k)] += damping * self.normal[(k, k)] + f64::MIN_POSITIVE;
        }
        damped
    }

    /// With an unknown that may not change.
    pub(crate) fn hold(&mut self, k: usize) {
        self.normal.row_mut(k).fill(0.0);
        self.normal.column_mut(k).fill(0.0);
        (self.normal[(k, k)], self.score[k]) = (1.0, 0.0);
    }

    /// The step to the best of what may be: what would go beyond ends there, and the others step as is best then.
    pub(crate) fn bounded(&self, [least, most]: &[DVector<f64>; 2]) -> Option<DVector<f64>> {
        let mut held = vec![None; self.score.len()];
        loop {
            let mut free = self.clone();
            for (k, held) in held.iter().enumerate() {
                if let Some(by) = held {
                    free.score -= self.normal.column(k) * *by;
                }
            }
            for (k, held) in held.iter().enumerate() {
                if let Some(by) = held {
                    free.hold(k);
                    free.score[k] = *by;
                }
            }
            let step = free.best()?;
            let mut is_within = true;
            let free = held.iter_mut().enumerate().filter(|(_, by)| by.is_none());
            for (k, held) in free {
                let end = step[k].clamp(least[k], most[k]);
                if end != step[k] {
                    *held = Some(end);
                    is_within = false;
                }
            }
            if is_within {
                return Some(step);
            }
        }
    }

    /// By how much likelier a step is as far as slopes tell.
    pub(crate) fn gain(&self, step: &DVector<f64>) -> f64 {
        step.dot(&self.score) - 0.5 * step.dot(&(&self.normal * step))
    }

    /// The step where slopes vanish, after scaling to a unit diagonal: metres and radians differ by orders of magnitude.
    pub(crate) fn best(&self) -> Option<DVector<f64>> {
        let Self { normal, score } = self;
        let scale = normal
            .diagonal()
            .map(|v| 1.0 / v.max(f64::MIN_POSITIVE).sqrt());
        let scaled = DMatrix::from_fn(score.len(), score.len(), |i, j| {
            normal[(i, j)] * scale[i] * scale[j] + if i == j { 1e-12 } else { 0.0 }
        });
        let step = scaled.cholesky()?.solve(&score.component_mul(&scale));
        let step = step.component_mul(&scale);
        step.iter().all(|v| v.is_finite()).then_some(step)
    }
}
