//! Reports on a calibration: text, tables, pictures.

mod files;
mod fit_details;
mod pictures;
mod static_friction;

pub use files::{FILES, files};
pub use fit_details::{FitReport, fit_json};
pub(crate) use fit_details::{in_words, parameter_table, which_errors};
pub(crate) use pictures::flat_friction;
pub use static_friction::StaticRow;
pub(crate) use static_friction::{rows as static_rows, table as static_table, words as static_words};

use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, counted};
use slipgrid_design::results::{SCREEN_WIDTH, Table, WHERE_ALL, doubts_in_brief, fixed, wrapped};
use slipgrid_infer::calibrate::{CalibrationOutcome, CalibrationTask, FittedPair, Measurement};
use slipgrid_io::formats::calibration::Calibration;

use crate::trials::TrialsReport;

/// Maximum number of measurements listed on the screen; further measurements are only counted.
const MAX_MEASUREMENTS: usize = 8;

/// Formats the calibration as text, including the [`ledger`] of its trials.
pub fn summary(
    calibration: &Calibration,
    task: &CalibrationTask,
    outcome: &CalibrationOutcome,
    ledger: Option<&TrialsReport>,
) -> String {
    let mut text = format!("{} ({})\n", calibration.stated.name, calibration.stated.source);
    for warning in &outcome.material.provenance.warnings {
        text += &format!("! {warning}\n");
    }
    for note in &outcome.material.provenance.notes {
        text += &format!("- {note}\n");
    }
    text += &format!("\n{}", flat_samples(task, outcome));
    let peaks = static_rows(task, outcome);
    text += &static_words(&peaks).map_or_else(String::new, |words| format!("\n{words}\n{}", static_table(&peaks)));
    if !outcome.fit.parameters.is_empty() {
        let (which, table) = (which_errors(outcome), parameter_table(outcome));
        text += &format!("\nby profile likelihood, {which}; a dash is an end that the data leave open\n{table}");
    }
    if let Some(ledger) = ledger {
        text += &format!("\n{}", ledger.text());
    } else if lacks_pattern(calibration) {
        text += "\n- measurements of patterned samples are given, but not their pattern: a table [pattern] would make a trial of them\n";
    }
    text
}

/// Formats the calibration for the screen; [`summary`] has all details.
pub fn brief(
    calibration: &Calibration,
    task: &CalibrationTask,
    outcome: &CalibrationOutcome,
    ledger: Option<&TrialsReport>,
) -> String {
    let line = |text: &str| wrapped(text, SCREEN_WIDTH, "  ", 2) + "\n";
    let provenance = &outcome.material.provenance;
    let mut text = line(&format!("{} ({})", calibration.stated.name, calibration.stated.source));
    text += &format!("\n  flat samples\n{}\n", flat_samples(task, outcome).brief(MAX_MEASUREMENTS));
    text += &doubts_in_brief(&provenance.warnings);
    text += &ledger.map_or_else(String::new, |ledger| line(&format!("- {}", ledger.learned_in_words())));
    if lacks_pattern(calibration) {
        text += &line("! patterned samples are measured, but [pattern], which would make a trial of them, is missing");
    }
    let trials = if ledger.is_some() { ", trials" } else { "" };
    text + &format!("{}, intervals of the coefficients{trials}: {WHERE_ALL}\n", counted(provenance.notes.len(), "note"))
}

/// Whether patterned samples were measured whose pattern is not given.
fn lacks_pattern(calibration: &Calibration) -> bool {
    !calibration.patterned.is_empty() && calibration.pattern.is_none()
}

/// Fitted pair of coefficients that belongs to the measurement with the index `row`; `None` if there is no such pair.
pub(crate) fn pair_of(outcome: &CalibrationOutcome, row: usize) -> Option<&FittedPair> {
    let pairs = &outcome.fit.pairs;
    if pairs.len() == 1 { pairs.first() } else { pairs.get(row) }
}

/// Table of the measured friction of flat samples, with the fitted coefficients and the residuals.
pub(crate) fn flat_samples(task: &CalibrationTask, outcome: &CalibrationOutcome) -> Table {
    let rows: Vec<(&Measurement, Option<&FittedPair>, Option<f64>)> = outcome
        .measurements
        .iter()
        .enumerate()
        .map(|(row, of)| {
            (of, pair_of(outcome, row), outcome.fit.predictions.get(row).map(|predicted| predicted.residual))
        })
        .collect();
    let mut table = Table::of(&rows);
    table.column("F N", |(of, ..)| of.force_n.to_string());
    table.column("P MPa", |(of, ..)| fixed(Some(PRESSURE_MPA.from_si(task.pressure_pa(of))), 3));
    table.column("v mm/s", |(of, ..)| SPEED_MM_S.from_si(of.speed_m_s).to_string());
    table.column("RH %", |(of, ..)| HUMIDITY_PCT.from_si(of.humidity).to_string());
    table.column("mu measured", |(of, ..)| fixed(Some(of.mu_dynamic), 4));
    table.column("+-", |(of, ..)| fixed(Some(of.mu_dynamic_std), 4));
    table.column("mu_d", |(_, pair, _)| fixed(pair.map(|pair| pair.dynamic_mean), 4));
    table.column("+-", |(_, pair, _)| fixed(pair.and_then(|pair| pair.dynamic_std_error), 4));
    table.column("mu_s", |(_, pair, _)| fixed(pair.map(|pair| pair.static_mean), 4));
    table.column("+-", |(_, pair, _)| fixed(pair.and_then(|pair| pair.static_std_error), 4));
    table.column("model - measured", |(.., residual)| fixed(*residual, 4));
    table.table()
}

/// Makes the ledger of the calibration's trials; `None` if no trial was measured.
///
/// # Errors
/// [`Cancelled`] once `monitor` has cancelled.
pub fn ledger(
    calibration: &Calibration,
    outcome: &CalibrationOutcome,
    monitor: &dyn Monitor,
) -> Result<Option<TrialsReport>, Cancelled> {
    let learned = outcome.uncertainty.learned.as_ref().filter(|learned| !learned.trials().is_empty());
    let Some(learned) = learned else { return Ok(None) };
    let ledger = TrialsReport::new(
        &calibration.stated.name,
        &calibration.stated.flat,
        &calibration.stated.trials.samples,
        learned,
        monitor,
    )?;
    // The material's warnings, which the calibration prints, already include the ledger's warnings.
    Ok(Some(TrialsReport { warnings: Vec::new(), ..ledger }))
}
