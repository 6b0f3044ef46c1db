//! Every outcome as a row of CSV.

use std::error::Error;
use std::path::Path;

use rodsight_bench::{Limit, Nees};
use rodsight_geometry::degrees;
use serde::{Deserialize, Serialize};

use crate::asked::answer::{Answer, status_name};

/// A scene and a method's answer to it; what is not known is empty.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Row {
    /// The variable, in the sweep's unit; of a named one its place in the list.
    pub(crate) value: f64,
    pub(crate) value_name: String,
    pub(crate) seed: u64,
    pub(crate) method: String,
    pub(crate) status: String,
    /// Short fixed name of the reason of a refusal.
    pub(crate) reason_code: String,
    pub(crate) reason: String,
    /// Axis offset at the true grasp, mm.
    pub(crate) offset_mm: Option<f64>,
    pub(crate) angle_deg: Option<f64>,
    /// Signed: less than nothing of a rod that is taken for thinner than it is.
    pub(crate) radius_error_mm: Option<f64>,
    pub(crate) nees: Option<f64>,
    pub(crate) nees_dof: Option<usize>,
    pub(crate) is_wrong: bool,
    pub(crate) claimed_offset_mm: Option<f64>,
    /// Cramér–Rao.
    pub(crate) limit_offset_mm: Option<f64>,
    pub(crate) limit_angle_deg: Option<f64>,
    /// Of the limbs, root mean square over their length.
    pub(crate) contrast_to_noise: Option<f64>,
    pub(crate) total_ms: f64,
}

impl Row {
    pub(crate) fn new(
        (value, value_name): (f64, &str),
        answer: &Answer,
        limit: Option<&Limit>,
        contrast_to_noise: Option<f64>,
    ) -> Self {
        Self {
            value,
            value_name: value_name.to_owned(),
            seed: answer.seed,
            method: answer.estimate.method.clone(),
            status: status_name(answer.status()).to_owned(),
            reason_code: answer.reason_code().to_owned(),
            reason: answer.estimate.reason.clone().unwrap_or_default(),
            offset_mm: answer.offset_mm(),
            angle_deg: answer.angle_deg(),
            radius_error_mm: answer.radius_error_mm(),
            nees: answer.nees().map(|nees| nees.value),
            nees_dof: answer.nees().map(|nees| nees.dof),
            is_wrong: answer.is_wrong(),
            claimed_offset_mm: answer.claimed_offset_m.map(|v| 1e3 * v),
            limit_offset_mm: limit.map(|limit| 1e3 * limit.axis_offset_m),
            limit_angle_deg: limit.map(|limit| degrees(limit.axis_angle_rad)),
            contrast_to_noise,
            total_ms: answer.estimate.timing_ms.total,
        }
    }

    pub(crate) fn is_answered(&self) -> bool {
        self.status != "refused"
    }

    pub(crate) fn nees(&self) -> Option<Nees> {
        Some(Nees {
            value: self.nees?,
            dof: self.nees_dof?,
        })
    }
}

pub(crate) fn write(file: &Path, rows: &[Row]) -> Result<(), Box<dyn Error>> {
    let mut writer = csv::Writer::from_path(file)?;
    for row in rows {
        writer.serialize(row)?;
    }
    Ok(writer.flush()?)
}

pub(crate) fn read(file: &Path) -> Result<Vec<Row>, Box<dyn Error>> {
    let mut reader =
        csv::Reader::from_path(file).map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(reader.deserialize().collect::<Result<_, _>>()?)
}
