//! What `optimize` found.

use serde_json::Value;
use slipgrid_export::NOT_MODELLED;

use super::page::{Page, each, number, plain, text, texts, with_error};
use super::section::section;
use super::{background, conditions, uncertainty};
use crate::Outputs;
use slipgrid_results::fixed;

/// The page of a design: from `result`, the object of result.json, and the pictures and files in `outputs`.
#[must_use]
pub fn design(result: &Value, outputs: &Outputs) -> String {
    let mut page = Page::new();
    page.heading(1, text(result, "name"));
    verdict(&mut page, result);
    dimensions(&mut page, result);
    target(&mut page, result, outputs);
    chance_parts(&mut page, result);
    uncertainty::robustness(&mut page, result);
    uncertainty::sensitivities(&mut page, result);
    pattern(&mut page, result, outputs);
    let interface = if result["dimensions"] == 3 {
        "one period of the patterned surface seen from above; a flat one carries the nominal pressure everywhere"
    } else {
        "flat and patterned"
    };
    pictures(&mut page, outputs, "Pressure along the interface", "interface-", interface);
    pictures(&mut page, outputs, "Friction in time", "friction-", "flat and patterned, with the averaging window");
    why(&mut page, result);
    uncertainty::trade_offs(&mut page, result, outputs);
    search(&mut page, result);
    material(&mut page, result, outputs);
    model(&mut page, result);
    laser(&mut page, result, outputs);
    page.finish(text(result, "name"), text(result, "version"))
}

fn verdict(page: &mut Page, result: &Value) {
    let scope = if result["section_model"] == true { " (by the vertical section, as grooves)" } else { "" };
    chance(page, result);
    let flat = &result["flat"];
    if flat.is_object() {
        let words = text(flat, "words");
        page.paragraph(
            "verdict missed",
            &format!("No pattern: {words}. What follows is the pattern that lowers it least."),
        );
        return;
    }
    let (class, words) = match text(result, "status") {
        "met" if result["goal"].is_object() => ("verdict", "Best design found within bounds and limits"),
        "met" => ("verdict", "Target met by the model"),
        "unreachable" => ("verdict missed", "Target not reachable within bounds and limits; nearest design below"),
        _ if result["out_of_time"] == true => {
            ("verdict missed", "The seconds allowed were spent before the search had ended; best design so far below")
        }
        _ => ("verdict missed", "Target not met before the evaluations allowed were spent; nearest design below"),
    };
    page.paragraph(class, &format!("{words}{scope}."));
    if result["material"]["synthetic_surface"] == true {
        page.paragraph(
            "warning",
            "The area law behind these numbers rests on a synthetic surface, not on a measured one.",
        );
    }
    for doubtful in texts(&result["material"], "warnings") {
        page.paragraph("warning", &format!("The material is doubtful: {doubtful}."));
    }
    for broken in texts(result, "violations") {
        page.paragraph("warning", &broken);
    }
}

/// The chance that a cut sample is on target, first of all.
fn chance(page: &mut Page, result: &Value) {
    let chance = &result["chance"];
    if !chance.is_object() {
        return;
    }
    let words = text(chance, "words");
    let mut letters = words.chars();
    let first = letters.next().map_or_else(String::new, |letter| letter.to_uppercase().collect());
    page.paragraph("chance", &format!("{first}{}.", letters.as_str()));
    if let Some(share) = chance["value"].as_f64() {
        page.bar(share);
    }
}

/// What the chance rests on.
fn chance_parts(page: &mut Page, result: &Value) {
    let chance = &result["chance"];
    let (included, not_known) = (texts(chance, "included"), texts(chance, "not_known"));
    if !included.is_empty() {
        page.paragraph(
            "",
            &format!("The chance is one of all pressures and conditions at once. It includes {}.", included.join(", ")),
        );
    }
    if !not_known.is_empty() {
        page.paragraph(
            "",
            &format!("Not in the chance, as nothing says how well it is known: {}.", not_known.join(", ")),
        );
    }
    if let Some(share) = chance["with_discrepancy"].as_f64() {
        page.paragraph(
            "",
            &format!(
                "Were the model as far off as on the calibration's patterned samples, it would be {:.1} %.",
                100.0 * share
            ),
        );
    }
    let rows: Vec<Vec<String>> = each(chance, "parts")
        .iter()
        .map(|part| {
            let share = part["chance_without"].as_f64().map(|share| 100.0 * share);
            vec![text(part, "input").to_owned(), text(part, "known_to").to_owned(), fixed(share, 1)]
        })
        .collect();
    page.table(
        "What limits the chance: what it would be in % were one of these known, or made, exactly.",
        &["what", "how well it is known", "chance in %"],
        &rows,
    );
}

