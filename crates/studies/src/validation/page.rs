//! The source's tables and figures beside the model's.

use serde_json::Value;
use slipgrid_export::NOT_MODELLED;

use slipgrid_report::Outputs;
use slipgrid_report::html::page::{Page, each, number, plain, text, texts, with_error};
use slipgrid_report::html::section::section;
use slipgrid_results::fixed;

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
        page.paragraph(
            "warning",
            "The altitude map behind the area law is synthetic, not measured: measured are the friction coefficients and the \
             pattern's dimensions alone. Read the spread between slopes of the surface as the model's uncertainty.",
        );
    }
    summary(&mut page, result);
    page.heading(2, "Ratio patterned over flat");
    picture(
        &mut page,
        outputs,
        "ratios.svg",
        "Measured with standard deviations; the modified law as grooves at the surface's slope and scaled, and as squares; \
         Amontons-Coulomb friction (dashed) has no effect",
    );
    ratios(&mut page, result);
    friction(&mut page, result);
    published(&mut page, result);
    areas(&mut page, result, outputs);
    interface(&mut page, outputs);
    in_time(&mut page, result, outputs);
    measured(&mut page, result);
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

/// The picture `name`, where it was made.
fn picture(page: &mut Page, outputs: &Outputs, name: &str, caption: &str) {
    if let Some(svg) = outputs.text(name) {
        page.picture(&svg, caption);
    }
}

fn summary(page: &mut Page, result: &Value) {
    page.heading(2, "What the comparison says");
    page.list(&texts(result, "statements"));
    let summary = &result["summary"];
    let percent = |value: &Value| fixed(value.as_f64().map(|share| 100.0 * share), 1);
    let explained = |value: &Value| match (value.as_f64(), summary["reduction_measured"].as_f64()) {
        (Some(modelled), Some(measured)) if measured > 0.0 => fixed(Some(100.0 * modelled / measured), 0),
        _ => "-".to_owned(),
    };
    let with_std = |value: &Value, std: &Value| match std.as_f64() {
        Some(std) => format!("{} ± {}", percent(value), fixed(Some(100.0 * std), 1)),
        None => percent(value),
    };
    let measured = with_std(&summary["reduction_measured"], &summary["reduction_measured_std"]);
    let mut rows = vec![
        vec!["measured".to_owned(), measured, "100".to_owned()],
        vec!["Amontons-Coulomb friction".to_owned(), amontons(result), "0".to_owned()],
    ];
    for model in each(summary, "modelled") {
        let factor = plain(&model["slope_factor"]);
        for (what, key, std) in [("grooves", "groove", "groove_std"), ("squares in space", "square", "square_std")] {
            let reduction = with_std(&model[key], &model[std]);
            rows.push(vec![format!("{what}, slope x {factor}"), reduction, explained(&model[key])]);
        }
    }
    page.table(
        "Mean reduction of dynamic friction over the conditions; after ± of measured ones the standard deviation between \
         conditions, of modelled ones that of Young's modulus and measured flat friction.",
        &["what", "reduction in %", "share of the measured in %"],
        &rows,
    );
}

/// Mean reduction without an area law, in per cent.
fn amontons(result: &Value) -> String {
    let found: Option<Vec<f64>> =
        each(result, "results").iter().map(|row| Some(1.0 - row["ratio_amontons_coulomb"].as_f64()?)).collect();
    let mean = found.filter(|found| !found.is_empty()).map(|found| found.iter().sum::<f64>() / found.len() as f64);
    fixed(mean.map(|share| 100.0 * share), 1)
}

fn ratios(page: &mut Page, result: &Value) {
    let note = text(result, "errors").replace("+-", "±");
    for (planform, key) in [("grooves", "ratio_groove"), ("squares", "ratio_square")] {
        planform_ratios(page, result, planform, key, &note);
    }
    solves(page, result);
}

