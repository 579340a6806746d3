//! `area-law`: real contact area of an altitude map against pressure.

use std::path::{Path, PathBuf};

use slipgrid_calibrate::area_law::{
    AreaLawError, AreaLawRequest, DEFAULT_PRESSURES_MPA, area_law, persson_curve, surface_area_law,
};
use slipgrid_calibrate::map_windows::{
    DEFAULT_WINDOWS, Resolution, STATISTICS_TOLERANCE, WINDOW_STATEMENT, WindowSpread, resolution,
};
use slipgrid_contact::AreaPoint;
use slipgrid_material::AreaLaw;
use slipgrid_topography::{Crop, Decimation, Form, LengthUnit, Missing, PreparedMap, ReadOptions};

use super::area_report::{AreaLawReport, AreaReport, ResolutionReport, WindowReport, picture, table, table_csv};
use crate::args::{AreaLawArgs, FormName, MapArgs, MissingName};
use crate::interruption::heed;
use crate::output::{Place, check_folder};
use crate::progress::{Job, Progress};
use crate::{CliError, Console, exit_code};
use slipgrid_formats::Diagnostic;
use slipgrid_formats::altitude_map::{law_warnings, read_period, refuse_law};
use slipgrid_formats::surface::MapOptions;
use slipgrid_report::Outputs;
use slipgrid_results::{VERSION, json, json_and_timings};
use slipgrid_units::{LENGTH_UM, MODULUS_GPA, POISSON, PRESSURE_MPA, Quantity, SLOPE, TOLERANCE};

/// Computes the curve and reports.
pub fn run(args: &AreaLawArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    if let Some(folder) = &args.output {
        let inputs: Vec<PathBuf> = args.map.iter().cloned().collect();
        check_folder(Place::output(folder), &["result.json", "timings.json", "area-law.*"], &inputs)?;
    }
    let request = Request::check(args)?;
    let report = match (&args.map, args.persson_rms_slope) {
        (Some(path), _) => of_map(path, args, &request, console)?,
        (None, Some(rms_slope)) => {
            of_theory(checked("--persson-rms-slope", rms_slope, SLOPE)?, args, &request, console)?
        }
        (None, None) => return Err(Diagnostic::flag("MAP", String::new(), "is missing").into()),
    };
    if let Some(folder) = &args.output {
        let mut outputs = Outputs::default();
        let [result, timings] = json_and_timings(&report)?;
        outputs.add("result.json", result);
        outputs.add("timings.json", timings);
        outputs.add("area-law.csv", table_csv(&report));
        outputs.add("area-law.svg", picture(&report)?);
        crate::output::write(&outputs, folder)?;
        console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    }
    if args.json {
        console.out.write_all(json(&report)?.as_bytes())?;
    } else {
        console.answer(&table(&report))?;
    }
    Ok(exit_code::DONE)
}

/// The flags in SI units.
struct Request {
    /// E*.
    contact_modulus_pa: f64,
    poisson_ratio: f64,
    tolerance: f64,
    /// P0.
    threshold_pa: f64,
    /// Pressures asked for.
    listed_pa: Vec<f64>,
    /// Pressures solved for: the threshold's beside them where all lie above it.
    solved_pa: Vec<f64>,
}

impl Request {
    fn check(args: &AreaLawArgs) -> Result<Self, Diagnostic> {
        let youngs_modulus_pa = checked("--youngs-modulus-gpa", args.youngs_modulus_gpa, MODULUS_GPA)?;
        let poisson_ratio = checked("--poisson-ratio", args.poisson_ratio, POISSON)?;
        let threshold_pa = checked("--threshold-mpa", args.threshold_mpa, PRESSURE_MPA)?;
        let listed_pa = pressures(args)?;
        // A(P0) is interpolated where the list goes past P0; otherwise it is computed beside the list.
        let mut solved_pa = listed_pa.clone();
        if listed_pa.iter().all(|&pressure_pa| pressure_pa > threshold_pa) {
            solved_pa.insert(0, threshold_pa);
        }
        Ok(Self {
            // E* = E / (1 - nu^2)
            contact_modulus_pa: youngs_modulus_pa / (1.0 - poisson_ratio * poisson_ratio),
            poisson_ratio,
            tolerance: checked("--tolerance", args.tolerance, TOLERANCE)?,
            threshold_pa,
            listed_pa,
            solved_pa,
        })
    }

