//! Runs calibrations: of a calibration file, or of a design whose material is a calibration file. Errors refer to file,
//! line and key.

use std::path::Path;

use slipgrid_base::monitor::{Key, Monitor};
use slipgrid_base::units::{MODULUS_GPA, SPEED_MM_S, significant_to, tidy};
use slipgrid_design::{KnownMaterial, Refusal};
use slipgrid_infer::calibrate::area_law::AreaLawError;
use slipgrid_infer::calibrate::{
    CalibrationError, CalibrationOutcome, CalibrationTask, FitError, Learned, Measurement, Selection,
    measured_friction, sample_bytes,
};
use slipgrid_model::material::{Material, Provenance};
use slipgrid_model::springblock::{Layer, SceneError};

use crate::Failure;
use crate::formats::altitude_map::{law_warnings, refuse_law};
use crate::formats::calibration::Calibration;
use crate::formats::design::Design;
use crate::formats::material::read_known;
use crate::formats::plausible::{FORCE, MODULUS, SPEED};
use crate::formats::source::Source;
use crate::formats::surface::NamedMap;
use crate::formats::written_material::material_toml;
use crate::formats::{Diagnostic, Document};

/// Calibrates the material of `design` if the design names a calibration, and returns the calibration; `None` if the
/// material is known.
///
/// # Errors
/// [`Failure`] if the calibration is refused or fails.
pub fn complete(design: &mut Design, files: &Source, monitor: &dyn Monitor) -> Result<Option<Calibration>, Failure> {
    let Some(calibration) = read_calibration(design, files)? else { return Ok(None) };
    complete_by(design, &calibration, files, monitor)?;
    Ok(Some(calibration))
}

/// Reads the calibration that gives `design` its material; `None` if the material is known.
///
/// # Errors
/// [`Diagnostic`] for anything refused in the calibration.
pub fn read_calibration(design: &Design, files: &Source) -> Result<Option<Calibration>, Diagnostic> {
    design.calibration.as_ref().map(|path| Calibration::read(files, path)).transpose()
}

/// Fits `calibration` and sets the material of the task of `design`; does nothing if the material is known.
///
/// # Errors
/// Errors of [`complete`].
pub fn complete_by(
    design: &mut Design,
    calibration: &Calibration,
    files: &Source,
    monitor: &dyn Monitor,
) -> Result<(), Failure> {
    let Some(path) = design.calibration.clone() else { return Ok(()) };
    // A pressure or condition that was not measured is refused before any computation.
    let measured = as_measured(calibration)?;
    let checked = design.task.resolve(&measured.friction);
    checked.map_err(|refused| design.refuse(&refused))?;
    let task = &design.task;
    task.loads(&measured).map_err(|refused| design.refuse(&refused))?;
    let conditions = task.condition.iter().chain(&task.also_at).copied().collect();
    let selection = Selection { conditions, pressures_pa: task.pressures_pa() };
    let asked = calibration.task(files, (task.layer, task.search.seed), selection, monitor)?;
    // The design sets the block size, so an error in the number of blocks is not reported as one of the calibration.
    let refused = |error: &SceneError| design.refuse(&Refusal::of_cost("samples of the calibration", error)).into();
    if let Err(CalibrationError::Scene(error)) = sample_bytes(&asked) {
        return Err(refused(&error));
    }
    let material = known_material(&asked, monitor).map_err(|error| match &error {
        // The blocks of the flat sample are set by the design as well.
        CalibrationError::Fit {
            error: FitError::Scene(error @ (SceneError::TooLarge { .. } | SceneError::TooLong { .. })),
            ..
        } => refused(error),
        _ => failed(&error, &path, calibration),
    })?;
    design.task.material = Some(material);
    design.task.is_calibrated = true;
    Ok(())
}

/// Material of `task`: read from the cache, or calibrated now.
fn known_material(task: &CalibrationTask, monitor: &dyn Monitor) -> Result<KnownMaterial, CalibrationError> {
    // Cached files of earlier versions had no flat friction.
    let memory = monitor.memory().map(|memory| (memory, Key::of("material", &("with flat friction", task))));
    let recalled = memory.as_ref().and_then(|(memory, key)| memory.recall(key));
    if let Some(known) = recalled.and_then(|bytes| read_kept(String::from_utf8(bytes).ok()?)) {
        return Ok(known);
    }
    let found = outcome(task, monitor)?;
    let file = memory.and_then(|(memory, key)| Some((memory, key, material_toml(task, &found, None).ok()?)));
    let known = KnownMaterial { material: found.material, uncertainty: found.uncertainty };
    // Only a file that reads back unchanged is cached.
    if let Some((memory, key, text)) = file
        && read_kept(text.clone()).as_ref() == Some(&known)
    {
        memory.keep(&key, text.as_bytes());
    }
    Ok(known)
}

