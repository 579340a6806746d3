//! Refused input: exit code 2, a message with file, line and key, warnings before it, and no written files.
//! `tests/golden` keeps the messages about every key and flag.

use crate::common::{CALIBRATION, DESIGN, FLAT, Place, SCENE, measured, program, small};
use slipgrid_io::disk::disk;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::design::Design;
use slipgrid_io::formats::{Diagnostic, Document};

/// The maximum step named in a refusal is itself accepted.
#[test]
fn the_stability_limit_that_is_named_is_accepted() {
    let dynamic = SCENE.replace("\"steady\"", "\"dynamic\"").replace("sliding_um = 2.0", "step_ns = 20");
    let place = Place::with(&[("scene.toml", &dynamic)]);
    let message = place.refuse("simulate scene.toml");
    let most = message.trim_end().rsplit_once("at most ").unwrap().1;
    place.write("scene.toml", dynamic.replace("step_ns = 20", &format!("sliding_um = 0.01\nstep_ns = {most}")));
    place.succeed("simulate scene.toml");
}

#[test]
fn a_material_that_is_absent_or_lacks_the_condition_is_refused_where_it_is_named() {
    let rest = &SCENE[SCENE.find("[pattern]").unwrap()..];
    let material = "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[friction]\n[[friction.conditions]]\n\
        speed_mm_s = 2.0\nhumidity_pct = 15.0\npressure_mpa = [0.6, 2.4]\nstatic_mean = [0.3, 0.31]\ndynamic_mean = [0.26, 0.28]\n";
    let place = Place::with(&[("m.toml", material), ("c.toml", CALIBRATION), ("flat.csv", FLAT)]);
    let scene = |head: &str| place.write("scene.toml", format!("{head}\n{rest}"));
    let at_condition = |speed: &str, humidity: &str| {
        format!("material = \"m.toml\"\ncondition = {{ speed_mm_s = {speed}, humidity_pct = {humidity} }}")
    };
    for (head, says) in [
        (
            "material = \"absent.toml\"".to_owned(),
            "scene.toml:1: material: \"absent.toml\" (absent.toml) cannot be read",
        ),
        ("material = \"c.toml\"".to_owned(), "c.toml: seems to be a calibration file"),
        ("material = \"m.toml\"".to_owned(), "scene.toml:1: material: \"m.toml\" the material has coefficients per"),
        (at_condition("2.0", "40.0"), "scene.toml:2: condition: no coefficients for 2 mm/s at 40 % humidity"),
        (at_condition("1.0", "15.0"), "scene.toml:14: load.speed_mm_s: 2.0 mm/s is more than the speed"),
    ] {
        scene(&head);
        let message = place.refuse("simulate scene.toml");
        assert!(message.starts_with(&format!("error: {says}")), "{message}");
    }
    scene(&at_condition("2.0", "15.0"));
    let found = place.json("simulate scene.toml --json");
    let extrapolated = [0, 1].map(|row| found["results"][row]["friction_extrapolated"].as_bool().unwrap());
    assert_eq!(extrapolated, [false, true]);
}

#[test]
fn a_number_of_threads_in_the_environment_is_refused_as_one() {
    let folder = Place::with(&[]);
    let ended = program().env("RAYON_NUM_THREADS", "100000").args(["new", "scene", "new.toml"]).output().unwrap();
    assert!(String::from_utf8_lossy(&ended.stderr).starts_with("error: RAYON_NUM_THREADS: 100000 "), "{ended:?}");
    assert!(ended.status.code() == Some(2) && !folder.path("new.toml").exists());
}

#[test]
fn folders_and_files_without_an_end_are_no_input() {
    let folder = Place::with(&[]);
    std::fs::create_dir(folder.path("mine")).unwrap();
    for command in ["simulate", "optimize", "calibrate", "export", "traces", "surface", "area-law", "validate"] {
        let message = folder.refuse(&format!("{command} mine"));
        assert!(message.starts_with("error: mine: is a folder") && message.contains("; expected "), "{message}");
        if cfg!(unix) && !["traces", "surface", "area-law", "validate"].contains(&command) {
            let message = folder.refuse(&format!("{command} /dev/zero"));
            assert!(message.starts_with("error: /dev/zero: cannot be read: it has more than 64 MiB"), "{message}");
        }
    }
    // The one that was meant is named.
    folder.write("mine/calibration.toml", CALIBRATION);
    assert!(folder.refuse("calibrate mine").contains("(did you mean `mine/calibration.toml`?)"));
    assert!(!folder.refuse("optimize mine").contains("did you mean"));
}

#[test]
fn inputs_too_large_to_compute_are_refused_before_anything_is() {
    let rows: String = (1..=300).map(|force| format!("{force},2,15,0.248,0.002\n")).collect();
    let many = format!("{}\n{rows}", FLAT.lines().next().unwrap());
    let windows = CALIBRATION.replace("persson_rms_slope = 0.0137", "map = \"map.asc\"\nwindows = 200");
    let fine = DESIGN.replace("block_um = 10.0", "block_um = 1.0");
    let place = Place::with(&[
        ("many.toml", &CALIBRATION.replace("flat.csv", "many.csv")),
        ("many.csv", &many),
        ("windows.toml", &windows),
        ("fine.toml", &fine),
        ("measured.toml", &measured(&fine, "c.toml")),
        ("c.toml", CALIBRATION),
        ("flat.csv", FLAT),
    ]);
    place.succeed("synthesize --pixels 256 -o map.asc");
    // Blocks are the design's, also those in which the samples of its calibration are modelled.
    place.refuse_all(
        "calibrate many.toml => error: many.toml: 300 coefficients are to be fitted
         calibrate windows.toml => error: windows.toml: surface.windows: number of windows per side is 200
         optimize fine.toml -o out => sample.block_um: 1.0 um makes confirming runs
         optimize measured.toml => sample.block_um: 1.0 um makes samples of the calibration that take about 12 GiB
         next measured.toml => sample.block_um: 1.0 um makes samples of the calibration that take about 12 GiB
         explore measured.toml => sample.block_um: 1.0 um makes samples of the calibration that take about 12 GiB",
    );
    assert!(!place.path("out").exists() && !place.path("out.study.jsonl").exists());
}

