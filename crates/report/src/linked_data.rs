//! Descriptions of results for catalogues of data, as JSON-LD with terms of schema.org.
//!
//! The JSON-LD context is part of the file, so that no network is needed to read it. Terms of tribology are those of
//! the ontology tribAIn (Kügler et al., Appl. Sci. 2020, 10, 4421); other quantities have no term.

use serde_json::{Value, json};
use slipgrid_base::units::counted;
use slipgrid_design::results::{NoJsonForm, json as to_text};
use slipgrid_design::{DesignReport, Expected};

use crate::Outputs;
use crate::trials::{MeasuredReport, TrialReport, TrialsReport};

/// File name of the description.
pub const FILE: &str = "result.jsonld";
/// Media types of files, by the ending of the file name.
const TYPES: [(&str, &str); 8] = [
    (".json", "application/json"),
    (".csv", "text/csv"),
    (".svg", "image/svg+xml"),
    (".toml", "application/toml"),
    (".dxf", "image/vnd.dxf"),
    (".html", "text/html"),
    (".md", "text/markdown"),
    (".png", "image/png"),
];
/// Code of UN/CEFACT and symbol of the unit of dimensionless quantities.
const ONE: [&str; 2] = ["C62", "1"];
/// Code of UN/CEFACT and symbol of the micrometre.
const MICROMETRE: [&str; 2] = ["4H", "µm"];

/// Describes a measured or computed quantity. The unit is given as its code of UN/CEFACT and its symbol; `term` is a
/// name in the ontology tribAIn.
fn quantity(name: &str, value: Option<f64>, [code, unit]: [&str; 2], term: Option<&str>) -> Value {
    let mut found = json!({"@type": "PropertyValue", "name": name, "unitCode": code, "unitText": unit});
    if let Some(value) = value {
        found["value"] = json!(value);
    }
    if let Some(term) = term {
        found["propertyID"] = json!(format!("tribain:{term}"));
    }
    found
}

/// Describes the nominal pressure, sliding speed and relative humidity at which a value holds.
fn condition([pressure_mpa, speed_mm_s, humidity_pct]: [f64; 3]) -> Value {
    json!([
        quantity("nominal pressure", Some(pressure_mpa), ["MPA", "MPa"], Some("ContactPressure")),
        quantity("sliding speed", Some(speed_mm_s), ["C16", "mm/s"], Some("Speed")),
        quantity("relative humidity", Some(humidity_pct), ["P1", "%"], Some("RelativeHumidity")),
    ])
}

/// Describes the lengths of a texture, in micrometres, and the `areal_density`, from 0 to 1.
fn texture([width_um, spacing_um, depth_um]: [f64; 3], areal_density: f64) -> Vec<Value> {
    vec![
        quantity("width of a cavity", Some(width_um), MICROMETRE, None),
        quantity("gap between cavities", Some(spacing_um), MICROMETRE, None),
        quantity("depth of a cavity", Some(depth_um), MICROMETRE, None),
        quantity("share of the face that is cavity", Some(areal_density), ONE, None),
    ]
}

/// Describes a data set of `variables`, with links to the files of `outputs`.
fn data_set(name: &str, description: &str, technique: &str, variables: Vec<Value>, outputs: &Outputs) -> Value {
    let file = |name: &&str| {
        let (_, kind) = TYPES.iter().find(|(ending, _)| name.ends_with(ending))?;
        Some(json!({"@type": "DataDownload", "name": name, "contentUrl": name, "encodingFormat": kind}))
    };
    json!({
        "@context": {
            "@vocab": "https://schema.org/",
            "tribain": "http://ktmfk.de/ontology/tribAIn/",
            "contentUrl": {"@type": "@id"},
            "propertyID": {"@type": "@id"},
        },
        "@type": "Dataset",
        "name": name,
        "description": description,
        "keywords": ["tribology", "dry friction", "laser surface texture"],
        "measurementTechnique": technique,
        "variableMeasured": variables,
        "distribution": outputs.names().iter().filter_map(file).collect::<Vec<_>>(),
    })
}

