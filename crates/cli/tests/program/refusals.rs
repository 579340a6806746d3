//! Input that must be refused: exit code 2, file, line and key in the message, nothing written.

use crate::common::{CALIBRATION, DESIGN, FLAT, Place, SCENE};

/// A change to a file, and what the refusal must say after the file's name.
struct Case {
    /// Text to replace.
    from: &'static str,
    /// What stands there instead.
    to: &'static str,
    /// Line and key.
    place: &'static str,
    /// Part of the rest.
    says: &'static str,
}

const fn case(from: &'static str, to: &'static str, place: &'static str, says: &'static str) -> Case {
    Case { from, to, place, says }
}

fn refuse_all(file: &str, good: &str, others: &[(&str, &str)], command: &str, cases: &[Case]) {
    for Case { from, to, place, says } in cases {
        assert!(good.contains(from), "{from}");
        let bad = good.replacen(from, to, 1);
        let mut files = vec![(file, bad.as_str())];
        files.extend(others);
        let folder = Place::with(&files);
        let before = folder.names();
        let message = folder.refuse(&[command, file, "-o", "out"]);
        assert!(message.starts_with(&format!("error: {file}{place}")), "{to}: {message}");
        assert!(message.contains(says), "{to}: {message}");
        assert_eq!(folder.names(), before, "{to}");
    }
}

