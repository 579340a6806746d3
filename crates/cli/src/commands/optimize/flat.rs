//! The flat sample beside the designs.

use slipgrid_springblock::{Extent, RunOptions, Scene};

use super::allowance::Allowance;
use super::in_time::{WARM_TRAVEL_M, in_time};

use crate::Console;
use crate::on_specimen::SpecimenError;
use crate::progress::Progress;

/// Dynamic friction of the flat sample at every load of `scene`; `None` where it does not slide.
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
    let simulation = in_time(Scene { pattern: None, run, ..scene.clone() }, None, &bar);
    bar.finish();
    Ok(simulation?.0.loads.iter().map(|load| load.surface.mu_dynamic).collect())
}
