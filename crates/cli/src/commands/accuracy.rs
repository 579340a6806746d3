//! `accuracy`: compares speed and error of every method on one page.

use std::env::consts::{ARCH, OS};
use std::path::PathBuf;

use slipgrid_design::cost_line;
use slipgrid_design::results::json;
use slipgrid_io::formats::run::Overrides;
use slipgrid_io::formats::scene::SceneInput;
use slipgrid_model::springblock::{Expense, Fidelity};
use slipgrid_report::Outputs;
use slipgrid_validate::accuracy::{self, Size};

use crate::args::AccuracyArgs;
use crate::output::open;
use crate::progress::Job;
use crate::{CliError, Console};
use slipgrid_io::disk::disk;

/// Source of the scene without a scene file.
const PAPER: &str = "LDPE after Balestra et al., J. Tribol. 144, 031704; synthetic surface: area law by Persson's theory from \
                     the rms slope 0.0137 of the map that stands in for the unpublished one";

/// Runs every method of the comparison and reports.
pub fn run(args: &AccuracyArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let inputs: Vec<PathBuf> = args.scene.iter().cloned().collect();
    let folder = open(args.output.as_ref(), &["accuracy.*", "result.json"], &inputs)?;
    let (scene, source, input) = match &args.scene {
        Some(path) => {
            let overrides = Overrides { fidelity: Some(Fidelity::Reference), extent: None };
            let input = SceneInput::read(&disk(), path, overrides)?;
            let first = if input.scene.loads.len() > 1 { ", the first of its loads" } else { "" };
            (input.scene.clone(), format!("scene: {}{first}", path.display()), Some(input))
        }
        None => (accuracy::paper_scene()?, PAPER.to_owned(), None),
    };
    let size = if args.full { Size::Full } else { Size::Quick };
    let base = accuracy::base(&scene);
    let base = if args.full { base } else { accuracy::reduced(&base) };
    accuracy::check_reference(&base).map_err(|error| match &input {
        Some(input) => CliError::from(input.refuse(&error)),
        None => CliError::Other(format!("the built-in scene: {error}")),
    })?;
    let wall_s = accuracy::expected_wall_s(size, &base, args.seeds);
    let expense = Expense { core_s: wall_s * console.threads as f64, wall_s, bytes: 0.0 };
    let line = cost_line("this comparison", expense, false, console.threads);
    line.iter().for_each(|line| console.note(line));
    let compared = accuracy::compare(size, &base, &source, args.seeds, [ARCH, OS], &Job::new(console))?;
    if let Some(folder) = &folder {
        let mut outputs = Outputs::default();
        outputs.add("accuracy.md", accuracy::markdown(&compared));
        outputs.add("accuracy.csv", accuracy::csv(&compared));
        if let Some(picture) = accuracy::picture(&compared)? {
            outputs.add("accuracy.svg", picture);
        }
        outputs.add("result.json", json(&compared)?);
        console.keep(&outputs, folder)?;
    }
    if args.json {
        console.out.write_all(json(&compared)?.as_bytes())?;
    } else if args.output.is_none() {
        console.answer(&accuracy::markdown(&compared))?;
    }
    Ok(())
}
