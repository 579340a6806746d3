//! Validation as a table, statements, CSV and a picture.

use std::fmt::Write as _;

use super::ratios::{ModelledRatio, RatioReport};
use super::report::ValidationReport;
use slipgrid_base::units::{LENGTH_MM, LENGTH_UM};
use slipgrid_design::results::Table;
use slipgrid_design::results::fixed;
use slipgrid_io::formats::scene::{DEFAULT_LAYER, DEFAULT_THICKNESS_M};
use slipgrid_report::charts::{self, Estimate};

/// Formats the report as text.
pub fn table(report: &ValidationReport) -> String {
    let trial = report.trial.as_ref().map_or_else(String::new, |name| format!(", trial \"{name}\""));
    let mut text = format!("{} ({}){trial}\n", report.name, report.source);
    for statement in &report.model {
        text += &format!("- {statement}\n");
    }
    text += &format!("\nMeasured, +- one standard deviation\n\n{}", measured(report));
    text += &format!(
        "\nModelled ratios, patterned over flat, at slopes of the surface times {}; {}\n{}\n\n{}\n",
        listed(&report.slope_factors),
        if report.has_squares() { "grooves in the plane, squares in space" } else { "in the plane" },
        report.errors,
        modelled(report),
    );
    if let Some(table) = by_measured_law(report) {
        text += &format!(
            "Modelled ratios where measured flat friction itself is the local law, mu(p) = mu_flat(P = p)\n\n{table}\n"
        );
    }
    for statement in &report.statements {
        text += &format!("{statement}\n");
    }
    if let Some(rims) = &report.rims {
        text +=
            &format!("\nRims of unknown height, cavities {} um deep\n\n{}\n", rims.depth_um, super::rims::table(rims));
        for statement in &rims.statements {
            text += &format!("{statement}\n");
        }
    }
    for warning in warnings(report) {
        text += &format!("! {warning}\n");
    }
    let in_time = report.in_time.as_ref().map(|run| format!(", of which friction in time {:.1} s", run.wall_s));
    text + &format!("\n{:.1} s on {} threads{}\n", report.wall_s, report.threads, in_time.unwrap_or_default())
}

/// Table of measurements, one row per condition.
fn measured(report: &ValidationReport) -> Table {
    let mut table =
        Table::new(["F N", "P MPa", "v mm/s", "RH %", "mu flat", "+-", "mu patterned", "+-", "ratio", "+-"]);
    for row in &report.results {
        let first = [
            row.measured.force_n.to_string(),
            fixed(Some(row.measured.pressure_mpa), 3),
            row.measured.speed_mm_s.to_string(),
            row.measured.humidity_pct.to_string(),
        ];
        let values = [
            row.measured.mu_flat,
            row.measured.mu_flat_std,
            row.measured.mu_patterned,
            row.measured.mu_patterned_std,
            row.measured.ratio,
            row.measured.ratio_std,
        ];
        table.row(first.into_iter().chain(values.map(|value| fixed(Some(value), 3))));
    }
    table
}

/// Table of model results.
fn modelled(report: &ValidationReport) -> Table {
    let mut header: Vec<String> = ["F N", "v mm/s", "RH %", "Amontons"].map(Into::into).into();
    for factor in &report.slope_factors {
        header.extend([format!("groove {factor}x"), "+-".into()]);
        if report.has_squares() {
            header.extend([format!("square {factor}x"), "+-".into()]);
        }
    }
    let mut table = Table::new(header.iter().map(String::as_str));
    for row in &report.results {
        let first = [
            row.measured.force_n.to_string(),
            row.measured.speed_mm_s.to_string(),
            row.measured.humidity_pct.to_string(),
            fixed(row.ratio_amontons_coulomb, 3),
        ];
        let values = report.slope_factors.iter().flat_map(|&factor| {
            let at = row.at_slope(factor);
            let value = |of: fn(&ModelledRatio) -> Option<f64>| fixed(at.and_then(of), 3);
            let mut values = vec![value(|at| at.ratio_groove), value(|at| at.ratio_groove_std)];
            if report.has_squares() {
                values.extend([value(|at| at.ratio_square), value(|at| at.ratio_square_std)]);
            }
            values
        });
        table.row(first.into_iter().chain(values));
    }
    table
}

