//! `calibrate`: local friction coefficients from measurements on flat samples.

use slipgrid_infer::calibrate::Selection;

use crate::args::CalibrateArgs;
use crate::output::{Place, ResultFolder, check_file, write_file};
use crate::progress::Job;
use crate::{CliError, Console};
use slipgrid_io::disk::disk;
use slipgrid_io::formats::calibrated::calibrate;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::made_from::MadeFrom;
use slipgrid_io::formats::scene::DEFAULT_SAMPLE;
use slipgrid_io::formats::written_material::material_toml;
use slipgrid_report::calibration::{FILES, Fitted};

/// Calibrates and reports.
pub fn run(args: &CalibrateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let read = Calibration::read(&disk(), &args.calibration)?;
    if let Some(path) = &args.output {
        check_file(Place::output(path), &read.inputs)?;
    }
    let of_traces = if read.traces.is_empty() { &[][..] } else { &super::traces::FILES };
    let names = [&FILES[..], of_traces].concat();
    let report = args.report.as_ref().map(|path| Place { flag: "--report", path });
    let report = report.map(|place| ResultFolder::open(place, &names, &read.inputs)).transpose()?;
    // Warnings may explain a fit that fails after minutes, and are printed first.
    console.warn(&read.stated.notes);
    let (task, outcome) =
        calibrate(&read, &args.calibration, &disk(), DEFAULT_SAMPLE, Selection::default(), &Job::new(console))?;
    let made_from = args.output.as_ref().and_then(|path| MadeFrom::new(&read, &args.calibration, path, &disk()));
    let file = material_toml(&task, &outcome, made_from)?;
    if let Some(path) = &args.output {
        write_file(path, file.as_bytes())?;
    }
    let fitted = Fitted::new(read, (task, outcome), &Job::new(console))?;
    if let Some(folder) = &report {
        console.keep(&fitted.files()?, folder)?;
    }
    console.answer(&if args.details { fitted.summary() } else { fitted.brief() })?;
    match &args.output {
        Some(path) => console.note(&format!("wrote {}", path.display())),
        None => console.note("nothing written; -o MATERIAL.toml keeps the material"),
    }
    Ok(())
}
