//! The flat sample beside the designs.

use slipgrid_springblock::{Extent, LoadOutcome, RunOptions, Scene};

use super::allowance::Allowance;
use super::confirmation::{WARM_TRAVEL_M, trusted};
use crate::Console;
use crate::on_specimen::{SpecimenError, simulate_on};
use crate::progress::Progress;

/// Dynamic friction of the flat sample at every load of `scene`; `None` where it does not slide, or only in waves.
pub(super) fn flat_friction(
    scene: &Scene,
    allowance: Allowance,
    console: &Console<'_>,
) -> Result<Option<Vec<f64>>, SpecimenError> {
    let bar = Progress::until("flat sample", console.quiet, allowance.until());
    // On the sample that the coefficients were calibrated on, in as many dimensions as there.
    let run = RunOptions {
        warm_start: true,
        sliding_m: WARM_TRAVEL_M,
        extent: Extent::Sample,
        dimensions: None,
        ..scene.run
    };
    let simulation = simulate_on(&Scene { pattern: None, run, ..scene.clone() }, None, &bar);
    bar.finish();
    let mu = |load: &LoadOutcome| load.surface.mu_dynamic.filter(|_| trusted(load));
    Ok(simulation?.loads.iter().map(mu).collect())
}
