//! `surface`, and `synthesize` with cavities: output, files and refusals.

use std::fs;

use crate::common::{Place, json, untimed};
use serde_json::Value;

/// Options for grooves of 130 um, 370 um apart and 5.2 um deep, on 256 pixels of 10 um.
const TEXTURED: &str = "synthesize --pixels 256 --side-mm 2.56 --waves 4:32 \
                        --cavities 130,370,5.2 --wall-um 20 --cavity-std 8,13,0.5 -o textured.asc --quiet";

#[test]
fn a_patterned_map_is_measured_drawn_and_written() {
    let place = Place::with(&[]);
    let said = place.succeed_line(TEXTURED);
    assert!(said.contains("Sa 0.1580 um") && said.contains("before 5 cavities were cut"), "{said}");
    let header = place.read("textured.asc");
    assert!(header.contains("# 5 grooves cut: width 130 +- 8 um, spacing 370 um"), "{}", &header[..600]);
    assert!(!header.contains("one period"));

    let result = place.json(&["surface", "textured.asc", "--cavities", "--json", "-o", "out"]);
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

    let files = "cavities.csv edge-profile.csv edge-profile.svg histogram.svg map.svg report.html result.json \
                 section.csv section.svg spectrum.csv spectrum.svg";
    assert_eq!(place.listed("out"), files);
    let written = |name: &str| fs::read_to_string(place.path("out").join(name)).unwrap();
    assert_eq!(json(&written("result.json")), result);
    assert_eq!(written("section.csv").lines().count(), 257);
    assert_eq!(written("cavities.csv").lines().count(), 6);
    assert!(written("map.svg").contains("data:image/png;base64,") && written("map.svg").len() < 400_000);

    // The same bytes again, and at another number of threads.
    let first = untimed(&place, "out");
    place.succeed(&["surface", "textured.asc", "--cavities", "--threads", "1", "-o", "out"]);
    assert!(untimed(&place, "out") == first);
    let table = place.succeed(&["surface", "textured.asc", "--cavities"]);
    for word in ["Sa", "Smr2", "width along x", "spacing along x", "depth", "cavities take"] {
        assert!(table.contains(word), "{word}: {table}");
    }
}

/// Parses the columns of a matrix text, in um.
fn matrix(text: &str) -> Vec<Vec<f64>> {
    let rows = text.lines().filter(|line| !line.starts_with('#'));
    rows.map(|row| row.split('\t').map(|height| height.parse().unwrap()).collect()).collect()
}

