//! Files that slipgrid did not write are not replaced, and unwritable outputs are reported before any computation.

use std::fs;

use crate::common::{CALIBRATION, FLAT, Place, SCENE, small, untimed};

const MAP: [&str; 5] = ["synthesize", "--pixels", "32", "--waves", "2:8"];

#[test]
fn inputs_and_what_others_wrote_are_not_replaced() {
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", FLAT), ("s.toml", SCENE)]);
    fs::create_dir(place.path("job")).unwrap();
    let design = small();
    place.write("job/scene.toml", &design);
    place.write("d.toml", &design);
    place.write("map.asc", "# Channel: height\n# Width: 1 um\n# Height: 1 um\n1 2\n3 4\n");
    let kept = ["c.toml", "flat.csv", "s.toml", "job/scene.toml", "d.toml", "map.asc"];
    let contents = || kept.map(|name| fs::read(place.path(name)).unwrap());
    let before = contents();
    let mut args = MAP.to_vec();
    args.extend(["-o", "map.asc"]);
    for (args, says) in [
        (vec!["optimize", "job/scene.toml", "-o", "job"], "job holds scene.toml, which is an input of this run"),
        (vec!["optimize", "d.toml", "-o", "job"], "job holds scene.toml, which was not written by slipgrid"),
        (vec!["optimize", "job/scene.toml", "-o", "job/../job"], "is an input of this run"),
        (vec!["calibrate", "c.toml", "-o", "c.toml"], "--output: c.toml is an input of this run"),
        (vec!["calibrate", "c.toml", "-o", "flat.csv"], "--output: flat.csv is an input of this run"),
        (vec!["calibrate", "c.toml", "-o", "s.toml"], "--output: s.toml was not written by slipgrid"),
        (args, "--output: map.asc was not written by slipgrid"),
    ] {
        let message = place.refuse(&args);
        assert!(message.contains(says) && message.contains("so that nothing is lost"), "{args:?}: {message}");
    }
    assert_eq!(contents(), before);
    assert_eq!(place.listed("job"), "scene.toml");
    // What begins as a file of slipgrid is none.
    place.succeed(&[&MAP[..], &["-o", "own.asc"]].concat());
    fs::create_dir(place.path("others")).unwrap();
    for (name, text, args) in [
        (
            "pattern.svg",
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100mm\"><!-- mine --></svg>",
            vec!["optimize", "d.toml"],
        ),
        ("section.csv", "x_um,height_um\n0,1\n", vec!["surface", "own.asc"]),
        ("interface.csv", "load_mpa,surface,x_um,pressure_mpa,friction_mpa\nmine\n", vec!["simulate", "s.toml"]),
        ("table.csv", "task,due,who\nbuy laser,2026-12-01,me\n", vec!["optimize", "d.toml", "--table"]),
        ("process.toml", "# Process sheet. Mine\n", vec!["optimize", "d.toml"]),
    ] {
        fs::write(place.path("others").join(name), text).unwrap();
        let message = place.refuse(&[&args[..], &["-o", "others"]].concat());
        assert!(message.contains(&format!("others holds {name}, which was not written by slipgrid")), "{message}");
        assert_eq!(fs::read_to_string(place.path("others").join(name)).unwrap(), text);
        fs::remove_file(place.path("others").join(name)).unwrap();
    }
    // Files that are not in the way are nobody's concern.
    place.succeed(&["simulate", "s.toml", "-o", "job"]);
    place.write("job/result.json", "{\"mine\": 1}");
    assert!(
        place.refuse(&["simulate", "s.toml", "-o", "job"]).contains("job holds result.json, which was not written")
    );
}

