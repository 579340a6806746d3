//! `area-law`: real contact area of an altitude map against pressure.

use std::fmt::Write as _;

use serde::Serialize;
use slipgrid_material::THRESHOLD_PRESSURE_PA;
use slipgrid_topography::{Crop, Decimation, Form, LengthUnit, ReadOptions};

use super::altitude_map::SurfaceMap;
use super::area_curve::{AreaPoint, DEFAULT_PRESSURES_MPA, area_curve, area_law};
use crate::args::{AreaLawArgs, FormName, MapArgs, MissingName};
use crate::charts::{self, AreaLawChart};
use crate::diagnostic::Diagnostic;
use crate::formats::surface::{MapOptions, Missing};
use crate::output::{Outputs, check_folder};
use crate::progress::Progress;
use crate::report::table::fixed;
use crate::report::{Table, VERSION, json};
use crate::units::{LENGTH_UM, MODULUS_GPA, POISSON, PRESSURE_MPA, Quantity, TOLERANCE, tidy};
use crate::{CliError, Console, exit_code};

/// What `area-law --json` prints.
#[derive(Clone, Debug, Serialize)]
struct AreaLawReport {
    program: &'static str,
    version: &'static str,
    map: String,
    /// The file says of itself that it is synthetic.
    synthetic_surface: bool,
    rms_slope: f64,
    sa_um: f64,
    pixel_um: f64,
    rows: usize,
    columns: usize,
    youngs_modulus_gpa: f64,
    poisson_ratio: f64,
    contact_modulus_gpa: f64,
    full_contact_pressure_mpa: f64,
    threshold_mpa: f64,
    tolerance: f64,
    model: Vec<String>,
    wall_s: f64,
    threads: usize,
    results: Vec<AreaReport>,
}

#[derive(Clone, Debug, Serialize)]
struct AreaReport {
    pressure_mpa: f64,
    area_fraction: f64,
    area_fraction_corrected: f64,
    /// f; null where the curve does not reach the threshold pressure.
    factor: Option<f64>,
    iterations: usize,
    residual: f64,
    status: &'static str,
}

/// Computes the curve and reports.
pub fn run(args: &AreaLawArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    if let Some(folder) = &args.output {
        check_folder(folder)?;
    }
    let youngs_modulus_pa = checked("--youngs-modulus-gpa", args.youngs_modulus_gpa, MODULUS_GPA)?;
    let poisson_ratio = checked("--poisson-ratio", args.poisson_ratio, POISSON)?;
    let tolerance = checked("--tolerance", args.tolerance, TOLERANCE)?;
    let pressures_pa = pressures(args)?;
    let mut options = map_options(&args.reading)?;
    if args.no_level {
        options.form = Form::Mean;
    }
    let surface = SurfaceMap::read(&args.map, &options)?;
    // E* = E / (1 - nu^2)
    let contact_modulus_pa = youngs_modulus_pa / (1.0 - poisson_ratio * poisson_ratio);

    // A(P0) is interpolated where the list goes past P0; otherwise it is computed beside the list.
    let beside = pressures_pa.iter().all(|&pressure_pa| pressure_pa > THRESHOLD_PRESSURE_PA);
    let mut solved_pa = pressures_pa.clone();
    if beside {
        solved_pa.insert(0, THRESHOLD_PRESSURE_PA);
    }
    let progress = Progress::start("area law", console.quiet);
    let curve = area_curve(&surface.map, contact_modulus_pa, &solved_pa, tolerance, &progress)
        .map_err(|error| Diagnostic::file(&args.map, error.to_string()))?;
    let wall_s = progress.finish();
    let law = area_law(&curve.points).ok();
    let below = pressures_pa.iter().all(|&pressure_pa| pressure_pa <= THRESHOLD_PRESSURE_PA);
    let factor = |pressure_pa| law.as_ref().map(|law| law.factor(pressure_pa)).or(below.then_some(1.0));

    let report = AreaLawReport {
        program: "slipgrid",
        version: VERSION,
        map: args.map.display().to_string(),
        synthetic_surface: surface.synthetic,
        rms_slope: surface.rms_slope,
        sa_um: LENGTH_UM.from_si(surface.sa_m),
        pixel_um: LENGTH_UM.from_si(surface.pixel_m()),
        rows: surface.map.rows(),
        columns: surface.map.cols(),
        youngs_modulus_gpa: args.youngs_modulus_gpa,
        poisson_ratio,
        contact_modulus_gpa: MODULUS_GPA.from_si(contact_modulus_pa),
        full_contact_pressure_mpa: PRESSURE_MPA.from_si(curve.full_contact_pressure_pa),
        threshold_mpa: PRESSURE_MPA.from_si(THRESHOLD_PRESSURE_PA),
        tolerance,
        model: model(&surface),
        wall_s,
        threads: console.threads,
        results: curve.points[usize::from(beside)..]
            .iter()
            .map(|point| report(point, factor(point.pressure_pa)))
            .collect(),
    };
    if let Some(folder) = &args.output {
        let mut outputs = Outputs::default();
        outputs.add("result.json", json(&report)?);
        outputs.add("area-law.csv", table_csv(&report));
        outputs.add("area-law.svg", picture(&report, &curve.points)?);
        outputs.write(folder)?;
        console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    }
    let text = if args.json { json(&report)? } else { table(&report) };
    console.out.write_all(text.as_bytes())?;
    Ok(exit_code::DONE)
}

