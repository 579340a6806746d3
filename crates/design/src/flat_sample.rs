//! The flat sample beside the designs.

use slipgrid_springblock::{Extent, LoadOutcome, RunOptions, Scene};

use crate::time_budget::TimeBudget;
use slipgrid_specimen::{SpecimenError, simulate_on};

/// Dynamic friction of the flat sample at every load of `scene`; `None` where it does not slide, or only in waves.
pub(super) fn flat_friction(scene: &Scene, budget: TimeBudget<'_>) -> Result<Option<Vec<f64>>, SpecimenError> {
    let bar = budget.stage("flat sample");
    // On the sample that the coefficients were calibrated on, in as many dimensions as there.
    let run = RunOptions { warm_start: true, extent: Extent::Sample, dimensions: None, ..scene.run };
    let simulation = simulate_on(&Scene { pattern: None, run, ..scene.clone() }.in_time(), None, &bar);
    bar.finish();
    let mu = |load: &LoadOutcome| load.surface.mu_dynamic.filter(|_| load.is_trusted());
    Ok(simulation?.loads.iter().map(mu).collect())
}