#[test]
fn every_command_replaces_what_it_wrote_before() {
    let design = small() + "[trade_offs]\ngoals = [\"misfit\", \"peak_pressure\"]\ndesigns = 8\n";
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", FLAT), ("s.toml", SCENE), ("d.toml", &design)]);
    let map = [&MAP[..], &["--cavities", "100,100,5", "-o", "map.asc"]].concat();
    let all = "dxf,svg,csv,process,plt,gcode,corners,hatch,png,stl";
    let laser = "spot_um = 23.0\nspeed_mm_s = 10.0";
    place.write("d.toml", design.replace("spot_um = 23.0", laser));
    for args in [
        map,
        vec!["optimize", "d.toml", "--table"],
        vec!["export", "out/d", "--format", all],
        vec!["export", "out/d", "--format", all, "-o", "laser"],
        vec!["simulate", "s.toml", "-o", "out/s"],
        vec!["simulate", "out/d/scene.toml", "-o", "out/t"],
        vec!["calibrate", "c.toml", "-o", "m.toml", "--report", "out/c"],
        vec!["surface", "map.asc", "--cavities", "-o", "out/m"],
        vec!["area-law", "map.asc", "--pressures-mpa", "0.7", "--tolerance", "1e-3", "-o", "out/a"],
        vec!["man", "-o", "out/man"],
    ] {
        place.succeed(&args);
        place.succeed(&args);
    }
}

#[test]
#[cfg(unix)]
fn what_stands_in_the_way_is_said_before_anything_is_computed() {
    use std::os::unix::fs::symlink;
    let place =
        Place::with_cache(&[("d.toml", &small()), ("c.toml", CALIBRATION), ("flat.csv", FLAT), ("s.toml", SCENE)]);
    symlink("nowhere", place.path("link")).unwrap();
    place.write("file", "");
    fs::create_dir_all(place.path("results/result.json")).unwrap();
    fs::create_dir_all(place.path("out/d.study.jsonl")).unwrap();
    fs::create_dir_all(place.path("held.lock")).unwrap();
    for (args, says) in [
        (vec!["optimize", "d.toml", "-o", "link"], "--output: link is a link to what does not exist"),
        (vec!["simulate", "s.toml", "-o", "link"], "--output: link is a link to what does not exist"),
        (vec!["calibrate", "c.toml", "-o", "link"], "--output: link is a link to what does not exist"),
        (vec!["calibrate", "c.toml", "--report", "link"], "--report: link is a link to what does not exist"),
        (vec!["optimize", "d.toml", "-o", "file"], "--output: file is a file"),
        (vec!["calibrate", "c.toml", "--report", "file"], "--report: file is a file"),
        (vec!["calibrate", "c.toml", "-o", "results"], "--output: results is a folder"),
        (
            vec!["optimize", "d.toml", "-o", "results"],
            "results holds result.json, which is a folder where a file is to go",
        ),
        (vec!["optimize", "d.toml"], "out/d.study.jsonl: is a folder where the study is to go"),
        (vec!["optimize", "d.toml", "-o", "held"], "held.lock: is a folder where a file is to go"),
    ] {
        let message = place.refuse(&args);
        assert!(message.contains(says), "{args:?}: {message}");
    }
    assert!(place.path("link").is_symlink());
    // What is computed is kept.
    assert!(place.cached().is_empty(), "{:?}", place.cached());
    place.succeed(&["optimize", "d.toml", "-o", "elsewhere"]);
    assert!(!place.cached().is_empty());
}

#[test]
fn a_design_that_no_specimen_takes_is_refused_before_the_search() {
    let place = Place::with(&[]);
    for (from, to, says) in [
        (
            "diameter_mm = 10.0",
            "diameter_mm = 0.03",
            "widths do not fit whole on the specimen, whose extent is 0.03 mm",
        ),
        (
            "diameter_mm = 10.0",
            "diameter_mm = 0.07",
            "is too small for any of the bounds: the pattern repeats every 0.08 mm, more than the specimen's 0.07 mm",
        ),
        (
            "shape = \"disc\"\ndiameter_mm = 10.0",
            "shape = \"rectangle\"\nlength_mm = 10000.0\nwidth_mm = 10000.0",
            "cavities fit on the specimen: expected at most 10000000",
        ),
    ] {
        let squares = small().replace("\"groove\"", "\"square\"").replace("[search]", "[search]\ndimensions = 2");
        place.write("d.toml", squares.replace("diameter_mm = 1.0", "diameter_mm = 10.0").replace(from, to));
        let message = place.refuse(&["optimize", "d.toml"]);
        assert!(message.contains("specimen") && message.contains(says), "{message}");
        assert_eq!(place.names(), ["d.toml"]);
    }
    // Where only some designs fit, the others are no answer.
    place.write("d.toml", small().replace("diameter_mm = 1.0", "diameter_mm = 0.1"));
    let code = place.run(&["optimize", "d.toml"]).status.code();
    assert!(matches!(code, Some(0 | 3 | 4)), "{code:?}");
    assert!(place.path("out/d/pattern.csv").exists());
}

