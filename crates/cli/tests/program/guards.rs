//! Files that slipgrid did not write are not replaced, and unwritable outputs are reported before any computation.

use std::fs;

use crate::common::{CALIBRATION, FLAT, Place, SCENE, small};

const MAP: &str = "synthesize --pixels 32 --waves 2:8";

#[test]
fn inputs_and_what_others_wrote_are_not_replaced() {
    let design = small();
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", FLAT), ("s.toml", SCENE), ("d.toml", &design)]);
    fs::create_dir(place.path("job")).unwrap();
    place.write("job/scene.toml", &design);
    place.write("map.asc", "# Channel: height\n# Width: 1 um\n# Height: 1 um\n1 2\n3 4\n");
    let kept = ["c.toml", "flat.csv", "s.toml", "job/scene.toml", "d.toml", "map.asc"];
    let contents = || kept.map(|name| place.read(name));
    let before = contents();
    place.refuse_all(
        "optimize job/scene.toml -o job => job holds scene.toml, which is an input of this run
         optimize d.toml -o job => job holds scene.toml, which was not written by slipgrid
         optimize job/scene.toml -o job/../job => is an input of this run
         calibrate c.toml -o c.toml => --output: c.toml is an input of this run
         calibrate c.toml -o flat.csv => --output: flat.csv is an input of this run
         calibrate c.toml -o s.toml => --output: s.toml was not written by slipgrid
         synthesize --pixels 32 --waves 2:8 -o map.asc => --output: map.asc was not written by slipgrid",
    );
    assert_eq!(contents(), before);
    assert_eq!(place.listed("job"), "scene.toml");
    // Files that are not in the way are nobody's concern.
    place.succeed("simulate s.toml -o job");
}

#[test]
fn every_command_replaces_what_it_wrote_before() {
    let design = small().replace("spot_um = 23.0", "spot_um = 23.0\nspeed_mm_s = 10.0")
        + "[trade_offs]\ngoals = [\"misfit\", \"peak_pressure\"]\ndesigns = 8\n";
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", FLAT), ("s.toml", SCENE), ("d.toml", &design)]);
    let all = "dxf,svg,csv,process,plt,gcode,corners,hatch,png,stl";
    for line in [
        &format!("{MAP} --cavities 100,100,5 -o map.asc"),
        "optimize d.toml --table",
        &format!("export out/d --format {all}"),
        &format!("export out/d --format {all} -o laser"),
        "simulate s.toml -o out/s",
        "simulate out/d/scene.toml -o out/t",
        "calibrate c.toml -o m.toml --report out/c",
        "surface map.asc --cavities -o out/m",
        "area-law map.asc --pressures-mpa 0.7 --tolerance 1e-3 -o out/a",
        "man -o out/man",
    ] {
        place.succeed(line);
        place.succeed(line);
    }
}

#[test]
#[cfg(unix)]
fn what_stands_in_the_way_is_said_before_anything_is_computed() {
    let files =
        [("d.toml", &small()[..]), ("c.toml", CALIBRATION), ("flat.csv", FLAT), ("s.toml", SCENE), ("file", "")];
    let place = Place::with_cache(&files);
    std::os::unix::fs::symlink("nowhere", place.path("link")).unwrap();
    for folder in ["results/result.json", "out/d.study.jsonl", "held.lock"] {
        fs::create_dir_all(place.path(folder)).unwrap();
    }
    place.refuse_all(
        "optimize d.toml -o link => --output: link is a link to what does not exist
         simulate s.toml -o link => --output: link is a link to what does not exist
         calibrate c.toml -o link => --output: link is a link to what does not exist
         calibrate c.toml --report link => --report: link is a link to what does not exist
         optimize d.toml -o file => --output: file is a file
         calibrate c.toml --report file => --report: file is a file
         calibrate c.toml -o results => --output: results is a folder
         optimize d.toml -o results => results holds result.json, which is a folder where a file is to go
         optimize d.toml => out/d.study.jsonl: is a folder where the study is to go
         optimize d.toml -o held => held.lock: is a folder where a file is to go",
    );
    assert!(place.path("link").is_symlink());
    // What is computed is kept.
    assert_eq!(fs::read_dir(place.cache()).unwrap().count(), 0);
    place.succeed("optimize d.toml -o elsewhere");
    assert!(fs::read_dir(place.cache()).unwrap().count() > 0);
}

