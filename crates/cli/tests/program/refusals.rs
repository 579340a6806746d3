//! Refused input: exit code 2, a message with file, line and key, and no written files. `tests/golden` keeps the
//! messages about every key and flag.

use crate::common::{CALIBRATION, DESIGN, FLAT, Place, SCENE};

#[test]
fn a_refusal_names_file_line_and_key_and_writes_nothing() {
    let spoiled = [("scene.toml", SCENE, "width_um = 130.0"), ("design.toml", DESIGN, "min_land_um = 40.0")];
    let spoiled = spoiled.into_iter().chain([("calibration.toml", CALIBRATION, "radius_mm = 5.0")]);
    for ((file, good, line), command) in spoiled.zip(["simulate", "optimize", "calibrate"]) {
        let number = good.lines().position(|found| found == line).unwrap() + 1;
        let key = line.split(' ').next().unwrap();
        let folder = Place::with(&[(file, &good.replace(line, &format!("{key} = -1"))), ("flat.csv", FLAT)]);
        let before = folder.names();
        let message = folder.refuse(&[command, file, "-o", "out"]);
        assert!(message.starts_with(&format!("error: {file}:{number}: ")) && message.contains(key), "{message}");
        assert_eq!(folder.names(), before);
    }
}

/// The maximum step named in a refusal is itself accepted.
#[test]
fn the_stability_limit_that_is_named_is_accepted() {
    let dynamic = SCENE.replace("\"steady\"", "\"dynamic\"").replace("sliding_um = 2.0", "step_ns = 20");
    let message = Place::with(&[("scene.toml", &dynamic)]).refuse(&["simulate", "scene.toml"]);
    let most = message.trim_end().rsplit_once("at most ").unwrap().1;
    let accepted = dynamic.replace("step_ns = 20", &format!("sliding_um = 0.01\nstep_ns = {most}"));
    Place::with(&[("scene.toml", &accepted)]).succeed(&["simulate", "scene.toml"]);
}

/// Too slow sliding is refused with its cost and the minimum accepted speed.
#[test]
fn a_row_that_takes_hours_is_refused_with_its_cost() {
    let slow = FLAT.replace("50,2,15", "50,0.0001,15");
    let folder = Place::with(&[("calibration.toml", CALIBRATION), ("flat.csv", &slow)]);
    let message = folder.refuse(&["calibrate", "calibration.toml", "-o", "m.toml"]);
    for said in [
        "error: flat.csv:2: (50 N, 0.0001 mm/s, 15 %): its run in time takes ",
        " hours of one core, and up to twenty times as long",
        "; expected speed_mm_s of at least 0.00",
        ", or this row left out",
    ] {
        assert!(message.contains(said), "{said}: {message}");
    }
}

#[test]
fn a_material_that_is_not_there_is_reported_where_it_is_named() {
    let rest = &SCENE[SCENE.find("[pattern]").unwrap()..];
    let scene = format!("material = \"absent.toml\"\n{rest}");
    let folder = Place::with(&[("scene.toml", &scene)]);
    let message = folder.refuse(&["simulate", "scene.toml"]);
    assert!(
        message.starts_with("error: scene.toml:1: material: \"absent.toml\" (absent.toml) cannot be read"),
        "{message}"
    );

    let scene = format!("material = \"calibration.toml\"\n{rest}");
    let folder = Place::with(&[("scene.toml", &scene), ("calibration.toml", CALIBRATION), ("flat.csv", FLAT)]);
    let message = folder.refuse(&["simulate", "scene.toml"]);
    assert!(
        message.starts_with("error: calibration.toml: seems to be a calibration file, which `slipgrid calibrate` takes; expected a material"),
        "{message}"
    );
}

#[test]
fn conditions_that_were_not_measured() {
    let rest = &SCENE[SCENE.find("[pattern]").unwrap()..];
    let material = "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[friction]\n[[friction.conditions]]\n\
        speed_mm_s = 2.0\nhumidity_pct = 15.0\npressure_mpa = [0.6, 2.4]\nstatic_mean = [0.3, 0.31]\ndynamic_mean = [0.26, 0.28]\n";
    for (head, says) in [
        (
            "material = \"m.toml\"\n",
            "error: scene.toml:1: material: \"m.toml\" the material has coefficients per condition",
        ),
        (
            "material = \"m.toml\"\ncondition = { speed_mm_s = 2.0, humidity_pct = 40.0 }\n",
            "error: scene.toml:2: condition: no coefficients for 2 mm/s at 40 % humidity, which is not between measured ones: the material has 2 mm/s at 15 %",
        ),
        (
            "material = \"m.toml\"\ncondition = { speed_mm_s = 1.0, humidity_pct = 15.0 }\n",
            "error: scene.toml:14: load.speed_mm_s: 2.0 mm/s is more than the speed of the condition",
        ),
    ] {
        let scene = format!("{head}{rest}");
        let folder = Place::with(&[("scene.toml", &scene), ("m.toml", material)]);
        let message = folder.refuse(&["simulate", "scene.toml"]);
        assert!(message.starts_with(says), "{message}");
    }
    let scene = format!("material = \"m.toml\"\ncondition = {{ speed_mm_s = 2.0, humidity_pct = 15.0 }}\n{rest}");
    let folder = Place::with(&[("scene.toml", &scene), ("m.toml", material)]);
    let json: serde_json::Value = folder.json(&["simulate", "scene.toml", "--json"]);
    assert_eq!(json["results"][0]["friction_extrapolated"], false);
    assert_eq!(json["results"][1]["friction_extrapolated"], true);
}

#[test]
fn a_number_of_threads_in_the_environment_is_refused_as_one() {
    let folder = Place::with(&[]);
    let mut command = crate::common::program();
    let ended = command.env("RAYON_NUM_THREADS", "100000").args(["new", "scene", "new.toml"]).output().unwrap();
    let message = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(message.starts_with("error: RAYON_NUM_THREADS: 100000 is no number of threads"), "{message}");
    assert!(ended.status.code() == Some(2) && !folder.path("new.toml").exists());
}
