//! A simulated laboratory with an unmeasured rim cuts the samples that `next` proposes, measures them, and is on target
//! within three cuts.

use std::fmt::Write as _;
use std::fs;

use crate::common::{CALIBRATION, DESIGN, Place, SCENE, correction, measured, result};
use serde_json::Value;

/// Forces, in newtons, with pressures of 0.64 to 2.55 MPa on the disc, and the flat sample's friction.
const FORCES_N: [f64; 3] = [50.0, 100.0, 200.0];
const MU_FLAT: [f64; 3] = [0.248, 0.262, 0.270];
const TOLERANCE: f64 = 0.02;

fn table(ratios: [f64; 3]) -> String {
    let mut text = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n".to_owned();
    for place in 0..3 {
        writeln!(text, "{},2,15,{:.5},0.001", FORCES_N[place], MU_FLAT[place] * ratios[place]).unwrap();
    }
    text
}

fn place() -> Place {
    let place = Place::with(&[("flat.csv", &table([1.0; 3])), ("calibration.toml", CALIBRATION)]);
    place.succeed(&["calibrate", "calibration.toml", "-o", "m.toml", "-q"]);
    place
}

/// True ratios of grooves of these lengths, which have the rim.
fn truth(place: &Place, [width_um, spacing_um, depth_um]: [f64; 3]) -> [f64; 3] {
    let area_m2 = std::f64::consts::PI * 25e-6;
    let pressures: Vec<String> = FORCES_N.iter().map(|force_n| (force_n / area_m2 / 1e6).to_string()).collect();
    let material = "material = \"m.toml\"\ncondition = { speed_mm_s = 2.0, humidity_pct = 15.0 }\n";
    let rest = &SCENE[SCENE.find("[sample]").unwrap()..];
    let rest = rest.replace("pressure_mpa = [0.65, 2.6]", &format!("pressure_mpa = [{}]", pressures.join(", ")));
    let rest = rest.replace("speed_mm_s = 2.0\n", "");
    let scene = format!(
        "{material}[pattern]\nplanform = \"groove\"\nwidth_um = {width_um}\nspacing_um = {spacing_um}\ndepth_um = {depth_um}\n\
         rim_height_um = 0.2\nrim_width_um = 20.0\n{rest}"
    );
    place.write("truth.toml", scene);
    let found: Value = place.json(&["simulate", "truth.toml", "--json"]);
    let ratio = |row: usize| found["results"][row]["ratio"].as_f64().unwrap();
    [ratio(0), ratio(1), ratio(2)]
}

fn design(target: [f64; 3]) -> String {
    measured(DESIGN, "calibration.toml")
        .replace("test design", "three cuts")
        .replace("pressure_mpa = [0.65, 2.6]", "pressure_mpa = [0.63662, 1.27324, 2.54648]")
        .replace("value = 0.9\n", &format!("value = [{:.4}, {:.4}, {:.4}]\n", target[0], target[1], target[2]))
        .replace("tolerance = 0.01", &format!("tolerance = {TOLERANCE}"))
        .replace("depth_um = [2.0, 50.0]", "depth_um = [10.4, 10.4]")
        .replace("[40.0, 400.0]", "[60.0, 200.0]")
        .replace("[40.0, 1000.0]", "[100.0, 500.0]")
        // Flat samples of the calibration are run in a third of the time.
        .replace("diameter_mm = 10.0", "diameter_mm = 3.0")
}

fn next(place: &Place, more: &[&str]) -> Value {
    let args = [&["next", "design.toml", "--json", "-q"], more].concat();
    place.json(&args)
}

fn lengths(of: &Value) -> [f64; 3] {
    ["width_um", "spacing_um", "depth_um"].map(|key| of["design"][key].as_f64().unwrap())
}

fn trial(name: &str, [width_um, spacing_um, depth_um]: [f64; 3], measurements: &str) -> String {
    format!(
        "[[trial]]\nname = \"{name}\"\ndate = \"2026-11-22\"\n{measurements}width_std_um = 2.0\n[trial.pattern]\n\
         planform = \"groove\"\nwidth_um = {width_um}\nspacing_um = {spacing_um}\ndepth_um = {depth_um}\n"
    )
}

