//! `next`: the samples to cut next, by the model and by what trials say that it lacks.

use slipgrid_design::{NextOptions, next_trials};
use slipgrid_formats::Diagnostic;
use slipgrid_formats::calibrated::complete;
use slipgrid_formats::design::Design;
use slipgrid_pattern::Pattern;
use slipgrid_report::{DrawingInput, LaserFile, Outputs, draw};
use slipgrid_results::VERSION;

use super::optimize::refused;
use crate::args::NextArgs;
use crate::output::{Place, check_folder};
use crate::progress::Job;
use crate::{CliError, Console, exit_code};
use slipgrid_disk::disk;

/// What is written for each sample.
const FILES: [&str; 2] = ["pattern.*", "process.toml"];

/// Chooses, writes and reports.
pub fn run(args: &NextArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let mut design = Design::read(&disk(), &args.design)?;
    for told in &design.told {
        console.note(&format!("warning: {told}"));
    }
    let folders: Vec<_> =
        args.output.iter().flat_map(|folder| (1..=args.count).map(|n| folder.join(format!("next-{n}")))).collect();
    for folder in &folders {
        check_folder(Place::output(folder), &FILES, &design.inputs)?;
    }
    if let Some(folder) = &args.output {
        check_folder(Place::output(folder), &["result.json", "timings.json"], &design.inputs)?;
    }
    let own = args.candidate.iter().map(|text| candidate(text, &design)).collect::<Result<_, _>>()?;
    let calibration = complete(&mut design, &disk(), &Job::new(console))?;
    let samples = calibration.map_or_else(Vec::new, |calibration| calibration.trials.samples);
    let pending = samples.iter().filter(|cut| cut.measured.is_empty()).map(|cut| cut.pattern).collect();
    let options = NextOptions { count: args.count.into(), pending, own };
    let found =
        next_trials(&design.task, &options, &Job::new(console)).map_err(|error| refused(error, &design, None))?;
    let report = &found.report;
    if let Some(folder) = &args.output {
        let mut record = Outputs::default();
        record.add_record(report)?;
        console.keep(&record, folder)?;
    }
    for (folder, pattern) in folders.iter().zip(&found.patterns) {
        let drawing = DrawingInput {
            name: &report.name,
            version: VERSION,
            seed: design.task.seed,
            pattern: *pattern,
            outline: design.task.specimen,
            laser: design.task.laser,
            material: &found.material,
        };
        let mut outputs = Outputs::default();
        draw(&drawing, &LaserFile::ALWAYS, &mut outputs).map_err(|error| design.refuse_whole(error.to_string()))?;
        console.keep(&outputs, folder)?;
    }
    console.report(args.json, report, || report.text())?;
    Ok(exit_code::DONE)
}

/// A pattern of the texture of `design`, of the lengths that a flag gives.
fn candidate(text: &str, design: &Design) -> Result<Pattern, Diagnostic> {
    let lengths: Vec<f64> = text.split(',').filter_map(|length| length.trim().parse().ok()).collect();
    let refuse = |reason: &str| {
        Diagnostic::flag("--candidate", text.to_owned(), reason).expected("width, spacing and depth in um: 100,300,10")
    };
    let [width_um, spacing_um, depth_um] = lengths[..] else { return Err(refuse("is no pattern")) };
    Pattern::new(*design.task.space.texture(), width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6)
        .map_err(|error| refuse(&error.to_string()))
}