/// Table of the model with the measured law, one row per condition; `None` if no condition has it.
fn by_measured_law(report: &ValidationReport) -> Option<Table> {
    let first = report.results.iter().find(|row| !row.measured_law.is_empty())?;
    let mut header: Vec<String> = ["F N", "v mm/s", "RH %", "measured"].map(Into::into).into();
    for law in &first.measured_law {
        header.push(format!("groove, {}", law.extrapolation));
        if report.has_squares() {
            header.push(format!("square, {}", law.extrapolation));
        }
    }
    let mut table = Table::new(header.iter().map(String::as_str));
    for row in report.results.iter().filter(|row| !row.measured_law.is_empty()) {
        let first = [
            row.measured.force_n.to_string(),
            row.measured.speed_mm_s.to_string(),
            row.measured.humidity_pct.to_string(),
            fixed(Some(row.measured.ratio), 3),
        ];
        let values = row.measured_law.iter().flat_map(|law| {
            let square = report.has_squares().then(|| fixed(law.ratio_square, 3));
            std::iter::once(fixed(law.ratio_groove, 3)).chain(square)
        });
        table.row(first.into_iter().chain(values));
    }
    Some(table)
}

/// Describes the results of both interpretations of flat friction, and the data that would discriminate between them.
fn two_laws(report: &ValidationReport) -> Option<String> {
    let ends = |of: &dyn Fn(&RatioReport) -> Vec<f64>| {
        let all: Vec<f64> = report.results.iter().flat_map(of).collect();
        let least = all.iter().copied().reduce(f64::min)?;
        Some(format!("{least:.3} to {:.3}", all.iter().copied().fold(least, f64::max)))
    };
    let grooves = ends(&|row| row.measured_law.iter().filter_map(|law| law.ratio_groove).collect())?;
    let by_area = ends(&|row| row.at_slope(1.0).and_then(|at| at.ratio_groove).into_iter().collect())?;
    let below = |row: &RatioReport| {
        let modelled = row.measured_law.iter().filter_map(|law| law.ratio_groove);
        let least = modelled.chain(row.at_slope(1.0).and_then(|at| at.ratio_groove)).reduce(f64::min);
        least.is_some_and(|least| row.measured.ratio < least)
    };
    let measured = if report.results.iter().all(below) { " The measured ratios lie below both." } else { "" };
    Some(format!(
        "Two laws fit the flat samples alike: coefficients of each load times the area law (grooves: {by_area}), or measured flat friction \
         itself as the law of local pressure (grooves: {grooves}). {DECIDES}{measured}"
    ))
}

/// Data that would discriminate between the two laws.
const DECIDES: &str = "Flat samples cannot tell them apart: in these local and nominal pressure are one. Samples with uneven pressure \
     of a known shape would decide: a sphere or a cylinder of the same material and finish, whose pressure is Hertz's, or patterns of \
     one areal density with more and with fewer edges. By the area law friction falls with the pressure under edges, by the \
     measured law it rises with it where flat friction does with load.";

fn listed(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ")
}

fn percent(share: Option<f64>) -> String {
    share.map_or_else(|| "-".to_owned(), |share| format!("{} %", fixed(Some(100.0 * share), 1)))
}

/// Conclusions from the numbers, and their basis.
pub fn statements(report: &ValidationReport) -> Vec<String> {
    let (summary, pattern) = (&report.summary, &report.pattern);
    let spread = summary.reduction_measured_std.map_or_else(String::new, |std| {
        format!(", standard deviation {} between {} conditions", percent(Some(std)), summary.conditions)
    });
    let mut said = vec![format!(
        "Measured: the pattern lowers dynamic friction by {}{spread}.",
        percent(Some(summary.reduction_measured))
    )];
    if let Some(given) = summary.modelled.iter().find(|modelled| modelled.slope_factor == 1.0) {
        let mut modelled = format!(
            "Modelled: by {} as grooves ({} of the surface)",
            percent(given.groove),
            percent(Some(pattern.areal_density))
        );
        if report.has_squares() {
            modelled += &format!(
                ", by {} as square cavities ({}, in space; {} by the strip estimate)",
                percent(given.square),
                percent(Some(report.areal_density_square)),
                percent(given.square_estimate),
            );
        }
        said.push(modelled + ".");
    }
    said.push(match (summary.explained_by_grooves, summary.explained_by_squares) {
        (Some(grooves), _) if !report.has_squares() => {
            format!("The area law alone explains {:.0} % of the measured reduction: {ELSEWHERE}", 100.0 * grooves)
        }
        (Some(grooves), Some(squares)) => format!(
            "The area law alone explains {:.0} % of the measured reduction if the cavities were grooves, {:.0} % as {}: {ELSEWHERE}",
            100.0 * grooves,
            100.0 * squares,
            match report.cut_as.as_deref() {
                Some("square") => "the squares they are",
                _ => "squares of the same lengths",
            }
        ),
        _ => "No share of the measured reduction can be given.".to_owned(),
    });
    said.extend(trend(report));
    said.extend(two_laws(report));
    let rims =
        if report.has_squares() { ": what some of unknown height would do stands in a table of its own" } else { "" };
    said.push(format!("{LEFT_OPEN}{rims}."));
    let others: Vec<String> = summary
        .modelled
        .iter()
        .filter(|modelled| modelled.slope_factor != 1.0)
        .map(|m| {
            let squares =
                if report.has_squares() { format!(" and {} as squares", percent(m.square)) } else { String::new() };
            format!("{} as grooves{squares} at {} times the slope", percent(m.groove), m.slope_factor)
        })
        .collect();
    if !others.is_empty() {
        said.push(format!("The surface's slope decides how much: the model gives {}.", others.join(", ")));
    }
    if let (Some(mean), Some(largest)) =
        (summary.ratio_change_at_measured_depth, summary.largest_ratio_change_at_measured_depth)
    {
        said.push(format!(
            "Depth: {} um is modelled, {} um was measured. At {} um the groove's ratio changes by {} on average, by {} at most, that of squares by {}.",
            pattern.depth_um,
            report.measured_depth_um,
            report.measured_depth_um,
            signed(mean),
            signed(largest),
            summary.square_ratio_change_at_measured_depth.map_or_else(|| "-".to_owned(), signed),
        ));
    }
    said.extend(thickness(report));
    if report.synthetic_surface {
        said.push(
            "The surface behind the area law is synthetic, not measured: these ratios are no test of the model until it is.".to_owned(),
        );
    }
    said.push("Nothing was tuned to the patterned samples.".to_owned());
    said
}

