//! What a design does at every speed and humidity, and in every direction, that it must hold at.

use slipgrid_design::records::{ConditionReport, ConditionValue, ConditionsReport};

use super::page::{Page, number, plain, with_error};

/// One row a condition, the worst of them, and why two of them cannot be met together where that is so.
pub(super) fn conditions(page: &mut Page, found: &ConditionsReport) {
    let Some(first) = found.at.first() else { return };
    let listed = |at: &ConditionReport, cell: fn(&ConditionValue) -> String| {
        at.by_pressure.iter().map(cell).collect::<Vec<_>>().join(", ")
    };
    let rows: Vec<Vec<String>> = found
        .at
        .iter()
        .map(|at| {
            vec![
                at.words.clone(),
                listed(at, |value| with_error(value.ratio, value.ratio_std, 4)),
                listed(at, |value| with_error(value.mu, value.mu_std, 4)),
                listed(at, |value| with_error(value.mu_flat, value.mu_flat_std, 4)),
                listed(at, |value| number(value.peak_pressure_mpa, 2)),
                number(at.misfit, 2),
                if at.in_time { "in time" } else { "steady model" }.to_owned(),
            ]
        })
        .collect();
    page.table(
        &format!(
            "At every condition, the one designed for first, at {} MPa: {}. Misfit: largest distance from the target at that \
             condition in tolerances; up to 1 is met. After ±: one standard deviation, of what the errors above are of.",
            listed(first, |value| plain(value.pressure_mpa)),
            found.meaning
        ),
        &["speed, humidity, direction", "ratio", "mu", "mu flat", "peak in MPa", "misfit", "by"],
        &rows,
    );
    if let Some(worst) = found.worst.and_then(|place| found.at.get(place)) {
        let words = format!("Worst: {}, misfit {}.", worst.words, number(worst.misfit, 2));
        if found.held {
            page.paragraph(&words);
        } else {
            page.warning(&words);
        }
    }
    if let Some(conflict) = &found.conflict {
        page.warning(&format!("Not to be met together: {}.", conflict.words));
    }
}
