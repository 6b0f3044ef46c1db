//! A port in a rig file.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::port::{
    DomePort, FlatPort, Port, PortShape, SALINITY_PSU, TEMPERATURE_C, sea_water_index,
};
use crate::{CameraError, Vec3};

/// The glass before a camera in a rig file. Focal lengths and distortion beside it are those of the camera in air. The water is given
/// by `water_index`, or by `salinity_psu` and `temperature_c`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum PortEntry {
    /// A plate.
    Flat(FlatPortEntry),
    /// A spherical shell.
    Dome(DomePortEntry),
}

/// A plane plate of glass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FlatPortEntry {
    /// From the camera's centre to the inner face, along the normal.
    pub distance_m: f64,
    /// Of the glass.
    pub thickness_m: f64,
    /// Normal of the plate in the camera's frame, towards the water, of any length; the optical axis if absent.
    #[serde(default = "optical_axis", skip_serializing_if = "is_optical_axis")]
    pub normal: [f64; 3],
    /// Refractive index of the glass against air, in all bands; that of acrylic, 1.49, if absent.
    #[serde(default = "acrylic")]
    pub glass_index: f64,
    /// Refractive index of the water against air at 600, 525 and 475 nm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water_index: Option<[f64; 3]>,
    /// Instead of `water_index`: salinity, 0 to 40.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub salinity_psu: Option<f64>,
    /// Instead of `water_index`: temperature, 0 to 30.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
}

/// A spherical shell of glass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DomePortEntry {
    /// Radius of the inner face.
    pub inner_radius_m: f64,
    /// Of the glass.
    pub thickness_m: f64,
    /// The dome's centre in the camera's frame; the camera's centre if absent.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub centre_offset_m: [f64; 3],
    /// Refractive index of the glass against air, in all bands; that of acrylic, 1.49, if absent.
    #[serde(default = "acrylic")]
    pub glass_index: f64,
    /// Refractive index of the water against air at 600, 525 and 475 nm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub water_index: Option<[f64; 3]>,
    /// Instead of `water_index`: salinity, 0 to 40.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub salinity_psu: Option<f64>,
    /// Instead of `water_index`: temperature, 0 to 30.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_c: Option<f64>,
}

fn acrylic() -> f64 {
    Port::ACRYLIC
}

fn optical_axis() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn is_optical_axis(normal: &[f64; 3]) -> bool {
    *normal == optical_axis()
}

fn is_zero(offset_m: &[f64; 3]) -> bool {
    *offset_m == [0.0; 3]
}

/// The key after the camera's name, what was expected, what was found.
pub(super) enum PortComplaint {
    Text(&'static str, String, String),
    Number(CameraError),
}

impl From<CameraError> for PortComplaint {
    fn from(error: CameraError) -> Self {
        Self::Number(error)
    }
}

impl PortEntry {
    pub(super) fn from_port(port: &Port) -> Self {
        let (glass_index, water_index) = (port.glass_index(), Some(port.water_index()));
        match *port.shape() {
            PortShape::Flat(flat) => Self::Flat(FlatPortEntry {
                distance_m: flat.distance_m,
                thickness_m: flat.thickness_m,
                normal: flat.normal.into(),
                glass_index,
                water_index,
                salinity_psu: None,
                temperature_c: None,
            }),
            PortShape::Dome(dome) => Self::Dome(DomePortEntry {
                inner_radius_m: dome.inner_radius_m,
                thickness_m: dome.thickness_m,
                centre_offset_m: dome.centre_m.into(),
                glass_index,
                water_index,
                salinity_psu: None,
                temperature_c: None,
            }),
        }
    }

    pub(super) fn to_port(self) -> Result<Port, PortComplaint> {
        match self {
            Self::Flat(flat) => {
                let shape = PortShape::Flat(FlatPort {
                    normal: unit(flat.normal)?,
                    distance_m: flat.distance_m,
                    thickness_m: flat.thickness_m,
                });
                let water = water_index(flat.water_index, flat.salinity_psu, flat.temperature_c)?;
                Ok(Port::new(shape, flat.glass_index, water)?)
            }
            Self::Dome(dome) => {
                let shape = PortShape::Dome(DomePort {
                    centre_m: dome.centre_offset_m.into(),
                    inner_radius_m: dome.inner_radius_m,
                    thickness_m: dome.thickness_m,
                });
                let water = water_index(dome.water_index, dome.salinity_psu, dome.temperature_c)?;
                Ok(Port::new(shape, dome.glass_index, water)?)
            }
        }
    }
}

fn unit(normal: [f64; 3]) -> Result<Vec3, PortComplaint> {
    let vector = Vec3::from(normal);
    let norm = vector.norm();
    if !(norm > 0.0 && norm.is_finite()) {
        return Err(PortComplaint::Text(
            "port.normal",
            "a direction, finite and not of zero length".to_owned(),
            format!("{normal:?}"),
        ));
    }
    // What is a unit vector already stays as it is: a written file reads back as itself.
    Ok(if (norm - 1.0).abs() <= 4.0 * f64::EPSILON {
        vector
    } else {
        vector / norm
    })
}

fn water_index(
    index: Option<[f64; 3]>,
    salinity_psu: Option<f64>,
    temperature_c: Option<f64>,
) -> Result<[f64; 3], PortComplaint> {
    match (index, salinity_psu, temperature_c) {
        (Some(index), None, None) => Ok(index),
        (None, Some(salinity_psu), Some(temperature_c)) => {
            for (key, range, found) in [
                ("port.salinity_psu", SALINITY_PSU, salinity_psu),
                ("port.temperature_c", TEMPERATURE_C, temperature_c),
            ] {
                if !range.contains(&found) {
                    let expected = format!("{} to {}", range.start(), range.end());
                    return Err(PortComplaint::Text(key, expected, found.to_string()));
                }
            }
            Ok(sea_water_index(salinity_psu, temperature_c))
        }
        _ => {
            let given = [
                ("water_index", index.is_some()),
                ("salinity_psu", salinity_psu.is_some()),
                ("temperature_c", temperature_c.is_some()),
            ];
            let names: Vec<&str> = given
                .iter()
                .filter(|(_, is)| *is)
                .map(|(name, _)| *name)
                .collect();
            Err(PortComplaint::Text(
                "port",
                "water_index, or salinity_psu and temperature_c".to_owned(),
                if names.is_empty() {
                    "neither".to_owned()
                } else {
                    names.join(", ")
                },
            ))
        }
    }
}
