//! The flat sample beside the designs.

use slipgrid_springblock::{Extent, RunOptions, Scene, SceneError, simulate};

use crate::Console;
use crate::progress::Progress;

/// Travel of runs from the sheared equilibrium, in metres: a hundred stick-slip cycles of a block. A confirming
/// run goes on until its standard error is small enough.
pub(super) const WARM_TRAVEL_M: f64 = 0.4e-6;

/// Dynamic friction of the flat sample at every load of `scene`; `None` where it does not slide.
pub fn flat_friction(scene: &Scene, console: &Console<'_>) -> Result<Option<Vec<f64>>, SceneError> {
    let bar = Progress::start("flat sample", console.quiet);
    // On the sample that the coefficients were calibrated on, in as many dimensions as there.
    let run = RunOptions {
        warm_start: true,
        sliding_m: WARM_TRAVEL_M,
        extent: Extent::Sample,
        dimensions: None,
        ..scene.run
    };
    let simulation = simulate(&Scene { pattern: None, run, ..scene.clone() }, &bar);
    bar.finish();
    Ok(simulation?.loads.iter().map(|load| load.surface.mu_dynamic).collect())
}
