//! `next`: proposes the samples to cut next, from the model and its discrepancy learned from trials.

use std::time::Instant;

use slipgrid_design::{NextOptions, next_trials};
use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::design::Design;
use slipgrid_report::charts::{MECHANISMS_FILE, mechanisms};
use slipgrid_report::{Outputs, draw_next};

use super::complete;
use super::optimize::{places, refused};
use crate::args::NextArgs;
use crate::output::open;
use crate::progress::Job;
use crate::{CliError, Console, exit_code};
use slipgrid_io::disk::disk;

/// Patterns of the names of files written for separate samples.
const FILES: [&str; 5] = ["result.json", "timings.json", "trials.toml", "next-*/pattern.*", "next-*/process.toml"];
/// Patterns of the names of files written for samples on one disc.
const FILES_OF_DISC: [&str; 6] =
    ["result.json", "timings.json", "trials.toml", "pattern.*", "process.toml", MECHANISMS_FILE];

/// Chooses samples, writes files and reports.
pub fn run(args: &NextArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let counts = NextOptions::counts(args.one_disc);
    if !counts.contains(&args.count) {
        let of_sectors = "cannot be the number of sectors of one specimen, which --one-disc asks for";
        let reason = if args.one_disc { of_sectors } else { "is no number of samples to cut at once" };
        let refused = Diagnostic::flag("--count", args.count.to_string(), reason);
        return Err(refused.expected(format!("{} to {}", counts.start(), counts.end())).into());
    }
    let started = Instant::now();
    let mut design = Design::read(&disk(), &args.design)?;
    console.warn(&design.told);
    let is_disc = args.one_disc || args.learn;
    // A disc to learn from does not replace one to cut for the target.
    let suffix = if args.learn { "-learn" } else { "-disc" };
    let output = args.output.clone().or_else(|| is_disc.then(|| places::default_folder(&args.design, suffix)));
    let folder = open(output.as_ref(), if is_disc { &FILES_OF_DISC } else { &FILES }, &design.inputs)?;
    let own = args.candidate.iter().map(|text| design.candidate(text)).collect::<Result<_, _>>()?;
    let calibration = complete(&mut design, console)?;
    let samples = calibration.map_or_else(Vec::new, |calibration| calibration.stated.trials.samples);
    let (count, one_disc, learn) = (args.count, args.one_disc, args.learn);
    design.task.search.take_seconds(started.elapsed().as_secs_f64());
    let options = NextOptions { count, own, one_disc, learn, ..NextOptions::of_samples(&samples) };
    let found =
        next_trials(&design.task, &options, &Job::new(console)).map_err(|error| refused(error, &design, None))?;
    let report = &found.report;
    if let Some(folder) = &folder {
        let mut outputs = Outputs::default();
        outputs.add_record(report)?;
        if let Some(learning) = &report.learning {
            outputs.add(MECHANISMS_FILE, mechanisms(&report.name, learning)?);
        }
        let drawn = draw_next(&found, &design.task);
        for (place, own) in drawn.iter().flatten().enumerate() {
            let below = if is_disc { String::new() } else { format!("next-{}/", place + 1) };
            outputs.add_below(&below, own);
        }
        // The record is written even if nothing can be drawn.
        console.keep(&outputs, folder)?;
        drawn.map_err(|error| design.refuse_whole(error.to_string()))?;
    }
    console.report(args.json, report, || report.text())?;
    Ok(exit_code::of_advice(found.advice.as_ref(), !report.cut_short.is_empty()))
}
