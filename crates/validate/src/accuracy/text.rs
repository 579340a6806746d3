//! Comparison as Markdown, CSV and a diagram.

use std::fmt::Write as _;

use super::difference::Quantity;
use super::plan::Family;
use super::report::{AccuracyReport, FrontReport, RowReport, ValueReport};
use slipgrid_design::results::fixed;
use slipgrid_report::charts::{self, WorkPoint, WorkPrecisionChart, WorkPrecisionPanel};

pub(super) const QUANTITIES: [Quantity; 3] = [Quantity::MuDynamic, Quantity::MuStatic, Quantity::Ratio];

/// Formats the page as Markdown; results that do not depend on the machine come first.
pub fn markdown(report: &AccuracyReport) -> String {
    let mut text = format!("# Speed against error ({})\n\n", report.size);
    for statement in &report.model {
        text += &format!("- {statement}\n");
    }
    let reference = &report.reference;
    text += "\n## Reference\n\n";
    text += &markdown_table(
        &["quantity", "mean", "+-", "standard deviation from draw to draw"],
        QUANTITIES.into_iter().filter_map(|quantity| Some((quantity, reference.value(quantity)?))).map(
            |(quantity, value)| {
                vec![
                    quantity.name().to_owned(),
                    fixed(Some(value.value), 5),
                    fixed(value.stderr, 5),
                    fixed(value.std, 5),
                ]
            },
        ),
    );
    text += &format!("\nStatus: {}.\n", reference.status);

    text += "\n## Methods: error against the reference, per cent\n\n";
    let header =
        ["method", "step ns", "site updates", "dynamic mu", "static mu", "ratio", "status", "wall s", "updates/s"];
    text += &markdown_table(&header, [reference].into_iter().chain(&report.methods).map(method_cells));
    text +=
        "\nWall time: one draw, both surfaces, on one thread with a core to itself. Bold: a default of the program.\n";

    if let Some(finest) = report.discretization.last() {
        text += &format!("\n## Blocks: change from `{}`, per cent\n\n", finest.name);
        text += &markdown_table(
            &["method", "dynamic mu", "ratio", "status", "wall s"],
            report.discretization.iter().map(|row| {
                let mut cells = vec![row.name.clone()];
                cells.extend([Quantity::MuDynamic, Quantity::Ratio].map(|quantity| change(row.value(quantity))));
                cells.extend([row.status.clone(), significant_digits(row.wall_s)]);
                cells
            }),
        );
    }

    text += "\n## Choices of the model: change of the answer, per cent\n\n";
    text += &format!(
        "No errors: each row is another scene. Compared with `dynamic` as in the scene, dynamic mu {}, static mu {}, \
         ratio {}.\n\n",
        fixed(report.base.mu_dynamic.map(|value| value.value), 4),
        fixed(report.base.mu_static.map(|value| value.value), 4),
        fixed(report.base.ratio.map(|value| value.value), 4),
    );
    text += &markdown_table(
        &["choice", "dynamic mu", "static mu", "ratio", "status"],
        report.choices.iter().map(|row| {
            let mut cells = vec![row.name.clone()];
            cells.extend(QUANTITIES.map(|quantity| error_text(row.value(quantity))));
            cells.push(row.status.clone());
            cells
        }),
    );

    text += "\n## Scatter from draw to draw\n\n";
    text += &scatter(&report.scatter);

    text += "\n## Fastest at each error\n\n";
    for front in &report.fronts {
        text += &front_text(front);
    }
    if report.size == "quick" {
        text += "A quick page resolves large errors only; `--full` tells apart what counts as equal here.\n";
    }
    text += "\n## Machine\n\n";
    text + &machine(report)
}

fn markdown_table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
    let mut text = format!("| {} |\n|---|{}\n", header.join(" | "), "---:|".repeat(header.len() - 1));
    for cells in rows {
        // A bar would end its cell.
        let cells: Vec<String> = cells.into_iter().map(|cell| cell.replace('|', "/")).collect();
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text
}

