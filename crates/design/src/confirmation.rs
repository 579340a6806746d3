//! Confirming run: a run of the specimen at the design condition, dynamic in the plane.
//!
//! In space a dynamic run would be a third of a job, and would say little: it moves ratios of the shipped squares by
//! 0.0001 to 0.0002, where 0.003 is stated for time, and their peak pressure by 2 %. There it is run only from rest, for
//! static friction.

use slipgrid_base::monitor::{Monitor, cached};
use slipgrid_laser::export::Specimen;
use slipgrid_laser::specimen::{SpecimenError, simulate_on};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Extent, Fidelity, RunOptions, Scene, Simulation, can_refine};

use crate::DesignError;
use crate::dynamic_excess::correct;
use crate::prepared_task::PreparedTask;
use crate::steady_model::SteadyModel;

/// Minimum number of contact blocks with separate coefficients in a confirming run in space, summed over all random
/// draws of the coefficients. After the correction for the drawn coefficients, the ratio then scatters by one twentieth
/// of the usual tolerance.
const MIN_CONTACTS: f64 = 100.0;

/// Builds the scene of the confirming run of `pattern`, from an unloaded layer at rest if `from_rest`.
pub fn confirming_scene(prepared: &PreparedTask, model: &SteadyModel<'_>, pattern: &Pattern, from_rest: bool) -> Scene {
    let task = &prepared.task;
    let is_dynamic = from_rest || model.dimension().takes_strips();
    let mut run = RunOptions {
        extent: if task.search.strip { Extent::Strip } else { Extent::Sample },
        seed: task.search.seed,
        dimensions: task.search.dimensions,
        ..RunOptions::default()
    }
    .on_specimen(task.space.texture());
    if is_dynamic {
        // Without static friction, a run starts at the onset of sliding.
        run = if from_rest { RunOptions { fidelity: Fidelity::Dynamic, ..run } } else { run.from_sliding() };
        // A strip has dozens of cells, which give enough contact blocks with one draw.
        if run.extent != Extent::Strip {
            run.draws = model.draws(pattern, MIN_CONTACTS);
        }
    }
    let flat = task.flat_scene(&prepared.material, prepared.loads().to_vec(), run);
    let scene = Scene { pattern: Some(*pattern), ..flat };
    run.refine = can_refine(&scene, pattern);
    let scene = Scene { run, ..scene };
    if is_dynamic { scene.in_time() } else { scene }
}

/// Runs `scene` on `specimen`, or returns the result in the cache of `monitor`: `next` and `optimize` run equal scenes.
///
/// # Errors
/// [`SpecimenError`] where the specimen does not take the pattern.
pub fn run_specimen(scene: &Scene, specimen: &Specimen, monitor: &dyn Monitor) -> Result<Simulation, SpecimenError> {
    cached(monitor, ("confirming run", &(scene, specimen)), 1.0, || simulate_on(scene, Some(specimen), monitor))
}

/// Runs the confirmation of `pattern`, or takes the result `known` of a run that started from sliding, unless the task
/// requires a start from rest. Friction is corrected to the calibrated friction of the flat surface. Returns the scene
/// and the result of the run.
///
/// # Errors
/// [`DesignError`] where the specimen does not take the pattern.
pub fn confirm(
    prepared: &PreparedTask,
    model: &SteadyModel<'_>,
    (pattern, known): (&Pattern, Option<&Simulation>),
    monitor: &dyn Monitor,
) -> Result<(Scene, Simulation), DesignError> {
    let task = &prepared.task;
    let scene = confirming_scene(prepared, model, pattern, task.search.from_rest);
    let mut run = match known.filter(|_| !task.search.from_rest) {
        Some(run) => run.clone(),
        None => run_specimen(&scene, &task.specimen, monitor)?,
    };
    let excess = prepared.uncertainty.excess(&task.pressures_pa(), task.condition.as_ref());
    correct(&mut run, &scene, excess.as_deref());
    Ok((scene, run))
}
