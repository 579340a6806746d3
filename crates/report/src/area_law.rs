//! Reports on the real contact area of a map or of Persson's theory: record, text, table and picture.

use serde::Serialize;

use crate::charts::{self, AreaPoint, Estimate};
use slipgrid_base::units::tidy;
use slipgrid_design::results::{MadeBy, Table, fixed};
use slipgrid_infer::calibrate::area_law_sampling::{Resolution, WindowSpread};

mod curve;

pub use curve::{AreaLawCurve, AreaLawOptions};

/// Record that `area-law --json` prints. Fields that need a map are null for an analytic law.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AreaLawReport {
    /// Program that made the record.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Name of the map.
    pub map: Option<String>,
    /// The map file states that its surface is synthetic.
    pub synthetic_surface: bool,
    /// Spectral rms slope.
    pub rms_slope: f64,
    /// Arithmetical mean height.
    pub sa_um: Option<f64>,
    /// `sa_um` and `rms_slope` belong to the map's periodic component, which replaces the map.
    pub periodic_component: bool,
    /// Side of a pixel along x.
    pub pixel_um: Option<f64>,
    /// Side of a pixel along y.
    pub pixel_y_um: Option<f64>,
    /// Pixels along y: number of lines in a file that stores one row per line.
    pub rows: Option<usize>,
    /// Pixels along x: number of values per line.
    pub columns: Option<usize>,
    /// Young's modulus.
    pub youngs_modulus_gpa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Contact modulus E* = E / (1 - nu^2), from Young's modulus E and Poisson's ratio nu.
    pub contact_modulus_gpa: f64,
    /// Lowest pressure at which the whole map is in contact; null without a map.
    pub full_contact_pressure_mpa: Option<f64>,
    /// Threshold pressure P0: the area factor f is 1 up to P0. Without a stated threshold, P0 is a small load at which
    /// A/P, real contact area over pressure, is close to the limit for small loads.
    pub threshold_mpa: f64,
    /// A/P at the threshold over A/P at the lowest pressure; 1 if the area A is proportional to the pressure P up to
    /// the threshold; null unless pressures at and below the threshold were solved.
    pub threshold_proportionality: Option<f64>,
    /// Relative error tolerance of the contact solver.
    pub tolerance: f64,
    /// Model assumptions and methods.
    pub model: Vec<String>,
    /// Warnings; each begins with its name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Wall time of the curve, in seconds.
    pub wall_s: f64,
    /// Number of threads.
    pub threads: usize,
    /// Results of windows of the map, if requested.
    pub windows: Option<WindowSpread>,
    /// Results at coarser pixels, if requested.
    pub resolutions: Vec<Resolution>,
    /// Results, one per pressure.
    pub results: Vec<ContactArea>,
}

/// Real contact area and area factor at one pressure.
#[derive(Clone, Debug, Serialize)]
pub struct ContactArea {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Real over nominal contact area.
    pub area_fraction: f64,
    /// Real over nominal contact area, corrected for the boundary of contact spots.
    pub area_fraction_corrected: f64,
    /// Area factor f: A/P over A/P at the threshold pressure, and 1 below; null if the curve gives no area law.
    pub factor: Option<f64>,
    /// Standard error of the area factor from the windows of the map; null without windows.
    pub factor_std: Option<f64>,
    /// Area factor by Persson's theory for the rms slope of the surface; null if the theory gives no area law.
    pub factor_persson: Option<f64>,
    /// Estimated error of both area fractions from stopping the solver at the tolerance.
    pub area_error: f64,
    /// Iterations of the solver.
    pub iterations: usize,
    /// Final residual: relative error of the pressures.
    pub residual: f64,
}

