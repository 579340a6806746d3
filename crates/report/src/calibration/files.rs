//! Files of a calibration.

use slipgrid_infer::calibrate::{CalibrationOutcome, CalibrationTask};
use slipgrid_io::formats::calibration::Calibration;

use super::{fit_details, fit_json, pictures};
use crate::friction_sheet::{self, FrictionSheet};
use crate::trials::TrialsReport;
use crate::{Outputs, ReportError, html};

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

/// Makes the files of a calibration: page, fit, profiles, residuals, flat friction, area law, the ledger of trials, the
/// sheet of the measurements, and traces if there are any.
///
/// # Errors
/// [`ReportError`] if a picture cannot be drawn or a record has no JSON form.
pub fn files(
    calibration: &Calibration,
    task: &CalibrationTask,
    outcome: &CalibrationOutcome,
    ledger: Option<&TrialsReport>,
) -> Result<Outputs, ReportError> {
    let mut outputs =
        if calibration.traces.is_empty() { Outputs::default() } else { crate::traces::files(&calibration.traces)? };
    outputs.add("fit.json", fit_json(task, outcome)?);
    outputs.add("profiles.csv", fit_details::profiles(&outcome.fit));
    outputs.add("residuals.svg", fit_details::residuals(&calibration.stated.name, outcome)?);
    let title = format!("{}: friction of flat samples", calibration.stated.name);
    outputs.add("flat-friction.svg", pictures::flat_friction(&title, task, outcome)?);
    if let Some(picture) = pictures::area_law(task, outcome)? {
        outputs.add("area-law.svg", picture);
    }
    if let Some(ledger) = ledger {
        outputs.add("trials.csv", ledger.csv());
        outputs.add("trials.svg", ledger.picture()?);
    }
    let sheet = FrictionSheet::new(calibration);
    outputs.add(friction_sheet::FILE, sheet.markdown());
    let page = html::calibration(html::Fitted { calibration, task, outcome, ledger, sheet: &sheet }, &outputs);
    outputs.add("report.html", page);
    Ok(outputs)
}
