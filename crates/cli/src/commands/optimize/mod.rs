//! `optimize`: finds and confirms the pattern that brings friction to a target, and writes the laser's files.

pub mod places;

use std::time::Instant;

use slipgrid_design::DesignError;
use slipgrid_design::results::{SCREEN_WIDTH, wrapped};
use slipgrid_io::formats::design::Design;
use slipgrid_report::{files, linked_data, uncertainty_budget};

use super::complete;
use crate::args::OptimizeArgs;
use crate::interruption::{goes_on_with, heed};
use crate::output::{Place, ResultFolder, replace};
use crate::progress::Job;
use crate::study_file::StudyFile;
use crate::{CliError, Console, exit_code};
use slipgrid_io::Failure;
use slipgrid_io::disk::disk;

/// Patterns of the names of files that this command may write.
const FILES: [&str; 17] = [
    "report.html",
    "result.json",
    "timings.json",
    uncertainty_budget::FILE,
    linked_data::FILE,
    "scene.toml",
    "process.toml",
    "pattern.*",
    "target.svg",
    "trade-offs.*",
    "table.*",
    "friction*",
    "interface*",
    // Drawings that `export` added for an earlier design.
    "corners.csv",
    "hatch.csv",
    "height-map.png",
    "removed.stl",
];

/// Searches a design, confirms it, writes its files and reports.
pub fn run(args: &OptimizeArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let started = Instant::now();
    let mut design = Design::read(&disk(), &args.design)?;
    console.warn(&design.told);
    let folder = args.output.clone().unwrap_or_else(|| places::default_folder(&args.design, ""));
    let results = ResultFolder::open(Place::output(&folder), &FILES, &design.inputs)?;
    if let Some(earlier) = results.earlier_name().filter(|earlier| *earlier != design.task.name) {
        let note = format!("the result of {earlier:?} in {} will be replaced", folder.display());
        console.note(&wrapped(&note, SCREEN_WIDTH, "  ", 2));
    }
    goes_on_with(args.resuming(console.no_cache));

    design.task.search.table |= args.table;
    design.task.explorer = !args.no_explorer;
    complete(&mut design, console)?;
    heed()?;
    let calibrated_s = started.elapsed().as_secs_f64();
    let mut task = design.task.clone();
    task.search.take_seconds(calibrated_s);
    let mut study = StudyFile::new(places::study_path(&folder), args.resume);
    let found = slipgrid_design::run(&task, &mut study, &Job::new(console));
    let mut found = found.map_err(|error| refused(error, &design, Some(&study)))?;
    heed()?;

    let mut outputs = files::of_design(&found).map_err(|error| match error {
        Failure::Refused(refused) => design.refuse_whole(refused.reason).into(),
        error => CliError::from(error),
    })?;
    found.report.timings_s.material = calibrated_s;
    found.report.wall_s = started.elapsed().as_secs_f64();
    found.report.timings_s.count_rest(found.report.wall_s);
    files::add_report(&found, &mut outputs)?;
    let report = &found.report;
    replace(&outputs, &results)?;
    console.report(args.json, report, || if args.details { report.summary() } else { report.brief() })?;
    if args.details || args.json {
        console.kept(&outputs, &folder);
    } else {
        let calibration = design.calibration.as_deref();
        console.answer(&places::written(&args.again(false), calibration, &folder, &found.advice))?;
    }
    Ok(exit_code::of_advice(Some(&found.advice), !report.cut_short.is_empty()))
}

/// Converts the `error` of a search for `design` to an error of the command, with the position in the design or study
/// file if there is one.
pub fn refused(error: DesignError, design: &Design, study: Option<&StudyFile>) -> CliError {
    match error {
        DesignError::Refused(refused) => design.refuse(&refused).into(),
        DesignError::Cache(reason) => {
            study.and_then(|study| study.refused().cloned()).map_or(CliError::Other(reason), CliError::Input)
        }
        DesignError::Cancelled => CliError::Interrupted,
        DesignError::OutOfTime(reason) => CliError::OutOfTime(reason),
        DesignError::NothingToCut(reason) => CliError::NothingToCut(reason),
        DesignError::Failed(reason) => CliError::Other(reason),
    }
}