/// Names, units and keys of a pattern's dimensions.
const DIMENSIONS: [(&str, &str, &str); 7] = [
    ("width", "µm", "width_um"),
    ("spacing (gap between cavities)", "µm", "spacing_um"),
    ("depth", "µm", "depth_um"),
    ("length", "µm", "length_um"),
    ("spacing across", "µm", "spacing_across_um"),
    ("grooves turned by", "degrees", "angle_deg"),
    ("sliding direction turned by", "degrees", "sliding_angle_deg"),
];

fn dimensions(page: &mut Page, result: &Value) {
    page.heading(2, "The design");
    let design = &result["design"];
    let mut rows = vec![vec!["planform".to_owned(), text(design, "planform").to_owned(), String::new()]];
    if let Some(arrangement) = design["arrangement"].as_str() {
        rows.push(vec!["arrangement".to_owned(), arrangement.to_owned(), String::new()]);
    }
    for (name, unit, key) in DIMENSIONS {
        if design[key].is_number() {
            rows.push(vec![name.to_owned(), plain(&design[key]), unit.to_owned()]);
        }
    }
    if let Some(density) = design["areal_density"].as_f64() {
        rows.push(vec!["share of a period".to_owned(), format!("{:.2}", 100.0 * density), "%".to_owned()]);
    }
    if let Some(density) = result["specimen_areal_density"].as_f64() {
        rows.push(vec!["share of the specimen's face".to_owned(), format!("{:.2}", 100.0 * density), "%".to_owned()]);
    }
    if result["passes"].is_number() {
        rows.push(vec!["passes".to_owned(), plain(&result["passes"]), "over every line".to_owned()]);
    }
    if result["bursts"].is_number() {
        rows.push(vec!["bursts".to_owned(), plain(&result["bursts"]), "per spot".to_owned()]);
    }
    page.table(
        "Exact as designed; what the laser makes of them is not known here.",
        &["quantity", "value", "unit"],
        &rows,
    );
    let selection = text(&result["selection"], "words");
    if !selection.is_empty() {
        page.paragraph("", &format!("The design was {selection}."));
    }
}