/// Limits of the comparison, independent of its numbers.
const LEFT_OPEN: &str = "What the mechanism can explain: a reduction that grows with load, by pressure under the edges of cavities where real \
     contact area saturates. What it cannot: a reduction at vanishing load, and how friction depends on speed and humidity, \
     which enters through the flat measurements alone. Adhesion and menisci, plasticity, heating and wear are not modelled, \
     and rims are not in these numbers";

/// Remark on the reduction that the area law does not explain.
const ELSEWHERE: &str = "the rest comes from elsewhere, or from another surface.";

/// Describes the change of both reductions from the lowest to the highest pressure.
fn trend(report: &ValidationReport) -> Option<String> {
    let by_pressure = |a: &&RatioReport, b: &&RatioReport| a.measured.pressure_mpa.total_cmp(&b.measured.pressure_mpa);
    let (low, high) = (report.results.iter().min_by(by_pressure)?, report.results.iter().max_by(by_pressure)?);
    let one_condition = report.results.iter().all(|row| row.measured.is_at_condition_of(&low.measured));
    if !one_condition || high.measured.pressure_mpa <= low.measured.pressure_mpa {
        return None;
    }
    let groove =
        |row: &RatioReport| row.at_slope(1.0).and_then(|modelled| modelled.ratio_groove).map(|ratio| 1.0 - ratio);
    Some(format!(
        "From {} to {} MPa the measured reduction goes from {} to {}, the grooves' from {} to {}.",
        fixed(Some(low.measured.pressure_mpa), 3),
        fixed(Some(high.measured.pressure_mpa), 3),
        percent(Some(1.0 - low.measured.ratio)),
        percent(Some(1.0 - high.measured.ratio)),
        percent(groove(low)),
        percent(groove(high)),
    ))
}

/// Describes the error of the source's layer, compared with the specimen.
fn thickness(report: &ValidationReport) -> Option<String> {
    let largest = |of: fn(&ModelledRatio) -> Option<f64>| {
        let each = report.results.iter().filter_map(|row| of(row.at_slope(1.0)?));
        each.reduce(|largest, own| if own.abs() > largest.abs() { own } else { largest })
    };
    let grooves = largest(|modelled| modelled.ratio_groove_thick_difference)?;
    let squares = largest(|modelled| modelled.ratio_square_thick_difference)?;
    Some(format!(
        "Layer: the source's {} um are modelled; all of its specimen's {} mm would change the groove's ratio by {} at most, that of squares by {}.",
        LENGTH_UM.from_si(DEFAULT_LAYER.height_m),
        LENGTH_MM.from_si(DEFAULT_THICKNESS_M),
        signed(grooves),
        signed(squares),
    ))
}

fn signed(value: f64) -> String {
    let text = fixed(Some(value), 4);
    if value > 0.0 { format!("+{text}") } else { text }
}

