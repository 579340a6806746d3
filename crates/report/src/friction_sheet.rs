//! Sheet of friction measurements with the items that ASTM G115 asks a report to state.

use slipgrid_base::units::{
    DENSITY_G_CM3, HUMIDITY_PCT, LENGTH_MM, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S, significant, tidy,
};
use slipgrid_design::results::{PatternReport, Table, fixed};
use slipgrid_infer::calibrate::{CutSample, Measurement, Surface};
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::surface::NamedMap;
use slipgrid_io::formats::traces::{ConditionTraces, SurfaceKind};
use slipgrid_model::pattern::Planform;

use crate::charts::extremes;

/// File name of the sheet.
pub const FILE: &str = "friction-sheet.md";
/// Text in place of a value that the calibration does not state.
const NOT_GIVEN: &str = "not given";
/// Explanation of the table of friction, on a page and in the sheet.
pub(crate) const FRICTION_WORDS: &str = "Forces act on one specimen. Pressure is force over the whole face, cavities included. The distance is the one slid up \
     to the middle of the averaging window. A standard deviation is that of another sample's friction: it includes the scatter between repeats.";

/// Sheet of the friction measurements of a calibration, with the items of ASTM G115.
#[derive(Clone, Debug, Default)]
pub struct FrictionSheet {
    name: String,
    /// Title of each group of items, with a table of the items and their values.
    pub(crate) items: Vec<(&'static str, Table)>,
    /// Table of the textured samples.
    pub(crate) textures: Table,
    /// Table of friction, one row per sample and condition.
    pub(crate) friction: Table,
    /// Items that the calibration does not state, each with the key or table of the calibration file that would state
    /// it.
    not_given: Vec<String>,
}

/// Friction of one sample in one condition.
struct Measured {
    sample: String,
    of: Measurement,
    force_n: f64,
    pressure_pa: f64,
    distance_m: Option<f64>,
    repeats: Option<usize>,
}

impl FrictionSheet {
    /// Makes the sheet of `calibration`.
    pub fn new(calibration: &Calibration) -> Self {
        let modulus_std = calibration.stated.youngs_modulus_std_pa.map(|pa| tidy(MODULUS_GPA.from_si(pa)));
        let modulus = tidy(MODULUS_GPA.from_si(calibration.stated.elastic.youngs_modulus_pa()));
        let modulus = modulus_std.map_or_else(|| format!("{modulus} GPa"), |std| format!("{modulus} ± {std} GPa"));
        let density = tidy(DENSITY_G_CM3.from_si(calibration.stated.elastic.density_kg_m3()));
        let area_mm2 = fixed(Some(1e6 * calibration.stated.specimen_area_m2), 2);
        let thickness = calibration.thickness_m.map(|m| format!("{} mm", tidy(LENGTH_MM.from_si(m))));
        let stated = calibration.reporting.clone();
        let measured = measured(calibration);
        let map = match (&calibration.map, &calibration.stated.surface) {
            (Some(NamedMap { path, synthetic, .. }), _) => {
                let kind = if *synthetic { "synthetic altitude map" } else { "altitude map" };
                Some(format!("{kind} {}", path.file_name().unwrap_or_default().to_string_lossy()))
            }
            (None, Surface::RmsSlope(rms_slope)) => Some(format!("rms slope {rms_slope}")),
            _ => None,
        };
        let spans = |of: fn(&Measured) -> f64| span(measured.iter().map(of));
        let repeats: Option<Vec<usize>> = measured.iter().map(|row| row.repeats).collect();
        let repeats = repeats.and_then(|all| span(all.into_iter().map(|count| count as f64)));
        let distances: Option<Vec<f64>> = measured.iter().map(|row| row.distance_m).collect();
        let distances = distances.and_then(|all| span(all.into_iter()));
        let unit = |span: Option<String>, unit: &str| span.map(|span| format!("{span} {unit}"));
        let humidity = spans(|row| HUMIDITY_PCT.from_si(row.of.humidity));
        let pressure = spans(|row| PRESSURE_MPA.from_si(row.pressure_pa));
        let speed = spans(|row| SPEED_MM_S.from_si(row.of.speed_m_s));
        let tables = "the tables of [measurements], or [traces]";
        let items = [
            ("Test", "pair of materials", Some(calibration.stated.name.clone()), "name"),
            ("Test", "source", Some(calibration.stated.source.clone()), "source"),
            ("Test", "standard or procedure", stated.standard, "standard in [reporting]"),
            ("Test", "laboratory and date", stated.laboratory, "laboratory in [reporting]"),
            ("Test", "apparatus", stated.apparatus, "apparatus in [reporting]"),
            ("Test", "contact and motion", stated.motion, "motion in [reporting]"),
            ("Specimens", "material", stated.specimen_material, "specimen_material in [reporting]"),
            ("Specimens", "Young's modulus", Some(modulus), "youngs_modulus_gpa in [material]"),
            ("Specimens", "density", Some(format!("{density} g/cm³")), "density_g_cm3 in [material]"),
            ("Specimens", "area of one face", Some(format!("{area_mm2} mm²")), "[specimen]"),
            ("Specimens", "thickness", thickness, "thickness_mm in [specimen]"),
            ("Specimens", "holder", calibration.holder.map(|own| own.name().to_owned()), "holder in [specimen]"),
            ("Specimens", "preparation", stated.specimen_preparation, "specimen_preparation in [reporting]"),
            ("Specimens", "roughness", stated.specimen_roughness, "specimen_roughness in [reporting]"),
            ("Specimens", "surface of the computation", map, "[surface]"),
            ("Counterface", "material", stated.counterface_material, "counterface_material in [reporting]"),
            ("Counterface", "preparation", stated.counterface_preparation, "counterface_preparation in [reporting]"),
            ("Counterface", "roughness", stated.counterface_roughness, "counterface_roughness in [reporting]"),
            ("Preparation of the test", "cleaning", stated.cleaning, "cleaning in [reporting]"),
            ("Preparation of the test", "running-in", stated.running_in, "running_in in [reporting]"),
            ("Preparation of the test", "lubricant", stated.lubricant, "lubricant in [reporting]"),
            ("Environment", "temperature", stated.temperature, "temperature in [reporting]"),
            ("Environment", "atmosphere", stated.atmosphere, "atmosphere in [reporting]"),
            ("Environment", "relative humidity", unit(humidity, "%"), tables),
            ("Conditions", "normal force on one specimen", unit(spans(|row| row.force_n), "N"), tables),
            ("Conditions", "nominal pressure", unit(pressure, "MPa"), tables),
            ("Conditions", "speed", unit(speed, "mm/s"), tables),
            (
                "Conditions",
                "distance slid before the mean",
                unit(distances, "m"),
                "the column sliding_mm of the tables, or [traces]",
            ),
            ("Conditions", "repeats of a condition", repeats, "[traces], a file for each repeat"),
            ("Observations", "wear, transfer, noise", stated.observations, "observations in [reporting]"),
        ];
        let mut sheet = Self {
            name: calibration.stated.name.clone(),
            textures: textures(&calibration.stated.trials.samples),
            friction: friction(&measured),
            ..Self::default()
        };
        for group in items.chunk_by(|a, b| a.0 == b.0) {
            let mut table = Table::new(["item", "value"]);
            for (title, name, value, place) in group {
                let value = value.as_ref().filter(|value| !value.trim().is_empty());
                if value.is_none() {
                    sheet.not_given.push(format!("{title}: {name} ({place})"));
                }
                table.row([(*name).to_owned(), or_not_given(value.cloned())]);
            }
            sheet.items.push((group[0].0, table));
        }
        sheet
    }

