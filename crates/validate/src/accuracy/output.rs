//! Comparison as Markdown, CSV and a picture.

use std::fmt::Write as _;

use slipgrid_base::units::counted;
use slipgrid_design::results::{Table, fixed};
use slipgrid_report::charts::{self, ChartError, WorkPoint, WorkPrecisionPanel};

use super::Accuracy;
use super::comparison::{Compared, OBSERVABLES, Value};
use super::plan::Family;

/// Indices in [`OBSERVABLES`] of the observables with a Pareto front: dynamic mu and the ratio. Static friction has no
/// front, because one run gives no standard error of static friction.
const WITH_FRONT: [usize; 2] = [0, 2];

/// Formats the comparison as Markdown.
pub fn markdown(of: &Accuracy) -> String {
    let mut text = format!("# Speed against error ({})\n\n", of.size);
    text += &slipgrid_report::marked("-", &of.model);
    if let Some(reference) = of.methods.first() {
        text += "\n## Reference\n\n| quantity | mean | +- | standard deviation between draws |\n|---|---:|---:|---:|\n";
        for (name, value) in OBSERVABLES.iter().zip(&reference.values) {
            let Some(value) = value else { continue };
            let [mean, stderr, std] = [Some(value.mean), value.stderr, value.std].map(|value| fixed(value, 5));
            let _ = writeln!(text, "| {name} | {mean} | {stderr} | {std} |");
        }
    }
    text += "\n## Methods: error against the reference, per cent\n\n\
             | method | step ns | site updates | dynamic mu | static mu | ratio | status | wall s | updates/s |\n\
             |---|---:|---:|---:|---:|---:|---:|---:|---:|\n";
    for compared in &of.methods {
        // A bar would end its cell.
        let status = compared.status.replace('|', "/");
        let [dynamic, at_rest, ratio] = compared.values.each_ref().map(|value| error(value.as_ref()));
        let updates = |number: Option<f64>| number.map_or_else(|| "-".to_owned(), |number| format!("{number:.2e}"));
        let _ = writeln!(
            text,
            "| {} | {} | {} | {dynamic} | {at_rest} | {ratio} | {status} | {} | {} |",
            if compared.method.default_of.is_some() {
                format!("**{}**", compared.method.name)
            } else {
                compared.method.name.clone()
            },
            fixed(compared.step_ns, 2),
            updates(compared.site_updates.map(|updates| updates as f64)),
            three_digits(compared.wall_s),
            updates(compared.site_updates_per_s),
        );
    }
    text += "\nWall time: one draw, both surfaces, on one thread. Bold: a default of the program.\n\n## Fastest at each error\n";
    for observable in WITH_FRONT {
        text += &front(of, observable);
    }
    let [architecture, system] = of.machine;
    text + &format!(
        "\nslipgrid {}, {architecture}, {system}; {:.0} s on {} in all.\n",
        of.made_by.version,
        of.wall_s,
        counted(of.threads, "thread")
    )
}

/// Formats the Pareto front of wall time and error in the observable with the index `observable`, and states which
/// default methods of the program are on the front; empty if the smallest distinguishable error is unknown.
fn front(of: &Accuracy, observable: usize) -> String {
    let Some(resolution_pct) = of.resolution_pct[observable] else { return String::new() };
    let ranked = || of.methods.iter().filter_map(|compared| Some((compared, compared.values[observable].as_ref()?)));
    let mut best: Vec<&Compared> =
        ranked().filter(|(_, value)| value.is_on_front).map(|(compared, _)| compared).collect();
    best.sort_by(|a, b| a.wall_s.total_cmp(&b.wall_s));
    let mut text = format!(
        "\nFront of wall time against error in {}, fastest first: {}. Errors below {} % and times within a tenth count as \
         equal.\n\n",
        OBSERVABLES[observable],
        best.iter().map(|compared| compared.method.name.as_str()).collect::<Vec<_>>().join("; "),
        fixed(Some(resolution_pct), 2),
    );
    for (compared, value) in ranked() {
        let Some(default_of) = compared.method.default_of else { continue };
        text += &match &value.better {
            None => format!("- on the front: {}, the default of {default_of}\n", compared.method.name),
            Some(better) => format!(
                "- not on the front: {}, the default of {default_of}; {better} is faster and no less accurate\n",
                compared.method.name
            ),
        };
    }
    text
}

