//! Statements of the source, compared with its own tables and this model.

use super::ratios::{MeasuredReport, RatioReport};
use super::report::{PublishedReport, ValidationReport};
use slipgrid_design::results::fixed;

/// Name of the statements' source in calibrations.
const SOURCE: &str = "J. Tribol. 144, 031704";

/// Whether `source`, as named in a calibration, is the paper of the statements.
#[must_use]
pub fn is_published(source: &str) -> bool {
    source.contains(SOURCE)
}

/// Statements about the source of `report`; none for any other source and none for a trial.
pub fn published(report: &ValidationReport) -> Vec<PublishedReport> {
    let Some(first) = report.results.first().filter(|_| report.trial.is_none() && is_published(&report.source)) else {
        return Vec::new();
    };
    let rows: Vec<&RatioReport> =
        report.results.iter().filter(|row| row.measured.is_at_condition_of(&first.measured)).collect();
    let light = rows
        .iter()
        .min_by(|a, b| a.measured.pressure_mpa.total_cmp(&b.measured.pressure_mpa))
        .copied()
        .unwrap_or(first);
    let heavy = rows
        .iter()
        .max_by(|a, b| a.measured.pressure_mpa.total_cmp(&b.measured.pressure_mpa))
        .copied()
        .unwrap_or(first);
    let mut said = Vec::new();
    let mut say = |quantity: &str, paper: &str, here: String| {
        said.push(PublishedReport { quantity: quantity.to_owned(), source: paper.to_owned(), here });
    };
    let percent = |share: f64| format!("{} %", fixed(Some(100.0 * share), 1));
    let three = |value: Option<f64>| fixed(value, 3);
    let groove = |row: &RatioReport| row.at_slope(1.0).and_then(|modelled| modelled.ratio_groove);
    let square = |row: &RatioReport| row.at_slope(1.0).and_then(|modelled| modelled.ratio_square);
    let ends =
        |value: &dyn Fn(&RatioReport) -> Option<f64>| format!("{} to {}", three(value(light)), three(value(heavy)));

    let dry: Vec<f64> = report
        .measured
        .iter()
        .filter(|row| row.humidity_pct == first.measured.humidity_pct)
        .map(|row| 1.0 - row.mu_patterned / row.mu_flat)
        .collect();
    let mean = dry.iter().sum::<f64>() / dry.len() as f64;
    let std = (dry.iter().map(|share| (share - mean).powi(2)).sum::<f64>() / (dry.len() as f64 - 1.0)).sqrt();
    say(
        "reduction of friction by the pattern, 15 % humidity",
        "(18 ± 3) %",
        format!(
            "({} ± {}) % over the {} tabulated conditions",
            fixed(Some(100.0 * mean), 1),
            fixed(Some(100.0 * std), 1),
            dry.len()
        ),
    );
    say(
        "nominal pressure at 50 N and 200 N",
        "0.65 and 2.6 MPa",
        format!("{} MPa on a disc of 5 mm radius", ends(&|row| Some(row.measured.pressure_mpa))),
    );
    say(
        "patterned over flat, friction proportional to load",
        "no reduction, whatever the coefficients",
        ends(&|row| row.ratio_amontons_coulomb),
    );
    say(
        "patterned over flat, modified law (grooves)",
        "below 1, decreasing with pressure; values only in its figure",
        ends(&groove),
    );
    say("patterned over flat, measured", "below 1, decreasing with pressure", ends(&|row| Some(row.measured.ratio)));
    if let (Some(grooves), Some(squares)) = (report.summary.explained_by_grooves, report.summary.explained_by_squares) {
        say(
            "size of the modelled reduction",
            "smaller than measured",
            format!("{} of the measured one as grooves, {} as squares", percent(grooves), percent(squares)),
        );
    }
    say(
        "grooves against square cavities",
        "not told apart in the plane; a few per cent apart in earlier work",
        format!("squares in space: {}", ends(&square)),
    );
    let local = |row: &RatioReport| row.at_slope(1.0).map(|modelled| modelled.dynamic_mean);
    say(
        "local dynamic coefficient",
        "0.27 for all loads (static 0.30, scatter 5 %)",
        format!("{} (measured flat friction over f at each load)", ends(&local)),
    );
    say("friction of the patterned sample above 2 MPa", "constant", patterned_above_2_mpa(&rows));
    if let Some([flat, patterned]) = rise_with_speed(&report.measured, first.measured.humidity_pct) {
        say(
            "rise of friction from 0.4 to 4 mm/s, 15 % humidity",
            "10 % flat, 20 % patterned",
            format!("{} and {} by its tables; the model has no speed dependence", percent(flat), percent(patterned)),
        );
    }
    said
}

/// Describes measured and modelled friction of the patterned sample at the two highest loads.
fn patterned_above_2_mpa(rows: &[&RatioReport]) -> String {
    let mut heaviest = rows.to_vec();
    heaviest.sort_by(|a, b| a.measured.pressure_mpa.total_cmp(&b.measured.pressure_mpa));
    let [.., before, last] = heaviest[..] else { return "-".to_owned() };
    let modelled =
        |row: &RatioReport| row.at_slope(1.0).and_then(|m| m.ratio_groove).map(|ratio| ratio * row.measured.mu_flat);
    format!(
        "{} to {} MPa: measured {} to {}, grooves {} to {}",
        fixed(Some(before.measured.pressure_mpa), 2),
        fixed(Some(last.measured.pressure_mpa), 2),
        fixed(Some(before.measured.mu_patterned), 3),
        fixed(Some(last.measured.mu_patterned), 3),
        fixed(modelled(before), 3),
        fixed(modelled(last), 3),
    )
}

/// Relative increase of flat and patterned friction over the measured speeds at 100 N.
fn rise_with_speed(measured: &[MeasuredReport], humidity_pct: f64) -> Option<[f64; 2]> {
    let at = |speed_mm_s: f64| {
        measured
            .iter()
            .find(|row| row.force_n == 100.0 && row.speed_mm_s == speed_mm_s && row.humidity_pct == humidity_pct)
    };
    let (slow, fast) = (at(0.4)?, at(4.0)?);
    Some([fast.mu_flat / slow.mu_flat - 1.0, fast.mu_patterned / slow.mu_patterned - 1.0])
}
