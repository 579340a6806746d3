//! `surface` and `synthesize` with cavities: what they print and write, and what they refuse.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

mod common;

use std::fs;

use common::{Place, names};
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Grooves of 130 um, 370 um apart and 5.2 um deep, on 256 pixels of 10 um.
const TEXTURED: [&str; 16] = [
    "synthesize",
    "--pixels",
    "256",
    "--side-mm",
    "2.56",
    "--waves",
    "4:32",
    "--cavities",
    "130,370,5.2",
    "--wall-um",
    "20",
    "--cavity-std",
    "8,13,0.5",
    "-o",
    "textured.asc",
    "--quiet",
];

#[test]
fn a_patterned_map_is_measured_drawn_and_written() {
    let place = Place::with(&[]);
    let said = place.succeed(&TEXTURED);
    assert!(said.contains("Sa 0.1580 um") && said.contains("before 5 cavities were cut"), "{said}");
    let header = fs::read_to_string(place.path("textured.asc")).unwrap();
    assert!(header.contains("# 5 grooves cut: width 130 +- 8 um, spacing 370 um"), "{}", &header[..600]);
    assert!(!header.contains("one period"));

    let result = json(&place.succeed(&["surface", "textured.asc", "--cavities", "--json", "-o", "out"]));
    assert_eq!((&result["format"], &result["synthetic_surface"]), (&Value::from("matrix"), &Value::from(true)));
    let spread = |key: &str, part: &str| result["cavities"][key][part].as_f64().unwrap();
    // The five drawn stray from the pattern by their standard errors: 8, 13 and 0.5 um over sqrt 5.
    assert!((spread("width_x", "mean_um") - 130.0).abs() < 9.0 && spread("width_x", "std_um") < 20.0);
    assert!((spread("spacing_x", "mean_um") - 370.0).abs() < 16.0);
    assert!((spread("depth", "mean_um") - 5.2).abs() < 0.5);
    assert!(result["cavities"]["width_y"].is_null());
    let parameter = |key: &str| result["parameters"][key].as_f64().unwrap();
    assert!(parameter("ssk") < -0.8 && parameter("svk_um") > parameter("spk_um"));
    assert!((parameter("sz_um") - parameter("sp_um") - parameter("sv_um")).abs() < 1e-9);
    assert!(result["parameters"]["str"].is_null(), "grooves run through the map");
    assert!(result["spectrum"].as_array().unwrap().len() > 15);

    let files = [
        "cavities.csv",
        "histogram.svg",
        "map.svg",
        "result.json",
        "section.csv",
        "section.svg",
        "spectrum.csv",
        "spectrum.svg",
    ];
    assert_eq!(names(&place.path("out")), files);
    let written = |name: &str| fs::read_to_string(place.path("out").join(name)).unwrap();
    assert_eq!(json(&written("result.json")), result);
    assert_eq!(written("section.csv").lines().count(), 257);
    assert_eq!(written("cavities.csv").lines().count(), 6);
    assert!(written("map.svg").contains("data:image/png;base64,") && written("map.svg").len() < 400_000);

    // The same bytes again, and at another number of threads.
    let first = files.map(written);
    place.succeed(&["surface", "textured.asc", "--cavities", "--threads", "1", "-o", "out"]);
    assert_eq!(files.map(written), first);
    let table = place.succeed(&["surface", "textured.asc", "--cavities"]);
    for word in ["Sa", "Smr2", "width along x", "spacing along x", "depth", "cavities take"] {
        assert!(table.contains(word), "{word}: {table}");
    }
}

#[test]
fn a_slope_can_be_asked_for_instead_of_sa() {
    let place = Place::with(&[]);
    let said = place.succeed(&["synthesize", "--pixels", "64", "--waves", "2:8", "--rms-slope", "0.02", "-o", "m.asc"]);
    assert!(said.contains("rms slope 0.020000"), "{said}");
    let result = json(&place.succeed(&["surface", "m.asc", "--json"]));
    let parameters = &result["parameters"];
    assert!((parameters["rms_slope"].as_f64().unwrap() - 0.02).abs() < 1e-6);
    assert!(parameters["str"].as_f64().unwrap() > 0.0 && result["cavities"].is_null());
    assert!(result["model"].as_array().unwrap().iter().any(|note| note.as_str().unwrap().contains("one whole period")));
}

