//! Effect of rims of unknown height on the modelled ratios.
//!
//! The heights are tabulated, not fitted: the source's rims were not measured. The distance of modelled ratios from the
//! measurements is chi^2, the sum over the loads of ((modelled - measured) / standard deviation of the measured
//! ratio)^2.

use rayon::prelude::*;
use serde::Serialize;
use slipgrid_base::monitor::Monitor;
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA};
use slipgrid_design::results::{Table, with_error};
use slipgrid_model::material::AreaLaw;
use slipgrid_model::pattern::{Pattern, Rim, RimProfile};
use slipgrid_model::springblock::{Layer, Scene, SteadyCell};
use slipgrid_report::charts::{ChartError, Estimate};
use slipgrid_report::html::page::{number, plain};

use super::figures::beside_measured;
use super::model::{Body, scene, squares};
use super::ratios::{MeasuredReport, Pair};
use super::tables::Captioned;
use crate::Failure;

/// Heights of the rims, in um.
const HEIGHTS_UM: [f64; 5] = [0.0, 0.1, 0.2, 0.3, 0.5];
/// Widths of the rims, in um.
const WIDTHS_UM: [f64; 2] = [10.0, 20.0];
/// Block size in metres: half the width of the narrowest rim.
const BLOCK_M: f64 = 5e-6;

/// Modelled ratios with rims of several heights and widths, and measured ratios.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RimsReport {
    /// Nominal pressures; all lists of ratios have one ratio per pressure.
    pub pressure_mpa: Vec<f64>,
    /// Measured ratios.
    pub measured: Vec<f64>,
    /// Standard deviations of the measured ratios.
    pub measured_std: Vec<f64>,
    /// Depth of the cavities.
    pub depth_um: f64,
    /// Size of the contact blocks.
    pub block_um: f64,
    /// Maximum change of a ratio with grooves if blocks have half the size; null if no solution converged.
    pub block_error: Option<f64>,
    /// Rows of the table, one per planform, rim width and rim height.
    pub rows: Vec<RimsRow>,
    /// Conclusions from the table, in sentences.
    pub statements: Vec<String>,
}

/// Modelled ratios for one planform with one rim.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RimsRow {
    /// `groove` or `square`.
    pub planform: String,
    /// Width of the flat-topped rim; null without a rim.
    pub rim_width_um: Option<f64>,
    /// Height of the rim.
    pub rim_height_um: f64,
    /// Ratios, one per pressure; null where a solution did not converge.
    pub ratio: Vec<Option<f64>>,
    /// Maximum pressure on a contact block at any load.
    pub peak_pressure_mpa: f64,
    /// chi^2: sum over the loads of ((ratio - measured ratio) / measured standard deviation)^2; null unless all ratios
    /// are known and the sum is finite.
    pub chi_square: Option<f64>,
}

