//! Picture of a target and of the expected values of a cut sample.

use crate::ChartError;
use crate::charts::{self, SamplePoint, TargetChart, TargetPoint};
use slipgrid_design::DesignReport;

/// Draws target and expected friction against pressure.
///
/// # Errors
/// [`ChartError`] if the picture cannot be drawn.
pub fn target(report: &DesignReport) -> Result<String, ChartError> {
    drawn(report, &format!("{}: friction of a cut sample", report.name), charts::target)
}

/// Draws [`target`] for a narrow column of a page, without the title, which the page has.
///
/// # Errors
/// Same as [`target`].
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
    let flat = wanted.pressure_mpa.iter().enumerate().filter_map(|(row, p)| Some([*p, flat_of(report, row)?]));
    let mut flat: Vec<[f64; 2]> = flat.collect();
    flat.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let count = wanted.pressure_mpa.len().max(1);
    let sample = |(row, at): (usize, &slipgrid_design::Expected)| SamplePoint {
        pressure_mpa: at.pressure_mpa,
        condition: row / count,
        median: at.median,
        interval_95: [at.low_95, at.high_95],
        model: model_alone(report, row),
    };
    draw(&TargetChart {
        title,
        quantity: if report.is_ratio() { "Dynamic friction over flat" } else { "Dynamic friction coefficient" },
        target: &points,
        samples: &report.sample.expected.iter().enumerate().map(sample).collect::<Vec<_>>(),
        flat: &flat,
    })
}

/// Friction of the flat surface at a load, in the target's quantity: 1 for a ratio, otherwise the confirmed value, which exists
/// at the design condition only.
pub(crate) fn flat_of(report: &DesignReport, row: usize) -> Option<f64> {
    if report.is_ratio() { Some(1.0) } else { report.confirmed.get(row)?.mu_flat }
}

/// Prediction of the model alone at a load, in the target's quantity.
pub(crate) fn model_alone(report: &DesignReport, row: usize) -> Option<f64> {
    Some(report.sample.modelled.get(row)?.ratio * flat_of(report, row)?)
}
