//! Reports on calibrations: tables, pictures and files of a fit.

mod fit_details;
mod pictures;
mod static_friction;

pub use fit_details::FitReport;
pub(crate) use fit_details::parameter_value;
pub use static_friction::StaticPeakFit;
pub(crate) use static_friction::{table as static_table, words as static_words};

use slipgrid_base::monitor::{Cancelled, Monitor};
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, counted};
use slipgrid_design::results::{SCREEN_WIDTH, Table, WHERE_ALL, doubts_in_brief, fixed, wrapped};
use slipgrid_infer::calibrate::{CalibrationOutcome, CalibrationTask, FittedPair, Measurement, ModelledRow};
use slipgrid_io::formats::calibration::Calibration;

use crate::friction_sheet::{self, FrictionSheet};
use crate::trials::TrialsReport;
use crate::{Failure, Outputs, html};

/// Names of a calibration's files other than traces, with `*` as a wildcard.
pub const FILES: [&str; 8] = [
    "report.html",
    "fit.json",
    "profiles.csv",
    "residuals.svg",
    "flat-friction.svg",
    "area-law.svg",
    "trials.*",
    friction_sheet::FILE,
];

/// Maximum number of measurements listed on the screen; further measurements are only counted.
const MAX_MEASUREMENTS: usize = 8;

/// Calibration with its fit and the ledger of its trials.
pub struct Fitted {
    /// The calibration as read.
    pub calibration: Calibration,
    /// Task of the fit.
    pub task: CalibrationTask,
    /// Outcome of the fit.
    pub outcome: CalibrationOutcome,
    /// Ledger of trials, if a trial was measured.
    pub ledger: Option<TrialsReport>,
}

impl Fitted {
    /// Makes the ledger of the trials of a fitted `calibration`.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` has cancelled.
    pub fn new(
        calibration: Calibration,
        (task, outcome): (CalibrationTask, CalibrationOutcome),
        monitor: &dyn Monitor,
    ) -> Result<Self, Cancelled> {
        let stated = &calibration.stated;
        let learned = outcome.uncertainty.learned.as_ref().filter(|learned| !learned.trials().is_empty());
        let ledger = learned
            .map(|learned| TrialsReport::new(&stated.name, &stated.flat, &stated.trials.samples, learned, monitor))
            .transpose()?;
        // The material's warnings, which are printed, already include the ledger's warnings.
        let ledger = ledger.map(|ledger| TrialsReport { warnings: Vec::new(), ..ledger });
        Ok(Self { calibration, task, outcome, ledger })
    }

    /// Formats the calibration as text, including the ledger of its trials.
    pub fn summary(&self) -> String {
        let (stated, provenance) = (&self.calibration.stated, &self.outcome.material.provenance);
        let mut text = format!("{} ({})\n", stated.name, stated.source);
        text += &(crate::marked("!", &provenance.warnings) + &crate::marked("-", &provenance.notes));
        text += &format!("\n{}", self.flat_samples());
        let peaks = self.static_rows();
        text += &static_words(&peaks).map_or_else(String::new, |words| format!("\n{words}\n{}", static_table(&peaks)));
        if !self.outcome.fit.parameters.is_empty() {
            let (which, table) = (self.which_errors(), self.parameter_table());
            text += &format!("\nby profile likelihood, {which}; a dash is an end that the data leave open\n{table}");
        }
        if let Some(ledger) = &self.ledger {
            text += &format!("\n{}", ledger.text());
        } else if self.lacks_pattern() {
            text += "\n- measurements of patterned samples are given, but not their pattern: a table [pattern] would make a trial of them\n";
        }
        text
    }

    /// Formats the calibration for the screen; [`Self::summary`] has all details.
    pub fn brief(&self) -> String {
        let line = |text: &str| wrapped(text, SCREEN_WIDTH, "  ", 2) + "\n";
        let (stated, provenance) = (&self.calibration.stated, &self.outcome.material.provenance);
        let mut text = line(&format!("{} ({})", stated.name, stated.source));
        text += &format!("\n  flat samples\n{}\n", self.flat_samples().brief(MAX_MEASUREMENTS));
        text += &doubts_in_brief(&provenance.warnings);
        text +=
            &self.ledger.as_ref().map_or_else(String::new, |ledger| line(&format!("- {}", ledger.learned_in_words())));
        if self.lacks_pattern() {
            text +=
                &line("! patterned samples are measured, but [pattern], which would make a trial of them, is missing");
        }
        let trials = if self.ledger.is_some() { ", trials" } else { "" };
        text + &format!(
            "{}, intervals of the coefficients{trials}: {WHERE_ALL}\n",
            counted(provenance.notes.len(), "note")
        )
    }

