//! Calibration job: from measurements and a surface to a material and its uncertainty.

use slipgrid_base::monitor::{Monitor, Part, Stage};

use crate::calibrate::fit::{check_speeds, seconds};
use crate::calibrate::fitted_material::CalibrationOutcome;
use crate::calibrate::surface_area_law_source::surface_findings;
use crate::calibrate::trial_discrepancy::{Learned, learn, sample_bytes, trial};
use crate::calibrate::{
    CalibrationError, CalibrationTask, CutSample, FitError, Measurement, Problem, Surface, fit_coefficients,
    fitted_material, planned_steps,
};

/// Runs a calibration: selects the required measurements, computes the area law, fits local coefficients and learns
/// from trials. Stages of the monitor: "area law", "windows", "area law after the test", "calibration", and "trials" if
/// the area law is fitted. The monitor gets a note if the run needs much memory or the fit will take long.
///
/// # Errors
/// [`CalibrationError`] if a number is invalid, the model cannot reproduce a measurement, or the monitor cancels.
pub fn run(task: &CalibrationTask, monitor: &dyn Monitor) -> Result<CalibrationOutcome, CalibrationError> {
    // Estimated first, so that a run that needs too much memory fails at once.
    let gib = sample_bytes(task)? / NOTED_BYTES;
    if gib > 1.0 {
        monitor.note(&format!("the strips of a measured sample take about {gib:.1} GiB of memory"));
    }
    let measurements = task.selection.flat(task);
    // Finds a modulus in the wrong unit before the contact of a map is computed.
    check_speeds(&task.elastic, task.specimen_area_m2, &measurements).map_err(|error| refused(error, &measurements))?;
    let mut surface = surface_findings(task, monitor)?;
    let problem = Problem {
        elastic: task.elastic,
        area_law: surface.law.clone(),
        area_law_scale: surface.scale()?,
        layer: task.layer,
        specimen_area_m2: task.specimen_area_m2,
        measurements,
        coefficients: task.coefficients,
        relative_std: task.relative_std,
        static_over_dynamic: task.static_over_dynamic,
        seed: task.seed,
    };
    if let Some(text) = long_fit_note(&problem) {
        monitor.note(&text);
    }
    let stage = Stage::new(monitor, "calibration", None);
    // Trials run in parallel with the fit, except if they need the fitted area law.
    let is_known = problem.area_law_scale.is_none();
    let trials_share =
        if is_known && task.trials.samples.iter().any(|sample| !sample.measured.is_empty()) { 0.2 } else { 0.0 };
    let (fit, early) = rayon::join(
        || fit_coefficients(&problem, &Part::new(&stage, 1.0 - trials_share)),
        || is_known.then(|| learn(task, surface.law_and_curve(), &Part::new(&stage, trials_share))),
    );
    stage.finish();
    let mut fit = fit.map_err(|error| refused(error, &problem.measurements))?;
    surface.set_fitted_scale(&fit)?;
    fit.include_law_errors(&problem, task.modulus_relative_std().filter(|_| surface.depends_on_modulus()))?;
    let learned = match early {
        Some(learned) => learned,
        None => {
            let stage = Stage::new(monitor, "trials", None);
            let learned = learn(task, surface.law_and_curve(), &stage);
            stage.finish();
            learned
        }
    };
    if monitor.cancelled() {
        return Err(CalibrationError::Cancelled);
    }
    fitted_material::outcome(task, problem.measurements, fit, surface, learned?)
}

fn refused(error: FitError, measurements: &[Measurement]) -> CalibrationError {
    match error {
        FitError::Cancelled => CalibrationError::Cancelled,
        error => {
            let measurement = error.measurement().and_then(|number| measurements.get(number - 1)).copied();
            CalibrationError::Fit { error, measurement }
        }
    }
}

/// Memory of a calibration, in bytes, above which the monitor gets a note.
const NOTED_BYTES: f64 = (1_u64 << 30) as f64;

/// Estimated minutes of a fit above which a note is given.
const NOTED_MINUTES: f64 = 0.5;

/// Returns a note on the estimated time of the fit if it is above `NOTED_MINUTES`.
fn long_fit_note(problem: &Problem) -> Option<String> {
    let steps: u64 = planned_steps(problem).ok()?.iter().fold(0, |sum, steps| sum.saturating_add(*steps));
    let runs = if problem.has_peaks() { 4.0 } else { 1.0 };
    // Each run uses one thread.
    let threads = rayon::current_num_threads().min(problem.measurements.len()) as f64;
    let minutes = runs * seconds(problem, steps as f64) / threads / 60.0;
    (minutes > NOTED_MINUTES).then(|| {
        format!("the runs of the flat sample take {steps} time steps a round, roughly {minutes:.1} minutes in all, and up to twenty times as long where means have to be taken for longer; steps grow with 1/speed, and heavy loads take more")
    })
}

/// Learns the discrepancy from trials. Flat samples are fitted only if the area law is fitted to them. Stages of the
/// monitor: those of the area law, "calibration" if a fit is made, and "trials".
///
/// # Errors
/// See [`run`].
pub fn learn_alone(task: &CalibrationTask, monitor: &dyn Monitor) -> Result<Learned, CalibrationError> {
    let (surface, learned) = if matches!(task.surface, Surface::FittedScale { .. }) {
        let found = run(task, monitor)?;
        (found.surface, found.uncertainty.learned)
    } else {
        (surface_findings(task, monitor)?, None)
    };
    let law = surface.law_and_curve();
    let stage = Stage::new(monitor, "trials", None);
    // An area law that is fitted has no map with which a land could be compared.
    let learned = learned.map_or_else(
        || learn(task, law, &stage),
        |discrepancy| Ok(Learned { discrepancy, warnings: Vec::new(), lands: Vec::new(), pending: Vec::new() }),
    );
    let pending = task.trials.samples.iter().filter(|sample| sample.measured.is_empty());
    let pending = pending.map(|sample| {
        // Flat measurements stand in for patterned ones; only the modelled values are used.
        let sample = CutSample { measured: task.flat.clone(), ..sample.clone() };
        trial(task, &sample, law, &Part::new(&stage, 0.0)).map(|found| found.trial)
    });
    let pending = pending.collect::<Result<Vec<_>, CalibrationError>>();
    stage.finish();
    if monitor.cancelled() {
        return Err(CalibrationError::Cancelled);
    }
    let learned = learned?;
    Ok(Learned { pending: pending?, ..learned })
}
