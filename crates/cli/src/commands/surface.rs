//! `surface`: parameters, pictures and cavities of an altitude map.

use slipgrid_base::monitor::Cancelled;
use slipgrid_surface::topography::{MapDoubt, MapError, PreparedMap};

use super::area_law::map_options;
use crate::args::SurfaceArgs;
use crate::output::{Place, check_map_file, open as open_folder, write_file};
use crate::progress::Job;
use crate::{CliError, Console};
use slipgrid_base::units::LENGTH_UM;
use slipgrid_io::formats::altitude_map::{read_for, refuse as refuse_map};
use slipgrid_io::formats::{Diagnostic, checked};
use slipgrid_report::surface::{FILES, Measured, SurfaceReport, files, period_note, period_text};

/// Reads the map, measures it and reports.
pub fn run(args: &SurfaceArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let folder = open_folder(args.output.as_ref(), &FILES, std::slice::from_ref(&args.map))?;
    if let Some(file) = &args.period_out {
        check_map_file(Place { flag: "--period-out", path: file }, std::slice::from_ref(&args.map))?;
    }
    let options = map_options(&args.reading)?;
    let section_m = args.section_um.map(|um| checked("--section-um", um, LENGTH_UM.or_zero())).transpose()?;
    let job = Job::new(console);
    let (read, how) = read_for(&slipgrid_io::disk::disk(), &args.map, &options, &job)?;
    let refuse = |error: MapError| Diagnostic::file(&args.map, error.to_string());
    // Cavities are detected on the map as measured, which keeps its form and its missing points.
    let mut as_read = args.cavities.then(|| read.map.clone());
    if let Some(map) = as_read.as_mut().filter(|_| how.despike) {
        map.despike(&job).map_err(|ended: Cancelled| refuse(ended.into()))?;
    }
    let cavities =
        as_read.as_ref().map(|map| map.measure_cavities(options.how.form, &job)).transpose().map_err(refuse)?;
    let period = args.period_out.as_deref().zip(as_read.as_ref());
    let period = period.map(|(file, map)| map.mean_cavity_period(options.how.form, &job).map(|period| (file, period)));
    let mut surface = PreparedMap::new(read, how, &job)
        .and_then(|map| if args.cavities { Ok(map) } else { map.possible() })
        .map_err(|error| refuse_map(&args.map, &error))?;
    if args.cavities {
        // The lowered areas are the requested cavities.
        surface.warnings.retain(|warning| warning.doubt != MapDoubt::Hole);
    }
    let map = &surface.map;
    // Index of the pixel that contains the distance; pixels are dy wide.
    let column = section_m.map_or(map.cols() / 2, |section_m| (section_m / map.dy_m()) as usize);
    if let Some(section_um) = args.section_um.filter(|_| column >= map.cols()) {
        let side_um = LENGTH_UM.from_si(map.dy_m() * map.cols() as f64);
        let refused = Diagnostic::flag("--section-um", section_um.to_string(), "lies outside the map");
        return Err(refused.expected(format!("less than {side_um} um")).into());
    }
    let measured = Measured::new(surface, cavities, &job).map_err(refuse)?;
    let report = SurfaceReport::new(&args.map, &measured, &job).map_err(refuse)?;
    if let Some(folder) = &folder {
        let outputs = files(&report, &measured, column, &job)?;
        console.keep(&outputs, folder)?;
    }
    if let Some(Ok((file, period))) = &period {
        write_file(file, period_text(period, measured.surface.synthetic).as_bytes())?;
        console.note(&format!("{}: {}", file.display(), period_note(period)));
    }
    console.report(args.json, &report, || report.table())?;
    // A map without a mean period has its other results.
    period.transpose().map_err(refuse)?;
    Ok(())
}
