//! `trials`: what was predicted of samples before they were cut, what was measured, and what that says of the next.

use slipgrid_calibrate::{Selection, learn_alone};
use slipgrid_formats::calibration::Calibration;
use slipgrid_formats::scene::DEFAULT_SPECIMEN;
use slipgrid_report::trials::TrialsReport;

use super::calibrate::{DEFAULT_SEED, failed};
use crate::args::TrialsArgs;
use crate::input::disk;
use crate::output::{Place, check_folder};
use crate::progress::Job;
use crate::{CliError, Console, exit_code};

/// Compares every trial with the model and reports.
pub fn run(args: &TrialsArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let calibration = Calibration::read(&disk(), &args.calibration)?;
    if let Some(folder) = &args.output {
        check_folder(Place::output(folder), &["trials.*", "result.json", "timings.json"], &calibration.inputs)?;
    }
    let task = calibration.task(&disk(), (DEFAULT_SPECIMEN, DEFAULT_SEED), Selection::default())?;
    let learned = learn_alone(&task, &Job::new(console));
    let learned = learned.map_err(|error| failed(&error, &args.calibration, &calibration))?;
    let report = TrialsReport::new(&calibration.name, &task.trials.samples, &learned);
    if let Some(folder) = &args.output {
        console.keep(&report.files()?, folder)?;
    }
    console.report(args.json, &report, || report.text())?;
    Ok(exit_code::DONE)
}