#[test]
fn scenes() {
    refuse_all(
        "scene.toml",
        SCENE,
        &[],
        "simulate",
        &[
            case("width_um = 130.0", "widht_um = 130.0", ":12: pattern.widht_um: ", "did you mean `width_um`?"),
            case("width_um = 130.0", "width_mm = 0.13", ":12: pattern.width_mm: ", "did you mean `width_um`?"),
            case("width_um = 130.0", "width_um = -130.0", ":12: pattern.width_um: -130.0 ", "from 0.000001"),
            case("width_um = 130.0", "width_um = nan", ":12: pattern.width_um: nan ", "from 0.000001"),
            case("width_um = 130.0", "width_um = inf", ":12: pattern.width_um: inf ", "from 0.000001"),
            case("width_um = 130.0", "width_um = \"wide\"", ":12: pattern.width_um: \"wide\" ", "expected a number"),
            case("width_um = 130.0", "", ":11: pattern.width_um: is missing", ""),
            case(
                "depth_um = 20.0",
                "depth_um = 20.0\ndepth_std_um = 1.0",
                ":15: pattern.depth_std_um: 1.0 has no meaning in a scene",
                "[tolerances] of a design",
            ),
            case("depth_um = 20.0", "depth_um = 200.0", ":14: pattern.depth_um: 200.0 ", "below 200 um"),
            case("\"groove\"", "\"grove\"", ":15: pattern.planform: \"grove\" ", "did you mean `groove`?"),
            case("\"groove\"", "\"rectangle\"", ":11: pattern.length_um: is missing", ""),
            case("\"groove\"", "\"groove\"\nlength_um = 5.0", ":16: pattern.length_um: 5.0 has no", "\"rectangle\""),
            case("\"groove\"", "\"disc\"\nangle_deg = 5", ":16: pattern.angle_deg: 5 has no", "sliding_angle_deg"),
            case("\"groove\"", "\"groove\"\nangle_deg = 91", ":16: pattern.angle_deg: 91 ", "-90 up to 90 degrees"),
            case(
                "\"groove\"",
                "\"square\"\nsliding_angle_deg = nan",
                ":16: pattern.sliding_angle_deg: nan ",
                "-180 up to 180 degrees",
            ),
            case(
                "\"groove\"",
                "\"groove\"\nspacing_across_um = 5.0",
                ":16: pattern.spacing_across_um: 5.0 has no meaning for planform \"groove\"",
                "or no such key",
            ),
            case(
                "\"groove\"",
                "\"square\"\narrangement = \"stagered\"",
                ":16: pattern.arrangement: \"stagered\" is not known",
                "did you mean `staggered`?",
            ),
            case(
                "\"groove\"",
                "\"groove\"\narrangement = \"staggered\"",
                ":16: pattern.arrangement: \"staggered\" has no meaning",
                "\"square\", or planform",
            ),
            case("layer_um = 200.0", "layer_um = 205.0", ":18: sample.layer_um: 205.0 ", "layer_um = 200"),
            case("length_um = 9960.0", "length_um = 3.0", ":17: sample.length_um: 3.0 ", "length_um = 10"),
            case("block_um = 10.0", "block_um = 0", ":19: sample.block_um: 0 ", "from 0.000001"),
            case("block_um = 10.0", "block_um = 0.0001", ":19: sample.block_um: 0.0001 ", "at most 4e7"),
            case("[0.65, 2.6]", "[0.65, 2.6e6]", ":21: load.pressure_mpa: 2.6e6 ", "MPa"),
            case("[0.65, 2.6]", "[0.65, 500]", ":21: load.pressure_mpa: 500 ", "at most 190 MPa"),
            case("[0.65, 2.6]", "[]", ":21: load.pressure_mpa: ", "at least one"),
            case(
                "[0.65, 2.6]",
                "[0.65, 2.6, 0.6500000000000001]",
                ":21: load.pressure_mpa: 0.6500000000000001 ",
                "once",
            ),
            case("[0.65, 2.6]", "-0.1", ":21: load.pressure_mpa: -0.1 ", "from 0"),
            case("speed_mm_s = 2.0", "speed_mm_s = -2.0", ":22: load.speed_mm_s: -2.0 ", "from 0"),
            case("speed_mm_s = 2.0", "", ":20: load.speed_mm_s: is missing", ""),
            case(
                "youngs_modulus_gpa = 0.38",
                "youngs_modulus_gpa = 380e6",
                ":2: material.youngs_modulus_gpa: ",
                "1250 GPa",
            ),
            case("density_g_cm3 = 0.9", "density_g_cm3 = 900", ":3: material.density_g_cm3: 900 ", "23 g/cm3"),
            case("relative_std = 0.05", "relative_std = 5", ":7: material.friction.relative_std: 5 ", "0.5"),
            case(
                "static_mean = 0.30",
                "static_mean = [0.30, 0.31]",
                ":5: material.friction.static_mean: ",
                "pressure_mpa",
            ),
            case(
                "static_mean = 0.30",
                "pressure_mpa = [0.65, 2.6]\nstatic_mean = [0.3]",
                ":6: material.friction.static_mean: ",
                "2, one for each",
            ),
            case("dynamic_mean = 0.27\n", "", ":4: material.friction.dynamic_mean: is missing", ""),
            case("[1.0, 0.96, 0.90, 0.60]", "[1.0, 0.96]", ":10: material.area_law.factor: ", "4, one for each"),
            case("[1.0, 0.96, 0.90, 0.60]", "[1.0, 0.96, nan, 0.60]", ":10: material.area_law.factor: nan ", "from 0"),
            case("[0.7, 1.3, 2.6, 10.0]", "[0.7, 2.6, 1.3, 10.0]", ":9: material.area_law.pressure_mpa: ", "increase"),
            case(
                "\"steady\"",
                "\"stead\"",
                ":24: run.fidelity: \"stead\" ",
                "\"steady\" or \"dynamic\" or \"reference\"",
            ),
            case("\"cell\"", "\"whole\"", ":25: run.extent: \"whole\" ", "\"cell\" or \"sample\""),
            case("seed = 1", "seed = -1", ":26: run.seed: -1 ", "whole number"),
            case("seed = 1", "seed = 1.5", ":26: run.seed: 1.5 ", "whole number"),
            case("seed = 1", "dimensions = 4", ":26: run.dimensions: 4 ", "2 or 3"),
            case("\"steady\"", "\"reference\"\ndimensions = 3", ":25: run.dimensions: 3 ", "\"dynamic\""),
            case("seed = 1", "draws = 0", ":26: run.draws: 0 ", "from 1 to 64"),
            case("seed = 1", "draws = 65", ":26: run.draws: 65 ", "from 1 to 64"),
            case("seed = 1", "draws = 1.5", ":26: run.draws: 1.5 ", "whole number"),
            case("seed = 1", "liftoff = 1", ":26: run.liftoff: 1 ", "true or false"),
            case("seed = 1", "seed = 1\nseed = 2", ":27: run.seed: ", "the first stands in line 26"),
            case("seed = 1", "seed = = 1", ":26: ", ""),
            case("[run]", "[runn]", ":23: runn: ", "did you mean `run`?"),
            case("[material]", "[other]\n[material]", ":1: other: ", "is not a known key"),
        ],
    );
}

#[test]
fn scenes_in_the_vertical_plane() {
    let asked = format!("{SCENE}dimensions = 2\n");
    let dynamic = SCENE.replace("\"steady\"", "\"dynamic\"").replace("\"cell\"", "\"sample\"");
    for scene in [&asked, &dynamic] {
        let cases = [
            case("\"groove\"", "\"disc\"", ":15: pattern.planform: \"disc\" needs three dimensions", "\"square\""),
            case(
                "\"groove\"",
                "\"groove\"\nangle_deg = 45.0",
                ":16: pattern.angle_deg: 45.0 needs three dimensions",
                "expected 0",
            ),
        ];
        refuse_all("scene.toml", scene, &[], "simulate", &cases);
    }
}

