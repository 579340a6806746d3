//! `optimize` from a design file to the laser's files, and `export` and `simulate` of its result.

use std::fs;

use crate::common::{Place, by_hand, names, optimized, program, short, trusted};
use serde_json::{Value, json};

/// Design of a short sample of several periods, confirmed in a second, with a target at one pressure.
fn design(value: &str) -> String {
    short()
        .replace("[0.65, 2.6]", "[2.6]")
        .replace("value = 0.9", value)
        .replace("tolerance = 0.01", "tolerance = 0.03")
}

#[test]
fn a_design_is_found_confirmed_and_written_for_a_laser() {
    let place = Place::with(&[("grooves.toml", &trusted(&design("value = 0.88")))]);
    let (summary, found) = optimized(&place, "grooves.toml", 0);
    assert!(summary.contains("make a series: ") || summary.contains("cut a trial: "), "{summary}");

    let confirmed = found["confirmed"][0]["ratio"].as_f64().unwrap();
    assert!((confirmed - 0.88).abs() <= 0.03, "{confirmed}");
    let um = |key: &str| found["design"][key].as_f64().unwrap();
    assert!((40.0..=100.0).contains(&um("width_um")) && um("spacing_um") == 120.0);
    let bursts = um("depth_um") / 2.6;
    assert!((bursts - bursts.round()).abs() < 1e-6 && found["bursts"].as_f64().unwrap() == bursts.round());
    assert!(found.get("timings_s").is_none() && found.get("threads").is_none());
    let times = place.read("out/grooves/timings.json");
    let times: Value = serde_json::from_str(&times).unwrap();
    for stage in ["material", "table", "search", "confirm", "trade_offs", "explorer", "export"] {
        assert!(times["timings_s"][stage].as_f64().unwrap() >= 0.0);
    }
    assert!(found["compared"] == 7 && found["seed"] == 1 && found["version"].is_string());
    let folder = place.path("out/grooves");
    for name in ["scene.toml", "pattern.dxf", "pattern.svg", "pattern.csv", "process.toml", "target.svg"] {
        assert!(names(&folder).contains(&name.to_owned()), "{name}");
    }

    // The screen says what decides, and where the rest is.
    let screen = program().current_dir(place.path("")).args(["optimize", "grooves.toml", "-o", "s"]).output().unwrap();
    let screen = String::from_utf8(screen.stdout).unwrap();
    assert!(screen.lines().count() <= 28 && screen.lines().all(|line| line.chars().count() <= 100), "{screen}");
    for said in
        ["95 % of samples", "\n- not modelled: ", "\nreport  s/report.html\nlaser   s/pattern.dxf, s/process.toml\n"]
    {
        assert!(screen.contains(said), "{said}: {screen}");
    }

    // The written scene is the confirming run.
    let again: Value = place.json(&["simulate", "out/grooves/scene.toml", "--json"]);
    assert_eq!(again["results"][0]["ratio"], found["confirmed"][0]["ratio"]);

    // Exported again: the same bytes.
    place.succeed(&["export", "out/grooves/result.json", "--format", "dxf,process,dxf", "-o", "laser"]);
    assert_eq!(place.listed("laser"), "pattern.dxf process.toml");
    for name in ["pattern.dxf", "process.toml"] {
        assert_eq!(fs::read(place.path("laser").join(name)).unwrap(), fs::read(folder.join(name)).unwrap(), "{name}");
    }
}