/// Computes the table of rims for the pattern `groove` and for squares of equal lengths, at the conditions of `pairs`.
/// Rows are solved in parallel.
///
/// # Errors
/// [`Failure`] if the numbers make no valid scene.
pub fn rims(
    body: Body<'_>,
    law: &AreaLaw,
    groove: &Pattern,
    pairs: &[Pair],
    monitor: &dyn Monitor,
) -> Result<RimsReport, Failure> {
    let body = Body { layer: Layer { block_m: BLOCK_M, ..body.layer }, ..body };
    let scene = scene(body, Some(law), *groove, pairs)?;
    let mut cases = Vec::new();
    for pattern in [*groove, squares(groove)] {
        cases.push((pattern, None));
        for rim_um in WIDTHS_UM.into_iter().flat_map(|width| HEIGHTS_UM[1..].iter().map(move |height| [width, *height]))
        {
            let [width_m, height_m] = rim_um.map(|um| LENGTH_UM.to_si(um));
            let rim = Rim::new(height_m, width_m, RimProfile::Flat).map_err(|error| body.refuse(&error))?;
            cases.push((pattern.with_rim(rim), Some(rim_um)));
        }
    }
    let of = |value: fn(&MeasuredReport) -> f64| {
        pairs.iter().map(|pair| value(&MeasuredReport::new(pair))).collect::<Vec<f64>>()
    };
    let [pressure_mpa, measured, measured_std] =
        [of(|row| row.pressure_mpa), of(|row| row.ratio), of(|row| row.ratio_std)];
    let solved = |pattern: &Pattern, block_m: f64| {
        let layer = Layer { block_m, ..scene.layer };
        let scene = Scene { pattern: Some(*pattern), layer, ..scene.clone() };
        SteadyCell::new(&scene).solve_heeding(pattern, monitor)
    };
    let rows = cases
        .par_iter()
        .map(|(pattern, rim)| {
            monitor.heed()?;
            let outcomes = solved(pattern, BLOCK_M);
            let ratio: Vec<Option<f64>> = outcomes.iter().map(|outcome| outcome.ratio).collect();
            let peaks = outcomes.iter().map(|outcome| outcome.surface.peak_pressure_pa);
            Ok(RimsRow {
                planform: pattern.planform().to_string(),
                rim_width_um: rim.map(|[width_um, _]| width_um),
                rim_height_um: rim.map_or(0.0, |[_, height_um]| height_um),
                chi_square: chi_square(&ratio, &measured, &measured_std),
                ratio,
                peak_pressure_mpa: PRESSURE_MPA.from_si(peaks.fold(0.0, f64::max)),
            })
        })
        .collect::<Result<Vec<RimsRow>, Failure>>()?;
    // Only grooves are solved with finer blocks, because squares take long: the error stands for both planforms.
    let mut block_error: Option<f64> = None;
    for ((pattern, _), row) in cases.iter().zip(&rows).filter(|((pattern, _), _)| pattern.texture().is_one_section()) {
        monitor.heed()?;
        let both = row.ratio.iter().zip(solved(pattern, 0.5 * BLOCK_M));
        let changes = both.filter_map(|(own, finer)| Some(((*own)? - finer.ratio?).abs()));
        block_error = changes.chain(block_error).reduce(f64::max);
    }
    let mut report = RimsReport {
        pressure_mpa,
        measured,
        measured_std,
        depth_um: LENGTH_UM.from_si(groove.depth_m()),
        block_um: LENGTH_UM.from_si(BLOCK_M),
        block_error,
        rows,
        statements: Vec::new(),
    };
    report.statements = statements(&report);
    Ok(report)
}

fn chi_square(ratio: &[Option<f64>], measured: &[f64], std: &[f64]) -> Option<f64> {
    let each = ratio.iter().zip(measured.iter().zip(std));
    each.map(|(ratio, (measured, std))| Some((((*ratio)? - measured) / std).powi(2)))
        .sum::<Option<f64>>()
        .filter(|sum| sum.is_finite())
}

/// Values at the lowest and at the highest pressure; `None` if the pressures are equal or a value is unknown.
fn ends(values: &[Option<f64>], pressure_mpa: &[f64]) -> Option<[f64; 2]> {
    let by_pressure = |a: &usize, b: &usize| pressure_mpa[*a].total_cmp(&pressure_mpa[*b]);
    let places = || 0..pressure_mpa.len();
    let (low, high) = (places().min_by(by_pressure)?, places().max_by(by_pressure)?);
    (pressure_mpa[low] < pressure_mpa[high]).then_some([(*values.get(low)?)?, (*values.get(high)?)?])
}