/// Formats the report as text.
pub fn table(report: &AreaLawReport) -> String {
    let pixel_um = report.pixel_um.zip(report.pixel_y_um);
    let mut text = match (&report.map, report.columns.zip(report.rows), pixel_um) {
        (Some(map), Some((columns, rows)), Some((along_x_um, along_y_um))) => format!(
            "{map}: {}{columns} x {rows} pixels of {along_x_um} x {along_y_um} um{}, Sa {} um",
            if report.synthetic_surface { "synthetic, " } else { "" },
            if report.periodic_component { "; of its periodic component" } else { "" },
            fixed(report.sa_um, 4),
        ),
        _ => "no map: analytic law".to_owned(),
    };
    text += &format!(
        ", rms slope {}; E {} GPa, nu {}\n",
        fixed(Some(report.rms_slope), 5),
        report.youngs_modulus_gpa,
        fixed(Some(report.poisson_ratio), 3),
    );
    text += &(crate::marked("-", &report.model) + &crate::marked("!", &report.warnings));
    let mut table = Table::of(&report.results);
    table.column("P MPa", |at| at.pressure_mpa.to_string());
    table.column("area", |at| fixed(Some(at.area_fraction), 5));
    table.column("corrected", |at| fixed(Some(at.area_fraction_corrected), 5));
    table.column("solver +-", |at| format!("{:.0e}", at.area_error));
    table.column("f", |at| fixed(at.factor, 5));
    table.column("windows +-", |at| fixed(at.factor_std, 5));
    table.column("iterations", |at| at.iterations.to_string());
    table.column("error", |at| format!("{:.1e}", at.residual));
    text += &format!("\n{}\n", table.table());
    if !report.resolutions.is_empty() {
        text += &format!("{}\n", resolution_table(report));
    }
    if let Some(share) = report.threshold_proportionality {
        text += &format!(
            "at P0 = {} MPa the area per load is {share:.3} times that at the lightest load\n",
            report.threshold_mpa
        );
    }
    let full = report.full_contact_pressure_mpa.map(|full| format!("full contact from {full:.1} MPa; "));
    let windows = report.windows.as_ref().map(|windows| format!(" and {:.2} s for windows", windows.wall_s));
    text += &format!("{}{:.2} s{}\n", full.unwrap_or_default(), report.wall_s, windows.unwrap_or_default());
    text
}

/// Table of the rms slope and the area factor f at the pixels of the map and at coarser pixels.
fn resolution_table(report: &AreaLawReport) -> Table {
    let mut titles = vec!["P MPa".to_owned(), "f".to_owned()];
    titles.extend(report.resolutions.iter().map(|coarse| format!("f, {} um", coarse.pixel_um)));
    let mut table = Table::new(titles.iter().map(String::as_str));
    let mut slopes = vec!["rms slope".to_owned(), fixed(Some(report.rms_slope), 5)];
    slopes.extend(report.resolutions.iter().map(|coarse| fixed(Some(coarse.rms_slope), 5)));
    table.row(slopes);
    for (n, point) in report.results.iter().enumerate() {
        let mut row = vec![point.pressure_mpa.to_string(), fixed(point.factor, 5)];
        row.extend(report.resolutions.iter().map(|coarse| fixed(coarse.factor.as_ref().map(|factor| factor[n]), 5)));
        table.row(row);
    }
    table
}

/// Formats the results as CSV, one row per pressure.
pub fn table_csv(report: &AreaLawReport) -> String {
    let rows: Vec<(usize, &ContactArea)> = report.results.iter().enumerate().collect();
    let mut table = Table::of(&rows);
    table.numbers("pressure_mpa", |(_, at)| at.pressure_mpa);
    table.numbers("area_fraction", |(_, at)| at.area_fraction);
    table.numbers("area_fraction_corrected", |(_, at)| at.area_fraction_corrected);
    table.numbers("factor", |(_, at)| at.factor);
    table.numbers("factor_std", |(_, at)| at.factor_std);
    for coarse in &report.resolutions {
        let name = format!("factor_at_{}_um", coarse.pixel_um);
        table.numbers(name, |(row, _)| coarse.factor.as_ref().map(|factor| factor[*row]));
    }
    table.table().csv()
}

/// Title of an area law's picture, for a synthetic or a measured surface.
pub(crate) const fn picture_title(is_synthetic: bool) -> &'static str {
    if is_synthetic {
        "Real contact area and the factor f (synthetic surface)"
    } else {
        "Real contact area and the factor f"
    }
}

/// Draws the area fraction and the area factor f against pressure.
///
/// # Errors
/// [`charts::ChartError`] if there is nothing to draw.
pub fn picture(report: &AreaLawReport) -> Result<String, charts::ChartError> {
    let threshold_mpa = tidy(report.threshold_mpa);
    let threshold_area = report
        .results
        .iter()
        .find(|point| tidy(point.pressure_mpa) == threshold_mpa)
        .map(|point| [threshold_mpa, point.area_fraction_corrected]);
    let title = match (report.synthetic_surface, &report.map) {
        (false, None) => "Real contact area and the factor f (Persson's theory)",
        (is_synthetic, _) => picture_title(is_synthetic),
    };
    // Windows may have been solved at some of the pressures only.
    let windows = report.windows.as_ref().filter(|of| of.factor_mean.len() == report.results.len());
    let point = |(row, of): (usize, &ContactArea)| AreaPoint {
        pressure_mpa: of.pressure_mpa,
        area_fraction: of.area_fraction_corrected,
        factor: of.factor.unwrap_or(1.0),
        factor_std: of.factor_std,
        windows: windows.map(|of| Estimate { value: of.factor_mean[row], error: of.factor_spread.get(row).copied() }),
    };
    let points: Vec<AreaPoint> = report.results.iter().enumerate().map(point).collect();
    charts::area_law(title, &points, threshold_area, &[])
}
