//! `calibrate`: local friction coefficients from measurements on flat samples.

mod details;
mod discrepancy;
mod write;

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
use slipgrid_report::Outputs;
use slipgrid_results::Table;
use slipgrid_results::fixed;
use slipgrid_units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S};

/// Seed of the flat sample's local coefficients where nothing else names one.
const DEFAULT_SEED: u64 = 1;

/// What is written into the folder of a report, beside what there is of traces.
const FILES: [&str; 4] = ["fit.json", "profiles.csv", "residuals.svg", "discrepancy.*"];

/// Calibrates and reports.
pub fn run(args: &CalibrateArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let calibration = Calibration::read(&disk(), &args.calibration)?;
    if let Some(path) = &args.output {
        check_file(Place::output(path), &calibration.inputs)?;
    }
    if let Some(folder) = &args.report {
        let place = Place { flag: "--report", path: folder };
        let names = [&FILES[..], &super::traces::FILES].concat();
        check_folder(place, &names, &calibration.inputs)?;
    }
    let sample = (DEFAULT_SPECIMEN, DEFAULT_SEED);
    let (task, outcome) = outcome(&args.calibration, &calibration, sample, Selection::default(), console)?;
    let file = write::material_toml(&task, &outcome)?;
    if let Some(path) = &args.output {
        write_file(path, file.as_bytes())?;
    }
    if let Some(folder) = &args.report {
        let outputs = report(&calibration, &outcome)?;
        crate::output::write(&outputs, folder)?;
        console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    }
    console.answer(&summary(&calibration, &task, &outcome))?;
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
fn failed(error: &CalibrationError, path: &Path, calibration: &Calibration) -> CliError {
    match (refuse(error, path, calibration), error) {
        (Some(refused), _) => refused.into(),
        (None, CalibrationError::Cancelled | CalibrationError::AreaLaw(AreaLawError::Cancelled)) => {
            CliError::Interrupted
        }
        (None, CalibrationError::Fit { error, .. }) => CliError::Other(format!("calibration: {error}")),
        (None, error) => CliError::Other(error.to_string()),
    }
}

fn summary(calibration: &Calibration, task: &CalibrationTask, outcome: &CalibrationOutcome) -> String {
    let fit = &outcome.fit;
    let mut text = format!("{} ({})\n", calibration.name, calibration.source);
    for note in &outcome.material.provenance.notes {
        text += &format!("- {note}\n");
    }
    for warning in &outcome.material.provenance.warnings {
        text += &format!("! {warning}\n");
    }
    let mut table = Table::new([
        "F N",
        "P MPa",
        "v mm/s",
        "RH %",
        "mu measured",
        "+-",
        "mu_d",
        "+-",
        "mu_s",
        "+-",
        "model - measured",
    ]);
    for (row, measured) in outcome.measurements.iter().enumerate() {
        let pair = if fit.pairs.len() == 1 { fit.pairs.first() } else { fit.pairs.get(row) };
        table.row([
            measured.force_n.to_string(),
            fixed(Some(PRESSURE_MPA.from_si(task.pressure_pa(measured))), 3),
            SPEED_MM_S.from_si(measured.speed_m_s).to_string(),
            HUMIDITY_PCT.from_si(measured.humidity).to_string(),
            fixed(Some(measured.mu_dynamic), 4),
            fixed(Some(measured.mu_dynamic_std), 4),
            fixed(pair.map(|pair| pair.dynamic_mean), 4),
            fixed(pair.and_then(|pair| pair.dynamic_std_error), 4),
            fixed(pair.map(|pair| pair.static_mean), 4),
            fixed(pair.and_then(|pair| pair.static_std_error), 4),
            fixed(fit.predictions.get(row).map(|predicted| predicted.residual), 4),
        ]);
    }
    text += &format!("\n{table}{}", details::table(fit));
    if let Some(patterned) = &outcome.patterned {
        text += &format!(
            "\nratios patterned / flat: measured, by the model, and predicted without the row itself\n{}",
            discrepancy::table(patterned)
        );
    } else if !calibration.patterned.is_empty() && calibration.pattern.is_none() {
        text += "\n- measurements of patterned samples are given, but not their pattern: a table [pattern] would give the model's discrepancy\n";
    }
    text
}

/// Everything that was found, for the folder of a report.
fn report(calibration: &Calibration, outcome: &CalibrationOutcome) -> Result<Outputs, CliError> {
    let mut outputs =
        if calibration.traces.is_empty() { Outputs::default() } else { super::traces::outputs(&calibration.traces)? };
    outputs.add("fit.json", details::json(&outcome.fit)?);
    outputs.add("profiles.csv", details::profiles(&outcome.fit));
    outputs.add("residuals.svg", details::residuals(&calibration.name, outcome)?);
    if let Some(patterned) = &outcome.patterned {
        outputs.add("discrepancy.csv", discrepancy::csv(patterned));
    }
    Ok(outputs)
}