/// Warnings for the reader.
fn warnings(report: &ValidationReport) -> Vec<String> {
    type Test = fn(&ModelledRatio) -> bool;
    let all: [(Test, &str); 4] = [
        (|modelled| !modelled.has_converged(), "solves did not converge"),
        (|modelled| modelled.cavity_closed, "solves close a cavity: its ceiling reaches the counterface"),
        (|modelled| modelled.area_law_extrapolated, "solves go past the last pressure of the area law"),
        (|modelled| modelled.tension_blocks > 0, "solves have contact blocks under tension, which carry no friction"),
    ];
    let solves = || report.results.iter().flat_map(|row| row.modelled.iter().chain(&row.modelled_at_measured_depth));
    all.into_iter()
        .filter_map(|(test, what)| {
            let count = solves().filter(|modelled| test(modelled)).count();
            (count > 0).then(|| format!("{count} of {} {what}", solves().count()))
        })
        .collect()
}

/// Formats the results as CSV: one row per condition and slope factor, and one for the measured depth.
pub fn csv(report: &ValidationReport) -> String {
    let mut text = String::from(
        "force_n,pressure_mpa,speed_mm_s,humidity_pct,mu_flat,mu_flat_std,mu_patterned,mu_patterned_std,ratio,ratio_std,\
         ratio_amontons_coulomb,depth_um,slope_factor,rms_slope,area_law_factor,dynamic_mean,ratio_groove,ratio_groove_std,\
         ratio_square,ratio_square_std,ratio_square_estimate\n",
    );
    let or_empty = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
    for row in &report.results {
        let slopes = row.modelled.iter().map(|modelled| (report.pattern.depth_um, modelled));
        let depth = row.modelled_at_measured_depth.iter().map(|modelled| (report.measured_depth_um, modelled));
        for (depth_um, modelled) in slopes.chain(depth) {
            // Writing to a string cannot fail.
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{},{},{},{},{depth_um},{},{},{},{},{},{},{},{},{}",
                row.measured.force_n,
                row.measured.pressure_mpa,
                row.measured.speed_mm_s,
                row.measured.humidity_pct,
                row.measured.mu_flat,
                row.measured.mu_flat_std,
                row.measured.mu_patterned,
                row.measured.mu_patterned_std,
                row.measured.ratio,
                row.measured.ratio_std,
                or_empty(row.ratio_amontons_coulomb),
                modelled.slope_factor,
                or_empty(modelled.rms_slope),
                modelled.area_law_factor,
                modelled.dynamic_mean,
                or_empty(modelled.ratio_groove),
                or_empty(modelled.ratio_groove_std),
                or_empty(modelled.ratio_square),
                or_empty(modelled.ratio_square_std),
                or_empty(modelled.ratio_square_estimate),
            );
        }
    }
    text
}

/// Draws measured and modelled ratios against pressure, at the condition of the first row.
///
/// # Errors
/// [`ChartError`](slipgrid_report::ChartError) if the picture cannot be drawn.
pub fn picture(report: &ValidationReport) -> Result<String, slipgrid_report::ChartError> {
    let Some(first) = report.results.first() else { return Ok(String::new()) };
    let rows: Vec<&RatioReport> =
        report.results.iter().filter(|row| row.measured.is_at_condition_of(&first.measured)).collect();
    let column = |factor: f64, of: fn(&ModelledRatio) -> (Option<f64>, Option<f64>)| -> Vec<Option<Estimate>> {
        let estimate = |row: &&RatioReport| {
            let (value, error) = of(row.at_slope(factor)?);
            Some(Estimate { value: value?, error })
        };
        rows.iter().map(estimate).collect()
    };
    let measured = rows
        .iter()
        .map(|row| Some(Estimate { value: row.measured.ratio, error: Some(row.measured.ratio_std) }))
        .collect();
    let mut columns = vec![("measured (bars: ± one standard deviation)".to_owned(), measured)];
    // The surface as given and the two most different slope factors: more would be indistinguishable.
    let mut factors: Vec<f64> = [report.slope_factors.first(), Some(&1.0), report.slope_factors.last()]
        .into_iter()
        .flatten()
        .copied()
        .collect();
    factors.dedup();
    for factor in factors {
        let label = if factor == 1.0 { "grooves".to_owned() } else { format!("grooves, {factor} times the slope") };
        columns.push((label, column(factor, |at| (at.ratio_groove, at.ratio_groove_std))));
    }
    if report.has_squares() {
        columns.push(("squares, in space".to_owned(), column(1.0, |at| (at.ratio_square, at.ratio_square_std))));
    }
    let title = format!(
        "Patterned over flat, {} mm/s, {} % humidity{}",
        first.measured.speed_mm_s,
        first.measured.humidity_pct,
        if report.synthetic_surface { " (synthetic surface)" } else { "" }
    );
    let pressure_mpa: Vec<f64> = rows.iter().map(|row| (row.measured.pressure_mpa * 1e3).round() / 1e3).collect();
    charts::ratios(&title, &pressure_mpa, &columns)
}
