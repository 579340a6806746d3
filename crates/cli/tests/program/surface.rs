//! `surface`, and `synthesize` with cavities: output, files and refusals.

use std::fs;

use crate::common::{Place, json, names};
use serde_json::Value;

/// Options for grooves of 130 um, 370 um apart and 5.2 um deep, on 256 pixels of 10 um.
const TEXTURED: &str = "synthesize --pixels 256 --side-mm 2.56 --waves 4:32 \
                        --cavities 130,370,5.2 --wall-um 20 --cavity-std 8,13,0.5 -o textured.asc --quiet";

#[test]
fn a_patterned_map_is_measured_drawn_and_written() {
    let place = Place::with(&[]);
    let said = place.succeed_line(TEXTURED);
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
        "edge-profile.csv",
        "edge-profile.svg",
        "histogram.svg",
        "map.svg",
        "report.html",
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
fn a_map_with_one_whole_cavity_has_no_period() {
    let place = Place::with(&[]);
    let made = "synthesize --pixels 128 --side-mm 0.4 --waves 2:16 --cavities 100,200,5 -o one.asc";
    place.succeed_line(made);
    let said = place.refuse(&["surface", "one.asc", "--cavities", "--period-out", "period.asc", "-o", "out"]);
    assert!(said.contains("the 1 whole cavities have no mean period: expected at least two"), "{said}");
    assert_eq!(place.names(), ["one.asc"]);
}

#[test]
fn cavities_that_no_laser_cuts_raise_the_question_of_units() {
    let place = Place::with(&[]);
    let cut = ["--pixels", "128", "--waves", "2:8", "--sa-um", "0.05", "--cavities", "130,370,9", "-o", "t.asc"];
    place.succeed(&[&["synthesize"], &cut[..]].concat());
    let asks = "! unit of heights: cavities 129 um wide are 8.98 nm deep";
    let said = place.succeed(&["surface", "t.asc", "--cavities"]);
    assert!(!said.contains("unit of heights"), "{said}");
    // What is in nanometres is read as picometres.
    let said = place.succeed(&["surface", "t.asc", "--cavities", "--height-unit", "pm"]);
    assert!(said.contains(asks) && said.contains("1000 times as large, the depth would be "), "{said}");
}

/// A part of a surface keeps its slope, although its opposite sides do not continue each other.
#[test]
fn the_slope_of_a_part_is_that_of_the_whole() {
    let place = Place::with(&[]);
    place.succeed(&["synthesize", "--pixels", "256", "--side-mm", "0.5", "-o", "map.asc"]);
    let slope = |more: &[&str]| {
        let found: Value =
            serde_json::from_str(&place.succeed(&[&["surface", "map.asc", "--json"], more].concat())).unwrap();
        found["parameters"]["rms_slope"].as_f64().unwrap()
    };
    let (whole, part) = (slope(&[]), slope(&["--crop", "0,0,128,128"]));
    assert!((part / whole - 1.0).abs() < 0.1, "{part} {whole}");
}
