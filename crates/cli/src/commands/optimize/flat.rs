//! The flat sample beside the designs.

use slipgrid_springblock::{Extent, RunOptions, Scene};

use super::in_time::{WARM_TRAVEL_M, in_time};

use crate::Console;
use crate::on_specimen::SpecimenError;
use crate::progress::Progress;

/// Dynamic friction of the flat sample at every load of `scene`; `None` where it does not slide.
pub fn flat_friction(scene: &Scene, console: &Console<'_>) -> Result<Option<Vec<f64>>, SpecimenError> {
    let bar = Progress::start("flat sample", console.quiet);
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
