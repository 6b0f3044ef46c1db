//! Marine snow: flakes and crumbs that drift in the water. What is typed is what is meant; the checks are here.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::SceneError;
use crate::error::Complaints;

/// Matt grey spheres strewn evenly through the water, the same for both eyes. Their diameters d are distributed as d^(−exponent).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Snow {
    /// How many, on average: 1000 (one a litre) is a little, 100 000 is a storm.
    pub number_per_m3: f64,
    /// Smallest and largest diameter; below 0.2 mm particles belong to the water's scattering.
    #[serde(default = "default_diameter_m")]
    pub diameter_m: [f64; 2],
    /// Slope of the size distribution.
    #[serde(default = "default_exponent")]
    pub exponent: f64,
    /// Albedo per band (red, green, blue), in [0, 1].
    #[serde(default = "default_albedo")]
    pub albedo: [f64; 3],
    /// Where it is, by the distance to the nearer camera: not closer than the first, not farther than the second.
    #[serde(default = "default_range_m")]
    pub range_m: [f64; 2],
    /// Seed of its places and sizes; the scene's if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
}

fn default_diameter_m() -> [f64; 2] {
    [5e-4, 5e-3]
}

/// Monterey Bay, 1 µm to 1 cm: 2.96 to 3.00 (Jackson et al. 1997).
fn default_exponent() -> f64 {
    3.0
}

fn default_albedo() -> [f64; 3] {
    [0.3; 3]
}

fn default_range_m() -> [f64; 2] {
    [0.15, 5.0]
}

impl Snow {
    /// More particles than this within reach of the cameras are a slip of units.
    const MOST: f64 = 1e8;

    pub(crate) fn checked(self, no: &Complaints<'_>) -> Result<Self, SceneError> {
        no.positive("snow.number_per_m3", self.number_per_m3)?;
        let [smallest_m, largest_m] = self.diameter_m;
        let sizes = "between 2e-4 and 0.05 (0.2 mm and 5 cm)";
        for (k, diameter_m) in self.diameter_m.into_iter().enumerate() {
            no.number(&format!("snow.diameter_m[{k}]"), diameter_m, sizes, |d| {
                (2e-4..=0.05).contains(&d)
            })?;
        }
        let expected = format!("at least the smallest diameter, {smallest_m}");
        no.number("snow.diameter_m[1]", largest_m, &expected, |d| {
            d >= smallest_m
        })?;
        no.number("snow.exponent", self.exponent, "between 0 and 6", |q| {
            (0.0..=6.0).contains(&q)
        })?;
        no.albedo("snow.albedo", self.albedo)?;
        let [near_m, far_m] = self.range_m;
        no.number(
            "snow.range_m[0]",
            near_m,
            &format!("at least the largest diameter, {largest_m}, and at most 100"),
            |r| r >= largest_m && r <= 100.0,
        )?;
        let expected = format!("more than the nearest, {near_m}, and at most 100");
        no.number("snow.range_m[1]", far_m, &expected, |r| {
            r > near_m && r <= 100.0
        })?;
        let number = self.number_per_m3 * 4.0 / 3.0 * core::f64::consts::PI * far_m * far_m * far_m;
        if number > Self::MOST {
            return Err(no.value(
                "snow.number_per_m3",
                format!(
                    "at most {:.0} to a distance of {far_m} m",
                    self.number_per_m3 * Self::MOST / number
                ),
                self.number_per_m3,
            ));
        }
        Ok(self)
    }

    /// The diameter below which a share of the particles lies, m.
    pub fn diameter_quantile_m(&self, share: f64) -> f64 {
        let [from, to] = self.diameter_m;
        let power = 1.0 - self.exponent;
        // Near an exponent of 1 the integral of d^−q is a logarithm.
        if power.abs() < 1e-9 {
            return from * libm::pow(to / from, share);
        }
        let [low, high] = [from, to].map(|d| libm::pow(d, power));
        libm::pow(low + share * (high - low), 1.0 / power).clamp(from, to)
    }
}