#[test]
fn what_a_solver_refuses_is_reported_in_the_units_of_the_file() {
    let dynamic = SCENE.replace("\"steady\"", "\"dynamic\"").replace("sliding_um = 2.0", "step_ns = 20");
    let small = dynamic.replace("step_ns = 20", "").replace("block_um = 10.0", "block_um = 0.5");
    let reference = small.replace("\"dynamic\"", "\"reference\"").replace("length_um = 9960.0", "length_um = 1000.0");
    let wide = SCENE.replace("130.0", "9e6").replace("370.0", "9e6").replace("layer_um = 200.0", "layer_um = 500.0");
    let shallow = SCENE.replace("layer_um = 200.0", "").replace("depth_um = 20.0", "depth_um = 200");
    for (scene, says) in [
        (&dynamic, "scene.toml:27: run.step_ns: 20 is beyond the stability limit of the leapfrog, 11.7"),
        (
            &reference,
            "scene.toml:19: sample.block_um: 0.5 um brings the stability limit of the Runge-Kutta method below",
        ),
        (&wide, "scene.toml:12: pattern.width_um: 9e6 and the spacing make a pitch of 18000000 um; expected"),
        (&shallow, "scene.toml:14: pattern.depth_um: 200 um leaves nothing of the layer of 200 um; expected"),
    ] {
        let message = Place::with(&[("scene.toml", scene)]).refuse(&["simulate", "scene.toml"]);
        assert!(message.starts_with(&format!("error: {says}")), "{message}");
    }
    // What is named as the most is accepted.
    let message = Place::with(&[("scene.toml", &dynamic)]).refuse(&["simulate", "scene.toml"]);
    let most = message.trim_end().rsplit_once("at most ").unwrap().1;
    let accepted = dynamic.replace("step_ns = 20", &format!("sliding_um = 0.01\nstep_ns = {most}"));
    Place::with(&[("scene.toml", &accepted)]).succeed(&["simulate", "scene.toml"]);
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
        speed_mm_s = 2.0\nhumidity_pct = 15.0\npressure_mpa = [0.6, 2.5]\nstatic_mean = [0.3, 0.31]\ndynamic_mean = [0.26, 0.28]\n";
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
    let json: serde_json::Value = serde_json::from_str(&folder.succeed(&["simulate", "scene.toml", "--json"])).unwrap();
    assert_eq!(json["results"][0]["friction_extrapolated"], false);
    assert_eq!(json["results"][1]["friction_extrapolated"], true);
}

