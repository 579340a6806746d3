//! `explore`: makes an interactive page with the predictions for any design of a material or a task.

use slipgrid_design::explore_bounds;
use slipgrid_io::formats::confirmed_scene::steady_scene;
use slipgrid_io::formats::explored::explored;
use slipgrid_report::html::exploration;

use super::complete;
use super::optimize::refused;
use crate::args::ExploreArgs;
use crate::output::{Place, check_file, write_file};
use crate::progress::Job;
use crate::{CliError, Console};
use slipgrid_io::disk::disk;

/// Computes the predictions and writes the page.
pub fn run(args: &ExploreArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let is_folder = args.output.is_dir() || args.output.extension().is_none();
    let output = if is_folder { args.output.join("explore.html") } else { args.output.clone() };
    check_file(Place::output(&output), std::slice::from_ref(&args.file))?;
    let condition = args.speed_mm_s.zip(args.humidity_pct).map(<[f64; 2]>::from);
    let mut design = explored(&disk(), &args.file, condition)?;
    console.warn(&design.told);
    complete(&mut design, console)?;
    let found = explore_bounds(&design.task, &Job::new(console)).map_err(|error| refused(error, &design, None))?;
    console.warn(&found.doubts());
    let toml = steady_scene(&found.task, &found.material, &found.loads, &found.pattern);
    let toml = toml.map_err(|error| design.refuse_whole(error.to_string()))?;
    write_file(&output, exploration(&found, toml).as_bytes())?;
    Ok(console.answer(&format!("{}\n", output.display()))?)
}