#[test]
fn slips_of_units_and_columns_are_told_before_a_run_is_refused() {
    // Forces of 0.6 and 1 N entered in kN, and friction with its two forces exchanged.
    let header = FLAT.lines().next().unwrap();
    let slips = format!("{header}\n0.0006,20,15,2.5,0.02\n0.001,20,15,2.0,0.02\n");
    let design = measured(DESIGN, "c.toml").replace("speed_mm_s = 2.0", "speed_mm_s = 20.0");
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", &slips), ("d.toml", &design)]);
    for command in ["calibrate c.toml", "optimize d.toml", "next d.toml"] {
        let message = place.refuse(command);
        let refused = message.find("error: flat.csv:").unwrap_or_else(|| panic!("{command}: {message}"));
        // Each once, what concerns a whole column as well.
        for says in
            ["warning: flat.csv:2: force_n: 0.0006 is", "if friction force and normal force stand in each other's"]
        {
            assert!(message.find(says).is_some_and(|told| told < refused), "{command}: {says}\n{message}");
            assert_eq!(message.matches(says).count(), 1, "{message}");
        }
    }
    assert!(!place.refuse("calibrate c.toml -q").contains("warning"));
}

#[test]
fn what_is_unusual_or_doubtful_is_told_by_every_command_that_goes_on() {
    let design = small().replacen("[material]\n", "[material]\nwarnings = [\"slope: odd\"]\n", 1);
    let stiff = SCENE.replace("youngs_modulus_gpa = 0.38", "youngs_modulus_gpa = 380.0");
    let place = Place::with(&[("d.toml", &design), ("s.toml", &stiff), ("usual.toml", SCENE)]);
    assert!(place.told("simulate s.toml").contains("warning: s.toml:2: material.youngs_modulus_gpa: 380.0 is unusual"));
    assert!(!place.told("simulate usual.toml").contains("warning"));
    assert!(place.run("optimize d.toml --details").1.contains("! the material is doubtful: slope: odd\n"));
    assert!(place.run("next d.toml").1.contains("! slope: odd\n"));
    assert!(place.told("explore d.toml -o e.html").contains("warning: the material is doubtful: slope: odd\n"));
    assert!(place.read("e.html").contains("The material is doubtful: slope: odd."));
}

/// Lines and keys of the contradictions between a design with `sample` and a calibration with `specimen`, which replace
/// the layer and extend the specimen.
fn contradictions(sample: &str, specimen: &str) -> Vec<(Option<u32>, String)> {
    let design = measured(&DESIGN.replace("layer_um = 200.0\n", sample), "c.toml");
    let calibration = CALIBRATION.replace("radius_mm = 5.0\n", &format!("radius_mm = 5.0\n{specimen}"));
    let place = Place::with(&[("c.toml", &calibration), ("flat.csv", FLAT), ("d.toml", &design)]);
    let design = Design::read(&disk(), &place.path("d.toml")).unwrap();
    let calibration = Calibration::read(&disk(), &place.path("c.toml")).unwrap();
    let place_of = |told: Diagnostic| (told.line, told.key.unwrap().into_string());
    design.contradictions(&calibration).into_iter().map(place_of).collect()
}

#[test]
fn a_thickness_or_a_holder_that_a_design_does_not_know_is_told() {
    let (thickness, holder) = ("sample.thickness_mm", "sample.holder");
    let held = "thickness_mm = 7.0\nholder = \"rigid\"\n";
    let aligning = "thickness_mm = 7.0\nholder = \"self-aligning\"\n";
    for (sample, specimen, expected) in [
        ("", "thickness_mm = 4.0\n", Some((None, thickness))),
        ("thickness_mm = 6.0\n", "thickness_mm = 4.0\n", Some((Some(26), thickness))),
        ("", held, Some((None, holder))),
        (aligning, held, Some((Some(27), holder))),
        ("thickness_mm = 6.0\n", "thickness_mm = 6.0\n", None),
        ("", "thickness_mm = 7.0\n", None),
        ("", "", None),
        (held, held, None),
        (held, "", None),
        // Nothing tilts a layer alone.
        ("layer_um = 200.0\n", "thickness_mm = 4.0\nholder = \"rigid\"\n", None),
    ] {
        let expected: Vec<_> = expected.into_iter().map(|(line, key)| (line, key.to_owned())).collect();
        assert_eq!(contradictions(sample, specimen), expected, "{sample:?} {specimen:?}");
    }
}

#[test]
fn a_speed_that_no_run_confirms_is_told_as_a_number() {
    let told = |text: &str| -> Vec<String> {
        let document = Document::new("d.toml", text);
        Design::from_document(document).unwrap().told.iter().map(Diagnostic::to_string).collect()
    };
    // v = 0.1 P / sqrt(E rho) = 1.52 mm/s, and 2 mm/s is the speed without a condition.
    let said = told(&DESIGN.replace("[0.65, 2.6]", "[0.1, 2.6]").replace("= 0.38", "= 48.0"));
    assert!(
        said.len() == 2 && said[1].ends_with("expected speed_mm_s of at most 1.5, or higher pressures"),
        "{said:?}"
    );
    assert_eq!(told(DESIGN), [""; 0]);
}