#[test]
fn a_design_that_no_specimen_takes_is_refused_before_the_search() {
    let squares = small().replace("\"groove\"", "\"square\"").replace("[search]", "[search]\ndimensions = 2");
    let specimen = "shape = \"disc\"\ndiameter_mm = 1.0";
    let large = "shape = \"rectangle\"\nlength_mm = 10000.0\nwidth_mm = 10000.0";
    let place = Place::with(&[
        ("small.toml", &squares.replace("diameter_mm = 1.0", "diameter_mm = 0.03")),
        ("large.toml", &squares.replace(specimen, large)),
        ("none.toml", &squares.replace("diameter_mm = 1.0", "diameter_mm = 0.07")),
        ("some.toml", &small().replace("diameter_mm = 1.0", "diameter_mm = 0.12")),
    ]);
    place.refuse_all(
        "optimize small.toml => widths do not fit whole on the specimen, whose extent is 0.03 mm
         optimize none.toml => is too small for any of the bounds: the pattern repeats every 0.1 mm, more than the specimen's 0.07 mm
         optimize large.toml => cavities fit on the specimen: expected at most 10000000",
    );
    assert!(!place.path("out").exists());
    // Where only some designs fit, the others are no answer.
    let code = place.run("optimize some.toml").0;
    assert!(matches!(code, 0 | 3 | 4), "{code}");
    assert!(place.path("out/some/pattern.csv").exists());
}

#[test]
fn a_design_named_by_dots_does_not_write_into_the_current_folder() {
    let place = Place::with(&[("...toml", &small())]);
    place.succeed("optimize ...toml --no-cache");
    assert_eq!((place.listed("").as_str(), place.listed("out").as_str()), ("...toml out", "design design.study.jsonl"));
}

#[test]
fn the_same_run_writes_the_same_bytes_but_for_its_timings() {
    let text =
        small().replace("quantity = \"ratio\"", "quantity = \"mu_dynamic\"").replace("value = 0.9", "value = 0.25");
    let more = "[trade_offs]\ngoals = [\"misfit\", \"peak_pressure\"]\ndesigns = 8\n[tolerances]\nwidth_std_um = 1.0\n";
    let place = Place::with(&[("d.toml", &(text + more)), ("s.toml", SCENE)]);
    for threads in ["1", "64"] {
        let code = place.run(&format!("optimize d.toml --table --no-cache --threads {threads} -o design-{threads}")).0;
        assert!(matches!(code, 0 | 3), "{code}");
        place.succeed(&format!("simulate s.toml --fidelity dynamic --threads {threads} -o scene-{threads}"));
    }
    for name in ["design", "scene"] {
        let [one, many] = ["1", "64"].map(|threads| place.untimed(&format!("{name}-{threads}")));
        assert!(one.len() >= 4 && one.len() == many.len());
        for ((name, one), (_, many)) in one.iter().zip(&many) {
            assert!(one == many, "{name} differs");
        }
    }
    // No more threads than cores are started.
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(64);
    let times = place.read("scene-64/timings.json");
    for key in ["\"wall_s\"", &format!("\"threads\": {threads}"), "\"site_updates_per_s\""] {
        assert!(times.contains(key), "{key}: {times}");
    }
}

#[test]
fn what_a_file_holds_cannot_steer_the_terminal() {
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", FLAT)]);
    for piece in ["\"\\u001b[31m\u{9b}\u{202e}red\"", &format!("\"{}\"", "x".repeat(100_000)), &"[".repeat(1000)] {
        place.write("s.toml", SCENE.replace("seed = 1", &format!("seed = {piece}")));
        let message = place.refuse("simulate s.toml");
        let steers = |letter: char| letter.is_control() || letter == '\u{202e}';
        assert!(!message.trim_end().contains(steers) && message.len() < 2500, "{message:?}");
    }
    // A name in a summary, and a path.
    place.write("d.toml", small().replace("test design", "a\\u001b[2Jb\\u009bc"));
    let told = place.succeed("optimize d.toml");
    assert!(told.starts_with("a\\u{1b}[2Jb\\u{9b}c: "), "{told:?}");
    place.write("c.toml", CALIBRATION.replace("name = \"test\"", "name = \"\\u001b]0;x\\u0007\""));
    assert!(!place.succeed("calibrate c.toml --details").contains('\u{1b}'));
    let message = place.refuse("simulate \u{1b}[31m.toml");
    assert!(message.starts_with("error: \\u{1b}[31m.toml: cannot be read"), "{message:?}");
    place.write("flat.csv", FLAT.replace("0.248", "\u{1b}[31m"));
    assert!(!place.refuse("calibrate c.toml").contains('\u{1b}'));
}
