//! Runs in time from the sheared equilibrium, as long as they need to be.

use slipgrid_springblock::{LoadOutcome, RunOptions, Scene, Simulation, Status};

use crate::on_specimen::{SpecimenError, simulate_on};
use crate::progress::Progress;
use crate::report::specimen::Specimen;

/// Travel of runs from the sheared equilibrium, in metres: a hundred stick-slip cycles of a block. A confirming
/// run goes on until its standard error is small enough.
pub(super) const WARM_TRAVEL_M: f64 = 0.4e-6;

/// Travel at which a confirming run gives up waiting for the onset of sliding, in metres.
const MOST_TRAVEL_M: f64 = 8e-6;

/// `scene` in time on `specimen`, or on one strip without, and how it was run: slender lands shear further before the last
/// block slips, and at high speeds the travel is over before an average means anything.
///
/// # Errors
/// [`SpecimenError`] if the scene means nothing or the specimen does not take its pattern.
pub(super) fn in_time(
    mut scene: Scene,
    specimen: Option<&Specimen>,
    bar: &Progress,
) -> Result<(Simulation, RunOptions), SpecimenError> {
    loop {
        let simulation = simulate_on(&scene, specimen, bar)?;
        let sliding = |load: &LoadOutcome| {
            let surfaces = std::iter::once(&load.surface).chain(&load.flat);
            surfaces.into_iter().all(|surface| !matches!(surface.status, Status::NoOnset | Status::ShortWindow))
        };
        if simulation.loads.iter().all(sliding) || scene.run.sliding_m >= MOST_TRAVEL_M {
            return Ok((simulation, scene.run));
        }
        scene.run.sliding_m *= 2.0;
    }
}