    /// Where the pressures asked for begin among those solved for.
    fn first(&self) -> usize {
        self.solved_pa.len() - self.listed_pa.len()
    }

    fn law(&self) -> AreaLawRequest<'_> {
        AreaLawRequest {
            contact_modulus_pa: self.contact_modulus_pa,
            pressures_pa: &self.solved_pa,
            threshold_pa: self.threshold_pa,
            tolerance: self.tolerance,
            windows: None,
        }
    }

    /// f at a pressure by `law`; 1 without one as long as no pressure lies above the threshold.
    fn factor(&self, law: Option<&AreaLaw>, pressure_pa: f64) -> Option<f64> {
        let below = self.listed_pa.iter().all(|&pressure_pa| pressure_pa <= self.threshold_pa);
        law.map(|law| law.factor(pressure_pa)).or(below.then_some(1.0))
    }

    /// The report of a curve, without what only a map has.
    fn report(&self, curve: &[AreaPoint], rms_slope: f64, args: &AreaLawArgs, console: &Console<'_>) -> AreaLawReport {
        let law = area_law(curve, self.threshold_pa).ok();
        let persson = persson_curve(rms_slope, self.contact_modulus_pa, &self.solved_pa).ok();
        let persson = persson.and_then(|curve| area_law(&curve, self.threshold_pa).ok());
        let report = |point: &AreaPoint| AreaReport {
            pressure_mpa: PRESSURE_MPA.from_si(point.pressure_pa),
            area_fraction: point.area_fraction,
            area_fraction_corrected: point.area_fraction_corrected,
            factor: self.factor(law.as_ref(), point.pressure_pa),
            factor_std: None,
            factor_persson: self.factor(persson.as_ref(), point.pressure_pa),
            area_error: point.area_error,
            iterations: point.convergence.iterations,
            residual: point.convergence.residual,
            status: point.convergence.status.name(),
        };
        AreaLawReport {
            program: "slipgrid",
            version: VERSION,
            map: None,
            synthetic_surface: false,
            rms_slope,
            sa_um: None,
            pixel_um: None,
            rows: None,
            columns: None,
            youngs_modulus_gpa: args.youngs_modulus_gpa,
            poisson_ratio: self.poisson_ratio,
            contact_modulus_gpa: MODULUS_GPA.from_si(self.contact_modulus_pa),
            full_contact_pressure_mpa: None,
            threshold_mpa: PRESSURE_MPA.from_si(self.threshold_pa),
            threshold_proportionality: proportionality(curve, self.threshold_pa),
            tolerance: self.tolerance,
            model: Vec::new(),
            warnings: Vec::new(),
            wall_s: 0.0,
            threads: console.threads,
            windows: None,
            resolutions: Vec::new(),
            results: curve[self.first()..].iter().map(report).collect(),
        }
    }
}

/// A(P0)/P0 over A/P at the lightest load, where the curve lists both.
fn proportionality(curve: &[AreaPoint], threshold_pa: f64) -> Option<f64> {
    let share = |point: &AreaPoint| point.area_fraction_corrected / point.pressure_pa;
    let lightest = curve.first().filter(|point| point.pressure_pa < threshold_pa && point.area_fraction > 0.0)?;
    let at_threshold = curve.iter().find(|point| point.pressure_pa == threshold_pa)?;
    Some(share(at_threshold) / share(lightest))
}

