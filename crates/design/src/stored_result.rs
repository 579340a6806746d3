//! Results read back: what `export` needs of them.

use serde::Deserialize;
use serde::de::IgnoredAny;
use slipgrid_export::{Laser, Tolerances};
use slipgrid_results::{MaterialReport, PatternReport, SpecimenReport};

use crate::next_report::NextReport;

/// The part of result.json of `optimize` that `export` needs.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct StoredDesign {
    /// Name of the design.
    pub name: String,
    /// Version that made it.
    pub version: String,
    /// Schema of the file.
    #[serde(default = "slipgrid_results::first_schema")]
    pub schema: u32,
    /// The design.
    pub design: PatternReport,
    /// The material.
    pub material: MaterialReport,
    /// The specimen.
    pub specimen: SpecimenReport,
    /// The laser.
    pub laser: Laser,
    /// How exactly samples are assumed to be cut; absent where the design file does not say.
    pub tolerances: Option<Tolerances>,
    /// Seed.
    pub seed: u64,
}

/// A file that holds no such result.
#[derive(Debug, thiserror::Error)]
pub enum StoredError {
    /// It is none of `optimize`.
    #[error("is not a result of `slipgrid optimize`: {0}")]
    Optimize(#[source] serde_json::Error),
    /// It is none of `next`, or of a version that did not write laser, specimen and material.
    #[error(
        "is not a result of `slipgrid next` that says laser, specimen and material, as this version writes it: {0}"
    )]
    Next(#[source] serde_json::Error),
    /// A sample is asked for that there is not.
    #[error(
        "has {rows} samples: those to cut first, then yours, then the other designs, as `slipgrid next` lists them"
    )]
    NoSample {
        /// How many there are.
        rows: usize,
    },
    /// A sample is asked for where there is one design.
    #[error("is a result of `slipgrid optimize`, which has one design and no samples")]
    OneDesign,
    /// Its samples are sectors.
    #[error(
        "holds sectors of one specimen, whose drawing pattern.dxf stands beside it; --sample 1 takes the pattern of the first on a whole \
         specimen, --sample 2 that of the second"
    )]
    Sectors,
}

/// What tells results apart.
#[derive(Deserialize)]
struct Kind {
    design: Option<IgnoredAny>,
    samples: Option<IgnoredAny>,
}

impl StoredDesign {
    /// The design of a result of `optimize`, or a sample of a result of `next`: by its place in the table, from 1, otherwise the first.
    ///
    /// # Errors
    /// [`StoredError`].
    pub fn read(text: &str, sample: Option<usize>) -> Result<Self, StoredError> {
        let is_next =
            serde_json::from_str(text).is_ok_and(|kind: Kind| kind.design.is_none() && kind.samples.is_some());
        if !is_next {
            let stored = serde_json::from_str(text).map_err(StoredError::Optimize)?;
            return if sample.is_none() { Ok(stored) } else { Err(StoredError::OneDesign) };
        }
        let stored: NextReport = serde_json::from_str(text).map_err(StoredError::Next)?;
        if stored.one_disc.is_some() && sample.is_none() {
            return Err(StoredError::Sectors);
        }
        let rows = stored.rows();
        let row = sample.unwrap_or(1).checked_sub(1).and_then(|place| rows.get(place));
        let (_, of) = row.ok_or(StoredError::NoSample { rows: rows.len() })?;
        let design = of.design.clone();
        let NextReport { name, version, schema, material, specimen, laser, tolerances, seed, .. } = stored;
        Ok(Self { name, version, schema, design, material, specimen, laser, tolerances, seed })
    }
}
