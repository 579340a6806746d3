//! Measured ratios beside modelled ones.

use serde_json::Value;
use slipgrid_export::NOT_MODELLED;

use super::page::{Page, each, number, plain, text, texts, with_error};
use super::section::section;
use crate::output::Outputs;

/// The page of a validation: from `result`, the object of result.json, and the pictures in `outputs`.
#[must_use]
pub fn validation(result: &Value, outputs: &Outputs) -> String {
    let mut page = Page::new();
    let title = format!("{}: measured and modelled", text(result, "name"));
    page.heading(1, &title);
    page.paragraph(
        "",
        &format!("Measurements: {}. Nothing was tuned to the patterned samples.", text(result, "source")),
    );
    if result["synthetic_surface"] == true {
        page.paragraph("warning", "The area law rests on a synthetic surface, not on a measured one.");
    }
    page.heading(2, "Ratio patterned over flat");
    for name in outputs.names().into_iter().filter(|name| name.ends_with(".svg")) {
        if let Some(svg) = outputs.text(name) {
            let stem = name.trim_end_matches(".svg").replace('-', " ");
            page.picture(&svg, &format!("Measured and modelled: {stem}"));
        }
    }
    ratios(&mut page, result);
    summary(&mut page, result);
    page.heading(2, "The modelled pattern");
    let length = |key: &str| result["pattern"][key].as_f64().unwrap_or(f64::NAN);
    let svg = section(length("width_um"), length("spacing_um"), length("depth_um"));
    if !svg.is_empty() {
        page.picture(&svg, "Vertical section through the centres of cavities, along their row");
    }
    page.paragraph("", &format!("Depth of the measured cavities: {} µm.", plain(&result["measured_depth_um"])));
    page.heading(2, "What was modelled, and why");
    page.list(&texts(result, "model"));
    page.paragraph("", &format!("Not modelled: {}.", NOT_MODELLED.join("; ")));
    page.finish(&title, text(result, "version"))
}

fn ratios(page: &mut Page, result: &Value) {
    let mut rows = Vec::new();
    for measured in each(result, "results") {
        for model in each(measured, "modelled") {
            rows.push(vec![
                plain(&measured["force_n"]),
                number(&measured["pressure_mpa"], 3),
                plain(&measured["speed_mm_s"]),
                plain(&measured["humidity_pct"]),
                with_error(&measured["ratio"], &measured["ratio_std"], 3),
                number(&measured["ratio_amontons_coulomb"], 3),
                plain(&model["slope_factor"]),
                number(&model["ratio_groove"], 3),
                number(&model["ratio_square_estimate"], 3),
                number(&model["peak_pressure_mpa"], 2),
                plain(&model["status"]),
            ]);
        }
    }
    page.table(
        "Ratios are dimensionless. Measured: ± one standard deviation. Modelled: the steady cell, at the slopes of the \
         surface times the factor; the spread between factors is the model's uncertainty.",
        &[
            "force in N",
            "P in MPa",
            "speed in mm/s",
            "humidity in %",
            "measured",
            "Amontons-Coulomb",
            "slope factor",
            "grooves",
            "squares (strip estimate)",
            "peak in MPa",
            "status",
        ],
        &rows,
    );
}

fn summary(page: &mut Page, result: &Value) {
    let summary = &result["summary"];
    let percent =
        |value: &Value| value.as_f64().map_or_else(|| "-".to_owned(), |share| format!("{:.1} %", 100.0 * share));
    let mut rows = vec![vec![
        "measured".to_owned(),
        percent(&summary["reduction_measured"]),
        percent(&summary["reduction_measured_std"]),
    ]];
    for model in each(summary, "modelled") {
        let factor = plain(&model["slope_factor"]);
        rows.push(vec![format!("grooves, slope x {factor}"), percent(&model["groove"]), "-".to_owned()]);
        rows.push(vec![format!("squares, slope x {factor}"), percent(&model["square"]), "-".to_owned()]);
    }
    page.table(
        "Mean reduction of friction over the conditions; beside the measured one its standard deviation between conditions.",
        &["what", "reduction", "deviation"],
        &rows,
    );
}