/// Formats a difference from the reference with its standard error, in per cent, and marks it if it is not significant.
fn error(value: Option<&Value>) -> String {
    let Some((value, percent)) = value.and_then(|value| Some((value, value.difference_pct?))) else {
        return "-".to_owned();
    };
    let sign = if percent > 0.0 { "+" } else { "" };
    let stderr =
        value.difference_stderr_pct.map_or_else(String::new, |stderr| format!(" +- {}", fixed(Some(stderr), 2)));
    let chance = if value.is_significant() == Some(false) { " n.s." } else { "" };
    format!("{sign}{}{stderr}{chance}", fixed(Some(percent), 2))
}

/// Formats `value` with three significant digits, or as a dash if it is not positive.
fn three_digits(value: f64) -> String {
    if value <= 0.0 {
        return "-".to_owned();
    }
    // Between 0 and 9: the cast is exact.
    let decimals = (2.0 - value.log10().floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

/// Formats the comparison as CSV, one row per method.
pub fn csv(of: &Accuracy) -> String {
    let quoted = |text: &str| format!("\"{}\"", text.replace('"', "\"\""));
    let mut table = Table::of(&of.methods);
    table.column("family", |of| Family::NAMES[of.method.family as usize].to_owned());
    table.column("name", |of| quoted(&of.method.name));
    table.column("default_of", |of| quoted(of.method.default_of.unwrap_or_default()));
    table.column("status", |of| quoted(&of.status));
    table.numbers("step_ns", |of| of.step_ns);
    table.numbers("site_updates", |of| of.site_updates.map(|updates| updates as f64));
    let mut column = |title: &str, place: usize, get: fn(&Value) -> Option<f64>| {
        table.numbers(title, |of| of.values[place].as_ref().and_then(get));
    };
    column("mu_dynamic", 0, |value| Some(value.mean));
    column("mu_dynamic_stderr", 0, |value| value.stderr);
    column("mu_dynamic_difference_pct", 0, |value| value.difference_pct);
    column("mu_dynamic_difference_stderr_pct", 0, |value| value.difference_stderr_pct);
    column("mu_static", 1, |value| Some(value.mean));
    column("mu_static_stderr", 1, |value| value.stderr);
    column("mu_static_difference_pct", 1, |value| value.difference_pct);
    column("mu_static_difference_stderr_pct", 1, |value| value.difference_stderr_pct);
    column("ratio", 2, |value| Some(value.mean));
    column("ratio_stderr", 2, |value| value.stderr);
    column("ratio_difference_pct", 2, |value| value.difference_pct);
    column("ratio_difference_stderr_pct", 2, |value| value.difference_stderr_pct);
    table.numbers("wall_s", |of| of.wall_s);
    table.numbers("site_updates_per_s", |of| of.site_updates_per_s);
    table.table().csv()
}

/// Draws wall time against error; `None` if no method has an error.
///
/// # Errors
/// [`ChartError`] if the picture cannot be drawn.
pub fn picture(of: &Accuracy) -> Result<Option<String>, ChartError> {
    let panel = |observable: usize| {
        let points = of.methods.iter().filter_map(|compared| work_point(compared, observable)).collect();
        let error_title = format!("error in {} (%)", OBSERVABLES[observable]);
        Some(WorkPrecisionPanel { error_title, points, resolution_pct: of.resolution_pct[observable]? })
    };
    let panels: Vec<WorkPrecisionPanel<'_>> =
        WITH_FRONT.into_iter().filter_map(panel).filter(|panel| !panel.points.is_empty()).collect();
    let Some(reference) = of.methods.first().filter(|_| !panels.is_empty()) else { return Ok(None) };
    let title = format!("Speed against error ({})", of.size);
    charts::work_precision(&title, &Family::NAMES, &panels, reference.wall_s).map(Some)
}

/// Point of a method in the panel of the observable with the index `observable`; `None` if the error is unknown.
fn work_point(compared: &Compared, observable: usize) -> Option<WorkPoint<'_>> {
    let value = compared.values[observable].as_ref()?;
    Some(WorkPoint {
        label: &compared.method.label,
        family: compared.method.family as usize,
        wall_s: compared.wall_s,
        error_pct: value.error_pct().filter(|error| error.is_finite() && compared.wall_s > 0.0)?,
        at_most: value.is_significant() != Some(true),
        on_front: value.is_on_front,
        is_default: compared.method.default_of.is_some(),
    })
}
