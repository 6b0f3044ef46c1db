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

#[cfg(test)]
mod tests {
    use rodsight_geometry::{Cylinder, Line3, Vec3};

    use super::*;
    use crate::MoveSigma;

    fn state() -> State {
        let cylinder = Cylinder {
            axis: Line3::new(Vec3::new(1.5, 0.1, -0.2), &Vec3::new(0.3, 0.2, 1.0)),
            radius_m: 0.05,
        };
        State::new(cylinder, 0.2)
    }

    fn drift() -> Drift {
        let sigma = MoveSigma {
            translation_m: 0.01,
            rotation_rad: 0.005,
        };
        Drift::new(&sigma, Vec3::zeros())
    }

    /// A definite matrix and a score, different for each pair.
    fn said(pair: usize) -> (Normal, Score) {
        let wave = |i: usize, j: usize| libm::sin(1.7 * (i * UNKNOWNS + j + 31 * pair) as f64);
        let root = Normal::from_fn(|i, j| wave(i, j) + if i == j { 4.0 } else { 0.0 });
        (root * root.transpose(), Score::from_fn(|i, _| wave(i, 99)))
    }

    /// What all pairs gain by a step is what each gains by its own, drifts and all.
    #[test]
    fn gains_are_sums_of_those_of_pairs() {
        let (state, drift) = (state(), drift());
        let layout =
            Layout::new([(&state, None), (&state, Some(&drift)), (&state, None)].into_iter());
        let pairs = [said(0), said(1), said(2)];
        let all = layout.gathered(&pairs);
        assert_eq!(all.score.len(), ROD + 3 * OWN + DRIFT);
        let step = DVector::from_fn(all.score.len(), |k, _| 0.01 * libm::cos(k as f64));
        let own = pairs.iter().enumerate().map(|(pair, (normal, score))| {
            let step = layout.of_pair(&step, pair);
            step.dot(score) - 0.5 * step.dot(&(normal * step))
        });
        let own: f64 = own.sum();
        assert!((all.gain(&step) - own).abs() < 1e-12, "{own}");
        // The rod's step is shared, but for what drifts.
        let rods = [0, 1, 2].map(|pair| {
            layout
                .of_pair(&step, pair)
                .fixed_rows::<ROD>(0)
                .into_owned()
        });
        assert_eq!(rods[0], rods[2]);
        let drifted = drift.of_rod(&state) * layout.of_drift(&step, 1);
        assert!((rods[1] - rods[0] - drifted).norm() < 1e-15 && drifted.norm() > 1e-4);
    }

    /// A pair that may be anywhere says nothing of where a straight rod is, and one that may not says as much as ever.
    #[test]
    fn drifts_take_what_is_known_of_them() {
        let (state, drift) = (state(), drift());
        let of_rod = |sigma: Option<f64>| {
            let drift = sigma.map(|sigma| {
                let mut drift = drift;
                drift.sigmas.fill(sigma);
                drift
            });
            let layout = Layout::new([(&state, None), (&state, drift.as_ref())].into_iter());
            let mut all = layout.gathered(&[said(0), said(1)]);
            layout.add_drifts(&mut all, [None, drift.as_ref()].into_iter());
            let inverse = all.normal.try_inverse().expect("a definite matrix");
            inverse.fixed_view::<4, 4>(0, 0).trace()
        };
        let (exact, nearly) = (of_rod(None), of_rod(Some(1e-7)));
        assert!((nearly / exact - 1.0).abs() < 1e-6, "{nearly} {exact}");
        let doubtful = [0.01, 0.1, 1.0, 100.0].map(|sigma| of_rod(Some(sigma)));
        let mut before = exact;
        for variance in doubtful {
            assert!(variance > before, "{doubtful:?} {exact}");
            before = variance;
        }
    }

    /// No step leaves its bounds, and what is bound is at one of them or where slopes vanish.
    #[test]
    fn steps_stay_within_bounds() {
        let state = state();
        let layout = Layout::new([(&state, None), (&state, None)].into_iter());
        let all = layout.gathered(&[said(0), said(1)]);
        let free = all.best().expect("a step");
        let most = 0.5 * free.amax();
        let ends = [-most, most].map(|end| DVector::repeat(free.len(), end));
        let step = all.bounded(&ends).expect("a step");
        let slopes = &all.score - &all.normal * &step;
        let mut held = 0;
        for (by, slope) in step.iter().zip(&slopes) {
            assert!(by.abs() <= most * (1.0 + 1e-12));
            if by.abs() > most * (1.0 - 1e-9) {
                held += 1;
            } else {
                assert!(slope.abs() < 1e-9, "{slope}");
            }
        }
        assert!(held > 0 && free.amax() > most);
    }
}