#[test]
fn designs() {
    refuse_all(
        "design.toml",
        DESIGN,
        &[],
        "optimize",
        &[
            case("\"groove\"", "\"rectangle\"", ":20: pattern.length_um: is missing", ""),
            case(
                "\"groove\"",
                "\"square\"\nspacing_across_um = 39.9",
                ":22: pattern.spacing_across_um: 39.9 is below limits.min_land_um",
                "at least 40 um",
            ),
            case("planform =", "planfrom =", ":21: pattern.planfrom: ", "did you mean `planform`?"),
            case("[40.0, 400.0]", "[400.0, 40.0]", ":17: bounds.width_um: [400.0, 40.0] ", "[smallest, largest]"),
            case("[40.0, 400.0]", "[40.0]", ":17: bounds.width_um: ", "[smallest, largest]"),
            case("[40.0, 400.0]", "[10.0, 20.0]", ":17: bounds.width_um: ", "at least 23 um"),
            case("[40.0, 1000.0]", "[5.0, 30.0]", ":18: bounds.spacing_um: ", "at least 40 um"),
            case("[2.0, 50.0]", "[2.0, 2.5]", ":19: bounds.depth_um: ", "multiple of 2.6 um"),
            case("[2.0, 50.0]", "[2.0, 200.0]", ":19: bounds.depth_um: ", "below 200 um"),
            case("[2.0, 50.0]", "[-2.0, 50.0]", ":19: bounds.depth_um: -2.0 ", "from 0.000001"),
            case("\"ratio\"", "\"ration\"", ":12: target.quantity: \"ration\" ", "did you mean `ratio`?"),
            case("value = 0.9", "value = [0.9, 0.8, 0.7]", ":14: target.value: ", "2, one for each"),
            case("value = 0.9", "value = -0.9", ":14: target.value: -0.9 ", "above 0"),
            case("[0.65, 2.6]", "[2.6, 2.6]", ":13: target.pressure_mpa: ", "once"),
            case("tolerance = 0.01", "tolerance = 0", ":15: target.tolerance: 0 ", "above 0"),
            case("tolerance = 0.01", "tolerance = [0.01]", ":15: target.tolerance: ", "2, one for each"),
            case("tolerance = 0.01", "", ":11: target.tolerance: is missing", "up to 1"),
            case(
                "tolerance = 0.01",
                "tolerance = 0.01\nlowest = 0.8",
                ":16: target.lowest: 0.8 stands beside value",
                "or",
            ),
            case("value = 0.9\ntolerance = 0.01", "", ":11: target.value: is missing", "goal"),
            case("value = 0.9\ntolerance = 0.01", "goal = \"low\"", ":14: target.goal: \"low\" ", "\"lowest\""),
            case(
                "value = 0.9\ntolerance = 0.01",
                "lowest = 0.9\nhighest = [0.95, 0.85]",
                ":15: target.highest: ",
                "band",
            ),
            case("value = 0.9", "goal = \"lowest\"", ":15: target.tolerance: 0.01 has nothing", "beside"),
            case("[0.65, 2.6]\nvalue = 0.9\ntolerance = 0.01", "2.6\ngoal = \"even\"", ":11: target: ", "at least two"),
            case("value = 0.9", "value = 0.9\nweights = [1.0, 0.0]", ":15: target.weights: 0.0 ", "above 0"),
            case("[limits]", "[limits]\nmin_bearing_area = 40.0", ":23: limits.min_bearing_area: 40.0 ", "up to 1"),
            case("[limits]", "[limits]\nlift_off = \"no\"", ":23: limits.lift_off: \"no\" ", "\"refuse\""),
            case("[limits]", "[limits]\nmax_laser_time_s = 60.0", ":23: limits.max_laser_time_s: ", "repetition_hz"),
            case("seed = 1", "max_seconds = -1.0", ":36: search.max_seconds: -1.0 ", "from 0"),
            case("\"disc\"", "\"rectangle\"", ":31: specimen.diameter_mm", ""),
            case("diameter_mm = 10.0", "", ":29: specimen.diameter_mm: is missing", ""),
            case("seed = 1", "dimensions = 4", ":36: search.dimensions: 4 ", "2 or 3"),
            case("[limits]", "[limit]", ":22: limit: ", "did you mean `limits`?"),
            case("[target]", "[target]\nunit = 1", ":12: target.unit: ", "is not a known key"),
        ],
    );
}

#[test]
fn walls_that_meet_above_every_floor() {
    let narrow = DESIGN.replace("[40.0, 400.0]", "40.0").replace("[2.0, 50.0]", "[45.0, 50.0]");
    let cases = [case(
        "spot_um = 23.0",
        "spot_um = 23.0\nwall_taper_deg = 30.0",
        ":29: laser.wall_taper_deg: ",
        "at most 23.9",
    )];
    refuse_all("design.toml", &narrow, &[], "optimize", &cases);
}

