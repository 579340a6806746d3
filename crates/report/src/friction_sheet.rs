//! Sheet of friction measurements with the items that ASTM G115 asks a report to state.

use slipgrid_base::units::{
    DENSITY_G_CM3, HUMIDITY_PCT, LENGTH_MM, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S, significant, tidy,
};
use slipgrid_design::results::{PatternReport, fixed};
use slipgrid_infer::calibrate::{CutSample, Measurement};
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::surface::Surface;
use slipgrid_io::formats::traces::{ConditionTraces, SurfaceKind};
use slipgrid_model::pattern::Planform;

/// Name of the file.
pub const FILE: &str = "friction-sheet.md";
/// Value of an item that the calibration does not state.
const NOT_GIVEN: &str = "not given";
/// Titles of the columns of [`FrictionSheet::friction_cells`].
pub(crate) const FRICTION_TITLES: [&str; 11] = [
    "sample",
    "normal force, N",
    "nominal pressure, MPa",
    "speed, mm/s",
    "relative humidity, %",
    "distance slid, m",
    "repeats",
    "dynamic friction",
    "standard deviation",
    "static friction",
    "standard deviation",
];
/// Titles of the columns of [`FrictionSheet::textures`].
pub(crate) const TEXTURE_TITLES: [&str; 7] =
    ["sample", "date", "planform", "width, µm", "spacing, µm", "depth, µm", "notes"];
/// Explanation of the table of friction.
pub(crate) const FRICTION_WORDS: &str = "Forces act on one specimen. Pressure is force over the whole face, cavities included. The distance is the one slid up \
     to the middle of the averaging window. A standard deviation is that of another sample's friction: it includes the scatter between repeats.";

/// Sheet of a calibration's measurements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrictionSheet {
    name: String,
    pub(crate) sections: Vec<Section>,
    pub(crate) textures: Vec<[String; 7]>,
    friction: Vec<FrictionRow>,
}

/// Group of items.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Section {
    pub(crate) title: &'static str,
    items: Vec<Item>,
}

/// Item of the sheet.
#[derive(Clone, Debug, PartialEq)]
struct Item {
    name: &'static str,
    value: Option<String>,
    /// Where a calibration states the item.
    place: &'static str,
}

/// Friction of one sample in one condition.
#[derive(Clone, Debug, PartialEq)]
struct FrictionRow {
    sample: String,
    measured: Measurement,
    force_n: f64,
    pressure_pa: f64,
    distance_m: Option<f64>,
    repeats: Option<usize>,
}

impl Section {
    fn new<const N: usize>(title: &'static str, items: [(&'static str, Option<String>, &'static str); N]) -> Self {
        let is_stated = |value: &String| !value.trim().is_empty();
        let items = items.map(|(name, value, place)| Item { name, value: value.filter(is_stated), place });
        Self { title, items: items.to_vec() }
    }

    /// Name and value of each item.
    pub(crate) fn rows(&self) -> Vec<[String; 2]> {
        let value = |item: &Item| item.value.clone().unwrap_or_else(|| NOT_GIVEN.to_owned());
        self.items.iter().map(|item| [item.name.to_owned(), value(item)]).collect()
    }
}