fn statements(report: &RimsReport) -> Vec<String> {
    let squares = || report.rows.iter().filter(|row| row.planform == "square");
    let measured: Vec<Option<f64>> = report.measured.iter().copied().map(Some).collect();
    let Some([low, high]) = ends(&measured, &report.pressure_mpa) else { return Vec::new() };
    let mut said = vec![format!(
        "The rims of the patterned samples were not measured: these heights are a table, fitted to nothing. Flat-topped rims in blocks of {} um{}.",
        report.block_um,
        report.block_error.map_or_else(String::new, |error| format!(
            ", half of which would change a groove's ratio by up to {error:.3}"
        ))
    )];
    let best = squares().filter(|row| row.rim_height_um > 0.0 && row.chi_square.is_some());
    let best =
        best.min_by(|a, b| a.chi_square.unwrap_or(f64::INFINITY).total_cmp(&b.chi_square.unwrap_or(f64::INFINITY)));
    let least = |row: &RimsRow| row.ratio.iter().flatten().copied().reduce(f64::min);
    let lowest = squares().filter_map(least).fold(f64::INFINITY, f64::min);
    let measured_lowest = report.measured.iter().copied().fold(f64::INFINITY, f64::min);
    if lowest.is_finite() {
        let has = if lowest <= measured_lowest { "have" } else { "do not reach" };
        said.push(format!(
            "Magnitude: rims of up to {} um {has} it: squares with them come down to a ratio of {lowest:.3}, where {measured_lowest:.3} was measured.",
            HEIGHTS_UM[HEIGHTS_UM.len() - 1]
        ));
    }
    if let Some(row) = best
        && let (Some([first, last]), Some(chi_square)) = (ends(&row.ratio, &report.pressure_mpa), row.chi_square)
    {
        let turns = (last > first) != (high > low);
        said.push(format!(
            "Trend: with one height, the ratio of squares goes from {first:.3} at the lightest load to {last:.3} at the heaviest (the nearest row, {} um high and {} um wide), as the share of the load that rims carry falls with load; the measured one goes from {low:.3} to {high:.3}. chi^2 of that row is {chi_square:.0} on {} loads{}",
            row.rim_height_um,
            row.rim_width_um.unwrap_or(0.0),
            report.measured.len(),
            if turns { ": rims of one height leave the measured squares unexplained." } else { "." }
        ));
    }
    said.push(
        "Grooves with a rim may come near what was measured on squares. That is no validation: only the planform that was measured counts."
            .to_owned(),
    );
    said
}

/// Table of the rims, the measured ratios first.
pub fn table(report: &RimsReport) -> Captioned {
    let mut header: Vec<String> = ["cavities", "rim in um", "width in um"].map(Into::into).into();
    header.extend(report.pressure_mpa.iter().map(|pressure| format!("{} MPa", number(*pressure, 2))));
    header.extend(["chi^2".to_owned(), "peak in MPa".to_owned()]);
    let mut table = Table::new(header.iter().map(String::as_str));
    let both = report.measured.iter().zip(&report.measured_std);
    let measured = both.map(|(ratio, std)| with_error(*ratio, *std, 3));
    let dashes = || ["-".to_owned(), "-".to_owned()];
    table.row(["measured".to_owned()].into_iter().chain(dashes()).chain(measured).chain(dashes()));
    for row in &report.rows {
        let first = [row.planform.clone(), plain(row.rim_height_um), plain(row.rim_width_um)];
        let ratios = row.ratio.iter().map(|ratio| number(*ratio, 3));
        table.row(first.into_iter().chain(ratios).chain([number(row.chi_square, 0), number(row.peak_pressure_mpa, 1)]));
    }
    let caption = format!(
        "Ratios, dimensionless, of cavities {} um deep with flat-topped rims of unknown height on all of their edges, elastic, at the \
         surface's slope. chi^2: sum over the loads of squared departures over the measured standard deviation.",
        plain(report.depth_um)
    );
    (caption, table)
}

/// Formats the table as CSV, one line per planform, rim width, rim height and pressure.
pub fn csv(report: &RimsReport) -> String {
    let rows: Vec<(&RimsRow, usize)> =
        report.rows.iter().flat_map(|row| (0..row.ratio.len()).map(move |at| (row, at))).collect();
    let mut table = Table::of(&rows);
    table.column("planform", |(row, _)| row.planform.clone());
    table.numbers("rim_width_um", |(row, _)| row.rim_width_um);
    table.numbers("rim_height_um", |(row, _)| row.rim_height_um);
    table.numbers("pressure_mpa", |(_, at)| report.pressure_mpa[*at]);
    table.numbers("ratio", |(row, at)| row.ratio[*at]);
    table.numbers("measured", |(_, at)| report.measured[*at]);
    table.numbers("measured_std", |(_, at)| report.measured_std[*at]);
    table.numbers("peak_pressure_mpa", |(row, _)| row.peak_pressure_mpa);
    table.table().csv()
}