    /// Formats the sheet as Markdown.
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "# Friction measurements: {}\n\nItems that ASTM G115 asks a report of friction to state. `{NOT_GIVEN}` marks an item that the \
             calibration file does not state.\n",
            inline(&self.name)
        );
        for (title, items) in &self.items {
            text += &format!("\n## {title}\n\n{}", markdown_table(items));
        }
        if !self.textures.body().is_empty() {
            text += &format!("\n## Textured samples\n\n{}", markdown_table(&self.textures));
        }
        text += &format!("\n## Friction\n\n{FRICTION_WORDS}\n\n{}", markdown_table(&self.friction));
        if !self.not_given.is_empty() {
            text += &format!("\n## Not given\n\n{}", crate::marked("-", &self.not_given));
        }
        text
    }
}

fn or_not_given(value: Option<String>) -> String {
    value.unwrap_or_else(|| NOT_GIVEN.to_owned())
}

/// Table of friction, one row per sample and condition.
fn friction(rows: &[Measured]) -> Table {
    let number = |value: f64, digits| fixed(Some(value), digits);
    let mut table = Table::of(rows);
    table.column("sample", |row| row.sample.clone());
    table.column("normal force, N", |row| number(row.force_n, 2));
    table.column("nominal pressure, MPa", |row| number(PRESSURE_MPA.from_si(row.pressure_pa), 3));
    table.column("speed, mm/s", |row| tidy(SPEED_MM_S.from_si(row.of.speed_m_s)).to_string());
    table.column("relative humidity, %", |row| tidy(HUMIDITY_PCT.from_si(row.of.humidity)).to_string());
    table.column("distance slid, m", |row| or_not_given(row.distance_m.map(|m| number(m, 3))));
    table.column("repeats", |row| or_not_given(row.repeats.map(|count| count.to_string())));
    table.column("dynamic friction", |row| number(row.of.mu_dynamic, 4));
    table.column("standard deviation", |row| number(row.of.mu_dynamic_std, 4));
    table.column("static friction", |row| or_not_given(row.of.static_peak.map(|peak| number(peak.mu, 4))));
    table.column("standard deviation", |row| or_not_given(row.of.static_peak.map(|peak| number(peak.std, 4))));
    table.table()
}