impl FrictionSheet {
    /// Makes the sheet of `calibration`.
    #[must_use]
    pub fn new(calibration: &Calibration) -> Self {
        let has_modulus_std = calibration.youngs_modulus_std_pa.map(|pa| tidy(MODULUS_GPA.from_si(pa)));
        let modulus = tidy(MODULUS_GPA.from_si(calibration.elastic.youngs_modulus_pa()));
        let modulus = has_modulus_std.map_or_else(|| format!("{modulus} GPa"), |std| format!("{modulus} ± {std} GPa"));
        let density = tidy(DENSITY_G_CM3.from_si(calibration.elastic.density_kg_m3()));
        let stated = calibration.reporting.clone();
        let friction = friction(calibration);
        let map = match &calibration.surface {
            Surface::Map { path, synthetic, .. } => {
                let kind = if *synthetic { "synthetic altitude map" } else { "altitude map" };
                Some(format!("{kind} {}", path.file_name().unwrap_or_default().to_string_lossy()))
            }
            Surface::Persson { rms_slope } => Some(format!("rms slope {rms_slope}")),
            _ => None,
        };
        let spans = |of: fn(&FrictionRow) -> f64| span(friction.iter().map(of));
        let repeats: Option<Vec<usize>> = friction.iter().map(|row| row.repeats).collect();
        let repeats = repeats.and_then(|all| span(all.into_iter().map(|count| count as f64)));
        let distances: Option<Vec<f64>> = friction.iter().map(|row| row.distance_m).collect();
        let unit = |span: Option<String>, unit: &str| span.map(|span| format!("{span} {unit}"));
        let measured = "the tables of [measurements], or [traces]";
        let sections = vec![
            Section::new(
                "Test",
                [
                    ("pair of materials", Some(calibration.name.clone()), "name"),
                    ("source", Some(calibration.source.clone()), "source"),
                    ("standard or procedure", stated.standard, "standard in [reporting]"),
                    ("laboratory and date", stated.laboratory, "laboratory in [reporting]"),
                    ("apparatus", stated.apparatus, "apparatus in [reporting]"),
                    ("contact and motion", stated.motion, "motion in [reporting]"),
                ],
            ),
            Section::new(
                "Specimens",
                [
                    ("material", stated.specimen_material, "specimen_material in [reporting]"),
                    ("Young's modulus", Some(modulus), "youngs_modulus_gpa in [material]"),
                    ("density", Some(format!("{density} g/cm³")), "density_g_cm3 in [material]"),
                    (
                        "area of one face",
                        Some(format!("{} mm²", fixed(Some(1e6 * calibration.specimen_area_m2), 2))),
                        "[specimen]",
                    ),
                    (
                        "thickness",
                        calibration.thickness_m.map(|m| format!("{} mm", tidy(LENGTH_MM.from_si(m)))),
                        "thickness_mm in [specimen]",
                    ),
                    ("holder", calibration.holder.map(|holder| holder.name().to_owned()), "holder in [specimen]"),
                    ("preparation", stated.specimen_preparation, "specimen_preparation in [reporting]"),
                    ("roughness", stated.specimen_roughness, "specimen_roughness in [reporting]"),
                    ("surface of the computation", map, "[surface]"),
                ],
            ),
            Section::new(
                "Counterface",
                [
                    ("material", stated.counterface_material, "counterface_material in [reporting]"),
                    ("preparation", stated.counterface_preparation, "counterface_preparation in [reporting]"),
                    ("roughness", stated.counterface_roughness, "counterface_roughness in [reporting]"),
                ],
            ),
            Section::new(
                "Preparation of the test",
                [
                    ("cleaning", stated.cleaning, "cleaning in [reporting]"),
                    ("running-in", stated.running_in, "running_in in [reporting]"),
                    ("lubricant", stated.lubricant, "lubricant in [reporting]"),
                ],
            ),
            Section::new(
                "Environment",
                [
                    ("temperature", stated.temperature, "temperature in [reporting]"),
                    ("atmosphere", stated.atmosphere, "atmosphere in [reporting]"),
                    (
                        "relative humidity",
                        unit(spans(|row| HUMIDITY_PCT.from_si(row.measured.humidity)), "%"),
                        measured,
                    ),
                ],
            ),
            Section::new(
                "Conditions",
                [
                    ("normal force on one specimen", unit(spans(|row| row.force_n), "N"), measured),
                    ("nominal pressure", unit(spans(|row| PRESSURE_MPA.from_si(row.pressure_pa)), "MPa"), measured),
                    ("speed", unit(spans(|row| SPEED_MM_S.from_si(row.measured.speed_m_s)), "mm/s"), measured),
                    (
                        "distance slid before the mean",
                        unit(distances.and_then(|all| span(all.into_iter())), "m"),
                        "the column sliding_mm of the tables, or [traces]",
                    ),
                    ("repeats of a condition", repeats, "[traces], a file for each repeat"),
                ],
            ),
            Section::new(
                "Observations",
                [("wear, transfer, noise", stated.observations, "observations in [reporting]")],
            ),
        ];
        Self {
            name: calibration.name.clone(),
            sections,
            textures: calibration.trials.samples.iter().map(texture).collect(),
            friction,
        }
    }

    /// Cells of the table of friction, one row per sample and condition.
    pub(crate) fn friction_cells(&self) -> Vec<[String; 11]> {
        let or_not_given = |value: Option<String>| value.unwrap_or_else(|| NOT_GIVEN.to_owned());
        let number = |value: f64, digits| fixed(Some(value), digits);
        let cells = |row: &FrictionRow| {
            let peak = row.measured.static_peak;
            [
                row.sample.clone(),
                number(row.force_n, 2),
                number(PRESSURE_MPA.from_si(row.pressure_pa), 3),
                tidy(SPEED_MM_S.from_si(row.measured.speed_m_s)).to_string(),
                tidy(HUMIDITY_PCT.from_si(row.measured.humidity)).to_string(),
                or_not_given(row.distance_m.map(|m| number(m, 3))),
                or_not_given(row.repeats.map(|count| count.to_string())),
                number(row.measured.mu_dynamic, 4),
                number(row.measured.mu_dynamic_std, 4),
                or_not_given(peak.map(|peak| number(peak.mu, 4))),
                or_not_given(peak.map(|peak| number(peak.std, 4))),
            ]
        };
        self.friction.iter().map(cells).collect()
    }

    /// Items that the calibration does not state, each with the place that would state it.
    pub(crate) fn not_given(&self) -> Vec<String> {
        let open = self.sections.iter().flat_map(|section| section.items.iter().map(move |item| (section, item)));
        open.filter(|(_, item)| item.value.is_none())
            .map(|(section, item)| format!("{}: {} ({})", section.title, item.name, item.place))
            .collect()
    }

