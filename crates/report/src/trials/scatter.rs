//! Scatter of samples of one texture.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::tidy;
use slipgrid_infer::discrepancy::Discrepancy;

/// Posterior weight of the stated scatter below which the ledger reports a different scatter.
const BELIEVED: f64 = 0.5;

/// Scatter of the logarithm of the ratio among samples of one texture, for samples without an individually stated scatter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScatterReport {
    /// Stated scatter, or the default if none was stated.
    pub stated: f64,
    /// Posterior weight of the stated scatter.
    pub weight: f64,
    /// Posterior scatter: root mean square over all candidate scatters.
    pub found: f64,
}

impl ScatterReport {
    /// Scatter from the trials of `learned`; `None` if they carry no information about it.
    pub(super) fn of(learned: &Discrepancy) -> Option<Self> {
        let all = learned.scatter_weights();
        let stated = all.first().filter(|_| all.len() > 1)?;
        Some(Self { stated: tidy(stated.std), weight: tidy(stated.weight), found: tidy(learned.sample_std()) })
    }

    /// Line for samples whose scatter is unlikely to be the stated one; otherwise empty.
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