#[test]
fn rims_are_found_and_stand_in_the_mean_period() {
    let place = Place::with(&[]);
    let made = "synthesize --side-mm 1.024 --waves 4:64 --cavities 60,140,5.2 --wall-um 10 --cavity-std 1,3,0.2 \
                --cavity-shape square --rims 1,16 --rim-profile round --rim-std-um 0.1 -o rims.asc --quiet";
    place.succeed_line(made);
    let header = place.read("rims.asc");
    assert!(header.contains("# rims raised: round, height 1 +- 0.1 um, width 16 um"), "{}", &header[..700]);

    let given = ["surface", "rims.asc", "--cavities", "--period-out", "period.asc", "--json", "-o", "out"];
    let result = place.json(&given);
    let rim = &result["cavities"]["rim"];
    let part = |key: &str, part: &str| rim[key][part].as_f64().unwrap_or_else(|| panic!("{key}: {rim}"));
    // 25 rims drawn from 1 +- 0.1 um have a mean within 0.02 um of it.
    assert!((part("height_um", "value") - 1.0).abs() < 0.04 + 2.0 * part("height_um", "error"), "{rim}");
    assert!(part("height_um", "error") < 0.1 && part("height_std_um", "value") < 0.25, "{rim}");
    assert!((part("width_um", "value") - 16.0).abs() < 3.0 * part("width_um", "error"), "{rim}");
    assert!(part("share_of_edge", "value") > 0.95 && rim["profile"] == "round", "{rim}");
    let angle = result["cavities"]["wall_angle_deg"]["value"].as_f64().unwrap();
    assert!((angle - (5.2_f64 / 10.0).atan().to_degrees()).abs() < 1.5, "{angle}");

    // Cavity in the middle, land at 0, rims between.
    let text = place.read("period.asc");
    assert!(text.contains("one period") && text.contains("synthetic") && text.contains("# Value units: um"));
    let period = matrix(&text);
    let (rows, cols) = (period.len(), period[0].len());
    assert_eq!((rows, cols), (100, 100));
    let line = &period[rows / 2];
    assert!((line[cols / 2] + 5.2).abs() < 0.15, "{}", line[cols / 2]);
    // Pixels of 2 um: the wall ends 35 um from the middle, the rim 51 um.
    let mean = |from: usize, to: usize| line[50 + from..50 + to].iter().sum::<f64>() / (to - from) as f64;
    // 1 - s^2 between 1 and 7 um of 16: 0.93
    assert!((mean(18, 21) - 0.93).abs() < 0.15, "{}", mean(18, 21));
    assert!(mean(27, 49).abs() < 0.12, "{}", mean(27, 49));
    let read = place.json(&["surface", "period.asc", "--json"]);
    assert_eq!(read["synthetic_surface"], Value::from(true));
    let width_um = read["pixel_um"][0].as_f64().unwrap() * rows as f64;
    assert!((width_um - 200.0).abs() < 2.0, "{width_um}");
    assert!(read["model"].as_array().unwrap().iter().any(|note| note.as_str().unwrap().contains("one whole period")));

    let svg = place.read("out/edge-profile.svg");
    assert!(svg.contains("round rim") && svg.contains("height above the land"));
    // It is replaced as slipgrid's own; the map that it comes from is not.
    place.succeed(&["surface", "rims.asc", "--cavities", "--period-out", "period.asc"]);
    assert_eq!(place.read("period.asc"), text);
    let said = place.refuse(&["surface", "rims.asc", "--cavities", "--period-out", "rims.asc"]);
    assert!(said.contains("--period-out") && said.contains("input of this run"), "{said}");
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

#[test]
fn a_slope_can_be_asked_for_instead_of_sa() {
    let place = Place::with(&[]);
    let said = place.succeed_line("synthesize --pixels 64 --waves 2:8 --rms-slope 0.02 -o m.asc");
    assert!(said.contains("rms slope 0.020000"), "{said}");
    let slope = place.json(&["surface", "m.asc", "--json"])["parameters"]["rms_slope"].as_f64().unwrap();
    assert!((slope - 0.02).abs() < 1e-6, "{slope}");
}

#[test]
fn decimal_commas_and_oblong_pixels_are_asked_for_by_flags() {
    let table = "1;2;3;4\n5;6;7;8\n9;10;11;12\n13;14;15;17.5\n";
    let place = Place::with(&[("plain.csv", table), ("comma.csv", &table.replace('.', ","))]);
    let read = |name: &str, more: &[&str]| {
        let given = ["surface", name, "--pixel-um", "2", "--height-unit", "nm", "--form", "mean", "--json"];
        place.json(&[&given, more].concat())
    };
    let whole = read("plain.csv", &[]);
    assert_eq!((whole["rows"].as_u64(), whole["columns"].as_u64()), (Some(4), Some(4)));
    assert_eq!(read("comma.csv", &["--decimal-comma"])["parameters"], whole["parameters"]);
    assert_eq!(read("plain.csv", &["--pixel-y-um", "0.5"])["pixel_um"], serde_json::json!([2.0, 0.5]));
}

#[test]
fn a_part_of_a_period_is_none() {
    let place = Place::with(&[]);
    place.succeed(&["synthesize", "--pixels", "64", "--waves", "2:8", "--rms-slope", "0.02", "-o", "m.asc"]);
    let says = |flags: &[&str], what: &str| {
        let law = place.json(&[&["area-law", "m.asc", "--pressures-mpa", "1", "--json"][..], flags].concat());
        assert!(law["model"].as_array().unwrap().iter().any(|note| note.as_str().unwrap().contains(what)), "{law}");
        law
    };
    let part = says(&["--crop", "0,0,32,64", "--form", "second-order"], "surface of second order has been subtracted");
    assert_eq!((part["rows"].as_u64(), part["columns"].as_u64()), (Some(32), Some(64)));
    // The text as that of `surface`, columns first, and of which surface Sa is.
    for (command, pixels) in [
        ("surface", "m.asc: matrix, synthetic, 64 x 32 pixels of 10 x 15.625 um\n"),
        ("area-law", "m.asc: synthetic, 64 x 32 pixels of 10 x 15.625 um; of its periodic component, Sa "),
    ] {
        let flags = ["m.asc", "--crop", "0,0,32,64", "--pixel-um", "10", "--pixel-y-um", "15.625"];
        let said = place.succeed(&[&[command], &flags[..]].concat());
        assert!(said.starts_with(pixels), "{said}");
    }
    says(&["--crop", "0,0,40,64"], "the least-squares plane has been subtracted");
    // All but a pixel of a period: its sides continue each other as neighbours do.
    says(&["--decimate", "3"], "no plane has been subtracted");
    let coarse = says(&["--decimate", "2"], "no plane has been subtracted");
    assert_eq!((coarse["rows"].as_u64(), coarse["pixel_um"].as_f64()), (Some(32), Some(31.25)));
}

/// A part of a surface keeps its slope, although its opposite sides do not continue each other.
#[test]
fn the_slope_of_a_part_is_that_of_the_whole() {
    let place = Place::with(&[]);
    place.succeed(&["synthesize", "--pixels", "256", "--side-mm", "0.5", "-o", "map.asc"]);
    let slope = |more: &[&str]| {
        let found: Value = place.json(&[&["surface", "map.asc", "--json"], more].concat());
        found["parameters"]["rms_slope"].as_f64().unwrap()
    };
    let (whole, part) = (slope(&[]), slope(&["--crop", "0,0,128,128"]));
    assert!((part / whole - 1.0).abs() < 0.1, "{part} {whole}");
}
