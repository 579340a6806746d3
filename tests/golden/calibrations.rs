//! Calibrations: the shipped ones and variants of them.

use std::fs;

use crate::Case;
use crate::place::Place;
use crate::record::Record;
use slipgrid_tests::repository;

/// Text of a file and its replacement.
type Change = (&'static str, &'static str);

/// Variants of the shipped calibrations: name, folder, and replacements.
const VARIANTS: [(&str, &str, &[Change]); 6] = [
    ("LDPE", "ldpe-cast-iron", &[]),
    ("LDPE, one pair", "ldpe-cast-iron", &[("coefficients = \"per-condition\"", "coefficients = \"single\"")]),
    (
        "LDPE, Persson",
        "ldpe-cast-iron",
        &[("map = \"flat-map.asc\"", "persson_rms_slope = 0.0137"), ("synthetic = true", "")],
    ),
    (
        "LDPE, measured law",
        "ldpe-cast-iron",
        &[("map = \"flat-map.asc\"", "local_law = \"measured\""), ("synthetic = true", "")],
    ),
    ("traces", "synthetic-polymer", &[]),
    (
        "traces, fixed slope",
        "synthetic-polymer",
        &[
            ("coefficients = \"single\"", "coefficients = \"per-condition\""),
            ("area_law_scale_mpa = [1.0, 100.0]", "[surface]\npersson_rms_slope = 0.005"),
        ],
    ),
];

pub fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = VARIANTS
        .iter()
        .map(|(name, folder, changes)| Case::new(*name, false, move || calibrate(folder, changes)))
        .collect();
    cases.push(Case::new("three forces", true, three_forces));
    // The page evidence/validation.md of the book shows the trials in every run of the tests.
    for name in ["trials", "validate"] {
        cases.push(Case::new(name, false, move || {
            let calibration = repository().join("calibration/ldpe-cast-iron/calibration.toml");
            let mut record = Record::new();
            let options = if name == "validate" { "--sliding-um 0" } else { "" };
            Place::new().run(&format!("{name} {} --json {options}", calibration.display()), &mut record);
            record
        }));
    }
    cases
}

/// Records the material, the tables of the report and the output of `calibrate`.
fn outputs(place: &Place) -> Record {
    let mut record = Record::new();
    place.run("calibrate @calibration.toml -o @m.toml --report @report --details", &mut record);
    place.record_folder("report", &mut record);
    place.record_file("m.toml", "m.toml", &mut record);
    record
}

fn calibrate(folder: &str, changes: &[(&str, &str)]) -> Record {
    let place = Place::new();
    copy(&repository().join("calibration").join(folder), "", &place);
    let mut text = fs::read_to_string(place.path("calibration.toml")).unwrap();
    for (from, to) in changes {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    place.write("calibration.toml", text.as_bytes());
    outputs(&place)
}

fn copy(from: &std::path::Path, below: &str, place: &Place) {
    for entry in fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let name = format!("{below}{}", path.file_name().unwrap().to_str().unwrap());
        if path.is_dir() {
            copy(&path, &format!("{name}/"), place);
        } else {
            place.write(&name, &fs::read(&path).unwrap());
        }
    }
}

/// Records a calibration of a table with three rows by Persson's law.
fn three_forces() -> Record {
    outputs(&Place::with(&[
        (
            "calibration.toml",
            "name = \"three\"\nsource = \"none\"\n[material]\nyoungs_modulus_gpa = 0.38\nyoungs_modulus_std_gpa = 0.08\ndensity_g_cm3 = 0.9\n\
             [surface]\npersson_rms_slope = 0.0137\n[specimen]\nradius_mm = 5.0\n[measurements]\nflat = \"flat.csv\"\n\
             [fit]\ncoefficients = \"single\"\n",
        ),
        (
            "flat.csv",
            "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n50,2,15,0.25,0.002\n75,2,15,0.25,0.002\n100,2,15,0.26,0.002\n",
        ),
    ]))
}