/// Adds the trial A with these ratios and `keys` to the calibration.
fn add_trial(place: &Place, ratios: [f64; 3], keys: &str) {
    let own = trial("A", [100.0, 200.0, 10.4], &format!("measurements = \"a.csv\"\n{keys}"));
    place.write("a.csv", table(ratios));
    place.write("calibration.toml", format!("{CALIBRATION}\n{own}"));
}

#[test]
#[ignore = "takes ten to twenty seconds of both cores"]
fn a_hidden_rim_is_on_target_within_three_cuts() {
    let place = place();
    let target = truth(&place, [120.0, 330.0, 10.4]);
    place.write("design.toml", design(target));
    let mut calibration = CALIBRATION.to_owned();
    let mut cuts = Vec::new();
    loop {
        place.write("calibration.toml", &calibration);
        let found = next(&place, &[]);
        assert_eq!(found["trials"], cuts.len());
        assert!(found["compared"].as_u64().unwrap() > 500);
        let lengths = lengths(&found["samples"][0]);
        assert!(!cuts.contains(&lengths), "never a texture that was cut: {cuts:?}");
        cuts.push(lengths);
        let made = truth(&place, lengths);
        if made.iter().zip(target).all(|(made, target)| (made - target).abs() <= TOLERANCE) {
            break;
        }
        assert!(cuts.len() < 3, "{cuts:?}");
        let name = format!("cut-{}", cuts.len());
        place.write(&format!("{name}.csv"), table(made));
        calibration += &trial(&name, lengths, &format!("measurements = \"{name}.csv\"\n"));
    }
    assert!(cuts.len() > 1, "what nobody measured was guessed at once: the truth is too easy");
    // The ledger: what was believed before the first cut, and how that changed.
    let ledger = place.succeed(&["trials", "calibration.toml", "-o", "ledger"]);
    assert!(ledger.contains("cut-1") && ledger.contains("predicted by the trials before it"), "{ledger}");
    let files = "friction-sheet.md report.html result.json result.jsonld timings.json trials.csv trials.svg";
    assert_eq!(place.listed("ledger"), files);
    let ledger = result(&place, "ledger");
    let before = &ledger["trials"][0]["measured"][0]["before"];
    let [low, high] = [0, 1].map(|end| before["interval_95"][end].as_f64().unwrap());
    assert!(high / low > 1.5, "before the first trial nothing is known: {low} {high}");
}

#[test]
#[ignore = "takes ten to twenty seconds of both cores"]
fn several_samples_complement_each_other_and_those_that_are_pending() {
    let place = place();
    place.write("design.toml", design([0.85, 0.83, 0.8]));
    let alone = next(&place, &["--count", "3", "--candidate", "100,300,10.4", "-o", "out"]);
    let chances = |found: &Value| -> Vec<f64> {
        found["samples"].as_array().unwrap().iter().map(|next| next["chance"].as_f64().unwrap()).collect()
    };
    let together = alone["one_on_target"].as_f64().unwrap();
    assert!(alone["samples"].as_array().unwrap().len() == 3 && together > chances(&alone)[0] - 0.02, "{alone}");
    assert_eq!(lengths(&alone["own"][0]), [100.0, 300.0, 10.4]);
    for n in 1..=3 {
        assert!(place.listed(&format!("out/next-{n}")).contains("pattern.dxf"));
    }
    // Each listed sample can be drawn for the laser: the first by default, then the others, those asked for, and the rest.
    place.succeed(&["export", "out/result.json", "--format", "corners,process"]);
    for (sample, of) in [("1", &alone["samples"][0]), ("3", &alone["samples"][2]), ("4", &alone["own"][0])] {
        let folder = format!("laser-{sample}");
        place.succeed(&["export", "out", "--sample", sample, "--format", "process,stl", "-o", &folder]);
        let sheet = place.toml(&format!("{folder}/process.toml"));
        let of_sheet = |key: &str| sheet["pattern"][key].as_float().unwrap();
        assert_eq!([of_sheet("width_um"), of_sheet("spacing_um"), of_sheet("depth_um")], lengths(of));
        if sample != "4" {
            let beside = place.read(&format!("out/next-{sample}/process.toml"));
            assert_eq!(beside, place.read(&format!("{folder}/process.toml")));
        }
    }
    for number in ["0", "99"] {
        let said = place.refuse(&["export", "out", "--sample", number]);
        assert!(said.contains(&format!("has no sample {number}, but 1 to ")), "{said}");
    }
    // The first of them pending, another comes next, and together they are as good as two at once.
    let pending = format!("{CALIBRATION}{}", trial("first", lengths(&alone["samples"][0]), ""));
    place.write("calibration.toml", pending);
    let after = next(&place, &[]);
    assert_eq!((after["pending"].as_u64(), after["trials"].as_u64()), (Some(1), Some(0)));
    assert_ne!(lengths(&after["samples"][0]), lengths(&alone["samples"][0]));
    assert!(after["one_on_target"].as_f64().unwrap() >= chances(&alone)[0] - 0.02, "{after}");
}

