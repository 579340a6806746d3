//! How far samples of one texture scatter.

use serde::{Deserialize, Serialize};
use slipgrid_discrepancy::Discrepancy;
use slipgrid_units::tidy;

/// Weight of the stated scatter below which the ledger says that there is another.
const BELIEVED: f64 = 0.5;

/// How far samples of one texture scatter, of the logarithm of the ratio, where none is stated of a sample itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScatterReport {
    /// As it was stated, or taken where nothing was.
    pub stated: f64,
    /// How much that is believed after the trials.
    pub weight: f64,
    /// What trials say: the root of the mean square of all scatters that may be.
    pub found: f64,
}

impl ScatterReport {
    /// What the trials of `learned` say; `None` where they say nothing of it.
    pub(super) fn of(learned: &Discrepancy) -> Option<Self> {
        let all = learned.scatter_weights();
        let stated = all.first().filter(|_| all.len() > 1)?;
        Some(Self { stated: tidy(stated.std), weight: tidy(stated.weight), found: tidy(learned.sample_std()) })
    }

    /// A line where samples hardly scatter as is stated; empty elsewhere.
    pub(super) fn text(&self) -> String {
        let Self { stated, weight, found } = self;
        if *weight >= BELIEVED {
            return String::new();
        }
        format!(
            "samples of one texture are taken to scatter by {found:.3} (standard deviation of ln ratio): that they scatter by {stated}, as \
             sample_std says, has a weight of {weight:.3}\n"
        )
    }
}