/// Table of textured samples.
fn textures(samples: &[CutSample]) -> Table {
    let words = |text: &str| or_not_given((!text.is_empty()).then(|| text.to_owned()));
    let length = |um: f64| tidy(um).to_string();
    let rows: Vec<_> = samples.iter().map(|cut| (cut, PatternReport::from(&cut.pattern))).collect();
    let groove = || Planform::Groove.name().to_owned();
    let mut table = Table::of(&rows);
    table.column("sample", |(cut, _)| cut.name.clone());
    table.column("date", |(cut, _)| words(&cut.date));
    table.column("planform", |(_, pattern)| pattern.texture.planform.clone().unwrap_or_else(groove));
    table.column("width, µm", |(_, pattern)| length(pattern.width_um));
    table.column("spacing, µm", |(_, pattern)| length(pattern.spacing_um));
    table.column("depth, µm", |(_, pattern)| length(pattern.depth_um));
    table.column("notes", |(cut, _)| words(&cut.notes));
    table.table()
}

/// Measured friction of the flat samples, of patterned samples whose pattern is not stated, and of the trials.
fn measured(calibration: &Calibration) -> Vec<Measured> {
    let row = |sample: &str, area_m2: f64, measured: &Measurement, traces: Option<&ConditionTraces>, placed_m| {
        let pressure_pa = calibration.pressure_pa(measured.force_n);
        Measured {
            sample: sample.to_owned(),
            of: *measured,
            force_n: pressure_pa * area_m2,
            pressure_pa,
            distance_m: traces.map(ConditionTraces::sliding_m).or(placed_m),
            repeats: traces.map(|traces| traces.mean.count),
        }
    };
    let area_m2 = calibration.stated.specimen_area_m2;
    let is_measured_by = |traces: &&ConditionTraces, measured: &Measurement| {
        let own = traces.measurement();
        own.condition() == measured.condition() && own.mu_dynamic == measured.mu_dynamic
    };
    let of_tables = |kind: SurfaceKind, measured: &Measurement| {
        let own = |traces: &&ConditionTraces| traces.condition.trial.is_none() && traces.condition.surface == kind;
        calibration.traces.iter().find(|traces| own(traces) && is_measured_by(traces, measured))
    };
    let mut rows: Vec<Measured> = calibration
        .stated
        .flat
        .iter()
        .zip(&calibration.placed)
        .map(|(of, placed)| row("flat", area_m2, of, of_tables(SurfaceKind::Flat, of), placed.sliding_m))
        .collect();
    if calibration.pattern.is_none() {
        let patterned = calibration.patterned.iter();
        rows.extend(patterned.map(|of| row("patterned", area_m2, of, of_tables(SurfaceKind::Patterned, of), None)));
    }
    let has_first = calibration.pattern.is_some() && !calibration.patterned.is_empty();
    for (place, cut) in calibration.stated.trials.samples.iter().enumerate() {
        let area_m2 = cut.specimen.face.map_or(area_m2, |face| face.outline.area_m2());
        let own = |of: &Measurement| match has_first && place == 0 {
            true => of_tables(SurfaceKind::Patterned, of),
            false => calibration.traces.iter().find(|traces| {
                traces.condition.trial.as_ref().is_some_and(|trial| trial.name == cut.name)
                    && is_measured_by(traces, of)
            }),
        };
        rows.extend(cut.measured.iter().map(|of| row(&cut.name, area_m2, of, own(of), None)));
    }
    rows
}