    /// Formats the sheet as Markdown.
    #[must_use]
    pub fn markdown(&self) -> String {
        let mut text = format!(
            "# Friction measurements: {}\n\nItems that ASTM G115 asks a report of friction to state. `{NOT_GIVEN}` marks an item that the \
             calibration file does not state.\n",
            inline(&self.name)
        );
        for section in &self.sections {
            text += &format!("\n## {}\n\n{}", section.title, table(&["item", "value"], &section.rows()));
        }
        if !self.textures.is_empty() {
            text += &format!("\n## Textured samples\n\n{}", table(&TEXTURE_TITLES, &self.textures));
        }
        text += &format!("\n## Friction\n\n{FRICTION_WORDS}\n\n{}", table(&FRICTION_TITLES, &self.friction_cells()));
        let open = self.not_given();
        if !open.is_empty() {
            text += "\n## Not given\n\n";
            open.iter().for_each(|item| text += &format!("- {item}\n"));
        }
        text
    }
}

/// Friction of the flat samples, of patterned samples without a pattern, and of the trials.
fn friction(calibration: &Calibration) -> Vec<FrictionRow> {
    let row = |sample: &str, area_m2: f64, measured: &Measurement, traces: Option<&ConditionTraces>, placed_m| {
        let pressure_pa = calibration.pressure_pa(measured.force_n);
        FrictionRow {
            sample: sample.to_owned(),
            measured: *measured,
            force_n: pressure_pa * area_m2,
            pressure_pa,
            distance_m: traces.map(ConditionTraces::sliding_m).or(placed_m),
            repeats: traces.map(|traces| traces.mean.count),
        }
    };
    let area_m2 = calibration.specimen_area_m2;
    let is_measured_by = |traces: &&ConditionTraces, measured: &Measurement| {
        let own = traces.measurement();
        own.condition() == measured.condition() && own.mu_dynamic == measured.mu_dynamic
    };
    let of_tables = |kind: SurfaceKind, measured: &Measurement| {
        let own = |traces: &&ConditionTraces| traces.condition.trial.is_none() && traces.condition.surface == kind;
        calibration.traces.iter().find(|traces| own(traces) && is_measured_by(traces, measured))
    };
    let mut rows: Vec<FrictionRow> = calibration
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
    for (place, cut) in calibration.trials.samples.iter().enumerate() {
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

/// Cells of [`TEXTURE_TITLES`].
fn texture(cut: &CutSample) -> [String; 7] {
    let pattern = PatternReport::from(&cut.pattern);
    let words = |text: &str| if text.is_empty() { NOT_GIVEN.to_owned() } else { text.to_owned() };
    let length = |um: f64| tidy(um).to_string();
    [
        cut.name.clone(),
        words(&cut.date),
        pattern.texture.planform.unwrap_or_else(|| Planform::Groove.name().to_owned()),
        length(pattern.width_um),
        length(pattern.spacing_um),
        length(pattern.depth_um),
        words(&cut.notes),
    ]
}

/// Smallest and largest of `values`, or the one value that all have; `None` without values.
fn span(values: impl Iterator<Item = f64>) -> Option<String> {
    let [low, high] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    let number = |value: f64| significant(value, 4).to_string();
    match low {
        _ if !low.is_finite() => None,
        _ if low == high => Some(number(low)),
        _ => Some(format!("{} to {}", number(low), number(high))),
    }
}

/// Text in one line, with the characters escaped that Markdown reads as a table or as HTML.
fn inline(text: &str) -> String {
    let one_line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    one_line.replace('\\', "\\\\").replace('|', "\\|").replace('<', "&lt;").replace('`', "\\`")
}

/// A table of Markdown.
fn table<const N: usize>(titles: &[&str; N], rows: &[[String; N]]) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut text = line(titles.map(str::to_owned).to_vec()) + &line(vec!["---".to_owned(); N]);
    rows.iter().for_each(|row| text += &line(row.iter().map(|cell| inline(cell)).collect()));
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
        let open = sheet("").not_given();
        for key in &keys {
            let named = open.iter().filter(|item| item.ends_with(&format!("({key} in [reporting])"))).count();
            assert_eq!(named, 1, "{key}: {open:?}");
            let given = sheet(&format!("[reporting]\n{key} = \"a | b\"\n"));
            assert_eq!(given.not_given().len() + 1, open.len(), "{key}");
            assert!(given.markdown().contains("| a \\| b |"), "{key}");
        }
        // An empty text states nothing.
        assert_eq!(sheet("[reporting]\nstandard = \" \"\n").not_given().len(), open.len());
    }

    #[test]
    fn the_sheet_has_every_measurement_with_its_standard_deviation() {
        let sheet = sheet("");
        let text = sheet.markdown();
        let rows = sheet.friction_cells();
        assert!(rows.len() > 20 && rows.iter().all(|row| row[7].starts_with("0.") && row[8].starts_with("0.")));
        assert!(text.contains("| area of one face | 78.54 mm² |"), "{text}");
        assert!(text.contains("| patterned samples | not given | square | 130 | 370 | 5.2 |"), "{text}");
        assert!(text.contains("- Conditions: repeats of a condition ([traces], a file for each repeat)\n"), "{text}");
        let flat = rows.iter().filter(|row| row[0] == "flat").count();
        assert!(flat > 0 && rows[flat][0] == "patterned samples", "{rows:?}");
    }
}
