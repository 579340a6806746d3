//! `accuracy`: speed against error of every method, on one page.

mod date;
mod difference;
mod front;
mod measure;
mod plan;
mod report;
mod scene;
mod text;

use std::path::PathBuf;

use slipgrid_springblock::{Expense, Fidelity, Scene, SceneError, Unwatched, simulate};

use super::announcement::say;
use plan::{Role, Size, rows};
use report::{AccuracyReport, Machine, model_notes};

use crate::args::AccuracyArgs;
use crate::interruption::heed;
use crate::output::{Place, check_folder};
use crate::progress::Progress;
use crate::{CliError, Console, exit_code};
use slipgrid_formats::run::Overrides;
use slipgrid_formats::scene::SceneInput;
use slipgrid_report::Outputs;
use slipgrid_results::json;

/// Runs every row and reports.
pub fn run(args: &AccuracyArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    if let Some(folder) = &args.output {
        let inputs: Vec<PathBuf> = args.scene.iter().cloned().collect();
        check_folder(Place::output(folder), &["accuracy.*", "result.json"], &inputs)?;
    }
    let (scene, input) = match &args.scene {
        Some(path) => {
            let input = SceneInput::read(
                &crate::input::disk(),
                path,
                Overrides { fidelity: Some(Fidelity::Reference), extent: None },
            )?;
            (input.scene.clone(), Some(input))
        }
        None => (scene::paper_scene()?, None),
    };
    let source = match &args.scene {
        Some(path) => source_of(path, &scene),
        None => {
            "LDPE after Balestra et al., J. Tribol. 144, 031704; synthetic surface: area law by Persson's theory from \
                 the rms slope 0.0137 of the map that stands in for the unpublished one"
                .to_owned()
        }
    };
    let size = if args.full { Size::Full } else { Size::Quick };
    let base = scene::base(&scene);
    let base = if size == Size::Quick { scene::reduced(&base) } else { base };
    check_reference(&base).map_err(|error| match &input {
        Some(input) => CliError::from(input.refuse(&error)),
        None => CliError::Other(format!("the built-in scene: {error}")),
    })?;
    let report = compare(size, &base, &source, args.seeds.get(), console);
    heed()?;
    if let Some(folder) = &args.output {
        let mut outputs = Outputs::default();
        outputs.add("accuracy.md", text::markdown(&report));
        outputs.add("accuracy.csv", text::csv(&report));
        if let Some(picture) = text::picture(&report)? {
            outputs.add("accuracy.svg", picture);
        }
        outputs.add("result.json", json(&report)?);
        crate::output::write(&outputs, folder)?;
        console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    }
    if args.json {
        console.out.write_all(json(&report)?.as_bytes())?;
    } else if args.output.is_none() {
        console.answer(&text::markdown(&report))?;
    }
    Ok(exit_code::DONE)
}

fn source_of(path: &std::path::Path, scene: &Scene) -> String {
    let first = if scene.loads.len() > 1 { ", the first of its loads" } else { "" };
    format!("scene: {}{first}", path.display())
}

/// Refuses a scene that the reference refuses, without running it.
fn check_reference(base: &Scene) -> Result<(), SceneError> {
    base.validate()?;
    // The largest step is refused with the limit named: the reference's own must be within it.
    let mut probe = base.clone();
    probe.run.step_s = Some(f64::MAX);
    match simulate(&probe, &Unwatched) {
        Err(SceneError::UnstableStep { limit_s, scheme, .. }) if REFERENCE_STEP_S > limit_s => {
            Err(SceneError::UnstableStep { step_s: REFERENCE_STEP_S, limit_s, scheme })
        }
        Err(SceneError::UnstableStep { .. }) | Ok(_) => Ok(()),
        Err(error) => Err(error),
    }
}

/// Step of the published scheme.
const REFERENCE_STEP_S: f64 = 1e-9;

/// Runs the rows on `base` and puts the page together.
fn compare(size: Size, base: &Scene, source: &str, seeds: u64, console: &mut Console<'_>) -> AccuracyReport {
    let rows = rows(size, base, seeds);
    let all_s = measure::expected_wall_s(&rows, base, console.threads);
    let expense = Expense { core_s: all_s * console.threads as f64, wall_s: all_s, bytes: 0.0 };
    say("this comparison", expense, false, console);
    let progress = Progress::start("accuracy", console.quiet);
    let runs = measure::measure_all(&rows, base, size == Size::Full, &progress);
    let wall_s = progress.finish();
    let size_name = match size {
        Size::Quick => "quick",
        Size::Full => "full",
    };
    debug_assert!(rows.iter().filter(|row| row.role == Role::Judge).count() == 1);
    let machine = Machine {
        architecture: std::env::consts::ARCH,
        system: std::env::consts::OS,
        processors: std::thread::available_parallelism().ok().map(Into::into),
        // A page that is kept says when it was made.
        date: (size == Size::Full).then(date::today),
    };
    let model = model_notes(base, source, size_name, seeds);
    AccuracyReport::new(size_name, model, &rows, &runs, machine, wall_s, console.threads)
}

#[cfg(test)]
mod tests;
