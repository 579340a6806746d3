//! What a design's numbers come from: the search's improvements and the material's coefficients.

use serde_json::Value;

use super::page::{Page, each, number, plain};
use slipgrid_results::fixed;

/// Improvements of the best design, where the result holds them.
pub(super) fn history(page: &mut Page, result: &Value) {
    let rows: Vec<Vec<String>> = each(result, "history")
        .iter()
        .map(|entry| {
            vec![
                plain(&entry["round"]),
                plain(&entry["evaluation"]),
                number(&entry["misfit"], 3),
                plain(&entry["feasible"]),
            ]
        })
        .collect();
    page.table(
        "Improvements during the search: misfit is the largest distance from the target in tolerances, by the search's model; \
         up to 1 is met.",
        &["search", "evaluation", "misfit", "respects every limit"],
        &rows,
    );
}

/// Local coefficients and area law of `scene`, the text of a scene file.
pub(super) fn coefficients(page: &mut Page, scene: &str) {
    let Ok(scene) = scene.parse::<toml::Table>() else { return };
    let Some(material) = scene.get("material").and_then(toml::Value::as_table) else { return };
    let numbers = |table: &str, key: &str| -> Vec<f64> {
        match material.get(table).and_then(|table| table.get(key)) {
            Some(toml::Value::Array(values)) => values.iter().filter_map(toml::Value::as_float).collect(),
            Some(value) => value.as_float().into_iter().collect(),
            None => Vec::new(),
        }
    };
    let friction = ["pressure_mpa", "static_mean", "dynamic_mean"].map(|key| numbers("friction", key));
    let rows: Vec<Vec<String>> = (0..friction[2].len())
        .map(|row| {
            let pressure = friction[0].get(row).map_or_else(|| "all".to_owned(), f64::to_string);
            vec![pressure, fixed(friction[1].get(row).copied(), 4), fixed(friction[2].get(row).copied(), 4)]
        })
        .collect();
    let scatter = numbers("friction", "relative_std").first().map(|std| 100.0 * std);
    page.table(
        &format!(
            "Means of the local friction coefficients, dimensionless; each block draws its own with a relative standard deviation of {} %.",
            fixed(scatter, 1)
        ),
        &["P in MPa", "static", "dynamic"],
        &rows,
    );
    let law = ["pressure_mpa", "factor", "factor_std"].map(|key| numbers("area_law", key));
    let rows: Vec<Vec<String>> = law[0]
        .iter()
        .zip(&law[1])
        .enumerate()
        .map(|(row, (pressure, factor))| {
            let factor = fixed(Some(*factor), 4);
            let std = law[2].get(row).map_or_else(String::new, |std| format!(" ± {}", fixed(Some(*std), 4)));
            vec![pressure.to_string(), factor + &std]
        })
        .collect();
    page.table(
        "The area law: local friction is the local coefficient times f, dimensionless, at the local pressure p; ± one standard error. \
         f is 1 below the first pressure.",
        &["p in MPa", "f"],
        &rows,
    );
}