/// Describes `report`, the result of `slipgrid optimize`, and the files in `outputs` as JSON-LD.
///
/// # Errors
/// [`NoJsonForm`] if a value has no JSON form.
pub fn of_design(report: &DesignReport, outputs: &Outputs) -> Result<String, NoJsonForm> {
    let design = &report.sample.design;
    let mut variables = texture([design.width_um, design.spacing_um, design.depth_um], report.specimen_areal_density);
    if let Some(chance) = report.sample.chance {
        variables.push(quantity("chance that a cut sample is on target", Some(chance), ONE, None));
    }
    let (name, term) = if report.is_ratio() {
        ("expected ratio of dynamic friction, textured over flat", None)
    } else {
        ("expected dynamic friction of a textured sample", Some("CoefficientOfFriction"))
    };
    variables.extend(report.sample.expected.iter().map(|at: &Expected| {
        let mut value = quantity(name, Some(at.median), ONE, term);
        value["minValue"] = json!(at.low_95);
        value["maxValue"] = json!(at.high_95);
        value["description"] = json!("median of cut samples; minimum and maximum enclose 95 % of samples");
        value["valueReference"] = condition([at.pressure_mpa, at.speed_mm_s, at.humidity_pct]);
        value
    }));
    let technique = format!(
        "simulation of dry friction by slipgrid {}, corrected by {}",
        report.made_by.version,
        counted(report.trials, "measured trial")
    );
    let description = format!("Laser texture designed for a target of dry friction: {}", report.words);
    let mut found = data_set(&report.name, &description, &technique, variables, outputs);
    if let Some(date) = &report.date {
        found["dateCreated"] = json!(date);
    }
    found["isBasedOn"] = json!({"@type": "CreativeWork", "name": report.material.source});
    to_text(&found)
}

/// Describes `report`, the result of `slipgrid trials`, and the files in `outputs` as JSON-LD.
///
/// # Errors
/// [`NoJsonForm`] if a value has no JSON form.
pub fn of_trials(report: &TrialsReport, outputs: &Outputs) -> Result<String, NoJsonForm> {
    let ratio = |trial: &TrialReport, at: &MeasuredReport| {
        let name = format!("measured ratio of dynamic friction, textured over flat, of {}", trial.name);
        let mut value = quantity(&name, Some(at.measured), ONE, None);
        let mut reference = condition([at.pressure_mpa, at.speed_mm_s, at.humidity_pct]);
        if let Value::Array(all) = &mut reference {
            all.extend(texture([trial.width_um, trial.spacing_um, trial.depth_um], trial.areal_density));
        }
        value["valueReference"] = reference;
        value
    };
    let ratios = report.trials.iter().flat_map(|trial| trial.measured.iter().map(move |at| ratio(trial, at)));
    let technique =
        format!("measurement in a tribometer, compared with predictions by slipgrid {}", report.made_by.version);
    let description =
        "Friction of laser-textured samples over that of flat samples, measured, with the predictions before";
    to_text(&data_set(&report.name, description, &technique, ratios.collect(), outputs))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    /// Terms of schema.org that are written.
    const TERMS: [&str; 24] = [
        "CreativeWork",
        "DataDownload",
        "Dataset",
        "PropertyValue",
        "contentUrl",
        "dateCreated",
        "description",
        "distribution",
        "encodingFormat",
        "isBasedOn",
        "keywords",
        "maxValue",
        "measurementTechnique",
        "minValue",
        "name",
        "propertyID",
        "unitCode",
        "unitText",
        "value",
        "valueReference",
        "variableMeasured",
        "tribain:ContactPressure",
        "tribain:RelativeHumidity",
        "tribain:Speed",
    ];

    fn terms(value: &Value, found: &mut BTreeSet<String>) {
        match value {
            Value::Object(keys) => {
                for (key, value) in keys.iter().filter(|(key, _)| *key != "@context") {
                    if key != "@type" {
                        found.insert(key.clone());
                    }
                    if ["@type", "propertyID"].contains(&key.as_str()) {
                        found.insert(value.as_str().unwrap().to_owned());
                    }
                    terms(value, found);
                }
            }
            Value::Array(values) => values.iter().for_each(|value| terms(value, found)),
            _ => {}
        }
    }

    #[test]
    fn only_terms_of_the_vocabularies_are_written_and_the_context_needs_no_network() {
        let mut report = crate::html::tests::fixture::report();
        report.date = Some("2026-11-28".to_owned());
        let mut outputs = Outputs::default();
        outputs.add("result.json", "{}");
        outputs.add("unknown.bin", "");
        let found: Value = serde_json::from_str(&of_design(&report, &outputs).unwrap()).unwrap();
        let mut seen = BTreeSet::new();
        terms(&found, &mut seen);
        assert_eq!(seen, TERMS.map(str::to_owned).into());
        assert!(found["@context"].is_object(), "a context by address");
        assert_eq!(found["distribution"].as_array().unwrap().len(), 1);
        let expected = found["variableMeasured"].as_array().unwrap().iter().filter(|of| of["minValue"].is_number());
        assert_eq!(expected.count(), report.sample.expected.len());
    }
}
