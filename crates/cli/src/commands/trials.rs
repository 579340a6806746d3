//! `trials`: compares predictions and measurements of trials, and updates the predictions for further samples.

use slipgrid_io::formats::calibrated::learn;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::scene::DEFAULT_SAMPLE;
use slipgrid_report::friction_sheet::{self, FrictionSheet};
use slipgrid_report::linked_data;
use slipgrid_report::trials::TrialsReport;

use crate::args::TrialsArgs;
use crate::output::open;
use crate::progress::Job;
use crate::{CliError, Console};
use slipgrid_io::disk::disk;

/// Compares every trial with the model and reports.
pub fn run(args: &TrialsArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let calibration = Calibration::read(&disk(), &args.calibration)?;
    console.warn(&calibration.stated.notes);
    let names = ["trials.*", "report.html", "result.json", "timings.json", friction_sheet::FILE, linked_data::FILE];
    let folder = open(args.output.as_ref(), &names, &calibration.inputs)?;
    let job = Job::new(console);
    let (task, learned) = learn(&calibration, &args.calibration, &disk(), DEFAULT_SAMPLE, &job)?;
    let report = TrialsReport::of_samples(&calibration, &task, &learned, &job)?;
    if let Some(folder) = &folder {
        console.keep(&report.files(&FrictionSheet::new(&calibration))?, folder)?;
    }
    console.report(args.json, &report, || if args.details { report.text() } else { report.brief() })
}
