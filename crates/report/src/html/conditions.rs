//! What a design does at every speed and humidity, and in every direction, that it must hold at.

use slipgrid_design::records::{ConditionReport, ConditionValue, ConditionsReport};

use super::page::{Page, number, plain, with_error};

/// A number of every pressure in one cell.
fn listed(at: &ConditionReport, cell: fn(&ConditionValue) -> String) -> String {
    at.by_pressure.iter().map(cell).collect::<Vec<_>>().join(", ")
}

/// One row a condition, the worst of them, and why two of them cannot be met together where that is so.
pub(super) fn conditions(page: &mut Page, found: &ConditionsReport) {
    let Some(first) = found.at.first() else { return };
    page.records(
        &format!(
            "At every condition, the one designed for first, at {} MPa: {}. Misfit: largest distance from the target at that \
             condition in tolerances; up to 1 is met. After ±: one standard deviation, of what the errors above are of.",
            listed(first, |value| plain(value.pressure_mpa)),
            found.meaning
        ),
        &found.at,
        &[
            ("speed, humidity, direction", |at| at.words.clone()),
            ("ratio", |at| listed(at, |value| with_error(value.ratio, value.ratio_std, 4))),
            ("mu", |at| listed(at, |value| with_error(value.mu, value.mu_std, 4))),
            ("mu flat", |at| listed(at, |value| with_error(value.mu_flat, value.mu_flat_std, 4))),
            ("peak in MPa", |at| listed(at, |value| number(value.peak_pressure_mpa, 2))),
            ("misfit", |at| number(at.misfit, 2)),
            ("by", |at| if at.in_time { "in time" } else { "steady model" }.to_owned()),
        ],
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