fn target(page: &mut Page, result: &Value, outputs: &Outputs) {
    page.heading(2, "Target, prediction, confirmation");
    if let Some(svg) = outputs.text("target.svg") {
        page.picture(&svg, if result["conditions"].is_object() {
            "Target band, predicted, confirmed and flat values against pressure at the condition designed for; from the lowest to the \
             highest value over all conditions"
        } else {
            "Target band, predicted, confirmed and flat values against pressure"
        });
    }
    let wanted = &result["target"];
    let is_ratio = text(wanted, "quantity") == "ratio";
    let key = if is_ratio { "ratio" } else { "mu" };
    let (predicted, confirmed) = (each(result, "predicted"), each(result, "confirmed"));
    let rows: Vec<Vec<String>> = each(wanted, "pressure_mpa")
        .iter()
        .enumerate()
        .map(|(row, pressure)| {
            let none = &Value::Null;
            let (predicted, confirmed) = (predicted.get(row).unwrap_or(none), confirmed.get(row).unwrap_or(none));
            let at = &result["errors"]["by_pressure"][row];
            vec![
                plain(pressure),
                accepted(wanted, row),
                with_error(&at["predicted"]["value"], &at["predicted"]["std"], 4),
                number(&predicted["ratio_discretization_error"], 4),
                with_error(&at[key]["value"], &at[key]["std"], 4),
                with_error(&at["mu"]["value"], &at["mu"]["std"], 4),
                with_error(&at["mu_flat"]["value"], &at["mu_flat"]["std"], 4),
                with_error(&at["mu_static"]["value"], &at["mu_static"]["std"], 4),
                number(&predicted["peak_pressure_mpa"], 2),
                plain(&confirmed["status"]),
            ]
        })
        .collect();
    let header = "P in MPa,target,predicted,to vanishing blocks,confirmed,mu,mu flat,mu static,peak in MPa,status";
    let (header, rows, status) = told(&header.split(',').collect::<Vec<_>>(), &rows);
    let quantity = if is_ratio { "ratio patterned over flat" } else { "dynamic friction coefficient" };
    page.table(
        &format!(
            "Target (or the band accepted), predicted and confirmed: {quantity}, dimensionless{}. After ±: of the target its \
             tolerance; else {}. To vanishing blocks: estimated change of the ratio. Peak \
             pressure grows as blocks shrink.{status}",
            if result["discrepancy"]["used"] == true { ", times the discrepancy of patterned samples" } else { "" },
            text(&result["errors"], "meaning").trim_start_matches("+-: "),
        ),
        &header,
        &rows,
    );
    uncertainty::errors(page, result);
    uncertainty::discrepancy(page, result);
    conditions::conditions(page, result);
    let goal = &result["goal"];
    if goal.is_object() {
        let what = if goal["goal"] == "even" { "least" } else { text(goal, "goal") };
        page.paragraph(
            "",
            &format!(
                "Goal: the {what} {}. Predicted {}, confirmed {}; highest less lowest value {} and {}.",
                text(goal, "of"),
                with_error(&goal["predicted"], &goal["predicted_std"], 5),
                with_error(&goal["confirmed"], &goal["confirmed_std"], 5),
                number(&goal["range_predicted"], 4),
                number(&goal["range_confirmed"], 4)
            ),
        );
    }
    let misfit = &result["misfit"];
    page.paragraph(
        "",
        &format!(
            "Largest distance from the target in tolerances: {} predicted, {} confirmed; up to 1 is met.",
            number(&misfit["predicted"], 2),
            number(&misfit["confirmed"], 2)
        ),
    );
    for (load, warning) in confirmed
        .iter()
        .flat_map(|load| [(load, "cavity_closed"), (load, "area_law_extrapolated"), (load, "friction_extrapolated")])
    {
        if load[warning] == true {
            let words = match warning {
                "cavity_closed" => {
                    "cavities close: their ceiling reaches the counterface, which the model lets through"
                }
                "area_law_extrapolated" => {
                    "local pressures exceed the area law's last: the area is taken as constant there"
                }
                _ => "outside the measured range: the nearest measurement's coefficients were taken",
            };
            page.paragraph("warning", &format!("At {} MPa {words}.", plain(&load["pressure_mpa"])));
        }
    }
}

/// Header and rows without the columns that say nothing at any pressure; the last, the status, in words where it
/// is one.
fn told<'a>(header: &[&'a str], rows: &[Vec<String>]) -> (Vec<&'a str>, Vec<Vec<String>>, String) {
    let status = rows.first().and_then(|row| row.last()).filter(|&status| status != "-");
    let status = status.filter(|&status| rows.iter().all(|row| row.last() == Some(status)));
    let words = status.map_or_else(String::new, |status| format!(" Status at every pressure: {status}."));
    let says = |&column: &usize| rows.iter().any(|row| row.get(column).is_some_and(|cell| cell != "-"));
    let columns: Vec<usize> = (0..header.len() - usize::from(status.is_some())).filter(says).collect();
    let rows = rows.iter().map(|row| columns.iter().filter_map(|&column| row.get(column).cloned()).collect());
    (columns.iter().map(|&column| header[column]).collect(), rows.collect(), words)
}