/// Two samples of one texture whose measurements contradict each other are reported once.
#[test]
fn samples_of_one_texture_that_contradict_each_other_are_named_once() {
    let place = place();
    let mut calibration = CALIBRATION.to_owned();
    for (name, ratio) in [("cut-1", 0.84), ("cut-2", 0.98)] {
        let file = format!("{name}.csv");
        place.write(&file, table([ratio; 3]));
        calibration += &trial(name, [150.0, 300.0, 12.0], &format!("measurements = \"{file}\"\n"));
    }
    place.write("pair.toml", calibration);
    for command in ["calibrate", "trials"] {
        let said = place.succeed(&[command, "pair.toml", "-o", command]);
        assert_eq!(said.matches("contradicting samples: \"cut-1\" and \"cut-2\"").count(), 1, "{said}");
    }
}

/// A ratio requires a flat sample at the same force, speed and humidity; rows without one are reported.
#[test]
fn rows_of_a_trial_without_a_flat_partner_are_named() {
    let rows = table([0.9; 3]);
    let place = Place::with(&[("flat.csv", &table([1.0; 3]))]);
    add_trial(&place, [0.9; 3], "");
    place.write("a.csv", rows.replace("\n100,2,", "\n141,2,"));
    let told = place.told(&["trials", "calibration.toml"]);
    let says = "a.csv:3: force_n: 141 has no flat sample beside it, measured at 141 N, 2 mm/s, 15 %";
    assert!(told.contains(says), "{told}");
    place.write("a.csv", rows.replace(",2,15,", ",2,40,"));
    let told = place.refuse(&["trials", "calibration.toml"]);
    assert!(told.contains("a.csv:2") && told.contains("50 N, 2 mm/s, 15 %"), "{told}");
}

/// A misplaced decimal point in a measurement is reported with the resulting ratio and a correction.
#[test]
fn a_ratio_that_is_hardly_meant_is_named_with_its_line() {
    let place = Place::with(&[("flat.csv", &table([1.0; 3]))]);
    add_trial(&place, [8.2, 0.88, 0.86], "");
    let said = place.succeed(&["trials", "calibration.toml"]);
    assert!(
        said.contains(
            "! measured ratio: a.csv:2: mu_dynamic: 2.0336 (8.200 times 0.248 of the flat sample, flat.csv:2)"
        ),
        "{said}"
    );
    assert!(said.contains("it would be 0.82") && said.matches("! measured ratio").count() == 1, "{said}");
    // One texture: nothing was predicted by a trial, and nothing is said of the form.
    assert!(said.contains("predicted by the trials before it: 3 ratios are not counted, because"), "{said}");
    assert!(
        said.contains("one texture does not tell whether the error grows") && said.contains(" to above 2 "),
        "{said}"
    );
}

