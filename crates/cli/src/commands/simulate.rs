//! `simulate`: friction of a given surface at given loads.

use slipgrid_springblock::simulate;

use super::announcement::announce;
use super::pictures;
use crate::args::SimulateArgs;
use crate::formats::scene::{Overrides, SceneInput};
use crate::interruption::heed;
use crate::output::{Outputs, check_folder};
use crate::progress::Progress;
use crate::report::simulation::SimulationReport;
use crate::report::{csv, json};
use crate::{CliError, Console, exit_code};

/// Solves a scene and reports.
pub fn run(args: &SimulateArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    if let Some(folder) = &args.output {
        check_folder(folder)?;
    }
    let overrides = Overrides { fidelity: args.fidelity.map(Into::into), extent: args.extent.map(Into::into) };
    let input = SceneInput::read(&args.scene, overrides)?;
    announce(&input.scene, console);
    let progress = Progress::start(input.scene.run.fidelity.name(), console.quiet);
    let solved = simulate(&input.scene, &progress);
    let wall_s = progress.finish();
    heed()?;
    let simulation = solved.map_err(|error| input.refuse(&error))?;
    let progress = Progress::start("errors", console.quiet);
    let report = SimulationReport::new(&input, &simulation, wall_s, console.threads)?;
    progress.finish();
    heed()?;
    if let Some(folder) = &args.output {
        let mut outputs = Outputs::default();
        outputs.add("result.json", json(&report)?);
        outputs.add("interface.csv", csv::interface(&simulation));
        if let Some(trace) = csv::friction_trace(&simulation) {
            outputs.add("friction.csv", trace);
        }
        pictures::simulation(&input.scene, &simulation, &report.errors, &mut outputs)?;
        outputs.write(folder)?;
        console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    }
    let text = if args.json { json(&report)? } else { report.table() };
    console.out.write_all(text.as_bytes())?;
    Ok(exit_code::DONE)
}