/// What is accepted at a pressure.
fn accepted(wanted: &Value, row: usize) -> String {
    if wanted["value"].is_array() {
        let each = &wanted["tolerance"][row];
        let tolerance = if each.is_number() { each } else { &wanted["tolerance"] };
        return format!("{} ± {}", plain(&wanted["value"][row]), plain(tolerance));
    }
    let (lowest, highest) = (&wanted["lowest"][row], &wanted["highest"][row]);
    match (lowest.is_number(), highest.is_number()) {
        (true, true) => format!("{} to {}", number(lowest, 4), number(highest, 4)),
        (true, false) => format!("at least {}", number(lowest, 4)),
        (false, true) => format!("at most {}", number(highest, 4)),
        (false, false) => "-".to_owned(),
    }
}

fn pattern(page: &mut Page, result: &Value, outputs: &Outputs) {
    page.heading(2, "The pattern to scale");
    if let Some(svg) = outputs.text("pattern.svg") {
        page.picture(&svg, "The specimen seen from above, with two periods enlarged");
    }
    let length = |key: &str| result["design"][key].as_f64().unwrap_or(f64::NAN);
    let svg = section(length("width_um"), length("spacing_um"), length("depth_um"));
    if !svg.is_empty() {
        page.picture(&svg, "Vertical section through the centres of cavities, along their row");
    }
}

/// The pictures whose names begin with `prefix`, by load.
fn pictures(page: &mut Page, outputs: &Outputs, heading: &str, prefix: &str, what: &str) {
    let named: Vec<(String, String)> = outputs
        .names()
        .into_iter()
        .filter(|name| name.starts_with(prefix) && name.ends_with(".svg"))
        .filter_map(|name| {
            let load = name.strip_prefix(prefix)?.strip_suffix("mpa.svg")?;
            Some((outputs.text(name)?, format!("{heading} at {load} MPa: {what}")))
        })
        .collect();
    if named.is_empty() {
        return;
    }
    page.heading(2, heading);
    page.pictures(named.iter().map(|(svg, caption)| (svg.as_str(), caption.as_str())));
}

fn search(page: &mut Page, result: &Value) {
    page.heading(2, "The search");
    page.paragraph(
        "",
        &format!(
            "{} designs evaluated in {}, {} that could not be computed, seed {}.",
            plain(&result["evaluations"]),
            match result["rounds"].as_u64() {
                Some(1) | None => "one search".to_owned(),
                Some(rounds) => format!("{rounds} searches, each corrected by the confirming run before it"),
            },
            plain(&result["failed_trials"]),
            plain(&result["seed"])
        ),
    );
    let reachable: Vec<Vec<String>> = each(result, "reachable")
        .iter()
        .map(|range| {
            let end = |key: &str, error: &str| with_error(&range[key], &range[error], 4);
            vec![plain(&range["pressure_mpa"]), end("lowest", "lowest_std"), end("highest", "highest_std")]
        })
        .collect();
    page.table(
        "Lowest and highest value among the designs tried that respect every constraint.",
        &["P in MPa", "lowest", "highest"],
        &reachable,
    );
    let alternatives: Vec<Vec<String>> = each(result, "alternatives")
        .iter()
        .map(|other| {
            let density =
                other["areal_density"].as_f64().map_or_else(|| "-".to_owned(), |share| format!("{:.2}", 100.0 * share));
            vec![plain(&other["width_um"]), plain(&other["spacing_um"]), plain(&other["depth_um"]), density]
        })
        .collect();
    page.table(
        "Other designs that meet the target by the search's model.",
        &["width in µm", "spacing in µm", "depth in µm", "share in %"],
        &alternatives,
    );
    table(page, result);
    background::history(page, result);
}

