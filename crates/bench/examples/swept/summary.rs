//! What a sweep's rows come to, value by value and method by method.

use rodsight_bench::Nees;
use rodsight_bench::statistics::{
    Interval, anees, coverage, efficiency, median_interval, quantile,
};
use rodsight_solver::Method;

use super::rows::Row;
use super::variable::Variable;

const RESAMPLES: usize = 1000;

/// Of one value of the variable.
pub(crate) struct Summary {
    pub(crate) value: f64,
    pub(crate) name: String,
    /// Median Cramér–Rao limit of the axis offset, mm; none where it is not known of every scene.
    pub(crate) limit_mm: Option<f64>,
    /// As [`Method::ALL`].
    pub(crate) methods: Vec<MethodSummary>,
}

pub(crate) struct MethodSummary {
    pub(crate) method: Method,
    pub(crate) scenes: usize,
    pub(crate) ok: usize,
    pub(crate) degraded: usize,
    /// Axis offset of what is answered, mm, with its bootstrap interval of 95 %.
    pub(crate) median_mm: Option<Interval>,
    pub(crate) p95_mm: Option<f64>,
    pub(crate) median_deg: Option<f64>,
    pub(crate) p95_deg: Option<f64>,
    pub(crate) ok_and_wrong: usize,
    pub(crate) degraded_and_wrong: usize,
    pub(crate) anees: Option<f64>,
    pub(crate) coverage_95: Option<f64>,
    /// Of what is called ok and whose limit is known.
    pub(crate) efficiency: Option<f64>,
}

impl MethodSummary {
    pub(crate) fn refused(&self) -> usize {
        self.scenes - self.ok - self.degraded
    }

    pub(crate) fn answered_share(&self) -> f64 {
        (self.ok + self.degraded) as f64 / self.scenes.max(1) as f64
    }
}

impl Summary {
    /// In the order of the variable's values; values without rows are left out.
    pub(crate) fn of(variable: &Variable, rows: &[Row]) -> Vec<Self> {
        variable
            .values()
            .into_iter()
            .filter_map(|(value, name)| {
                let here: Vec<&Row> = rows.iter().filter(|row| row.value == value).collect();
                let limits: Option<Vec<f64>> = here.iter().map(|row| row.limit_offset_mm).collect();
                (!here.is_empty()).then(|| Self {
                    value,
                    name,
                    limit_mm: limits.and_then(|limits| quantile(&limits, 0.5)),
                    methods: Method::ALL.map(|method| summarise(method, &here)).into(),
                })
            })
            .collect()
    }

    pub(crate) fn method(&self, method: Method) -> Option<&MethodSummary> {
        self.methods.iter().find(|of| of.method == method)
    }
}

pub(crate) fn summarise(method: Method, rows: &[&Row]) -> MethodSummary {
    let mine: Vec<&Row> = rows
        .iter()
        .copied()
        .filter(|row| row.method == method.name())
        .collect();
    let with = |status: &str| mine.iter().filter(|row| row.status == status).count();
    let wrong = |status: &str| {
        let wrong = mine.iter().filter(|row| row.is_wrong);
        wrong.filter(|row| row.status == status).count()
    };
    let answered = || mine.iter().filter(|row| row.is_answered());
    let ok = || mine.iter().filter(|row| row.status == "ok");
    let off_mm: Vec<f64> = answered().filter_map(|row| row.offset_mm).collect();
    let off_deg: Vec<f64> = answered().filter_map(|row| row.angle_deg).collect();
    let nees: Vec<Nees> = answered().filter_map(|row| row.nees()).collect();
    let against: Vec<[f64; 2]> = ok()
        .filter_map(|row| Some([row.offset_mm?, row.limit_offset_mm?]))
        .collect();
    MethodSummary {
        method,
        scenes: mine.len(),
        ok: with("ok"),
        degraded: with("degraded"),
        median_mm: median_interval(&off_mm, 0.95, RESAMPLES, 1),
        p95_mm: quantile(&off_mm, 0.95),
        median_deg: quantile(&off_deg, 0.5),
        p95_deg: quantile(&off_deg, 0.95),
        ok_and_wrong: wrong("ok"),
        degraded_and_wrong: wrong("degraded"),
        anees: anees(&nees),
        coverage_95: coverage(&nees, 0.95),
        efficiency: efficiency(&against),
    }
}
