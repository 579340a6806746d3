//! Stored results of `optimize` and `next`: the parts that `export` needs.

use std::collections::BTreeMap;

use crate::results::PatternReport;
use serde::Deserialize;
use serde::de::IgnoredAny;
use slipgrid_laser::export::{ProcessInput, SpecimenRecord};

/// Design of `optimize` or sample of `next` to export, from result.json.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredDesign {
    /// Design to export.
    pub design: PatternReport,
    /// Specimen to export.
    pub specimen: SpecimenRecord,
    /// Laser and metadata.
    pub about: ProcessInput,
}

/// Specimen and samples of a result of `optimize` or `next`.
#[derive(Deserialize)]
struct Stored {
    specimen: SpecimenRecord,
    design: Option<PatternReport>,
    one_disc: Option<IgnoredAny>,
    #[serde(default)]
    samples: Vec<Sample>,
    #[serde(default)]
    own: Vec<Sample>,
    #[serde(default)]
    others: Vec<Sample>,
}

#[derive(Deserialize)]
struct Sample {
    design: PatternReport,
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
        let refused = if has("design") { StoredError::Optimize } else { StoredError::Next };
        // Separately, because errors in a flattened record would have no line.
        let stored: Stored = serde_json::from_str(text).map_err(refused)?;
        let about: ProcessInput = serde_json::from_str(text).map_err(refused)?;
        if stored.one_disc.is_some() && sample.is_none() {
            return Err(StoredError::Sectors);
        }
        // In the order of the tables of `optimize` and `next`.
        let samples = [stored.samples, stored.own, stored.others].into_iter().flatten().map(|of| of.design);
        let mut designs: Vec<PatternReport> = stored.design.into_iter().chain(samples).collect();
        let (number, rows) = (sample.unwrap_or(1), designs.len());
        if !(1..=rows).contains(&number) {
            return Err(StoredError::NoSample { number, rows });
        }
        Ok(Self { design: designs.swap_remove(number - 1), specimen: stored.specimen, about })
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