/// A material file is reported as outdated if its calibration has a trial that was added later.
#[test]
fn a_material_is_told_from_its_calibration_that_has_changed_since() {
    let place = place();
    place.write(
        "design.toml",
        design([0.85, 0.83, 0.8])
            .replace("[60.0, 200.0]", "120.0")
            .replace("[100.0, 500.0]", "300.0")
            .replace("\"calibration.toml\"", "\"m.toml\""),
    );
    let scene =
        "material = \"m.toml\"\ncondition = { speed_mm_s = 2.0, humidity_pct = 15.0 }\n[load]\npressure_mpa = 1.0\n";
    place.write("scene.toml", scene);
    let told = || place.told(&["simulate", "scene.toml"]);
    assert!(!told().contains("has changed since"));
    add_trial(&place, [0.9, 0.88, 0.86], "");
    for said in [told(), place.told(&["next", "design.toml"])] {
        assert!(said.contains("m.toml: was made from calibration.toml, which has changed since"), "{said}");
        assert!(said.contains("slipgrid calibrate calibration.toml -o m.toml"), "{said}");
    }
    // Made again it knows the trial; a row that is corrected in its table counts as a change too.
    place.succeed(&["calibrate", "calibration.toml", "-o", "m.toml", "-q"]);
    assert!(!told().contains("has changed since"));
    place.write("a.csv", table([0.9, 0.88, 0.87]));
    assert!(told().contains("has changed since"));
    // However the calibration is named, and though the folder of the material is made only now.
    let absolute = place.path("calibration.toml").display().to_string();
    for (calibration, output, way) in [
        (absolute.as_str(), "m.toml", "calibration = \"calibration.toml\""),
        (absolute.as_str(), "new/m.toml", "calibration = \"../calibration.toml\""),
        ("calibration.toml", "newer/m.toml", "calibration = \"../calibration.toml\""),
    ] {
        place.succeed(&["calibrate", calibration, "-o", output, "-q"]);
        let text = place.read(output);
        assert!(text.contains("[made_from]") && text.contains(way), "{text}");
    }
    // A calibration that went elsewhere is not missed.
    fs::remove_file(place.path("calibration.toml")).unwrap();
    assert!(!told().contains("has changed since"));
}

/// A trial is compared with its own lengths and is named; two rows of one condition are not two ratios.
#[test]
fn a_trial_that_is_compared_is_named_and_has_its_own_lengths() {
    let place = place();
    // A sector of a disc, which is modelled as endless, as what is compared is.
    add_trial(&place, [0.9, 0.88, 0.86], "disc = \"one\"\n");
    let validate = ["validate", "calibration.toml", "--trial", "A"];
    let said = place.refuse(&[&validate[..], &["--depth-um", "20"]].concat());
    assert!(said.contains("--depth-um: 20 stands beside the trial \"A\""), "{said}");
    place.succeed(&[&validate[..], &["--sliding-um", "0", "-o", "out"]].concat());
    let result = crate::common::result(&place, "out");
    assert_eq!((&result["trial"], &result["cut_as"]), (&"A".into(), &"groove".into()));
    // The published layer and squares are no part of it: the whole height of the specimen is modelled, as `trials` does.
    assert_eq!(result["thickness_mm"], 7.0);
    assert!(!place.path("out/friction.svg").exists(), "without a run in time");
    let page = place.read("out/report.html");
    assert!(page.contains("Compared is the trial") && page.contains("the whole specimen, 7 mm high"));
    let said = place.succeed(&validate);
    assert!(said.contains("of the measured reduction: the rest comes from elsewhere"), "{said}");
    for text in [&page, &said] {
        assert!(!text.contains("square"), "{text}");
    }
    let ledger: serde_json::Value = place.json(&["trials", "calibration.toml", "--json"]);
    let by_trials = ledger["trials"][0]["measured"].as_array().unwrap();
    for (own, row) in by_trials.iter().zip(result["results"].as_array().unwrap()) {
        let modelled = row["modelled"].as_array().unwrap();
        let given = modelled.iter().find(|modelled| modelled["slope_factor"] == 1.0).unwrap();
        let [own, here] = [&own["modelled"], &given["ratio_groove"]].map(|ratio| ratio.as_f64().unwrap());
        // Smaller blocks of `trials` are the difference, and what time adds, which is some thousandths.
        assert!((own - here).abs() < 0.015, "{own} {here}");
    }
    // Without any there is nothing to compare.
    place.write("flat-alone.toml", CALIBRATION);
    let said = place.refuse(&["validate", "flat-alone.toml"]);
    assert!(said.contains("has no measured sample with a pattern") && said.contains("[[trial]]"), "{said}");
    let rows = table([0.9, 0.88, 0.86]);
    let again = rows.lines().last().unwrap();
    place.write("a.csv", format!("{rows}{again}\n"));
    let said = place.refuse(&["trials", "calibration.toml"]);
    assert!(said.contains("% again, as line 4 has"), "{said}");
}