/// Measured ratios beside those of one planform.
fn planform_ratios(page: &mut Page, result: &Value, planform: &str, key: &str, note: &str) {
    let none = &Value::Null;
    let results = each(result, "results");
    let of_first = |row: &Value| ["speed_mm_s", "humidity_pct"].iter().all(|key| row[*key] == results[0][*key]);
    let is_one_condition = results.iter().all(of_first);
    let mut header = vec!["force in N", "P in MPa"];
    if !is_one_condition {
        header.extend(["speed in mm/s", "humidity in %"]);
    }
    header.extend(["measured", "Amontons-Coulomb"]);
    let mut header: Vec<String> = header.into_iter().map(str::to_owned).collect();
    let factors = each(result, "slope_factors");
    header.extend(factors.iter().map(|factor| format!("slope x {}", plain(factor))));
    let has_depth = results.iter().any(|row| row["modelled_at_measured_depth"].is_object());
    if has_depth {
        header.push(format!("{} µm deep", plain(&result["measured_depth_um"])));
    }
    let error = format!("{key}_std");
    let cell = |model: &Value| with_error(&model[key], &model[&error], 3);
    let rows: Vec<Vec<String>> = results
        .iter()
        .map(|row| {
            let mut cells = condition(row);
            if is_one_condition {
                cells.truncate(2);
            }
            cells.push(with_error(&row["ratio"], &row["ratio_std"], 3));
            cells.push(number(&row["ratio_amontons_coulomb"], 3));
            let modelled = each(row, "modelled");
            cells.extend((0..factors.len()).map(|n| cell(modelled.get(n).unwrap_or(none))));
            if has_depth {
                cells.push(cell(&row["modelled_at_measured_depth"]));
            }
            cells
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    page.table(
        &format!(
            "Ratios with {planform}, dimensionless. Measured: ± one standard deviation. Modelled: the steady cell {}, cavities {} µm \
             deep where nothing else is said, at the slopes of the surface times a factor. {note}.",
            if planform == "squares" { "in space" } else { "in the plane" },
            plain(&result["pattern"]["depth_um"])
        ),
        &header,
        &rows,
    );
}

/// Force, pressure, speed and humidity of a row.
fn condition(row: &Value) -> Vec<String> {
    vec![
        plain(&row["force_n"]),
        number(&row["pressure_mpa"], 3),
        plain(&row["speed_mm_s"]),
        plain(&row["humidity_pct"]),
    ]
}

/// Peak pressures and how the solves ended.
fn solves(page: &mut Page, result: &Value) {
    let mut rows = Vec::new();
    for measured in each(result, "results") {
        let models = each(measured, "modelled").iter().map(|model| (&result["pattern"]["depth_um"], model));
        let deep = &measured["modelled_at_measured_depth"];
        for (depth_um, model) in models.chain(deep.is_object().then_some((&result["measured_depth_um"], deep))) {
            let (grooves, squares) = (text(model, "status"), text(model, "status_square"));
            rows.push(vec![
                number(&measured["pressure_mpa"], 3),
                plain(depth_um),
                plain(&model["slope_factor"]),
                number(&model["ratio_square_estimate"], 3),
                number(&model["peak_pressure_mpa"], 2),
                number(&model["peak_pressure_square_mpa"], 2),
                plain(&model["cavity_closed"]),
                if grooves == squares { grooves.to_owned() } else { format!("{grooves}, {squares}") },
            ]);
        }
    }
    page.table(
        "Behind these ratios. Strip estimate: squares taken from grooves, for comparison. Peak pressures are those of blocks of \
         10 µm and grow as blocks shrink.",
        &[
            "P in MPa",
            "depth in µm",
            "slope factor",
            "strip estimate",
            "peak, grooves, in MPa",
            "peak, squares, in MPa",
            "cavity closes",
            "status",
        ],
        &rows,
    );
}

/// Friction coefficients themselves, as modelled on the surface as given.
fn friction(page: &mut Page, result: &Value) {
    let rows: Vec<Vec<String>> = each(result, "results")
        .iter()
        .filter_map(|row| {
            let model = each(row, "modelled").iter().find(|model| model["slope_factor"] == 1.0)?;
            let flat = row["mu_flat"].as_f64()?;
            let times = |key: &str, error: &str| {
                let mu = model[key].as_f64().map_or(Value::Null, |ratio| Value::from(ratio * flat));
                with_error(&mu, &model[error], 3)
            };
            let mut cells = condition(row);
            cells.extend([
                with_error(&row["mu_flat"], &row["mu_flat_std"], 3),
                number(&model["area_law_factor"], 3),
                number(&model["dynamic_mean"], 3),
                with_error(&row["mu_patterned"], &row["mu_patterned_std"], 3),
                times("ratio_groove", "mu_groove_std"),
                times("ratio_square", "mu_square_std"),
            ]);
            Some(cells)
        })
        .collect();
    page.table(
        "Dynamic friction coefficients, dimensionless, ± as above. The local coefficient is the measured flat one over f: the model's flat \
         surface slides as the measured one does.",
        &[
            "force in N",
            "P in MPa",
            "speed in mm/s",
            "humidity in %",
            "flat, measured",
            "f(P)",
            "local coefficient",
            "patterned, measured",
            "grooves, modelled",
            "squares, modelled",
        ],
        &rows,
    );
}

fn published(page: &mut Page, result: &Value) {
    let rows: Vec<Vec<String>> = each(result, "published")
        .iter()
        .map(|row| ["quantity", "source", "here"].map(|key| text(row, key).to_owned()).into())
        .collect();
    if rows.is_empty() {
        return;
    }
    page.heading(2, "What the paper says, and what is found here");
    page.paragraph(
        "",
        "The paper gives its simulated values in figures alone, and its altitude map not at all: what its text and tables \
         say is compared.",
    );
    page.table("", &["quantity", "paper", "here"], &rows);
}

fn areas(page: &mut Page, result: &Value, outputs: &Outputs) {
    let tables = each(result, "area_laws");
    let Some(first) = tables.first() else { return };
    page.heading(2, "Real contact area and the factor f");
    picture(
        page,
        outputs,
        "area-law.svg",
        "Real contact area and the factor f against nominal pressure, up to what edges of cavities see; dashed: area in \
         proportion to load from P0 on",
    );
    let mut header = vec!["P in MPa".to_owned()];
    for table in tables {
        let factor = plain(&table["slope_factor"]);
        header.extend([format!("area, slope x {factor}"), format!("f, slope x {factor}")]);
    }
    let rows: Vec<Vec<String>> = each(first, "pressure_mpa")
        .iter()
        .enumerate()
        .map(|(row, pressure)| {
            let mut cells = vec![plain(pressure)];
            for table in tables {
                cells.extend([number(&table["area_fraction"][row], 4), number(&table["factor"][row], 4)]);
            }
            cells
        })
        .collect();
    let header: Vec<&str> = header.iter().map(String::as_str).collect();
    page.table(
        "Area: share of the nominal area, corrected along its perimeter. f = [A(P)/A(P0)] / [P/P0] above P0, 1 below. Both are \
         dimensionless.",
        &header,
        &rows,
    );
}

fn interface(page: &mut Page, outputs: &Outputs) {
    let captions = [
        (
            "interface.svg",
            "Flat and patterned sample in steady sliding, grooves; drawn local coefficients. The flat sample departs from the nominal pressure at its ends alone",
        ),
        ("interface-end.svg", "The same, the first periods enlarged"),
        ("interface-squares.svg", "Square cavities of the same lengths, one cell in space, seen from above"),
    ];
    if captions.iter().all(|(name, _)| outputs.text(name).is_none()) {
        return;
    }
    page.heading(2, "Pressure along the interface");
    for (name, caption) in captions {
        picture(page, outputs, name, caption);
    }
}

fn in_time(page: &mut Page, result: &Value, outputs: &Outputs) {
    let run = &result["in_time"];
    if !run.is_object() {
        return;
    }
    page.heading(2, "Friction in time");
    picture(
        page,
        outputs,
        "friction.svg",
        "Flat and patterned sample as grooves, from rest, with the averaging window",
    );
    let heavy = each(result, "results").iter().max_by(|a, b| {
        let pressure = |row: &Value| row["pressure_mpa"].as_f64().unwrap_or(0.0);
        pressure(a).total_cmp(&pressure(b))
    });
    let measured = each(result, "measured").iter().find(|row| {
        heavy.is_some_and(|heavy| ["force_n", "speed_mm_s", "humidity_pct"].iter().all(|key| row[*key] == heavy[*key]))
    });
    let none = &Value::Null;
    let of = |key: &str| measured.map_or(none, |row| &row[key]);
    let rows = [
        ("flat", "mu_flat", "mu_static_flat", "status_flat"),
        ("patterned", "mu_patterned", "mu_static_patterned", "status_patterned"),
    ]
    .map(|(name, key, peak, status)| {
        let error = format!("{key}_std");
        let of_peak = format!("{peak}_std");
        vec![
            name.to_owned(),
            with_error(of(key), of(&error), 3),
            with_error(&run[key], &run[&error], 4),
            with_error(&run[peak], &run[&of_peak], 4),
            plain(&run[status]),
        ]
    });
    let ratio = vec![
        "ratio".to_owned(),
        with_error(of("ratio"), of("ratio_std"), 3),
        with_error(&run["ratio"], &run["ratio_std"], 4),
        "-".to_owned(),
        "-".to_owned(),
    ];
    let rows: Vec<Vec<String>> = rows.into_iter().chain([ratio]).collect();
    page.table(
        "Dynamic friction, dimensionless. Measured: ± one standard deviation of three repeats; modelled: ± one of \
         time average, local coefficients drawn, measured flat friction and Young's modulus.",
        &["surface", "measured", "modelled", "static peak, modelled", "status"],
        &rows,
    );
    page.paragraph(
        "",
        &format!(
            "{} MPa, {} mm/s, {} µm of travel; local coefficients {} dynamic and {} static (0.30/0.27 times it, the published \
             pair: no static friction was tabulated), scatter {} %. The flat sample lies a little above its measured friction \
             because sliding in time is micro-stick-slip, which calibrate corrects for and this comparison does not; the \
             ratio hardly notices.",
            number(&run["pressure_mpa"], 3),
            plain(&run["speed_mm_s"]),
            plain(&run["sliding_um"]),
            number(&run["dynamic_mean"], 4),
            number(&run["static_mean"], 4),
            fixed(run["relative_std"].as_f64().map(|share| 100.0 * share), 1),
        ),
    );
}

fn measured(page: &mut Page, result: &Value) {
    let rows: Vec<Vec<String>> = each(result, "measured")
        .iter()
        .map(|row| {
            let mut cells = condition(row);
            cells.extend([
                with_error(&row["mu_flat"], &row["mu_flat_std"], 3),
                with_error(&row["mu_patterned"], &row["mu_patterned_std"], 3),
                with_error(&row["ratio"], &row["ratio_std"], 3),
            ]);
            cells
        })
        .collect();
    if rows.is_empty() {
        return;
    }
    page.heading(2, "All that was measured");
    page.table(
        "Dynamic friction coefficients, dimensionless, ± one standard deviation; of the ratio propagated.",
        &["force in N", "P in MPa", "speed in mm/s", "humidity in %", "flat", "patterned", "ratio"],
        &rows,
    );
}