/// Rough contact of the map at `path`.
fn of_map(
    path: &Path,
    args: &AreaLawArgs,
    request: &Request,
    console: &mut Console<'_>,
) -> Result<AreaLawReport, CliError> {
    let mut options = map_options(&args.reading)?;
    if args.no_level {
        options.form = Form::Mean;
    }
    let surface = read_period(&crate::input::disk(), path, &options)?;
    let wanted = AreaLawRequest { windows: args.windows, ..request.law() };
    let found = surface_area_law(&surface, &wanted, &Job::new(console)).map_err(|error| match &error {
        AreaLawError::Windows(_) => {
            let per_side = args.windows.unwrap_or(DEFAULT_WINDOWS);
            Diagnostic::flag("--windows", per_side.to_string(), error.to_string()).into()
        }
        error => refuse_law(path, error).map_or(CliError::Interrupted, CliError::Input),
    })?;
    let mut model = model(&surface);
    let windows = found.windows.as_ref().map(|spread| window_report(spread, request.first(), found.windows_s));
    if let Some(windows) = &windows {
        model.push(format!(
            "factor_std is the standard deviation of f among {} windows over the root of their number, itself known to \
             {:.0} %; {WINDOW_STATEMENT}",
            windows.count,
            // A standard deviation of n normal values is known to 1/sqrt(2(n - 1)).
            100.0 / (2.0 * (windows.count as f64 - 1.0)).sqrt(),
        ));
    }
    let progress = Progress::start("resolutions", console.quiet);
    let mut resolutions = Vec::new();
    for &factor in args.resolutions.as_deref().unwrap_or_default() {
        let blunt = resolution(&surface.map, factor, &request.law(), &progress)
            .map_err(|error| Diagnostic::flag("--resolutions", factor.to_string(), error.to_string()))?;
        heed()?;
        resolutions.push(resolution_report(&blunt, request.first()));
    }
    progress.finish();

    let curve = &found.curve;
    let mut report = AreaLawReport {
        map: Some(path.display().to_string()),
        synthetic_surface: surface.synthetic,
        sa_um: Some(LENGTH_UM.from_si(surface.sa_m)),
        pixel_um: Some(LENGTH_UM.from_si(surface.pixel_m())),
        rows: Some(surface.map.rows()),
        columns: Some(surface.map.cols()),
        full_contact_pressure_mpa: Some(PRESSURE_MPA.from_si(curve.full_contact_pressure_pa)),
        model,
        warnings: law_warnings(&found.warnings),
        wall_s: found.curve_s,
        resolutions,
        ..request.report(&curve.points, surface.rms_slope, args, console)
    };
    if let Some(windows) = windows {
        let root = (windows.count as f64).sqrt();
        for (point, spread) in report.results.iter_mut().zip(&windows.factor_spread) {
            point.factor_std = Some(spread / root);
        }
        report.windows = Some(windows);
    }
    Ok(report)
}

fn window_report(spread: &WindowSpread, first: usize, wall_s: f64) -> WindowReport {
    WindowReport {
        per_side: spread.per_side,
        count: spread.count(),
        rows: spread.pixels[0],
        columns: spread.pixels[1],
        made_periodic: WINDOW_STATEMENT,
        tolerance: STATISTICS_TOLERANCE,
        rms_slope_mean: spread.rms_slope_mean,
        rms_slope_spread: spread.rms_slope_spread,
        factor_mean: spread.factor_mean[first..].to_vec(),
        factor_spread: spread.factor_spread[first..].to_vec(),
        wall_s,
    }
}

fn resolution_report(resolution: &Resolution, first: usize) -> ResolutionReport {
    ResolutionReport {
        coarser: resolution.coarser,
        pixel_um: LENGTH_UM.from_si(resolution.pixel_m),
        rms_slope: resolution.rms_slope,
        tolerance: STATISTICS_TOLERANCE,
        factor: resolution.factor.as_ref().map(|factor| factor[first..].to_vec()),
    }
}

