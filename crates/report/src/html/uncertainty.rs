//! How far a design's numbers move with its dimensions.

use serde_json::Value;

use super::page::{Page, each, number, plain, text, texts, with_error};
use crate::Outputs;
use slipgrid_results::fixed;

/// Slopes at the design, where the result holds them.
pub(super) fn sensitivities(page: &mut Page, result: &Value) {
    let found = &result["sensitivities"];
    let rows: Vec<Vec<String>> = each(found, "by_pressure")
        .iter()
        .map(|row| {
            let cell = |axis: &str| match (row["per_um"][axis].as_f64(), row["error_per_um"][axis].as_f64()) {
                (Some(value), Some(error)) => {
                    format!("{} ± {}", fixed(Some(1e4 * value), 2), fixed(Some(1e4 * error), 2))
                }
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

/// The parts of the errors beside the confirmed values.
pub(super) fn errors(page: &mut Page, result: &Value) {
    let found = &result["errors"];
    let names = texts(found, "includes");
    let rows: Vec<Vec<String>> = each(found, "by_pressure")
        .iter()
        .flat_map(|row| [("ratio", row), ("mu", row)])
        .map(|(key, row)| {
            let part = |name: &String| {
                let parts = each(&row[key], "parts").iter();
                let mut own = parts.filter(|part| text(part, "input") == name);
                number(own.next().map_or(&Value::Null, |part| &part["std"]), 4)
            };
            let ends = &row[key]["interval_95"];
            let ends = if ends.is_array() {
                format!("{} to {}", number(&ends[0], 4), number(&ends[1], 4))
            } else {
                "-".to_owned()
            };
            let first = [plain(&row["pressure_mpa"]), key.to_owned(), number(&row[key]["std"], 4), ends];
            first.into_iter().chain(names.iter().map(part)).collect()
        })
        .collect();
    let header: Vec<&str> =
        ["P in MPa", "of", "±", "95 %"].into_iter().chain(names.iter().map(String::as_str)).collect();
    page.table(
        "What the error of a confirmed value is made of: one standard deviation, and that of each part alone.",
        &header,
        &rows,
    );
}

/// Which patterns count as near those of the samples, and whether this one does; empty where that is not known.
fn near(domain: &Value) -> String {
    if !domain.is_object() {
        return String::new();
    }
    let ends = |key: &str, factor: f64, digits| {
        let at = |place: usize| {
            number(&domain[key][place].as_f64().map_or(Value::Null, |end| (factor * end).into()), digits)
        };
        format!("{} to {}", at(0), at(1))
    };
    let far: Vec<&str> = each(domain, "far").iter().filter_map(Value::as_str).collect();
    format!(
        "; near them are areal densities of {} % and depths of {} µm{}",
        ends("areal_density", 100.0, 1),
        ends("depth_um", 1.0, 1),
        if far.is_empty() {
            String::new()
        } else {
            format!(", and this pattern is far from them in {}", far.join(" and "))
        },
    )
}

/// Values by the physics alone and with the discrepancy, where patterned samples are known.
pub(super) fn discrepancy(page: &mut Page, result: &Value) {
    let found = &result["discrepancy"];
    if !found.is_object() {
        return;
    }
    let used = found["used"] == true;
    // The other reading stands in the table of the target.
    let other = if used { "physics" } else { "with_discrepancy" };
    page.paragraph(
        "",
        &format!(
            "{} The factor is the measured over the modelled ratio of patterned samples ({}; degrees of freedom: {}) and holds for patterns \
             like theirs{}{}. Largest distance of the confirmed values from the target in tolerances: {} by the physics alone, {} with \
             the discrepancy.",
            if used {
                "The search aimed with the discrepancy: what is compared with the target is the model's value times the factor."
            } else {
                "The search aimed with the physics alone; this is what the discrepancy would make of it."
            },
            text(found, "pattern"),
            plain(&found["degrees_of_freedom"]),
            if found["other_planform"].is_string() { ", which this one is not: take it as a guess" } else { "" },
            near(&found["domain"]),
            number(&found["misfit"]["physics"], 2),
            number(&found["misfit"]["with_discrepancy"], 2),
        ),
    );
    let rows: Vec<Vec<String>> = each(found, "by_pressure")
        .iter()
        .map(|row| {
            let error = row["factor"].as_f64().zip(row["relative_std"].as_f64()).map(|(factor, std)| factor * std);
            let factor = with_error(&row["factor"], &error.map_or(Value::Null, Value::from), 3);
            let mark = if row["outside_measured_range"] == true { " (outside the pressures measured)" } else { "" };
            let readings = ["predicted", "confirmed", "mu"].into_iter().map(|key| {
                let of = &row[key];
                with_error(&of[other], &of[&format!("{other}_std")], 4)
            });
            [plain(&row["pressure_mpa"]), format!("{factor}{mark}")].into_iter().chain(readings).collect()
        })
        .collect();
    page.table(
        &format!(
            "The same values {}: {}.",
            if used { "by the physics alone" } else { "times the factor" },
            text(found, "quantity")
        ),
        &["P in MPa", "factor", "predicted", "confirmed", "mu"],
        &rows,
    );
}

/// What samples made after the design do, where the result says it.
pub(super) fn robustness(page: &mut Page, result: &Value) {
    let found = &result["robustness"];
    if !found.is_object() {
        return;
    }
    page.heading(2, "What samples will do");
    let percent = |share: &Value, error: &Value| match (share.as_f64(), error.as_f64()) {
        (Some(share), Some(error)) => format!("{:.1} ± {:.1} %", 100.0 * share, 100.0 * error),
        _ => "-".to_owned(),
    };
    let how = match text(found, "method") {
        "sampled" => "draws of the steady model about the confirming run",
        _ => "draws of the steady model to first order about the confirming run",
    };
    let (samples, material, corrected) = (&found["samples"], &found["with_material"], &found["with_discrepancy"]);
    let within = |of: &Value| percent(&of["probability"], &of["probability_stderr"]);
    page.paragraph(
        "",
        &format!(
            "Within the tolerance at all pressures: {} of samples of the material as calibrated, by {} {how} ({} could not be \
             computed and count as outside, {} without a positive dimension were drawn again). After ± the binomial standard error.",
            within(samples),
            plain(&samples["draws"]),
            plain(&samples["failed"]),
            plain(&samples["redrawn"]),
        ),
    );
    if material.is_object() {
        page.paragraph(
            "",
            &format!("{} with what is not known of the material as well, which all samples share.", within(material)),
        );
    }
    if corrected.is_object() {
        page.paragraph(
            "",
            &format!(
                "{} if the model is also as far off as on the calibration's patterned samples, which holds for patterns like theirs.",
                within(corrected),
            ),
        );
    }
    let band = |spread: &Value| match spread["band_95"].as_array() {
        Some(ends) if ends.len() == 2 => format!("{} to {}", number(&ends[0], 4), number(&ends[1], 4)),
        _ => "-".to_owned(),
    };
    let shown = if material.is_object() { material } else { samples };
    let rows: Vec<Vec<String>> = each(samples, "by_pressure")
        .iter()
        .enumerate()
        .map(|(row, at)| {
            let all = &shown["by_pressure"][row];
            vec![
                plain(&at["pressure_mpa"]),
                band(&at["ratio"]),
                band(&all["ratio"]),
                band(&corrected["by_pressure"][row]["ratio"]),
                number(&all["mu"]["mean"], 4),
                band(&all["mu"]),
            ]
        })
        .collect();
    page.table(
        "Bands hold 95 % of samples.",
        &["P in MPa", "ratio: samples", "with material", "and model", "mu", "mu: with material"],
        &rows,
    );
    parts(page, found);
    let inputs: Vec<Vec<String>> = each(found, "inputs")
        .iter()
        .map(|input| {
            let std: Vec<String> = each(input, "std").iter().map(|std| number(std, 2)).collect();
            vec![
                text(input, "name").to_owned(),
                std.join(", "),
                if text(input, "unit") == "um" { "µm".to_owned() } else { text(input, "unit").to_owned() },
                text(input, "basis").to_owned(),
            ]
        })
        .collect();
    page.table("What scatters: standard deviations.", &["input", "std", "unit", "basis"], &inputs);
    page.paragraph("", &format!("{}.", text(found, "meaning")));
    let optimum = &found["optimum"];
    if optimum.is_object() {
        let nominal = &optimum["nominal"];
        page.paragraph(
            "",
            &format!(
                "Chosen for made samples: expected misfit {} tolerances (root mean square). The nearest design on paper, {} / {} / {} µm \
                 (width, spacing, depth), has {}.",
                number(&optimum["expected_rms"], 2),
                plain(&nominal["width_um"]),
                plain(&nominal["spacing_um"]),
                plain(&nominal["depth_um"]),
                number(&optimum["nominal_expected_rms"], 2),
            ),
        );
    }
}

/// What each input alone would do.
fn parts(page: &mut Page, found: &Value) {
    let all = each(found, "parts");
    let Some(first) = all.first() else { return };
    let mut header = vec!["P in MPa".to_owned(), "all".to_owned()];
    header.extend(each(first, "of").iter().map(|part| text(part, "input").to_owned()));
    let rows: Vec<Vec<String>> = all
        .iter()
        .map(|row| {
            let own = [plain(&row["pressure_mpa"]), number(&row["std"], 4)];
            own.into_iter().chain(each(row, "of").iter().map(|part| number(&part["std"], 4))).collect()
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    page.table("Standard deviations of the target's quantity that each input alone would cause.", &header, &rows);
}

/// Designs that no other beats in every goal, where the result holds them.
pub(super) fn trade_offs(page: &mut Page, result: &Value, outputs: &Outputs) {
    let found = &result["trade_offs"];
    if !found.is_object() {
        return;
    }
    page.heading(2, "What can be had for what");
    if let Some(reason) = found["none_because"].as_str() {
        page.paragraph("", &format!("Nothing could be compared: {reason}."));
        return;
    }
    if let Some(svg) = outputs.text("trade-offs.svg") {
        page.picture(
            &svg,
            "Designs by the goals they were compared by; those on the front are beaten by none in every goal",
        );
    }
    let chosen = if found["chosen_is_on_front"] == true {
        "The chosen design is one of them."
    } else {
        "The chosen design is not one of them: it was not chosen by these goals."
    };
    page.paragraph(
        "",
        &format!(
            "Of {} designs {} are beaten by none in every goal ({} more could not be computed or break a limit). {chosen} By {}.",
            plain(&found["designs"]),
            plain(&found["front"]),
            plain(&found["left_out"]),
            text(found, "model"),
        ),
    );
    let words = texts(found, "words");
    let header: Vec<&str> =
        ["width in µm", "spacing in µm", "depth in µm"].into_iter().chain(words.iter().map(String::as_str)).collect();
    let rows: Vec<Vec<String>> = each(found, "listed")
        .iter()
        .map(|listed| {
            let lengths = ["width_um", "spacing_um", "depth_um"].map(|key| plain(&listed["design"][key]));
            lengths.into_iter().chain(each(listed, "goals").iter().map(|goal| number(goal, 2))).collect()
        })
        .collect();
    let caption = if found["on_target"] == true {
        "Designs of the front that meet the target, or some of them, from one end to the other; trade-offs.csv has the whole front."
    } else {
        "Some of the front, from one end to the other; trade-offs.csv has all."
    };
    page.table(caption, &header, &rows);
}