fn report(point: &AreaPoint, factor: Option<f64>) -> AreaReport {
    AreaReport {
        pressure_mpa: PRESSURE_MPA.from_si(point.pressure_pa),
        area_fraction: point.area_fraction,
        area_fraction_corrected: point.area_fraction_corrected,
        factor,
        iterations: point.iterations,
        residual: point.residual,
        status: point.status.name(),
    }
}

/// The number of a flag in SI units.
pub(super) fn checked(flag: &str, value: f64, quantity: Quantity) -> Result<f64, Diagnostic> {
    if quantity.accepts(value) {
        Ok(quantity.to_si(value))
    } else {
        Err(Diagnostic::flag(flag, value.to_string(), "is out of range").expected(quantity.to_string()))
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
    Ok(MapOptions { read, form, missing })
}

fn unit(flag: &str, name: &str) -> Result<LengthUnit, Diagnostic> {
    name.parse().map_err(|error: slipgrid_topography::UnknownUnit| Diagnostic {
        key: Some(flag.into()),
        reason: error.to_string(),
        ..Diagnostic::default()
    })
}

fn model(surface: &SurfaceMap) -> Vec<String> {
    let mut model = vec![
        "rough contact of the map with a rigid plane: elastic half-space, periodic, no adhesion".to_owned(),
        "f is the area over that at 0.7 MPa, divided by P/0.7 MPa: the line through the origin, not the tangent"
            .to_owned(),
    ];
    if surface.synthetic {
        model.push("the map is synthetic, not measured".to_owned());
    }
    model.extend(surface.notes.iter().cloned());
    model
}

fn table(report: &AreaLawReport) -> String {
    let mut text = format!(
        "{}: {}{} x {} pixels of {} um, Sa {} um, rms slope {}; E {} GPa, nu {}\n",
        report.map,
        if report.synthetic_surface { "synthetic, " } else { "" },
        report.rows,
        report.columns,
        report.pixel_um,
        fixed(Some(report.sa_um), 4),
        fixed(Some(report.rms_slope), 5),
        report.youngs_modulus_gpa,
        fixed(Some(report.poisson_ratio), 3),
    );
    for statement in &report.model {
        text += &format!("- {statement}\n");
    }
    let mut table = Table::new(["P MPa", "area", "corrected", "f", "iterations", "error", "status"]);
    for point in &report.results {
        table.row([
            point.pressure_mpa.to_string(),
            fixed(Some(point.area_fraction), 5),
            fixed(Some(point.area_fraction_corrected), 5),
            fixed(point.factor, 5),
            point.iterations.to_string(),
            format!("{:.1e}", point.residual),
            point.status.to_owned(),
        ]);
    }
    text +=
        &format!("\n{table}\nfull contact from {:.1} MPa; {:.2} s\n", report.full_contact_pressure_mpa, report.wall_s);
    text
}

fn table_csv(report: &AreaLawReport) -> String {
    let mut text = String::from("pressure_mpa,area_fraction,area_fraction_corrected,factor\n");
    for point in &report.results {
        let factor = point.factor.map_or_else(String::new, |factor| factor.to_string());
        // Writing to a string cannot fail.
        let _ =
            writeln!(text, "{},{},{},{factor}", point.pressure_mpa, point.area_fraction, point.area_fraction_corrected);
    }
    text
}

fn picture(report: &AreaLawReport, curve: &[AreaPoint]) -> Result<String, CliError> {
    let column = |value: fn(&AreaReport) -> f64| report.results.iter().map(value).collect::<Vec<f64>>();
    let factor: Vec<f64> = report.results.iter().map(|point| point.factor.unwrap_or(1.0)).collect();
    let threshold_area = curve
        .iter()
        .find(|point| point.pressure_pa == THRESHOLD_PRESSURE_PA)
        .map(|point| [tidy(report.threshold_mpa), point.area_fraction_corrected]);
    let title = if report.synthetic_surface { "Real contact area (synthetic surface)" } else { "Real contact area" };
    Ok(charts::area_law(&AreaLawChart {
        title,
        pressure_mpa: &column(|point| point.pressure_mpa),
        area_fraction: &column(|point| point.area_fraction_corrected),
        factor: &factor,
        threshold: threshold_area,
    })?)
}
