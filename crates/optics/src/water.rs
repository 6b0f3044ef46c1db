//! Published waters. "Jerlov names are labels for rows": two published sets for one name differ up to 3.6 times in b, so a
//! scene's water is its numbers, and the name only says where they came from.
//!
//! The rows are those marked as recommended in `data/jerlov.csv`: Williamson and Hollins (2022) where they measured,
//! Solonenko and Mobley (2015) where nobody else publishes one, and pure sea water. Natural variability of b is about 30 %.

use crate::{Bands, Medium, Phase};

/// One row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Water {
    /// Its name: a Jerlov type, or `pure_sea`.
    pub label: String,
    /// a, m⁻¹.
    pub absorption_per_m: Bands,
    /// b, m⁻¹.
    pub scattering_per_m: Bands,
    /// Diffuse attenuation of daylight (Jerlov 1976), m⁻¹; never for a camera's ray.
    pub diffuse_attenuation_per_m: Option<Bands>,
    /// Where the numbers were published.
    pub source: String,
    /// How far they are to be trusted: low, low-medium, medium or high.
    pub confidence: String,
}

const TABLE: &str = include_str!("../data/jerlov.csv");

/// The label of pure sea water, whose scattering is not that of particles.
const PURE: &str = "pure_sea";

impl Water {
    /// The phase function that belongs to the row: [`Phase::petzold3`] for particles. Molecules scatter as
    /// 1 + 0.835 cos² θ, which [`Phase::Isotropic`] stands for: the same mean cosine and backscatter fraction.
    pub fn phase(&self) -> Phase {
        if self.label == PURE {
            Phase::Isotropic
        } else {
            Phase::petzold3()
        }
    }

    /// The row as a medium.
    pub fn medium(&self) -> Medium {
        Medium::new(self.absorption_per_m, self.scattering_per_m, self.phase())
            .expect("the table holds non-negative numbers: a test reads every row")
    }
}

/// The water of a name, exactly as [`names`] gives it.
pub fn by_name(name: &str) -> Option<Water> {
    all().into_iter().find(|water| water.label == name)
}

/// The names there are, in the order of the table: from clear to turbid within each source.
pub fn names() -> Vec<String> {
    all().into_iter().map(|water| water.label).collect()
}

/// Every recommended row.
pub fn all() -> Vec<Water> {
    let mut reader = csv::Reader::from_reader(TABLE.as_bytes());
    let records: Vec<_> = reader
        .records()
        .map(|record| record.expect("the table is compiled in; a test reads it"))
        .filter(|record| &record[0] == PURE || record[11].starts_with("RECOMMENDED"))
        .collect();
    // A water is three consecutive rows: 600, 525, 475 nm.
    records
        .chunks(3)
        .map(|rows| {
            let column = |index: usize| -> Option<Bands> {
                let mut bands = [0.0; 3];
                for (band, row) in bands.iter_mut().zip(rows) {
                    *band = row[index].parse().ok()?;
                }
                Some(bands)
            };
            let number = "the table is compiled in; a test reads it";
            Water {
                label: rows[0][0].to_owned(),
                absorption_per_m: column(3).expect(number),
                scattering_per_m: column(4).expect(number),
                diffuse_attenuation_per_m: column(8),
                source: rows[0][9].to_owned(),
                confidence: rows[0][10].to_owned(),
            }
        })
        .collect()
}
