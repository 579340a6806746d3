//! What a design does at every speed and humidity, and in every direction, that it must hold at.

use serde_json::Value;

use super::page::{Page, each, number, plain, text, with_error};

/// One row a condition, the worst of them, and why two of them cannot be met together where that is so.
pub(super) fn conditions(page: &mut Page, result: &Value) {
    let found = &result["conditions"];
    let at = each(found, "at");
    let listed = |at: &Value, key: &str, digits: usize| {
        let error = format!("{key}_std");
        let one = |value: &Value| with_error(&value[key], &value[&error], digits);
        each(at, "by_pressure").iter().map(one).collect::<Vec<_>>().join(", ")
    };
    let rows: Vec<Vec<String>> = at
        .iter()
        .map(|at| {
            vec![
                text(at, "words").to_owned(),
                listed(at, "ratio", 4),
                listed(at, "mu", 4),
                listed(at, "mu_flat", 4),
                listed(at, "peak_pressure_mpa", 2),
                number(&at["misfit"], 2),
                if at["in_time"] == true { "in time" } else { "steady model" }.to_owned(),
            ]
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    let pressures: Vec<String> =
        each(&at[0], "by_pressure").iter().map(|value| plain(&value["pressure_mpa"])).collect();
    page.table(
        &format!(
            "At every condition, the one designed for first, at {} MPa: {}. Misfit: largest distance from the target at that \
             condition in tolerances; up to 1 is met. After ±: one standard deviation, of what the errors above are of.",
            pressures.join(", "),
            text(found, "meaning")
        ),
        &["speed, humidity, direction", "ratio", "mu", "mu flat", "peak in MPa", "misfit", "by"],
        &rows,
    );
    if let Some(worst) = found["worst"].as_u64().and_then(|place| at.get(usize::try_from(place).ok()?)) {
        page.paragraph(
            if found["held"] == true { "" } else { "warning" },
            &format!("Worst: {}, misfit {}.", text(worst, "words"), number(&worst["misfit"], 2)),
        );
    }
    if let Some(words) = found["conflict"]["words"].as_str() {
        page.paragraph("warning", &format!("Not to be met together: {words}."));
    }
}