/// Formats the smallest and the largest of `values`, or a single number if both are equal; `None` without values.
fn span(values: impl Iterator<Item = f64>) -> Option<String> {
    let [low, high] = extremes(values);
    let number = |value: f64| significant(value, 4).to_string();
    match low {
        _ if !low.is_finite() => None,
        _ if low == high => Some(number(low)),
        _ => Some(format!("{} to {}", number(low), number(high))),
    }
}

/// Formats text in one line and escapes characters that Markdown would read as part of a table or as HTML.
fn inline(text: &str) -> String {
    let one_line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    one_line.replace('\\', "\\\\").replace('|', "\\|").replace('<', "&lt;").replace('`', "\\`")
}

/// Formats a table as Markdown.
fn markdown_table(table: &Table) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut text = line(table.header().to_vec()) + &line(vec!["---".to_owned(); table.header().len()]);
    table.body().iter().for_each(|row| text += &line(row.iter().map(|cell| inline(cell)).collect()));
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_io::disk::disk;
    use slipgrid_io::formats::Document;

    fn sheet(more: &str) -> FrictionSheet {
        let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap();
        let path = root.join("calibration/ldpe-cast-iron/calibration.toml");
        let text = std::fs::read_to_string(&path).unwrap() + more;
        let document = Document::within(&disk(), &path, &text);
        FrictionSheet::new(&Calibration::from_document(&document).unwrap())
    }

    #[test]
    fn every_key_of_reporting_fills_one_item_and_an_item_without_a_value_is_listed() {
        let keys = serde_json::to_value(slipgrid_io::formats::reporting::Reporting::default()).unwrap();
        let keys: Vec<&String> = keys.as_object().unwrap().keys().collect();
        let open = sheet("").not_given;
        for key in &keys {
            let named = open.iter().filter(|item| item.ends_with(&format!("({key} in [reporting])"))).count();
            assert_eq!(named, 1, "{key}: {open:?}");
            let given = sheet(&format!("[reporting]\n{key} = \"a | b\"\n"));
            assert_eq!(given.not_given.len() + 1, open.len(), "{key}");
            assert!(given.markdown().contains("| a \\| b |"), "{key}");
        }
        // An empty text states nothing.
        assert_eq!(sheet("[reporting]\nstandard = \" \"\n").not_given.len(), open.len());
    }

    #[test]
    fn the_sheet_has_every_measurement_with_its_standard_deviation() {
        let sheet = sheet("");
        let text = sheet.markdown();
        let rows = sheet.friction.body();
        assert!(rows.len() > 20 && rows.iter().all(|row| row[7].starts_with("0.") && row[8].starts_with("0.")));
        assert!(text.contains("| area of one face | 78.54 mm² |"), "{text}");
        assert!(text.contains("| patterned samples | not given | square | 130 | 370 | 5.2 |"), "{text}");
        assert!(text.contains("- Conditions: repeats of a condition ([traces], a file for each repeat)\n"), "{text}");
        let flat = rows.iter().filter(|row| row[0] == "flat").count();
        assert!(flat > 0 && rows[flat][0] == "patterned samples", "{rows:?}");
    }
}