#[test]
fn parts_and_coarser_maps() {
    let table = "1;2;3;4\n5;6;7;8\n9;10;11;12\n13;14;15;17,5\n".replace(',', ".");
    let place = Place::with(&[("plain.csv", &table), ("comma.csv", &table.replace('.', ","))]);
    let read = |name: &str, more: &[&str]| {
        let given = ["surface", name, "--pixel-um", "2", "--height-unit", "nm", "--form", "mean", "--json"];
        json(&place.succeed(&[&given, more].concat()))
    };
    let size = |result: &Value| (result["rows"].as_u64().unwrap(), result["columns"].as_u64().unwrap());
    let whole = read("plain.csv", &[]);
    assert_eq!(size(&whole), (4, 4));
    let comma = read("comma.csv", &["--decimal-comma"]);
    assert_eq!(comma["parameters"], whole["parameters"]);
    let part = read("plain.csv", &["--crop", "1,1,2,3"]);
    assert_eq!(size(&part), (2, 3));
    // 6, 7, 8 and 10, 11, 12: Sz 6 nm.
    assert!((part["parameters"]["sz_um"].as_f64().unwrap() - 6e-3).abs() < 1e-12);
    let coarse = read("plain.csv", &["--decimate", "2"]);
    assert_eq!((size(&coarse), &coarse["pixel_um"][0]), ((2, 2), &Value::from(4.0)));
    let narrow = read("plain.csv", &["--pixel-y-um", "0.5"]);
    assert_eq!(narrow["pixel_um"], serde_json::json!([2.0, 0.5]));
    let picked = read("plain.csv", &["--decimate", "2", "--decimate-by", "pick"]);
    // 1, 3, 9, 11
    assert!((picked["parameters"]["sz_um"].as_f64().unwrap() - 10e-3).abs() < 1e-12);
}

#[test]
fn a_part_of_a_period_is_none() {
    let place = Place::with(&[]);
    place.succeed(&["synthesize", "--pixels", "64", "--waves", "2:8", "--rms-slope", "0.02", "-o", "m.asc"]);
    let says = |flags: &[&str], what: &str| {
        let law = json(&place.succeed(&[&["area-law", "m.asc", "--pressures-mpa", "1", "--json"][..], flags].concat()));
        assert!(law["model"].as_array().unwrap().iter().any(|note| note.as_str().unwrap().contains(what)), "{law}");
        law
    };
    let part = says(&["--crop", "0,0,32,64", "--form", "second-order"], "surface of second order has been subtracted");
    assert_eq!((part["rows"].as_u64(), part["columns"].as_u64()), (Some(32), Some(64)));
    says(&["--crop", "0,0,40,64"], "the least-squares plane has been subtracted");
    // All but a pixel of a period: its sides continue each other as neighbours do.
    says(&["--decimate", "3"], "no plane has been subtracted");
    let coarse = says(&["--decimate", "2"], "no plane has been subtracted");
    assert_eq!((coarse["rows"].as_u64(), coarse["pixel_um"].as_f64()), (Some(32), Some(31.25)));
}

#[test]
fn what_cannot_be_measured_is_refused_and_nothing_is_written() {
    let holed = "# Width: 3 um\n# Height: 3 um\n# Value units: nm\n1 2 3\n4 NaN 6\n7 8 9\n";
    let place = Place::with(&[("holed.asc", holed), ("blob.bin", "\u{1}\u{2}\u{3}")]);
    for (args, message) in [
        (vec!["surface", "absent.sur"], "error: absent.sur: cannot be read"),
        (vec!["surface", "blob.bin"], "error: blob.bin: the file begins with \"\\x01\\x02\\x03\""),
        (vec!["surface", "holed.asc", "--missing", "refuse"], "error: holed.asc: 1 of 9 heights are missing"),
        (vec!["surface", "holed.asc", "--crop", "0,0,4,3"], "error: holed.asc: the crop takes rows 0 to 3"),
        (vec!["surface", "holed.asc", "--crop", "0,0,4"], "error: invalid value '0,0,4'"),
        (vec!["surface", "holed.asc", "--cavities"], "error: holed.asc: no cavities found"),
        (vec!["surface", "holed.asc", "--section-um", "3.5"], "error: --section-um: 3.5 lies outside the map"),
        (vec!["surface", "holed.asc", "--height-unit", "inch"], "error: --height-unit: \"inch\""),
        (vec!["area-law", "holed.asc", "--no-level", "--form", "mean"], "error: the argument '--no-level'"),
        (vec!["synthesize", "--cavities", "130,370", "-o", "m"], "error: invalid value '130,370'"),
        (vec!["synthesize", "--wall-um", "5", "-o", "m"], "error: the following required arguments"),
        (vec!["synthesize", "--cavities", "130,370,5", "--wall-um", "131", "-o", "m"], "error: wall width is"),
        (vec!["synthesize", "--rms-slope", "-1", "-o", "m"], "error: "),
    ] {
        let mut args = args;
        if args[0] != "synthesize" {
            args.extend(["-o", "out"]);
        }
        let said = place.refuse(&args);
        assert!(said.starts_with(message), "{args:?}: {said}");
    }
    assert_eq!(place.names(), ["blob.bin", "holed.asc"]);
    let filled = json(&place.succeed(&["surface", "holed.asc", "--json"]));
    assert_eq!(filled["missing_points"], 1);
}
