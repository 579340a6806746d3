//! Commands, one module each: read input, call the libraries, report.

mod accuracy;
mod area_law;
mod calibrate;
mod campaign;
mod explore;
mod export;
mod new;
mod next;
mod optimize;
mod shell;
mod simulate;
mod studio;
mod surface;
mod synthesize;
mod traces;
mod trials;
mod validate;

use slipgrid_io::disk::disk;
use slipgrid_io::formats::calibrated::{complete_by, read_calibration};
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::design::Design;

use crate::args::Command;
use crate::progress::Job;
use crate::{CliError, Console, exit_code};

/// Runs `command` and returns the exit code.
///
/// # Errors
/// [`CliError`] if the command ended without a result.
pub fn run(command: &Command, console: &mut Console<'_>) -> Result<u8, CliError> {
    match command {
        Command::Simulate(args) => simulate::run(args, console),
        Command::Optimize(args) => return optimize::run(args, console),
        Command::Calibrate(args) => calibrate::run(args, console),
        Command::Traces(args) => traces::run(args, console),
        Command::Next(args) => return next::run(args, console),
        Command::Trials(args) => trials::run(args, console),
        Command::AreaLaw(args) => area_law::run(args, console),
        Command::Surface(args) => surface::run(args, console),
        Command::Synthesize(args) => synthesize::run(args, console),
        Command::Explore(args) => explore::run(args, console),
        Command::Export(args) => export::run(args, console),
        Command::Validate(args) => validate::run(args, console),
        Command::Accuracy(args) => accuracy::run(args, console),
        Command::Campaign(args) => return campaign::run(args, console),
        Command::New(args) => new::run(args, console),
        Command::Studio(args) => studio::run(args, console),
        Command::Completions(args) => shell::completions(args, console),
        Command::Man(args) => shell::man(args, console),
    }?;
    Ok(exit_code::DONE)
}

/// Completes `design` with its material; returns the calibration if the material must be calibrated first. Warnings about the
/// calibration are printed before any computation, because they may explain its failure.
fn complete(design: &mut Design, console: &mut Console<'_>) -> Result<Option<Calibration>, CliError> {
    let Some(calibration) = read_calibration(design, &disk())? else { return Ok(None) };
    console.warn(&calibration.stated.notes);
    console.warn(&design.contradictions(&calibration));
    complete_by(design, &calibration, &disk(), &Job::new(console))?;
    console.warn(&design.material_told());
    Ok(Some(calibration))
}
