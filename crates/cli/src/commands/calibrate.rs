//! `calibrate`: local friction coefficients from measurements on flat samples.

use std::path::Path;

use slipgrid_calibrate::area_law::AreaLawError;
use slipgrid_calibrate::{CalibrationError, CalibrationOutcome, CalibrationTask, Selection};
use slipgrid_material::{Material, Provenance};
use slipgrid_springblock::Layer;

use crate::args::CalibrateArgs;
use crate::input::disk;
use crate::output::{Place, check_file, check_folder, write_file};
use crate::progress::Job;
use crate::{CliError, Console, exit_code};
use slipgrid_formats::altitude_map::law_warnings;
use slipgrid_formats::calibration::Calibration;
use slipgrid_formats::refused_calibration::refuse;
use slipgrid_formats::scene::DEFAULT_SPECIMEN;
use slipgrid_formats::written_material::material_toml;
use slipgrid_report::calibration;

/// Seed of the flat sample's local coefficients where nothing else names one.
pub const DEFAULT_SEED: u64 = 1;

/// What is written into the folder of a report, beside what there is of traces.
const FILES: [&str; 4] = ["fit.json", "profiles.csv", "residuals.svg", "trials.*"];

/// Calibrates and reports.
pub fn run(args: &CalibrateArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let read = Calibration::read(&disk(), &args.calibration)?;
    if let Some(path) = &args.output {
        check_file(Place::output(path), &read.inputs)?;
    }
    if let Some(folder) = &args.report {
        let place = Place { flag: "--report", path: folder };
        let names = [&FILES[..], &super::traces::FILES].concat();
        check_folder(place, &names, &read.inputs)?;
    }
    let sample = (DEFAULT_SPECIMEN, DEFAULT_SEED);
    let (task, outcome) = outcome(&args.calibration, &read, sample, Selection::default(), console)?;
    let file = material_toml(&task, &outcome)?;
    if let Some(path) = &args.output {
        write_file(path, file.as_bytes())?;
    }
    if let Some(folder) = &args.report {
        let outputs = calibration::files(&read, &outcome)?;
        console.keep(&outputs, folder)?;
    }
    console.answer(&calibration::summary(&read, &task, &outcome))?;
    match &args.output {
        Some(path) => console.note(&format!("wrote {}", path.display())),
        None => console.note("nothing written; -o MATERIAL.toml keeps the material"),
    }
    Ok(exit_code::DONE)
}

/// The material as measured, before anything is fitted: enough to find out whether the pressures and the condition of a design
/// are among those measured.
pub fn provisional(calibration: &Calibration) -> Result<Material, CliError> {
    let Calibration { flat, specimen_area_m2, coefficients, relative_std, .. } = calibration;
    let friction = slipgrid_calibrate::measured_friction(flat, *specimen_area_m2, *coefficients, *relative_std)
        .map_err(|error| CliError::Other(error.to_string()))?;
    Ok(Material { elastic: calibration.elastic, friction, area_law: None, provenance: Provenance::default() })
}

/// The calibration at `path` of a sample with this layer and seed, as far as `selection` needs it.
pub fn outcome(
    path: &Path,
    calibration: &Calibration,
    sample: (Layer, u64),
    selection: Selection,
    console: &mut Console<'_>,
) -> Result<(CalibrationTask, CalibrationOutcome), CliError> {
    let task = calibration.task(&disk(), sample, selection)?;
    let outcome = slipgrid_calibrate::run(&task, &Job::new(console));
    let mut outcome = outcome.map_err(|error| failed(&error, path, calibration))?;
    // What can be done about a doubtful map is said as well.
    let warnings = &mut outcome.material.provenance.warnings;
    warnings.splice(..outcome.surface.warnings.len(), law_warnings(&outcome.surface.warnings));
    Ok((task, outcome))
}

/// Why a calibration ended without a material.
pub fn failed(error: &CalibrationError, path: &Path, calibration: &Calibration) -> CliError {
    match (refuse(error, path, calibration), error) {
        (Some(refused), _) => refused.into(),
        (None, CalibrationError::Cancelled | CalibrationError::AreaLaw(AreaLawError::Cancelled)) => {
            CliError::Interrupted
        }
        (None, CalibrationError::Fit { error, .. }) => CliError::Other(format!("calibration: {error}")),
        (None, error) => CliError::Other(error.to_string()),
    }
}
