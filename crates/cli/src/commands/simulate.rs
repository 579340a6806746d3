//! `simulate`: computes friction of a given surface at given loads.

use slipgrid_base::monitor::Stage;

use crate::args::SimulateArgs;
use crate::interruption::{enter, heed};
use crate::output::open;
use crate::progress::Job;
use crate::{CliError, Console};
use slipgrid_design::results::SimulationReport;
use slipgrid_design::{run_line, simulate_on};
use slipgrid_io::disk::disk;
use slipgrid_io::formats::run::Overrides;
use slipgrid_io::formats::scene::SceneInput;
use slipgrid_report::{files, uncertainty_budget};

/// Patterns of the names of files that this command may write.
const FILES: [&str; 7] = [
    "result.json",
    "timings.json",
    uncertainty_budget::FILE,
    "interface.csv",
    "friction.csv",
    "friction-*mpa.svg",
    "interface-*mpa.svg",
];

/// Solves a scene and reports.
pub fn run(args: &SimulateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let folder = open(args.output.as_ref(), &FILES, std::slice::from_ref(&args.scene))?;
    let overrides = Overrides { fidelity: args.fidelity, extent: args.extent };
    let input = SceneInput::read(&disk(), &args.scene, overrides)?;
    console.warn(&input.told);
    run_line(&input.scene, &input.uncertainty, input.condition.as_ref()).iter().for_each(|line| console.note(line));
    let (simulation, mut report) = {
        let job = Job::new(console);
        let stage = Stage::new(&job, input.scene.run.fidelity.name(), None);
        let solved = simulate_on(&input.scene, input.specimen.as_ref(), &stage);
        heed()?;
        let simulation = solved.map_err(|error| input.refuse_on_specimen(&error))?;
        enter("errors");
        let (simulation, report) = input.report(simulation)?;
        (simulation, SimulationReport { wall_s: stage.finish(), ..report })
    };
    report.threads = console.threads;
    heed()?;
    if let Some(folder) = &folder {
        console.keep(&files::of_scene(&input.scene, &simulation, &report)?, folder)?;
    }
    console.report(args.json, &report, || if args.details { report.text() } else { report.brief() })
}