/// Parses a cached material file; `None` if it is invalid.
fn read_kept(text: String) -> Option<KnownMaterial> {
    let document = Document::new("kept.toml", text);
    let (material, uncertainty) = read_known(&document, &document.parse().ok()?, &(0..0)).ok()?;
    Some(KnownMaterial { material, uncertainty })
}

/// Material with measured instead of local friction, for checks before the fit.
fn as_measured(calibration: &Calibration) -> Result<Material, Failure> {
    let CalibrationTask { flat, specimen_area_m2, coefficients, relative_std, .. } = &calibration.stated;
    let friction = measured_friction(flat, *specimen_area_m2, *coefficients, *relative_std).map_err(Failure::failed)?;
    Ok(Material { elastic: calibration.stated.elastic, friction, area_law: None, provenance: Provenance::default() })
}

/// Runs the `calibration` from `path` for a sample with this layer and seed, for the measurements in `selection`.
/// Returns the task and its outcome.
///
/// # Errors
/// [`Failure`] if the calibration is refused or fails.
pub fn calibrate(
    calibration: &Calibration,
    path: &Path,
    files: &Source,
    sample: (Layer, u64),
    selection: Selection,
    monitor: &dyn Monitor,
) -> Result<(CalibrationTask, CalibrationOutcome), Failure> {
    let task = calibration.task(files, sample, selection, monitor)?;
    let outcome = outcome(&task, monitor).map_err(|error| failed(&error, path, calibration))?;
    Ok((task, outcome))
}

/// Runs `task` and adds advice to the warnings about the map.
fn outcome(task: &CalibrationTask, monitor: &dyn Monitor) -> Result<CalibrationOutcome, CalibrationError> {
    let mut outcome = slipgrid_infer::calibrate::run(task, monitor)?;
    let of_surface = &outcome.surface.warnings;
    for (warning, told) in of_surface.iter().map(ToString::to_string).zip(law_warnings(of_surface)) {
        let own = outcome.material.provenance.warnings.iter_mut().find(|own| **own == warning);
        own.into_iter().for_each(|own| told.clone_into(own));
    }
    Ok(outcome)
}

/// Computes the discrepancy of the model from the trials of the `calibration` from `path`, without the fit if possible.
/// Returns the task with the learned samples.
///
/// # Errors
/// [`Failure`] if the calibration is refused or fails.
pub fn learn(
    calibration: &Calibration,
    path: &Path,
    files: &Source,
    sample: (Layer, u64),
    monitor: &dyn Monitor,
) -> Result<(CalibrationTask, Learned), Failure> {
    let task = calibration.task(files, sample, Selection::default(), monitor)?;
    let learned =
        slipgrid_infer::calibrate::learn_alone(&task, monitor).map_err(|error| failed(&error, path, calibration))?;
    Ok((task, learned))
}

/// Converts the error of a calibration to a `Failure`.
fn failed(error: &CalibrationError, path: &Path, calibration: &Calibration) -> Failure {
    match (refuse(error, path, calibration), error) {
        (Some(refused), _) => refused.into(),
        (None, CalibrationError::Cancelled | CalibrationError::AreaLaw(AreaLawError::Cancelled)) => Failure::Cancelled,
        (None, CalibrationError::Fit { error, .. }) => Failure::Failed(format!("calibration: {error}")),
        (None, error) => Failure::failed(error),
    }
}

/// Diagnostic for an error in the calibration at `path`; `None` if the input did not cause the error.
fn refuse(error: &CalibrationError, path: &Path, calibration: &Calibration) -> Option<Diagnostic> {
    let at_key = || Diagnostic { key: error.field().map(Into::into), ..Diagnostic::file(path, error.to_string()) };
    match (error, &calibration.map) {
        (CalibrationError::Cancelled, _) => None,
        (CalibrationError::AreaLaw(AreaLawError::Windows(_)), _) => Some(at_key()),
        (CalibrationError::AreaLaw(error), Some(NamedMap { path, .. })) => refuse_law(path, error),
        (CalibrationError::MapAfter(reason), Some(NamedMap { after: Some(path), .. })) => {
            Some(Diagnostic::file(path, reason.clone()))
        }
        (
            CalibrationError::NoAreaLaw(_)
            | CalibrationError::OutOfRange { .. }
            | CalibrationError::Scene(_)
            | CalibrationError::Specimen(_),
            _,
        ) => Some(Diagnostic::file(path, error.to_string())),
        (CalibrationError::Fit { error, measurement }, _) => refuse_fit(error, measurement.as_ref(), path, calibration),
        _ => None,
    }
}

