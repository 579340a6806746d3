//! Validation as text.

use slipgrid_base::units::counted;

use super::ratios::ModelledRatio;
use super::report::ValidationReport;
use super::rims;
use super::tables::{self, Captioned, planforms, solutions};

/// Formats the report as text.
pub fn text(report: &ValidationReport) -> String {
    let trial = report.trial.as_ref().map_or_else(String::new, |name| format!(", trial \"{name}\""));
    let mut text = format!("{} ({}){trial}\n", report.name, report.source);
    text += &slipgrid_report::marked("-", &report.model);
    let mut add = |(caption, table): Captioned, statements: &[String]| {
        if !table.body().is_empty() {
            text += &format!("\n{caption}\n\n{table}");
        }
        text += if statements.is_empty() { "" } else { "\n" };
        statements.iter().for_each(|statement| text += &format!("{statement}\n"));
    };
    for planform in planforms(report) {
        add(tables::ratios(report, planform), &[]);
    }
    add(tables::friction(report), &[]);
    add(tables::by_measured_law(report), &report.statements);
    if let Some(rims) = &report.rims {
        add(rims::table(rims), &rims.statements);
    }
    text += &slipgrid_report::marked("!", warnings(report));
    let in_time = report.in_time.as_ref().map(|run| format!(", of which friction in time {:.1} s", run.wall_s));
    text + &format!(
        "\n{:.1} s on {}{}\n",
        report.wall_s,
        counted(report.threads, "thread"),
        in_time.unwrap_or_default()
    )
}

/// Warnings with the number of solutions that have a numerical or physical problem.
fn warnings(report: &ValidationReport) -> Vec<String> {
    type Test = fn(&ModelledRatio) -> bool;
    let all: [(Test, &str); 4] = [
        (|modelled| !modelled.has_converged(), "solves did not converge"),
        (|modelled| modelled.cavity_closed, "solves close a cavity: its ceiling reaches the counterface"),
        (|modelled| modelled.area_law_extrapolated, "solves go past the last pressure of the area law"),
        (|modelled| modelled.tension_blocks > 0, "solves have contact blocks under tension, which carry no friction"),
    ];
    let solutions = solutions(report);
    let count = |test: Test| solutions.iter().filter(|(.., modelled)| test(modelled)).count();
    let warning = |(test, words): (Test, &str)| format!("{} of {} {words}", count(test), solutions.len());
    all.into_iter().filter(|(test, _)| count(*test) > 0).map(warning).collect()
}
