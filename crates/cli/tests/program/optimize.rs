//! `optimize` from a design file to the laser's files, and `export` and `simulate` of its result.

use crate::common::{DESIGN, Place, at, by_hand, column, correction, json, short_at_one_pressure, trusted};
use serde_json::json as object;

#[test]
fn a_design_is_found_confirmed_and_written_for_a_laser() {
    let place =
        Place::with(&[("grooves.toml", &trusted(&short_at_one_pressure("value = 0.88\ntolerance = 0.03", "")))]);
    let found = place.optimized("grooves", 0).1;
    assert!(["series", "trial"].contains(&found["advice"].as_str().unwrap()), "{}", found["advice"]);
    let confirmed = at(&found, "/confirmed/0/ratio");
    assert!((confirmed - 0.88).abs() <= 0.03, "{confirmed}");
    let um = |key: &str| at(&found, &format!("/design/{key}"));
    assert!((40.0..=100.0).contains(&um("width_um")) && um("spacing_um") == 120.0);
    let bursts = um("depth_um") / 2.6;
    assert!((bursts - bursts.round()).abs() < 1e-6 && at(&found, "/bursts") == bursts.round());
    assert!(found.get("timings_s").is_none() && found.get("threads").is_none());
    assert!(found["compared"] == 7 && found["seed"] == 1 && found["version"].is_string());
    let files = place.listed("out/grooves");
    for name in "scene.toml pattern.dxf pattern.svg pattern.csv process.toml target.svg".split(' ') {
        assert!(files.split(' ').any(|file| file == name), "{name}: {files}");
    }
    // The written scene is the confirming run.
    assert_eq!(place.ratios("out/grooves/scene.toml"), [confirmed]);
    // Exported again: the same bytes.
    place.succeed("export out/grooves/result.json --format dxf,process,dxf -o laser");
    assert_eq!(place.listed("laser"), "pattern.dxf process.toml");
    for name in ["pattern.dxf", "process.toml"] {
        assert_eq!(place.read(&format!("laser/{name}")), place.read(&format!("out/grooves/{name}")), "{name}");
    }
}

#[test]
fn other_textures_worth_cutting_are_samples_after_the_design() {
    let mut result = json(&by_hand(r#""planform": "square""#, "", r#""shape": "disc", "diameter_mm": 10.0"#));
    let others = [61.0, 73.0].map(|width_um| {
        let mut other = object!({ "design": result["design"], "chance": 0.3 });
        other["design"]["width_um"] = object!(width_um);
        other
    });
    result["others"] = object!(others);
    let place = Place::with(&[("result.json", &result.to_string())]);
    for (sample, width_um) in [("1", at(&result, "/design/width_um")), ("2", 61.0), ("3", 73.0)] {
        place.succeed(&format!("export result.json --sample {sample} -o {sample}"));
        assert_eq!(place.toml(&format!("{sample}/process.toml"))["pattern"]["width_um"].as_float(), Some(width_um));
        assert!(place.read(&format!("{sample}/pattern.dxf")).contains(&format!("width {width_um:.3} um")));
    }
    place.refuse_all(
        "export result.json --sample 0 -o none => has no sample 0, but 1 to 3
         export result.json --sample 4 -o none => has no sample 4, but 1 to 3",
    );
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
    place.refuse_all(
        "export mask.json --format gcode -o refused => holds the lines of a spot, but a mask exposes whole cavities
         export mask.json --format hatch -o refused => --format dxf, plt or corners",
    );
    assert!(!place.path("refused").exists());
    // The others are written, and what is not is said with the reason of each.
    let (told, said) = place.ends("export mask.json --format gcode,dxf,hatch,csv -o some", 1);
    assert_eq!((place.listed("some").as_str(), told.lines().count()), ("pattern.csv pattern.dxf", 2));
    let starts = ["error: mask.json: 2 of 4 formats cannot be written:", "  gcode: ", "  hatch: "];
    assert!(said.lines().zip(starts).all(|(line, start)| line.starts_with(start)), "{said}");
    place.succeed("export mask.json --format dxf,plt,corners,csv,process -o contours");
    assert!(place.read("contours/pattern.plt").contains("PD"));
    place.succeed("export hatch.json --format gcode,hatch -o lines");
    assert_eq!(place.listed("lines"), "hatch.csv pattern.gcode");
}

#[test]
fn designs_are_searched_in_the_specimen_as_thick_as_it_is() {
    let narrow = DESIGN
        .replace("[40.0, 400.0]", "400.0")
        .replace("[40.0, 1000.0]", "820.0")
        .replace("[2.0, 50.0]", "46.8")
        .replace("value = 0.9", "value = 0.85")
        .replace("diameter_mm = 10.0", "diameter_mm = 3.0")
        .replace("layer_um = 200.0\nblock_um = 10.0", "block_um = 20.0");
    let place = Place::with(&[("thick.toml", &narrow)]);
    place.run("optimize thick.toml -o out --quiet");
    let design = place.read("out/scene.toml");
    assert!(design.contains("layer_um = 200.0") && design.contains("thickness_mm = 7.0"), "{design}");
    let found = place.result("out");
    assert!(at(correction(&found["confirmed"][0], "specimen behind the layer").unwrap(), "/change") < 0.0);
    // The written scene gives the confirmed ratio to the last bit.
    assert_eq!(place.ratios("out/scene.toml"), column(&found["confirmed"], "/ratio"));
    // A study of thin layers holds other answers.
    assert!(place.read("out.study.jsonl").lines().next().unwrap().contains("\"thickness_mm\":7.0"));
}