#[test]
fn a_design_named_by_dots_does_not_write_into_the_current_folder() {
    let place = Place::with(&[("...toml", &small())]);
    place.succeed(&["optimize", "...toml", "--no-cache"]);
    assert_eq!(place.names(), ["...toml", "out"]);
    assert_eq!(place.listed("out"), "design design.study.jsonl");
}

#[test]
fn the_same_run_writes_the_same_bytes_but_for_its_timings() {
    let text =
        small().replace("quantity = \"ratio\"", "quantity = \"mu_dynamic\"").replace("value = 0.9", "value = 0.25");
    let more = "[trade_offs]\ngoals = [\"misfit\", \"peak_pressure\"]\ndesigns = 8\n[tolerances]\nwidth_std_um = 1.0\n";
    let place = Place::with(&[("d.toml", &(text + more)), ("s.toml", SCENE)]);
    for (folder, threads) in [("one", "1"), ("two", "64")] {
        let code = place.run(&["optimize", "d.toml", "--table", "--threads", threads, "-o", folder]).status.code();
        assert!(matches!(code, Some(0 | 3)), "{code:?}");
        let scene = format!("{folder}-scene");
        place.succeed(&["simulate", "s.toml", "--fidelity", "dynamic", "--threads", threads, "-o", &scene]);
    }
    for (one, two) in [("one", "two"), ("one-scene", "two-scene")] {
        let (one, two) = (untimed(&place, one), untimed(&place, two));
        assert!(one.len() >= 4);
        for ((name, one), (_, two)) in one.iter().zip(&two) {
            assert!(one == two, "{name} differs");
        }
        assert_eq!(one.len(), two.len());
    }
    let times = place.read("two/timings.json");
    // No more threads than cores are started.
    let threads = format!("\"threads\": {}", std::thread::available_parallelism().map_or(1, usize::from).min(64));
    for key in ["\"timings_s\"", "\"wall_s\"", &threads, "\"site_updates_per_s\""] {
        assert!(times.contains(key), "{key}: {times}");
    }
}

#[test]
fn what_a_file_holds_cannot_steer_the_terminal() {
    let brackets = "[".repeat(1000);
    let long = "x".repeat(100_000);
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", FLAT)]);
    let scene = |from: &str, to: &str| place.write("s.toml", SCENE.replace(from, to));
    let pieces = [
        "\"\\u001b[31m\u{9b}\u{202e}red\"",
        &format!("\"{long}\""),
        &brackets,
        &format!("{brackets}{}", "]".repeat(1000)),
    ];
    for piece in pieces {
        for (from, to) in [
            ("planform = \"groove\"", format!("planform = {piece}")),
            ("seed = 1", format!("seed = {piece}")),
            ("seed = 1", format!("{piece} = 1")),
            ("width_um = 130.0", format!("width_um = {piece}")),
            ("[material]", format!("material = {piece}\n[other]")),
        ] {
            scene(from, &to);
            let message = place.refuse(&["simulate", "s.toml"]);
            assert!(
                !message.trim_end().contains(|letter: char| letter.is_control() || letter == '\u{202e}'),
                "{message:?}"
            );
            assert!(message.len() < 2500, "{message}");
        }
    }
    // A name in a summary, and a path.
    place.write("d.toml", small().replace("test design", "a\\u001b[2Jb\\u009bc"));
    let told = place.succeed(&["optimize", "d.toml"]);
    assert!(
        told.starts_with("a\\u{1b}[2Jb\\u{9b}c: ") && told.contains("chance that a cut sample is on target"),
        "{told:?}"
    );
    place.write("c.toml", CALIBRATION.replace("name = \"test\"", "name = \"\\u001b]0;x\\u0007\""));
    assert!(!place.succeed(&["calibrate", "c.toml"]).contains('\u{1b}'));
    let message = place.refuse(&["simulate", "\u{1b}[31m.toml"]);
    assert!(message.starts_with("error: \\u{1b}[31m.toml: cannot be read"), "{message:?}");
    place.write("flat.csv", FLAT.replace("0.248", "\u{1b}[31m"));
    assert!(!place.refuse(&["calibrate", "c.toml"]).contains('\u{1b}'));
}
