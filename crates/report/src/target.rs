//! The picture of a target and of what a design makes of it.

use crate::ChartError;
use crate::charts::{self, Estimate, TargetChart, TargetPoint};
use slipgrid_design::DesignReport;
use slipgrid_results::ErrorReport;

/// Target, prediction and confirmation against pressure.
///
/// # Errors
/// [`crate::ReportError`] if the picture cannot be drawn.
pub fn target(report: &DesignReport) -> Result<String, ChartError> {
    drawn(report, &format!("{}: friction against pressure", report.name), charts::target)
}

/// The same for a phone, whose page has the title already.
///
/// # Errors
/// As [`target`].
pub fn target_narrow(report: &DesignReport) -> Result<String, ChartError> {
    drawn(report, "", charts::target_narrow)
}

fn drawn(
    report: &DesignReport,
    title: &str,
    draw: fn(&TargetChart<'_>) -> Result<String, ChartError>,
) -> Result<String, ChartError> {
    let wanted = &report.target;
    let mut points: Vec<TargetPoint> = wanted
        .pressure_mpa
        .iter()
        .enumerate()
        .map(|(row, &pressure_mpa)| TargetPoint {
            pressure_mpa,
            value: wanted.value.as_ref().map(|values| values[row]),
            lowest: wanted.lowest[row],
            highest: wanted.highest[row],
        })
        .collect();
    points.sort_by(|a, b| a.pressure_mpa.total_cmp(&b.pressure_mpa));
    let estimates = |of: &dyn Fn(usize) -> Option<Estimate>| {
        let at = |(row, pressure_mpa): (usize, &f64)| Some((*pressure_mpa, of(row)?));
        let mut all: Vec<(f64, Estimate)> = wanted.pressure_mpa.iter().enumerate().filter_map(at).collect();
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        all
    };
    let estimate = |found: &ErrorReport| Some(Estimate { value: found.value?, error: found.std });
    let predicted = estimates(&|row| estimate(report.errors.at(row)?.predicted.as_ref()?));
    let confirmed = estimates(&|row| estimate(report.confirmed_at(row)?));
    let flat = estimates(&|row| {
        if report.is_ratio() {
            Some(Estimate { value: 1.0, error: None })
        } else {
            estimate(report.errors.at(row)?.mu_flat.as_ref()?)
        }
    });
    draw(&TargetChart {
        title,
        quantity: if report.is_ratio() {
            "Dynamic friction, patterned over flat"
        } else {
            "Dynamic friction coefficient"
        },
        target: &points,
        predicted: &predicted,
        confirmed: &confirmed,
        flat: &flat,
        spread: &spread(report),
    })
}

/// Lowest and highest value at each pressure over all conditions; empty where there is one.
fn spread(report: &DesignReport) -> Vec<[f64; 3]> {
    let at = report.conditions.iter().flat_map(|conditions| &conditions.at);
    let mut spread: Vec<[f64; 3]> = Vec::new();
    for value in at.flat_map(|condition| &condition.by_pressure) {
        let own = if report.is_ratio() { value.ratio } else { value.mu };
        match spread.iter_mut().find(|known| known[0] == value.pressure_mpa) {
            Some(known) => *known = [known[0], known[1].min(own), known[2].max(own)],
            None => spread.push([value.pressure_mpa, own, own]),
        }
    }
    spread.sort_by(|a, b| a[0].total_cmp(&b[0]));
    spread
}
