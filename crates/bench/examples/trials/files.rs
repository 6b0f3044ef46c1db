//! Every outcome, and how often each reason was given, as CSV.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use serde::Serialize;

use crate::asked::answer::{Answer, status_name};

#[derive(Serialize)]
struct Row<'a> {
    kind: &'a str,
    seed: u64,
    status: &'a str,
    reason_code: &'a str,
    reason: &'a str,
    is_wrong: bool,
    offset_mm: Option<f64>,
    angle_deg: Option<f64>,
    nees: Option<f64>,
    nees_dof: Option<usize>,
    claimed_offset_mm: Option<f64>,
    total_ms: f64,
}

#[derive(Serialize)]
struct Counted<'a> {
    kind: &'a str,
    status: &'a str,
    /// Of a refusal its code, of a degraded answer one of its warnings.
    reason: &'a str,
    count: usize,
}

pub(crate) fn write(dir: &Path, all: &[(&str, Vec<Answer>)]) -> Result<(), Box<dyn Error>> {
    let mut outcomes = csv::Writer::from_path(dir.join("outcomes.csv"))?;
    let mut counts = BTreeMap::<(&str, &str, &str), usize>::new();
    for (kind, answers) in all {
        for answer in answers {
            let status = status_name(answer.status());
            outcomes.serialize(Row {
                kind,
                seed: answer.seed,
                status,
                reason_code: answer.reason_code(),
                reason: answer.estimate.reason.as_deref().unwrap_or_default(),
                is_wrong: answer.is_wrong(),
                offset_mm: answer.offset_mm(),
                angle_deg: answer.angle_deg(),
                nees: answer.nees().map(|nees| nees.value),
                nees_dof: answer.nees().map(|nees| nees.dof),
                claimed_offset_mm: answer.claimed_offset_m.map(|v| 1e3 * v),
                total_ms: answer.estimate.timing_ms.total,
            })?;
            let mut count = |reason| *counts.entry((*kind, status, reason)).or_default() += 1;
            if answer.is_answered() {
                for warning in &answer.estimate.observability.warnings {
                    count(warning.as_str());
                }
            } else {
                count(answer.reason_code());
            }
        }
    }
    outcomes.flush()?;
    let mut reasons = csv::Writer::from_path(dir.join("reasons.csv"))?;
    for ((kind, status, reason), count) in counts {
        reasons.serialize(Counted {
            kind,
            status,
            reason,
            count,
        })?;
    }
    Ok(reasons.flush()?)
}
