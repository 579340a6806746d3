//! Picture of a target and of the expected values of a cut sample.

use crate::ChartError;
use crate::charts::{self, SamplePoint, TargetPoint};
use slipgrid_base::units::PRESSURE_MPA;
use slipgrid_design::{DesignOutcome, DesignReport, DesignTask};
use slipgrid_infer::discrepancy::Load;

/// Difference of speeds, relative, and of humidities up to which a trial was measured at the design condition.
const SAME_CONDITION: f64 = 1e-6;
/// Factor beyond the target's pressures up to which trials are drawn, so that they do not widen the plot.
const BEYOND: f64 = 1.1;

/// Draws target and expected friction against pressure, with the trials of `found`, the design of `report`, if available.
///
/// # Errors
/// [`ChartError`] if the picture cannot be drawn.
pub fn target(report: &DesignReport, found: Option<&DesignOutcome>) -> Result<String, ChartError> {
    drawn(report, found, &format!("{}: friction of a cut sample", report.name))
}

/// Draws [`target`] for a narrow column of a page, without the title, which the page has.
///
/// # Errors
/// Same as [`target`].
pub fn target_narrow(report: &DesignReport, found: Option<&DesignOutcome>) -> Result<String, ChartError> {
    drawn(report, found, "")
}

fn drawn(report: &DesignReport, found: Option<&DesignOutcome>, title: &str) -> Result<String, ChartError> {
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
            flat: flat_of(report, row),
        })
        .collect();
    points.sort_by(|a, b| a.pressure_mpa.total_cmp(&b.pressure_mpa));
    let count = wanted.pressure_mpa.len().max(1);
    let sample = |(row, at): (usize, &slipgrid_design::Expected)| SamplePoint {
        pressure_mpa: at.pressure_mpa,
        condition: row / count,
        median: at.median,
        interval_95: [at.low_95, at.high_95],
        model: model_alone(report, row),
    };
    let samples: Vec<SamplePoint> = report.sample.expected.iter().enumerate().map(sample).collect();
    let quantity = if report.is_ratio() { "Dynamic friction over flat" } else { "Dynamic friction coefficient" };
    charts::target(title, quantity, &points, &samples, &found.map_or_else(Vec::new, |found| measured(report, found)))
}

/// Whether a trial's `load` is at the design condition of `task`, if there is one.
pub(crate) fn is_at_condition(task: &DesignTask, load: &Load) -> bool {
    task.condition.is_none_or(|wanted| {
        (load.speed_m_s / wanted.speed_m_s - 1.0).abs() < SAME_CONDITION
            && (load.humidity - wanted.humidity).abs() < SAME_CONDITION
    })
}

/// Ratios measured in trials at the design condition, within the range of the target's pressures; none for other targets,
/// because flat friction at the loads of trials is not known here.
fn measured(report: &DesignReport, found: &DesignOutcome) -> Vec<[f64; 2]> {
    let (Some(learned), true) = (&found.material.uncertainty.learned, report.is_ratio()) else { return Vec::new() };
    let all = learned.trials().iter().flat_map(|trial| &trial.measured);
    let all = all.filter(|of| is_at_condition(&found.task, &of.load));
    let points = all.map(|of| [PRESSURE_MPA.from_si(of.load.pressure_pa), of.measured]);
    let ends = report.target.pressure_mpa.iter();
    let [low, high] = ends.fold([f64::INFINITY, 0.0], |[low, high]: [f64; 2], p| [low.min(*p), high.max(*p)]);
    points.filter(|[p, _]| (low / BEYOND..=high * BEYOND).contains(p)).collect()
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