/// A trial with the friction of its confirming run has no discrepancy: both include the change in time, the margins of
/// the face and the correction for smaller blocks.
#[test]
fn a_sample_that_slides_as_it_was_confirmed_lacks_nothing() {
    let place = place();
    let area_m2 = std::f64::consts::PI * 25e-6;
    let pressures: Vec<String> = FORCES_N.iter().map(|force_n| (force_n / area_m2 / 1e6).to_string()).collect();
    let scene = format!(
        "material = \"m.toml\"\ncondition = {{ speed_mm_s = 2.0, humidity_pct = 15.0 }}\n\
         [pattern]\nplanform = \"groove\"\nwidth_um = 100\nspacing_um = 200\ndepth_um = 10.4\n\
         [specimen]\nshape = \"disc\"\ndiameter_mm = 10.0\n[sample]\nlayer_um = 200.0\nblock_um = 10.0\nthickness_mm = 7.0\n\
         [load]\npressure_mpa = [{}]\n[run]\nfidelity = \"dynamic\"\nextent = \"sample\"\nseed = 2\nsliding_um = 0.1\nwarm_start = true\n\
         mu_stderr = 0.001\nrefine = true\n",
        pressures.join(", ")
    );
    place.write("confirmed.toml", scene);
    let found: Value = place.json(&["simulate", "confirmed.toml", "--json"]);
    let ratio = |key: &str| [0, 1, 2].map(|row| found["results"][row][key].as_f64().unwrap());
    let time = |row: usize| correction(&found["results"][row], "sliding in time").unwrap()["change"].as_f64().unwrap();
    let (confirmed, by_time) = (ratio("ratio"), [0, 1, 2].map(time));
    add_trial(&place, confirmed, "");
    let ledger: Value = place.json(&["trials", "calibration.toml", "--json"]);
    for (row, (confirmed, by_time)) in confirmed.into_iter().zip(by_time).enumerate() {
        let modelled = ledger["trials"][0]["measured"][row]["modelled"].as_f64().unwrap();
        // Two runs in time, of blocks drawn anew: each within its error.
        assert!((modelled - confirmed).abs() < 0.0015 && by_time > 0.003, "{row}: {modelled} {confirmed} {by_time}");
    }
}

/// A pending sample is predicted at the conditions of the flat measurements.
#[test]
fn a_pending_sample_stands_in_the_ledger_with_what_is_predicted() {
    let calibration = format!("{CALIBRATION}\n{}", trial("to come", [100.0, 200.0, 10.4], ""));
    let place = Place::with(&[("flat.csv", &table([1.0; 3])), ("calibration.toml", &calibration)]);
    let said = place.succeed(&["trials", "calibration.toml", "-o", "ledger"]);
    assert!(said.contains("pending: cut and not yet measured") && said.contains("to come    0.333"), "{said}");
    let page = place.read("ledger/report.html");
    assert!(page.contains("Pending: cut and not yet measured"));
}

