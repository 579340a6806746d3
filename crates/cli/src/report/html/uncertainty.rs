//! How far a design's numbers move with its dimensions.

use serde_json::Value;

use super::page::{Page, each, plain, text};

/// Slopes at the design, where the result holds them.
pub(super) fn sensitivities(page: &mut Page, result: &Value) {
    let found = &result["sensitivities"];
    let rows: Vec<Vec<String>> = each(found, "by_pressure")
        .iter()
        .map(|row| {
            let cell = |axis: &str| match (row["per_um"][axis].as_f64(), row["error_per_um"][axis].as_f64()) {
                (Some(value), Some(error)) => format!("{:.2} ± {:.2}", 1e4 * value, 1e4 * error),
                _ => "-".to_owned(),
            };
            vec![plain(&row["pressure_mpa"]), cell("width"), cell("spacing"), cell("depth")]
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    page.heading(2, "What a micrometre changes");
    let step = |axis: &str| plain(&found["step_um"][axis]);
    page.table(
        &format!(
            "Change of {} in units of 0.0001 where one dimension grows by 1 µm and the others stay, by the steady model: central \
             differences over {}, {} and {} µm each way. After ± the distance to differences over twice that.",
            text(found, "quantity"),
            step("width"),
            step("spacing"),
            step("depth"),
        ),
        &["P in MPa", "width", "spacing", "depth"],
        &rows,
    );
}