/// Draws the ratios of squares with the wider rims and without rims, and the measured ratios.
///
/// # Errors
/// [`ChartError`] if the picture cannot be drawn.
pub fn picture(report: &RimsReport) -> Result<String, ChartError> {
    let widest = WIDTHS_UM[WIDTHS_UM.len() - 1];
    let is_wide = |row: &&RimsRow| row.planform == "square" && row.rim_width_um.is_none_or(|width| width == widest);
    // With more rows, two rows would share a mark.
    let drawn = report.rows.iter().filter(is_wide).filter(|row| row.rim_height_um != HEIGHTS_UM[2]);
    let column = |row: &RimsRow| {
        let label = match row.rim_height_um {
            height_um if height_um > 0.0 => format!("squares, rim {height_um} µm"),
            _ => "squares, no rim".to_owned(),
        };
        (label, row.ratio.iter().map(|ratio| Some(Estimate { value: (*ratio)?, error: None })).collect())
    };
    let title = format!("Patterned over flat: squares with flat rims {widest} µm wide, fitted to nothing");
    let both = report.measured.iter().zip(&report.measured_std);
    let measured = report.pressure_mpa.iter().zip(both).map(|(pressure, (ratio, std))| [*pressure, *ratio, *std]);
    beside_measured(&title, measured, drawn.map(column).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report(measured: [f64; 2], square: [f64; 2]) -> RimsReport {
        let row = |planform: &str, height: f64, ratio: [f64; 2]| RimsRow {
            planform: planform.into(),
            rim_width_um: (height > 0.0).then_some(20.0),
            rim_height_um: height,
            ratio: ratio.map(Some).to_vec(),
            peak_pressure_mpa: 9.0,
            chi_square: chi_square(&ratio.map(Some), &measured, &[0.01, 0.01]),
        };
        let mut report = RimsReport {
            pressure_mpa: vec![0.65, 2.6],
            measured: measured.to_vec(),
            measured_std: vec![0.01, 0.01],
            depth_um: 5.2,
            block_um: 5.0,
            block_error: Some(0.008),
            rows: vec![row("groove", 0.1, [0.85, 0.80]), row("square", 0.0, [0.99, 0.96]), row("square", 0.5, square)],
            statements: Vec::new(),
        };
        report.statements = statements(&report);
        report
    }

    #[test]
    fn a_trend_that_turns_is_told_as_unexplained() {
        let said = report([0.84, 0.81], [0.73, 0.87]).statements.join("\n");
        assert!(said.contains("from 0.730 at the lightest load to 0.870") && said.contains("unexplained"), "{said}");
        assert!(said.contains("have it") && said.contains("no validation") && said.contains("fitted to nothing"));
        // ((0.73 - 0.84)^2 + (0.87 - 0.81)^2) / 0.01^2 = 121 + 36
        assert!(said.contains("chi^2 of that row is 157 on 2 loads"), "{said}");
        let said = report([0.73, 0.87], [0.74, 0.86]).statements.join("\n");
        assert!(!said.contains("unexplained"), "{said}");
    }

    #[test]
    fn the_table_and_the_file_hold_every_row_and_the_picture_the_squares() {
        let report = report([0.84, 0.81], [0.73, 0.87]);
        let (text, csv, svg) = (table(&report).1.to_string(), csv(&report), picture(&report).unwrap());
        assert!(text.contains("measured") && text.contains("0.730") && text.contains("groove"), "{text}");
        assert_eq!(csv.lines().count(), 1 + 3 * 2);
        assert!(svg.contains("squares, no rim") && svg.contains("rim 0.5") && !svg.contains("groove"));
    }
}