/// Diagnostic for an error of the fit, at the measurement concerned; `None` if the input did not cause the error.
fn refuse_fit(
    error: &FitError,
    measurement: Option<&Measurement>,
    path: &Path,
    calibration: &Calibration,
) -> Option<Diagnostic> {
    let (speed, change);
    let expected = match error {
        FitError::NoSliding { status: "no_onset", .. } => {
            "friction and a load at which the modelled layer slides as a whole, or no mu_static in this row"
        }
        FitError::NoSliding { .. } => {
            "a load and a speed at which the modelled layer slides evenly: a lower speed or a higher load, where it slides in waves (sliding_waves)"
        }
        FitError::PeakTooHigh { .. } => "a smaller mu_static, or nothing in mu_static and mu_static_std",
        FitError::BeyondLaw { .. } => "another [surface], or a smaller load",
        FitError::TooFast { most_m_s, modulus_pa, most_modulus_pa, .. } => {
            let most_mm_s = significant_to(SPEED_MM_S.from_si(*most_m_s), 2, f64::floor);
            let [modulus_gpa, most_gpa] = [*modulus_pa, *most_modulus_pa].map(|pa| tidy(MODULUS_GPA.from_si(pa)));
            let least_gpa = MODULUS.measurable[0];
            let slip = MODULUS.within([least_gpa, most_gpa]).slip(modulus_gpa);
            let slip = slip.map_or_else(String::new, |slip| format!(" ({slip})"));
            let modulus = match significant_to(most_gpa, 2, f64::floor) {
                most_gpa if most_gpa >= least_gpa => format!(", or youngs_modulus_gpa of at most {most_gpa}{slip}"),
                _ => String::new(),
            };
            // The highest speed is proportional to the pressure.
            let force = measurement.map_or_else(String::new, |row| {
                let least_n = significant_to(row.force_n * row.speed_m_s / most_m_s, 2, f64::ceil);
                format!("force_n of at least {least_n}, ")
            });
            // Exchanged, the speed in mm/s is the force in newtons and the reverse.
            let exchanged = measurement.map_or_else(String::new, |row| {
                let (force_n, speed_mm_s) = (tidy(SPEED_MM_S.from_si(row.speed_m_s)), row.force_n);
                let is_usual = FORCE.judge(force_n) == Ok(None) && SPEED.judge(speed_mm_s) == Ok(None);
                let fits = SPEED_MM_S.to_si(speed_mm_s) <= most_m_s * force_n / row.force_n;
                let words =
                    || format!("; with force_n and speed_mm_s in each other's place, {force_n} N at {speed_mm_s} mm/s");
                if is_usual && fits { words() } else { String::new() }
            });
            change = format!("{force}speed_mm_s of at most {most_mm_s}{modulus}{exchanged}");
            &change
        }
        FitError::NotQuasiStatic { .. } => {
            "a larger force_n, a smaller speed_mm_s, or mu_dynamic below 1, above which the modelled layer hardly slides steadily; is its \
             unit right, that of a friction force in traces among them?"
        }
        FitError::TooManySteps { least_m_s, .. } => {
            let least_mm_s = significant_to(SPEED_MM_S.from_si(*least_m_s), 2, f64::ceil);
            speed = format!("speed_mm_s of at least {least_mm_s}, or this row left out");
            &speed
        }
        FitError::TooManyCoefficients { .. } => "fewer conditions, or coefficients = \"single\" in [fit]",
        FitError::TooMuchWork { .. } => "fewer rows, or larger speeds",
        _ => return None,
    };
    let text = error.to_string();
    let reason = text.split_once(": expected").map_or(text.as_str(), |(reason, _)| reason);
    let row = measurement.and_then(|measurement| calibration.place(measurement));
    let Some(row) = row else { return Some(Diagnostic::file(path, reason).expected(expected)) };
    // The condition replaces the row number in the message.
    let reason = reason.split_once(": ").map_or(reason, |(_, reason)| reason);
    let measured = match error {
        FitError::NotQuasiStatic { .. } | FitError::NoSliding { .. } => {
            format!(", mu_dynamic {}", tidy(row.measurement.mu_dynamic))
        }
        _ => String::new(),
    };
    let reason = format!("({}{measured}): {reason}", row.condition());
    Some(Diagnostic { line: Some(row.line), ..Diagnostic::file(&row.path, reason) }.expected(expected))
}
