//! `area-law`: real contact area of an altitude map against pressure.

use std::path::{Path, PathBuf};

use slipgrid_infer::calibrate::area_law::{AreaLawError, AreaLawRequest, DEFAULT_PRESSURES_MPA, surface_area_law};
use slipgrid_infer::calibrate::area_law_sampling::{DEFAULT_WINDOWS, resolution};
use slipgrid_surface::topography::{Crop, Decimation, Form, LengthUnit, Preparation, ReadOptions, UnknownUnit};

use crate::args::{AreaLawArgs, MapArgs};
use crate::interruption::heed;
use crate::output::open;
use crate::progress::Job;
use crate::{CliError, Console};
use slipgrid_base::monitor::Monitor;
use slipgrid_base::units::{LENGTH_UM, MODULUS_GPA, POISSON, PRESSURE_MPA, SLOPE, TOLERANCE};
use slipgrid_io::formats::altitude_map::{read_period, refuse_law};
use slipgrid_io::formats::plausible::checked_pressures;
use slipgrid_io::formats::surface::MapOptions;
use slipgrid_io::formats::{Diagnostic, checked};
use slipgrid_report::Outputs;
use slipgrid_report::area_law::{AreaLawOptions, AreaLawReport, picture, table, table_csv};

/// Young's modulus of the published polyethylene, in GPa.
const POLYETHYLENE_GPA: f64 = 0.38;

/// Computes contact area and area law, and reports.
pub fn run(args: &AreaLawArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let inputs: Vec<PathBuf> = args.map.iter().cloned().collect();
    let folder = open(args.output.as_ref(), &["result.json", "timings.json", "area-law.*"], &inputs)?;
    let request = request(args)?;
    let mut report = match (&args.map, args.persson_rms_slope) {
        (Some(path), _) => of_map(path, args, request, console)?,
        (None, Some(rms_slope)) => {
            let rms_slope = checked("--persson-rms-slope", rms_slope, SLOPE)?;
            let curve = request.on_surface(rms_slope, None);
            curve.of_theory(rms_slope).map_err(|error| CliError::Other(error.to_string()))?
        }
        (None, None) => return Err(Diagnostic::flag("MAP", String::new(), "is missing").into()),
    };
    if args.youngs_modulus_gpa.is_none() {
        let said = "Young's modulus was not given: that of the published polyethylene is taken; area goes with pressure over modulus";
        report.model.push(said.to_owned());
    }
    if let Some(folder) = &folder {
        let mut outputs = Outputs::default();
        outputs.add_record(&report)?;
        outputs.add("area-law.csv", table_csv(&report));
        outputs.add("area-law.svg", picture(&report)?);
        console.keep(&outputs, folder)?;
    }
    console.report(args.json, &report, || table(&report))
}

/// Checks the flags and converts them to SI units.
fn request(args: &AreaLawArgs) -> Result<AreaLawOptions, Diagnostic> {
    let youngs_modulus_gpa = args.youngs_modulus_gpa.unwrap_or(POLYETHYLENE_GPA);
    checked("--youngs-modulus-gpa", youngs_modulus_gpa, MODULUS_GPA)?;
    let poisson_ratio = checked("--poisson-ratio", args.poisson_ratio, POISSON)?;
    let threshold_pa = args.threshold_mpa.map(|mpa| checked("--threshold-mpa", mpa, PRESSURE_MPA)).transpose()?;
    let pressures_mpa = args.pressures_mpa.as_deref().unwrap_or(&DEFAULT_PRESSURES_MPA);
    let pressures_pa = checked_pressures("--pressures-mpa", pressures_mpa)?;
    let tolerance = checked("--tolerance", args.tolerance, TOLERANCE)?;
    Ok(AreaLawOptions { youngs_modulus_gpa, poisson_ratio, tolerance, threshold_pa, pressures_pa })
}

/// Computes contact area and area law of the map at `path`.
fn of_map(
    path: &Path,
    args: &AreaLawArgs,
    request: AreaLawOptions,
    console: &mut Console<'_>,
) -> Result<AreaLawReport, CliError> {
    let mut options = map_options(&args.reading)?;
    if args.no_level {
        options.how.form = Form::Mean;
    }
    let job = Job::new(console);
    let surface = read_period(&slipgrid_io::disk::disk(), path, &options, &job)?;
    let request = request.on_surface(surface.rms_slope, Some(surface.map.rows() * surface.map.cols()));
    let wanted = AreaLawRequest { windows: args.windows, ..request.law() };
    let found = surface_area_law(&surface, &wanted, &job).map_err(|error| match &error {
        AreaLawError::Windows(_) => {
            let per_side = args.windows.unwrap_or(DEFAULT_WINDOWS);
            Diagnostic::flag("--windows", per_side.to_string(), error.to_string()).into()
        }
        error => refuse_law(path, error).map_or(CliError::Interrupted, CliError::Input),
    })?;
    job.stage("resolutions");
    let mut resolutions = Vec::new();
    for &factor in args.resolutions.as_deref().unwrap_or_default() {
        let blunt = resolution(&surface.map, factor, &request.law(), &job);
        heed()?;
        let refuse =
            |error| Diagnostic::flag("--resolutions", factor.to_string(), format!("{}: {error}", path.display()));
        resolutions.push(blunt.map_err(refuse)?);
    }
    job.stage_ended();

    Ok(request.of_map(&path.display().to_string(), &surface, &found, &resolutions))
}

/// Checks the flags for reading a map, and converts them to options.
pub(super) fn map_options(args: &MapArgs) -> Result<MapOptions, Diagnostic> {
    let pixel_m = args.pixel_um.map(|pixel_um| checked("--pixel-um", pixel_um, LENGTH_UM)).transpose()?;
    let pixel_y_m = args.pixel_y_um.map(|pixel_um| checked("--pixel-y-um", pixel_um, LENGTH_UM)).transpose()?;
    let read = ReadOptions {
        pixel_m: pixel_m.map(|pixel_m| [pixel_m, pixel_y_m.unwrap_or(pixel_m)]),
        height_unit: args.height_unit.as_deref().map(|name| unit("--height-unit", name)).transpose()?,
        lateral_unit: args.lateral_unit.as_deref().map(|name| unit("--lateral-unit", name)).transpose()?,
        decimal_comma: args.decimal_comma,
        crop: args.crop.map(|[first_row, first_col, rows, cols]| Crop { first_row, first_col, rows, cols }),
        decimation: args.decimate.map(|factor| Decimation { factor: factor.get(), method: args.decimate_by }),
        ..ReadOptions::default()
    };
    let how = Preparation { form: args.form, missing: args.missing, despike: args.despike };
    Ok(MapOptions { read, how })
}

fn unit(flag: &str, name: &str) -> Result<LengthUnit, Diagnostic> {
    name.parse().map_err(|error: UnknownUnit| Diagnostic::key(flag, error.to_string()))
}