pub(super) fn method_cells(row: &RowReport) -> Vec<String> {
    let mut cells = vec![
        if row.default_of.is_some() { format!("**{}**", row.name) } else { row.name.clone() },
        fixed(row.step_ns, 2),
        row.site_updates.map_or_else(|| "-".to_owned(), |updates| format!("{:.2e}", updates as f64)),
    ];
    cells.extend(QUANTITIES.map(|quantity| error_text(row.value(quantity))));
    cells.extend([
        row.status.clone(),
        significant_digits(row.wall_s),
        row.site_updates_per_s.map_or_else(|| "-".to_owned(), |rate| format!("{rate:.2e}")),
    ]);
    cells
}

/// Formats a difference with its standard error, and its significance.
pub(super) fn error_text(value: Option<ValueReport>) -> String {
    let Some(value) = value else { return "-".to_owned() };
    let Some(percent) = value.difference_pct else { return "-".to_owned() };
    let size = fixed(Some(percent), 2);
    let sign = if percent > 0.0 { "+" } else { "" };
    match (value.difference_stderr_pct, value.significant) {
        (Some(stderr), Some(true)) => format!("{sign}{size} +- {}", fixed(Some(stderr), 2)),
        (Some(stderr), _) => format!("{sign}{size} +- {} n.s.", fixed(Some(stderr), 2)),
        (None, _) => format!("{sign}{size}"),
    }
}

/// Formats a difference between two deterministic methods.
pub(super) fn change(value: Option<ValueReport>) -> String {
    let percent = value.and_then(|value| value.difference_pct);
    let sign = if percent.is_some_and(|percent| percent > 0.0) { "+" } else { "" };
    format!("{sign}{}", fixed(percent, 3))
}