/// Trials on specimens of another size are matched by pressure: a pin of 2 mm radius needs 0.16 times the force of a
/// disc of 5 mm radius, and forces are set in round numbers.
#[test]
fn forces_on_a_sample_of_another_size_count_by_their_pressure() {
    let rows = table([0.9, 0.88, 0.86]);
    let rounded = rows.replace("\n50,2,", "\n8.03,2,").replace("\n100,2,", "\n16,2,").replace("\n200,2,", "\n32,2,");
    let ledger = |rows: &str, specimen: &str| {
        let keys = format!("measurements = \"a.csv\"\n{specimen}");
        let calibration = format!("{CALIBRATION}\n{}", trial("A", [100.0, 200.0, 10.4], &keys));
        let place = Place::with(&[("flat.csv", &table([1.0; 3])), ("calibration.toml", &calibration), ("a.csv", rows)]);
        let output = place.run(&["trials", "calibration.toml", "--json"]);
        (output.status.code(), String::from_utf8(output.stdout).unwrap(), String::from_utf8(output.stderr).unwrap())
    };
    // On sectors: samples of another size have other margins.
    let (disc, pin) =
        (ledger(&rows, "disc = \"one\"\n"), ledger(&rounded, "disc = \"one\"\nspecimen = { radius_mm = 2.0 }\n"));
    assert_eq!((disc.0, pin.0), (Some(0), Some(0)), "{} {}", disc.2, pin.2);
    assert_eq!(disc.1, pin.1);
    // Alone, a sample is modelled on its own face: friction tilts the pressure on it, the more the shorter it is for its height.
    let modelled = |said: &str| {
        let said: Value = serde_json::from_str(said).unwrap();
        said["trials"][0]["measured"][0]["modelled"].as_f64().unwrap()
    };
    let [whole, small] = [ledger(&rows, "").1, ledger(&rounded, "specimen = { radius_mm = 2.0 }\n").1];
    let [endless, whole, small] = [&disc.1, &whole, &small].map(|said| modelled(said));
    assert!(whole < endless - 1e-3 && small < whole - 1e-3, "{endless} {whole} {small}");
    // Without its own face the same forces have no partner.
    assert_eq!(ledger(&rounded, "").0, Some(2));
}

/// Three samples as sectors of one disc: files for the laser, and trials that the calibration accepts unchanged.
#[test]
fn sectors_of_one_disc_are_drawn_and_become_trials() {
    let place = place();
    place.write(
        "design.toml",
        design([0.85, 0.83, 0.8]).replace("diameter_mm = 3.0", "diameter_mm = 10.0").replace("[100.0, 500.0]", "300.0"),
    );
    let found = next(&place, &["--count", "3", "--one-disc", "-o", "out"]);
    let files = "pattern.dxf pattern.svg process.toml result.json timings.json trials.toml";
    assert_eq!(place.listed("out"), files);
    let read = |name: &str| place.read(&format!("out/{name}"));
    let sheet: toml::Table = toml::from_str(&read("process.toml")).unwrap();
    let sectors = sheet["sector"].as_array().unwrap();
    assert!(sheet["measuring"].as_str().unwrap().contains("a mean of all sectors"));
    for (place, sector) in sectors.iter().enumerate() {
        let of = |key: &str| sector["pattern"][key].as_float().unwrap();
        assert_eq!([of("width_um"), of("spacing_um"), of("depth_um")], lengths(&found["samples"][place]));
        let cut = found["one_disc"]["sectors"][place]["areal_density"].as_f64().unwrap();
        assert!((sector["areal_density"].as_float().unwrap() / cut - 1.0).abs() < 1e-5);
        assert!(read("pattern.dxf").contains(&format!("CAVITIES_{}", place + 1)));
    }
    // Again into the same folder: these are slipgrid's own.
    next(&place, &["--count", "3", "--one-disc", "-o", "out"]);
    let trials = read("trials.toml");
    place.write("calibration.toml", format!("{CALIBRATION}{trials}"));
    let after = next(&place, &["--count", "2", "--one-disc"]);
    assert_eq!(place.listed("out/design-disc"), files);
    assert_eq!((after["pending"].as_u64(), after["one_disc"]["name"].as_str()), (Some(3), Some("three cuts, disc 2")));
    // Measured: the material keeps which trials share a disc.
    for number in 1..=3 {
        place.write(&format!("sector-{number}.csv"), table([0.9, 0.88, 0.86]));
    }
    place.write("calibration.toml", format!("{CALIBRATION}{}", trials.replace("# measurements", "measurements")));
    place.succeed(&["calibrate", "calibration.toml", "-o", "learned.toml", "-q"]);
    let learned = place.read("learned.toml");
    assert_eq!(learned.matches("disc = \"three cuts, disc 1\"").count(), 3, "{learned}");
    let ledger: Value = place.json(&["trials", "calibration.toml", "--json"]);
    assert_eq!(ledger["trials"][2]["disc"], "three cuts, disc 1");
}