/// Which limits and bounds keep designs from the target, where it is out of reach.
fn why(page: &mut Page, result: &Value) {
    let explanation = &result["explanation"];
    if !explanation.is_object() {
        return;
    }
    page.heading(2, "Why the target is out of reach");
    let rows: Vec<Vec<String>> = each(explanation, "binding")
        .iter()
        .map(|relief| {
            let nearest = &relief["nearest"];
            let suffices = relief["suffices"] == true;
            vec![
                text(relief, "what").to_owned(),
                plain(&relief["limit"]),
                if suffices { plain(&relief["relaxed"]) } else { number(&relief["relaxed"], 3) },
                text(relief, "unit").to_owned(),
                if suffices {
                    "met".to_owned()
                } else {
                    format!("missed by {} tolerances", number(&nearest["misfit"], 2))
                },
                lengths(&nearest["design"]),
            ]
        })
        .collect();
    page.table(
        "Limits and bounds that bind, by the search's model: each relaxed alone, and what the target is then.",
        &["limit or bound", "now", "relaxed to", "unit", "target", "design (width / spacing / depth in µm)"],
        &rows,
    );
    if rows.is_empty() {
        page.paragraph("", "No single limit or bound is the reason: relaxing each alone brings no design nearer.");
    }
    let together = &explanation["together"];
    if together.is_object() {
        page.paragraph(
            "",
            &format!(
                "With all of them relaxed together the nearest design, {} µm, misses by {} tolerances.",
                lengths(&together["design"]),
                number(&together["misfit"], 2)
            ),
        );
    }
}

/// Width, spacing and depth of a design.
fn lengths(design: &Value) -> String {
    ["width_um", "spacing_um", "depth_um"].map(|key| plain(&design[key])).join(" / ")
}

/// What a table of designs says of the one found.
fn table(page: &mut Page, result: &Value) {
    let table = &result["table"];
    if !table.is_object() {
        return;
    }
    let verdict = match (table["by_chance"] == true, table["confirms_search"] == true) {
        (true, _) => "Not by its misfit alone was chosen",
        (false, true) => "None is better than",
        (false, false) => "One is better than",
    };
    page.paragraph(
        "",
        &format!(
            "Table of {} designs (table.csv; whole blocks and bursts): {} respect every limit, {} of them do what is demanded. {verdict} \
             the design found, whose cost is {}; the best of the table, {} µm, has {}. Cost is the largest misfit in \
             tolerances, or the goal in per cent.",
            plain(&table["designs"]),
            plain(&table["feasible"]),
            plain(&table["meeting"]),
            number(&table["found_cost"], 3),
            lengths(&table["best"]["design"]),
            number(&table["best"]["cost"], 3),
        ),
    );
}

fn material(page: &mut Page, result: &Value, outputs: &Outputs) {
    page.heading(2, "Material and calibration");
    let material = &result["material"];
    let (name, source) = (text(material, "name"), text(material, "source"));
    if !name.is_empty() {
        page.paragraph("", &if source.is_empty() { name.to_owned() } else { format!("{name}. Source: {source}.") });
    }
    page.list(&texts(material, "notes"));
    if let Some(scene) = outputs.text("design.toml") {
        background::coefficients(page, &scene);
        page.folded("design.toml: coefficients, area law, sample and run, as confirmed", &scene);
    }
}

fn model(page: &mut Page, result: &Value) {
    page.heading(2, "What was modelled, and why");
    page.list(&texts(result, "model"));
    page.paragraph("", &format!("Not modelled: {}.", NOT_MODELLED.join("; ")));
}

fn laser(page: &mut Page, result: &Value, outputs: &Outputs) {
    page.heading(2, "For the laser");
    let rows: Vec<Vec<String>> = result["laser"]
        .as_object()
        .into_iter()
        .flatten()
        .filter(|(_, value)| !value.is_object())
        .map(|(key, value)| vec![key.clone(), plain(value)])
        .collect();
    page.table("As the design gives it; units stand in the names.", &["quantity", "value"], &rows);
    let law = &result["laser"]["ablation"];
    if law.is_object() {
        page.paragraph(
            "",
            &format!(
                "Depth per burst d = delta ln(F / F_th): delta {} µm, F_th {} J/cm², at {} J/cm² {} µm ({} fluences).",
                with_error(&law["delta_um"], &law["delta_stderr_um"], 3),
                with_error(&law["threshold_j_cm2"], &law["threshold_stderr_j_cm2"], 3),
                plain(&law["fluence_j_cm2"]),
                with_error(&law["depth_per_burst_um"], &law["depth_per_burst_stderr_um"], 3),
                plain(&law["points"]),
            ),
        );
    }
    if let Some(sheet) = outputs.text("process.toml") {
        page.folded("process.toml: the process sheet", &sheet);
    }
}