/// Exports a result made by hand, so that no solver is involved.
#[test]
fn every_planform_can_be_exported() {
    let result = |texture: &str| by_hand(texture, "", r#""shape": "disc", "diameter_mm": 10.0"#);
    for (texture, says) in [
        (r#""planform": "disc", "arrangement": "staggered""#, "Pattern: disc, staggered, width 130.000 um"),
        (r#""planform": "groove", "angle_deg": 30.0"#, "Pattern: groove, turned by 30 degrees from lying across x"),
        (r#""planform": "square", "sliding_angle_deg": 45.0"#, "Sliding direction: 45 degrees from x"),
        (
            r#""planform": "rectangle", "length_um": 200.0, "spacing_across_um": 50.0"#,
            "Pattern: rectangle, length 200.000 um, spacing across 50.000 um",
        ),
    ] {
        let place = Place::with(&[("result.json", &result(texture))]);
        place.succeed(&["export", "result.json", "--format", "dxf,svg,csv,process", "-o", "laser"]);
        let drawing = place.read("laser/pattern.dxf");
        assert!(drawing.contains(says), "{texture}");
        // Two circles at least: the outline and a disc.
        assert_eq!(drawing.matches("\nCIRCLE\n").count() > 1, texture.contains("disc"));
    }
    for (texture, says) in [
        (
            r#""planform": "groove", "arrangement": "staggered""#,
            r#"design.arrangement: "staggered" has no meaning for planform "groove""#,
        ),
        (r#""planform": "disc", "sliding_angle_deg": 200.0"#, "design.sliding_angle_deg: 200.0 is out of range"),
        (r#""planform": "rectangle", "length_um": -1.0"#, "design.length_um: -1.0 is out of range"),
    ] {
        let place = Place::with(&[("result.json", &result(texture))]);
        let message = place.refuse(&["export", "result.json", "--format", "dxf", "-o", "laser"]);
        assert!(message.starts_with(&format!("error: result.json: {says}")), "{message}");
    }
}

#[test]
fn other_textures_worth_cutting_are_samples_after_the_design() {
    let text = by_hand(r#""planform": "square""#, "", r#""shape": "disc", "diameter_mm": 10.0"#);
    let mut result: Value = serde_json::from_str(&text).unwrap();
    let others = [61.0, 73.0].map(|width_um| {
        let mut other = json!({ "design": result["design"], "chance": 0.3 });
        other["design"]["width_um"] = json!(width_um);
        other
    });
    let own = result["design"]["width_um"].as_f64().unwrap();
    result["others"] = json!(others);
    let place = Place::with(&[("result.json", &result.to_string())]);
    for (sample, width_um) in [("1", own), ("2", 61.0), ("3", 73.0)] {
        place.succeed(&["export", "result.json", "--sample", sample, "-o", sample]);
        assert_eq!(place.toml(&format!("{sample}/process.toml"))["pattern"]["width_um"].as_float(), Some(width_um));
        assert!(place.read(&format!("{sample}/pattern.dxf")).contains(&format!("width {width_um:.3} um")));
    }
    for sample in ["0", "4"] {
        let said = place.refuse(&["export", "result.json", "--sample", sample, "-o", "none"]);
        assert!(said.contains(&format!("has no sample {sample}, but 1 to 3")), "{said}");
    }
}

#[test]
fn a_mask_has_contours_and_no_lines() {
    let result = |exposure: &str| {
        let laser = format!(
            r#""exposure": "{exposure}", "spot_um": 20.0, "speed_mm_s": 100.0, "repetition_hz": 20000.0, "hatch_um": 10.0"#
        );
        by_hand(r#""planform": "square""#, &laser, r#""shape": "disc", "diameter_mm": 3.0"#)
    };
    let place = Place::with(&[("mask.json", &result("mask")), ("hatch.json", &result("hatch"))]);
    for (format, what) in [("gcode", "G-code"), ("hatch", "hatch.csv")] {
        let said = place.refuse(&["export", "mask.json", "--format", format, "-o", "refused"]);
        assert!(
            said.contains(&format!("{what} holds the lines of a spot, but a mask exposes whole cavities")),
            "{said}"
        );
        assert!(said.contains("--format dxf, plt or corners") && !place.path("refused").exists(), "{said}");
    }
    // The others are written, and what is not is said with the reason of each.
    let some = place.run(&["export", "mask.json", "--format", "gcode,dxf,hatch,csv", "-o", "some"]);
    let said = String::from_utf8_lossy(&some.stderr).into_owned();
    assert_eq!(some.status.code(), Some(1), "{said}");
    assert_eq!(place.listed("some"), "pattern.csv pattern.dxf");
    assert_eq!(String::from_utf8_lossy(&some.stdout).lines().count(), 2);
    let lines: Vec<&str> = said.lines().collect();
    assert_eq!(lines[0], "error: mask.json: 2 of 4 formats cannot be written:");
    assert!(
        lines[1].starts_with("  gcode: G-code holds the lines") && lines[2].starts_with("  hatch: hatch.csv"),
        "{said}"
    );
    place.succeed(&["export", "mask.json", "--format", "dxf,plt,corners,csv,process", "-o", "contours"]);
    let plot = place.read("contours/pattern.plt");
    assert!(plot.contains("PD"), "{plot}");
    place.succeed(&["export", "hatch.json", "--format", "gcode,hatch", "-o", "lines"]);
    assert_eq!(place.listed("lines"), "hatch.csv pattern.gcode");
}