#[test]
fn calibrations() {
    let with_table = &[("flat.csv", FLAT)];
    refuse_all(
        "calibration.toml",
        CALIBRATION,
        with_table,
        "calibrate",
        &[
            case("\"flat.csv\"", "\"flt.csv\"", ":12: measurements.flat: \"flt.csv\" ", "cannot be read"),
            case(
                "persson_rms_slope = 0.0137",
                "map = \"absent.asc\"",
                ":8: surface.map: \"absent.asc\" ",
                "cannot be read",
            ),
            case(
                "persson_rms_slope = 0.0137",
                "persson_rms_slope = 0",
                ":8: surface.persson_rms_slope: 0 ",
                "from 0.0000001",
            ),
            case("persson_rms_slope = 0.0137", "", ":7: surface.map: is missing", "persson_rms_slope"),
            case("radius_mm = 5.0", "radius_um = 5.0", ":10: specimen.radius_um: ", "did you mean `radius_mm`?"),
            case(
                "\"per-condition\"",
                "\"both\"",
                ":14: fit.coefficients: \"both\" ",
                "\"single\" or \"per-condition\"",
            ),
            case("source = \"nowhere\"\n", "", ":1: source: is missing", "a text, such as source ="),
        ],
    );
    // How a map is read; the map itself is not opened before its keys are understood.
    for (line, place, says) in [
        ("height_unit = \"inch\"", ":9: surface.height_unit: \"inch\" ", "m, cm, mm, um, nm, pm"),
        ("pixel_y_um = 0.5", ":9: surface.pixel_y_um: 0.5 ", "`pixel_um`"),
        ("crop = [0, 0, 1, 5]", ":9: surface.crop: [0, 0, 1, 5] ", "from 2 up"),
        ("crop = [0, 0, 5]", ":9: surface.crop: [0, 0, 5] ", "[0, 0, 512, 512]"),
        ("crop = [-1, 0, 5, 5]", ":9: surface.crop", ""),
        ("decimate = 0", ":9: surface.decimate: 0 ", "from 1 up"),
        ("decimate_by = \"pick\"", ":9: surface.decimate_by: \"pick\" ", "`decimate`"),
        ("decimate = 2\ndecimate_by = \"mode\"", ":10: surface.decimate_by: \"mode\" ", "\"mean\" or \"pick\""),
        ("missing = \"ignore\"", ":9: surface.missing: \"ignore\" ", "\"fill\" or \"refuse\""),
        ("form = \"plain\"", ":9: surface.form: \"plain\" ", "did you mean `plane`?"),
        ("form = \"plane\"\nlevel = true", ":10: surface.level: true ", "either `form` or `level`"),
    ] {
        let bad = CALIBRATION.replace("persson_rms_slope = 0.0137", &format!("map = \"flat.csv\"\n{line}"));
        let folder = Place::with(&[("calibration.toml", &bad), ("flat.csv", FLAT)]);
        let message = folder.refuse(&["calibrate", "calibration.toml", "-o", "m.toml"]);
        assert!(message.starts_with(&format!("error: calibration.toml{place}")), "{line}: {message}");
        assert!(message.contains(says), "{line}: {message}");
        assert_eq!(folder.names(), ["calibration.toml", "flat.csv"]);
    }
    let folder = Place::with(&[("calibration.toml", CALIBRATION), ("flat.csv", &FLAT.replace("0.248", "24.8"))]);
    let message = folder.refuse(&["calibrate", "calibration.toml", "-o", "m.toml"]);
    assert!(message.starts_with("error: flat.csv:2: mu_dynamic: \"24.8\" is out of range"), "{message}");
    assert_eq!(folder.names(), ["calibration.toml", "flat.csv"]);
    // The cost of slow sliding, and the speed from which on it is borne.
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
fn lengths_that_nothing_can_have_are_refused_with_their_line() {
    let (specimen, limits) = ("\ndiameter_mm = ", "\n[limits]\n");
    let design = |from: &str, to: &str| DESIGN.replacen(from, to, 1);
    for (text, says) in [
        (
            design(specimen, "\ndiameter_mm = 5e-324 #"),
            "specimen.diameter_mm: 5e-324 is out of range; expected a number from 0.000001 up to",
        ),
        (
            design(specimen, "\ncavities = \"clipped\"\ndiameter_mm = 0.01 #"),
            "specimen: has a diameter of 10 um, of blocks of ",
        ),
        (design(limits, "\n[limits]\nmin_land_um = 5e-324 #"), "limits.min_land_um: 5e-324 is out of range"),
    ] {
        let place = Place::with(&[("design.toml", &text)]);
        let message = place.refuse(&["optimize", "design.toml"]);
        assert!(message.starts_with("error: design.toml:") && message.contains(says), "{message}");
    }
}

/// Keys of earlier versions are refused with what does their work now.
#[test]
fn keys_that_are_gone() {
    let tolerances = format!("{DESIGN}[tolerances]\nwidth_std_um = 1.0\ndraws = 100\n");
    let after = |line: &str, key: &str| DESIGN.replace(line, &format!("{line}\n{key}"));
    for (text, place, instead) in [
        (
            after("tolerance = 0.01", "discrepancy = true"),
            ":16: target.discrepancy: ",
            "chances and expected values always have what trials say that the model lacks",
        ),
        (after("seed = 1", "robust = true"), ":37: search.robust: ", "textures are chosen by the chance"),
        (after("seed = 1", "max_evaluations = 50"), ":37: search.max_evaluations: ", "max_seconds limits the time"),
        (tolerances, ":39: tolerances.draws: ", "what is expected of samples is computed without draws"),
    ] {
        let folder = Place::with(&[("design.toml", &text)]);
        for command in ["optimize", "next", "explore"] {
            let message = folder.refuse(&[command, "design.toml"]);
            assert!(message.starts_with(&format!("error: design.toml{place}")), "{message}");
            assert!(message.contains("is no longer a key; expected no such line: "), "{message}");
            assert!(message.contains(instead), "{message}");
        }
        assert_eq!(folder.names(), ["design.toml"]);
    }
}
