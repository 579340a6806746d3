//! Statements of the source paper, compared with the tables of the paper and with this model.

use super::ratios::{MeasuredReport, RatioReport};
use super::report::{PublishedReport, ValidationReport};
use super::statements::percent;
use slipgrid_base::statistics::mean_and_std;
use slipgrid_design::results::fixed;

/// Part of the source name by which calibrations of the paper's measurements are recognized.
const SOURCE: &str = "J. Tribol. 144, 031704";

/// Whether `source`, as named in a calibration, is the paper whose statements are compared.
pub fn is_published(source: &str) -> bool {
    source.contains(SOURCE)
}

/// Statements of the paper with their counterparts in `report`; none if `report` has another source or is about a
/// trial.
pub fn published(report: &ValidationReport) -> Vec<PublishedReport> {
    let rows = report.by_pressure();
    let [Some(&light), Some(&heavy)] = [rows.first(), rows.last()] else { return Vec::new() };
    if report.trial.is_some() || !is_published(&report.source) {
        return Vec::new();
    }
    let humidity_pct = light.measured.humidity_pct;
    let ends = |value: &dyn Fn(&RatioReport) -> Option<f64>| {
        format!("{} to {}", fixed(value(light), 3), fixed(value(heavy), 3))
    };
    let dry = report.measured.iter().filter(|row| row.humidity_pct == humidity_pct);
    let dry = dry.map(|row| 100.0 * (1.0 - row.mu_patterned / row.mu_flat));
    let (mean, std) = mean_and_std(dry.clone()).unwrap_or_default();
    let dry = format!("({} ± {}) % over the {} tabulated conditions", fixed(Some(mean), 1), fixed(std, 1), dry.count());
    let pressures = format!("{} MPa on a disc of 5 mm radius", ends(&|row| Some(row.measured.pressure_mpa)));
    let measured = ends(&|row| Some(row.measured.ratio));
    let explained = report.summary.explained_by_grooves.zip(report.summary.explained_by_squares);
    let explained = explained.map(|(grooves, squares)| {
        format!("{} of the measured one as grooves, {} as squares", percent(grooves), percent(squares))
    });
    let squares = format!("squares in space: {}", ends(&|row| row.given()?.ratio_square));
    let local = ends(&|row| Some(row.given()?.dynamic_mean));
    let local = format!("{local} (measured flat friction over f at each load)");
    let rise = rise_with_speed(&report.measured, humidity_pct).map(|[flat, patterned]| {
        format!("{} and {} by its tables; the model has no speed dependence", percent(flat), percent(patterned))
    });
    let proportional = "patterned over flat, friction proportional to load";
    let no_reduction = "no reduction, whatever the coefficients";
    let in_figure = "below 1, decreasing with pressure; values only in its figure";
    let by_planform = "not told apart in the plane; a few per cent apart in earlier work";
    let said = [
        ("reduction of friction by the pattern, 15 % humidity", "(18 ± 3) %", Some(dry)),
        ("nominal pressure at 50 N and 200 N", "0.65 and 2.6 MPa", Some(pressures)),
        (proportional, no_reduction, Some(ends(&|row| row.ratio_amontons_coulomb))),
        ("patterned over flat, modified law (grooves)", in_figure, Some(ends(&RatioReport::groove))),
        ("patterned over flat, measured", "below 1, decreasing with pressure", Some(measured)),
        ("size of the modelled reduction", "smaller than measured", explained),
        ("grooves against square cavities", by_planform, Some(squares)),
        ("local dynamic coefficient", "0.27 for all loads (static 0.30, scatter 5 %)", Some(local)),
        ("friction of the patterned sample above 2 MPa", "constant", Some(patterned_above_2_mpa(&rows))),
        ("rise of friction from 0.4 to 4 mm/s, 15 % humidity", "10 % flat, 20 % patterned", rise),
    ];
    let row = |(quantity, paper, here): (&str, &str, Option<String>)| {
        Some(PublishedReport { quantity: quantity.to_owned(), source: paper.to_owned(), here: here? })
    };
    said.into_iter().filter_map(row).collect()
}

/// Describes measured and modelled friction of the patterned sample at the two highest pressures; `rows` must be sorted
/// by pressure.
fn patterned_above_2_mpa(rows: &[&RatioReport]) -> String {
    let [.., before, last] = rows else { return "-".to_owned() };
    let ends = |value: &dyn Fn(&RatioReport) -> Option<f64>, digits: usize| {
        format!("{} to {}", fixed(value(before), digits), fixed(value(last), digits))
    };
    format!(
        "{} MPa: measured {}, grooves {}",
        ends(&|row| Some(row.measured.pressure_mpa), 2),
        ends(&|row| Some(row.measured.mu_patterned), 3),
        ends(&|row| Some(row.groove()? * row.measured.mu_flat), 3),
    )
}

/// Relative increase of flat and of patterned friction from 0.4 to 4 mm/s at 100 N; `None` if either speed was not
/// measured.
fn rise_with_speed(measured: &[MeasuredReport], humidity_pct: f64) -> Option<[f64; 2]> {
    let at = |speed_mm_s: f64| {
        measured
            .iter()
            .find(|row| row.force_n == 100.0 && row.speed_mm_s == speed_mm_s && row.humidity_pct == humidity_pct)
    };
    let (slow, fast) = (at(0.4)?, at(4.0)?);
    Some([fast.mu_flat / slow.mu_flat - 1.0, fast.mu_patterned / slow.mu_patterned - 1.0])
}