    /// Makes the files of the calibration: page, fit, profiles, residuals, flat friction, area law, the ledger of
    /// trials, the sheet of the measurements, and traces if there are any.
    ///
    /// # Errors
    /// [`Failure`] if a picture cannot be drawn or a record has no JSON form.
    pub fn files(&self) -> Result<Outputs, Failure> {
        let (traces, name) = (&self.calibration.traces, &self.calibration.stated.name);
        let mut outputs = if traces.is_empty() { Outputs::default() } else { crate::traces::files(traces)? };
        outputs.add("fit.json", self.fit_json()?);
        outputs.add("profiles.csv", self.profiles());
        outputs.add("residuals.svg", self.residuals()?);
        outputs.add("flat-friction.svg", self.flat_friction(&format!("{name}: friction of flat samples"))?);
        if let Some(picture) = self.area_law()? {
            outputs.add("area-law.svg", picture);
        }
        if let Some(ledger) = &self.ledger {
            outputs.add("trials.csv", ledger.csv());
            outputs.add("trials.svg", ledger.picture()?);
        }
        let sheet = FrictionSheet::new(&self.calibration);
        outputs.add(friction_sheet::FILE, sheet.markdown());
        let page = html::calibration(self, &sheet, &outputs);
        outputs.add("report.html", page);
        Ok(outputs)
    }

    /// Whether patterned samples were measured whose pattern is not given.
    fn lacks_pattern(&self) -> bool {
        !self.calibration.patterned.is_empty() && self.calibration.pattern.is_none()
    }

    /// Measurements on flat samples, each with the model's prediction.
    pub(crate) fn measured(&self) -> impl Iterator<Item = (&Measurement, &ModelledRow)> {
        self.outcome.measurements.iter().zip(&self.outcome.fit.predictions)
    }

    /// Fitted pair of coefficients of each measurement; a single pair belongs to all measurements.
    pub(crate) fn pairs(&self) -> impl Iterator<Item = &FittedPair> {
        self.outcome.fit.pairs.iter().cycle()
    }

    /// Nominal pressure of a measurement, in MPa.
    pub(crate) fn pressure_mpa(&self, of: &Measurement) -> f64 {
        PRESSURE_MPA.from_si(self.task.pressure_pa(of))
    }

    /// Table of the measured friction of flat samples, with the fitted coefficients and the residuals.
    pub(crate) fn flat_samples(&self) -> Table {
        let rows: Vec<_> = self.measured().zip(self.pairs()).collect();
        let mut table = Table::of(&rows);
        table.column("F N", |((of, _), _)| of.force_n.to_string());
        table.column("P MPa", |((of, _), _)| fixed(Some(self.pressure_mpa(of)), 3));
        table.column("v mm/s", |((of, _), _)| SPEED_MM_S.from_si(of.speed_m_s).to_string());
        table.column("RH %", |((of, _), _)| HUMIDITY_PCT.from_si(of.humidity).to_string());
        table.column("mu measured", |((of, _), _)| fixed(Some(of.mu_dynamic), 4));
        table.column("+-", |((of, _), _)| fixed(Some(of.mu_dynamic_std), 4));
        table.column("mu_d", |(_, pair)| fixed(Some(pair.dynamic_mean), 4));
        table.column("+-", |(_, pair)| fixed(pair.dynamic_std_error, 4));
        table.column("mu_s", |(_, pair)| fixed(Some(pair.static_mean), 4));
        table.column("+-", |(_, pair)| fixed(pair.static_std_error, 4));
        table.column("model - measured", |((_, predicted), _)| fixed(Some(predicted.residual), 4));
        table.table()
    }
}
