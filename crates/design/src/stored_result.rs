//! Stored results of `optimize` and `next`: the parts that `export` needs.

use std::collections::BTreeMap;

use crate::results::PatternReport;
use serde::Deserialize;
use serde::de::IgnoredAny;
use slipgrid_laser::export::{Laser, SpecimenRecord, Tolerances};
use slipgrid_model::material::Provenance;

use crate::next_report::NextReport;

/// Design of `optimize` or sample of `next` to export, from result.json.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredDesign {
    /// Name of the design.
    pub name: String,
    /// Version of the program that wrote the file.
    pub version: String,
    /// Schema version of the file.
    #[serde(default = "crate::results::first_schema")]
    pub schema: u32,
    /// Design to export.
    pub design: PatternReport,
    /// Material of the design.
    pub material: Provenance,
    /// Specimen to export.
    pub specimen: SpecimenRecord,
    /// Laser settings.
    pub laser: Laser,
    /// Assumed manufacturing tolerances of samples; absent where the design file does not give them.
    pub tolerances: Option<Tolerances>,
    /// Seed of the random local coefficients.
    pub seed: u64,
}

/// Error of reading a stored result.
#[derive(Debug, thiserror::Error)]
pub enum StoredError {
    /// Not a result of `optimize`.
    #[error("is not a result of `slipgrid optimize`: {0}")]
    Optimize(#[source] serde_json::Error),
    /// Not a result of `next`, or written by a version that did not store laser, specimen and material.
    #[error(
        "is not a result of `slipgrid next` that says laser, specimen and material, as this version writes it: {0}"
    )]
    Next(#[source] serde_json::Error),
    /// Result of another command, whose words are given.
    #[error("holds no design and no samples{0}")]
    Another(&'static str),
    /// The requested sample does not exist.
    #[error("has no sample {number}, but 1 to {rows}: those to cut first, then yours, then the others worth cutting")]
    NoSample {
        /// Number of the requested sample.
        number: usize,
        /// Number of samples.
        rows: usize,
    },
    /// The samples are sectors of one specimen, and no sample number was given.
    #[error(
        "holds sectors of one specimen, whose drawing pattern.dxf stands beside it; --sample 1 takes the pattern of the first on a whole \
         specimen, --sample 2 that of the second"
    )]
    Sectors,
}

/// Fields of the results of other commands, and words that name the command.
const OTHERS: [(&str, &str); 3] = [
    ("fidelity", ", as a result of `slipgrid simulate`"),
    ("coverage", ", as a result of `slipgrid trials`"),
    ("parameters", ", as a result of `slipgrid surface`"),
];

/// Other textures worth cutting in a result of `optimize`.
#[derive(Deserialize)]
struct Others {
    #[serde(default)]
    others: Vec<Other>,
}

#[derive(Deserialize)]
struct Other {
    design: PatternReport,
}

impl StoredDesign {
    /// Reads the sample with the number `sample` from a result of `optimize` or `next`: its row in the table, counted
    /// from 1, by default the first. In a result of `optimize` the first is the design, and the others worth cutting
    /// follow.
    ///
    /// # Errors
    /// [`StoredError`].
    pub fn read(text: &str, sample: Option<usize>) -> Result<Self, StoredError> {
        let fields: BTreeMap<String, IgnoredAny> = serde_json::from_str(text).map_err(StoredError::Optimize)?;
        let has = |field: &str| fields.contains_key(field);
        if !has("design") && !has("samples") {
            let other = OTHERS.into_iter().find(|(field, _)| has(field));
            return Err(StoredError::Another(other.map_or("", |(_, words)| words)));
        }
        let number = sample.unwrap_or(1);
        if has("design") {
            let stored: Self = serde_json::from_str(text).map_err(StoredError::Optimize)?;
            if number == 1 {
                return Ok(stored);
            }
            let Others { others } = serde_json::from_str(text).map_err(StoredError::Optimize)?;
            let rows = 1 + others.len();
            let other = number.checked_sub(2).and_then(|place| others.into_iter().nth(place));
            let Other { design } = other.ok_or(StoredError::NoSample { number, rows })?;
            return Ok(Self { design, ..stored });
        }
        let stored: NextReport = serde_json::from_str(text).map_err(StoredError::Next)?;
        if stored.one_disc.is_some() && sample.is_none() {
            return Err(StoredError::Sectors);
        }
        let rows = stored.rows();
        let row = number.checked_sub(1).and_then(|place| rows.get(place));
        let (_, of) = row.ok_or(StoredError::NoSample { number, rows: rows.len() })?;
        let design = of.design.clone();
        let NextReport { name, version, schema, material, specimen, laser, tolerances, seed, .. } = stored;
        Ok(Self { name, version, schema, design, material, specimen, laser, tolerances, seed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_of_other_commands_are_named() {
        let refused = |text: &str| StoredDesign::read(text, None).unwrap_err().to_string();
        let simulated = refused("{\"fidelity\": \"steady\", \"results\": []}");
        assert_eq!(simulated, "holds no design and no samples, as a result of `slipgrid simulate`");
        assert_eq!(refused("{}"), "holds no design and no samples");
        for text in ["", "[1]", "{", "{\"design\": {}}"] {
            assert!(refused(text).starts_with("is not a result of `slipgrid optimize`"), "{text}");
        }
    }
}