/// Persson's theory for a surface of which only the rms slope is known.
fn of_theory(
    rms_slope: f64,
    args: &AreaLawArgs,
    request: &Request,
    console: &Console<'_>,
) -> Result<AreaLawReport, CliError> {
    let curve = persson_curve(rms_slope, request.contact_modulus_pa, &request.solved_pa)
        .map_err(|error| CliError::Other(error.to_string()))?;
    let model = vec![
        "area by Persson's theory, erf(sqrt 2 P / (E* h'rms)): it knows the surface only by its rms slope and is no \
         substitute for a map"
            .to_owned(),
        FACTOR_STATEMENT.to_owned(),
    ];
    Ok(AreaLawReport { model, ..request.report(&curve, rms_slope, args, console) })
}

/// How f is meant.
const FACTOR_STATEMENT: &str =
    "f is the area over that at the threshold P0, divided by P/P0: the line through the origin, not the tangent";

/// The number of a flag in SI units.
pub(super) fn checked(flag: &str, value: f64, quantity: Quantity) -> Result<f64, Diagnostic> {
    if quantity.accepts(value) {
        Ok(quantity.to_si(value))
    } else {
        // Not with three hundred digits.
        let given = if value.abs() < 1e16 { value.to_string() } else { format!("{value:e}") };
        Err(Diagnostic::flag(flag, given, "is out of range").expected(quantity.to_string()))
    }
}

fn pressures(args: &AreaLawArgs) -> Result<Vec<f64>, Diagnostic> {
    let listed = args.pressures_mpa.as_deref().unwrap_or(&DEFAULT_PRESSURES_MPA);
    for pair in listed.windows(2) {
        if pair[1] <= pair[0] {
            let reason = format!("does not exceed the {} before it", pair[0]);
            return Err(
                Diagnostic::flag("--pressures-mpa", pair[1].to_string(), reason).expected("pressures that increase")
            );
        }
    }
    listed.iter().map(|&pressure_mpa| checked("--pressures-mpa", pressure_mpa, PRESSURE_MPA)).collect()
}

/// How the flags want a map read.
pub(super) fn map_options(args: &MapArgs) -> Result<MapOptions, Diagnostic> {
    let pixel_m = args.pixel_um.map(|pixel_um| checked("--pixel-um", pixel_um, LENGTH_UM)).transpose()?;
    let pixel_y_m = args.pixel_y_um.map(|pixel_um| checked("--pixel-y-um", pixel_um, LENGTH_UM)).transpose()?;
    let read = ReadOptions {
        pixel_m: pixel_m.map(|pixel_m| [pixel_m, pixel_y_m.unwrap_or(pixel_m)]),
        height_unit: args.height_unit.as_deref().map(|name| unit("--height-unit", name)).transpose()?,
        lateral_unit: args.lateral_unit.as_deref().map(|name| unit("--lateral-unit", name)).transpose()?,
        decimal_comma: args.decimal_comma,
        crop: args.crop.map(|[first_row, first_col, rows, cols]| Crop { first_row, first_col, rows, cols }),
        decimation: args.decimate.map(|factor| Decimation { factor: factor.get(), method: args.decimate_by.into() }),
        ..ReadOptions::NONE
    };
    let form = match args.form {
        FormName::Mean => Form::Mean,
        FormName::Plane => Form::Plane,
        FormName::SecondOrder => Form::SecondOrder,
    };
    let missing = match args.missing {
        MissingName::Fill => Missing::Fill,
        MissingName::Refuse => Missing::Refuse,
    };
    Ok(MapOptions { read, form, missing, despike: args.despike })
}

fn unit(flag: &str, name: &str) -> Result<LengthUnit, Diagnostic> {
    name.parse().map_err(|error: slipgrid_topography::UnknownUnit| Diagnostic {
        key: Some(flag.into()),
        reason: error.to_string(),
        ..Diagnostic::default()
    })
}

fn model(surface: &PreparedMap) -> Vec<String> {
    let mut model = vec![
        "rough contact of the map with a rigid plane: elastic half-space, periodic, no adhesion".to_owned(),
        FACTOR_STATEMENT.to_owned(),
    ];
    if surface.synthetic {
        model.push("the map is synthetic, not measured".to_owned());
    }
    model.extend(surface.notes.iter().cloned());
    model
}