/// Formats three significant digits.
pub(super) fn significant_digits(value: f64) -> String {
    if value <= 0.0 {
        return "-".to_owned();
    }
    let decimals = (2.0 - value.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

fn scatter(row: &RowReport) -> String {
    let mut text = format!("`dynamic` as in the scene with {} draws of the local coefficients:\n\n", row.seeds);
    text += &markdown_table(
        &["quantity", "mean", "standard deviation", "per cent"],
        QUANTITIES.into_iter().filter_map(|quantity| Some((quantity, row.value(quantity)?))).map(
            |(quantity, value)| {
                vec![
                    quantity.name().to_owned(),
                    fixed(Some(value.value), 5),
                    fixed(value.std, 5),
                    fixed(value.std.map(|std| 100.0 * std / value.value), 2),
                ]
            },
        ),
    );
    text
}

fn front_text(front: &FrontReport) -> String {
    let mut text = format!(
        "Front of wall time against error in {}, fastest first: {}. Errors below {} % cannot be told apart here and count \
         as equal, as do times within a tenth.\n\n",
        front.quantity,
        front.methods.join("; "),
        fixed(Some(front.resolution_pct), 2),
    );
    for default in &front.defaults {
        let what = format!("{}, the default of {}", default.name, default.default_of);
        text += &match (&default.better, &default.among_static) {
            (None, _) => format!("- on the front: {what}\n"),
            (Some(better), None) => format!("- not on the front: {what}; {better} is faster and no less accurate\n"),
            (Some(better), Some(among)) => {
                let standing = among.better.as_ref().map_or_else(
                    || "this one is on the front".to_owned(),
                    |better| format!("{better} is faster and no less accurate"),
                );
                format!(
                    "- not on the front: {what}; {better} is faster and no less accurate but gives no static mu, and \
                     among the methods that do {standing}\n"
                )
            }
        };
    }
    text + "\n"
}

pub(super) fn machine(report: &AccuracyReport) -> String {
    let machine = &report.machine;
    let mut text = format!("slipgrid {}, {}, {}", report.version, machine.architecture, machine.system);
    if let Some(processors) = machine.processors {
        text += &format!(", {processors} processors");
    }
    if let Some(date) = &machine.date {
        text += &format!(", {date}");
    }
    text + &format!("; {:.0} s on {} threads in all.\n", report.wall_s, report.threads)
}

/// Formats the rows as CSV, one line per row.
pub fn csv(report: &AccuracyReport) -> String {
    let mut text = String::from(
        "kind,family,name,default_of,status,seeds,step_ns,site_updates,\
         mu_dynamic,mu_dynamic_stderr,mu_dynamic_difference_pct,mu_dynamic_difference_stderr_pct,mu_dynamic_significant,\
         mu_static,mu_static_difference_pct,mu_static_difference_stderr_pct,mu_static_significant,\
         ratio,ratio_stderr,ratio_difference_pct,ratio_difference_stderr_pct,ratio_significant,\
         wall_s,site_updates_per_s\n",
    );
    let kinds = [("reference", std::slice::from_ref(&report.reference)), ("method", &report.methods)];
    let others = [("base", std::slice::from_ref(&report.base)), ("choice", &report.choices)];
    let scatter = [("scatter", std::slice::from_ref(&report.scatter))];
    for (kind, rows) in kinds.into_iter().chain(others).chain(scatter) {
        for row in rows {
            let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
            let mut cells = vec![
                kind.to_owned(),
                row.family.to_owned(),
                quoted(&row.name),
                quoted(row.default_of.unwrap_or_default()),
                quoted(&row.status),
                row.seeds.to_string(),
                number(row.step_ns),
                row.site_updates.map_or_else(String::new, |updates| updates.to_string()),
            ];
            for quantity in QUANTITIES {
                let value = row.value(quantity);
                cells.push(number(value.map(|value| value.value)));
                if quantity != Quantity::MuStatic {
                    cells.push(number(value.and_then(|value| value.stderr)));
                }
                cells.push(number(value.and_then(|value| value.difference_pct)));
                cells.push(number(value.and_then(|value| value.difference_stderr_pct)));
                let significant = value.and_then(|value| value.significant);
                cells.push(significant.map_or_else(String::new, |significant| significant.to_string()));
            }
            cells.push(row.wall_s.to_string());
            cells.push(number(row.site_updates_per_s));
            let _ = writeln!(text, "{}", cells.join(","));
        }
    }
    text
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(String::new, |value| value.to_string())
}

/// Draws the diagram; `None` if no method has an error.
///
/// # Errors
/// [`slipgrid_report::ChartError`] if the diagram cannot be drawn.
pub fn picture(report: &AccuracyReport) -> Result<Option<String>, charts::ChartError> {
    let families = Family::METHODS.map(Family::name);
    let points: Vec<(Vec<WorkPoint<'_>>, &FrontReport)> = [Quantity::MuDynamic, Quantity::Ratio]
        .into_iter()
        .filter_map(|quantity| {
            let front = report.fronts.iter().find(|front| front.quantity == quantity.name())?;
            let place = |row| work_point(row, quantity, front, &families);
            Some((report.methods.iter().filter_map(place).collect(), front))
        })
        .collect();
    if points.is_empty() {
        return Ok(None);
    }
    let titles: Vec<String> = points.iter().map(|(_, front)| format!("error in {} (%)", front.quantity)).collect();
    let panels: Vec<WorkPrecisionPanel<'_>> = points
        .iter()
        .zip(&titles)
        .map(|((points, front), title)| WorkPrecisionPanel {
            error_title: title,
            points,
            resolution_pct: front.resolution_pct,
        })
        .collect();
    let title = format!("Speed against error ({})", report.size);
    let chart = WorkPrecisionChart {
        title: &title,
        families: &families,
        panels: &panels,
        reference_s: report.reference.wall_s,
    };
    Ok(Some(charts::work_precision(&chart)?))
}

fn work_point<'a>(
    row: &'a RowReport,
    quantity: Quantity,
    front: &FrontReport,
    families: &[&str],
) -> Option<WorkPoint<'a>> {
    let point = row.point(quantity)?;
    Some(WorkPoint {
        label: &row.label,
        family: families.iter().position(|family| *family == row.family)?,
        wall_s: point.cost,
        error_pct: point.error,
        at_most: row.value(quantity)?.significant != Some(true),
        on_front: front.methods.contains(&row.name),
        is_default: row.default_of.is_some(),
    })
}
