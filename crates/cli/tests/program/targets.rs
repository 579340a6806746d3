//! Kinds of targets and limits, reasons why a target is out of reach, and studies from which a killed run is resumed.

use std::fs;
use std::time::Duration;

use crate::common::{Place, free, number, optimized, short, small, trusted, untimed};
use serde_json::Value;

/// Design of a short sample of several periods, which is confirmed in a second.
fn design(target: &str, limits: &str) -> String {
    short().replace("value = 0.9\ntolerance = 0.01", target).replace("max_peak_pressure_mpa = 20.0", limits)
}

#[test]
fn goals_and_bands_are_searched_told_and_drawn() {
    let place = Place::with(&[
        (
            "lowest.toml",
            &design("goal = \"lowest\"", "min_bearing_area = 0.6\nliftoff = \"refuse\"\nmin_clearance_um = 1.0"),
        ),
        ("even.toml", &trusted(&design("lowest = 0.7\nhighest = [1.0, 0.95]\ngoal = \"even\"", ""))),
        ("most.toml", &design("highest = [0.98, 0.9]\nweights = [1.0, 3.0]", "max_areal_density = 0.4")),
    ]);
    let (told, found) = optimized(&place, "lowest.toml", 0);
    assert!(told.contains("cut a trial: the best texture found for the goal"), "{told}");
    assert!(told.contains("lowest mean ratio over the pressures: "), "{told}");
    let medians = |found: &Value| [0, 1].map(|load| number(&found["expected"][load]["median"]));
    let goal = &found["goal"];
    assert!((number(&goal["expected"]) - 0.5 * medians(&found).iter().sum::<f64>()).abs() < 1e-9, "{goal}");
    assert!(number(&goal["modelled"]) < 0.95 && found["chance"].is_null());
    // Land of 60 % of a period binds: grooves of 80 um between lands of 120 um.
    assert_eq!(number(&found["design"]["width_um"]), 80.0);
    assert!(number(&found["specimen_areal_density"]) <= 0.4);
    assert_eq!((&found["target"]["value"], &found["target"]["goal"]), (&Value::Null, &Value::from("lowest")));
    let page = place.read("out/lowest/report.html");
    assert!(page.contains("Cut a trial: the best texture found for the goal"));

    let (told, found) = optimized(&place, "even.toml", 0);
    assert!(
        told.contains("0.700 to 1.000") && told.contains("even standard deviation of the ratio over its mean"),
        "{told}"
    );
    let [first, last] = medians(&found);
    assert!((0.7..=1.0).contains(&first) && (0.7..=0.95).contains(&last) && number(&found["chance"]) >= 0.5);
    assert_eq!(found["target"]["highest"], serde_json::json!([1.0, 0.95]));

    let (told, found) = optimized(&place, "most.toml", 0);
    assert!(told.contains("<= 0.900"), "{told}");
    assert!(medians(&found)[0] <= 0.98 && medians(&found)[1] <= 0.9, "{}", found["expected"]);
    assert!(number(&found["specimen_areal_density"]) <= 0.4);
}

#[test]
fn time_under_the_laser_can_be_limited() {
    let laser = |text: String| {
        free(&text).replace("spot_um = 23.0", "spot_um = 23.0\nrepetition_hz = 1000.0\nspeed_mm_s = 10.0")
    };
    let place = Place::with(&[
        ("slow.toml", &laser(design("goal = \"lowest\"", ""))),
        ("fast.toml", &laser(design("goal = \"lowest\"", "max_laser_time_s = 5.0"))),
    ]);
    let time_s =
        |folder: &str| place.toml(&format!("{folder}/process.toml"))["work"]["estimated_time_s"].as_float().unwrap();
    let slow = optimized(&place, "slow.toml", 0).1["goal"]["expected"].as_f64().unwrap();
    let fast = optimized(&place, "fast.toml", 0).1["goal"]["expected"].as_f64().unwrap();
    assert!(time_s("out/slow") > 5.0, "{}", time_s("out/slow"));
    assert!(time_s("out/fast") <= 5.0 && fast > slow, "{} {fast} {slow}", time_s("out/fast"));
}

#[test]
fn a_killed_run_is_resumed_and_ends_with_the_same_bytes() {
    let place = Place::with(&[("a.toml", &free(&design("value = [0.95, 0.9]\ntolerance = 0.02", "")))]);
    // Answers of earlier runs would stand in no study.
    place.succeed(&["optimize", "a.toml", "-o", "whole", "--no-cache"]);
    let whole = untimed(&place, "whole");
    let study = place.read("whole.study.jsonl");
    let lines = study.lines().count();

    // Killed as soon as something has been answered.
    let mut child = place.begin(&["optimize", "a.toml", "-o", "cut"]);
    let path = place.path("cut.study.jsonl");
    while !fs::metadata(&path).is_ok_and(|file| file.len() > 1000) && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_micros(100));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let answered = fs::read_to_string(&path).unwrap().lines().count();
    assert!(answered > 1, "{answered}");

    assert!(place.told(&["optimize", "a.toml", "-o", "cut", "--resume", "--no-cache"]).contains("took over "));
    assert!(untimed(&place, "cut") == whole);
    let both = [study, fs::read_to_string(&path).unwrap()].map(|text| {
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines.sort();
        lines
    });
    assert_eq!(both[0].len(), lines);
    assert_eq!(both[0], both[1], "nothing is evaluated twice");

    // Another target is served by the same study, another layer is not.
    let text = place.read("a.toml");
    place.write("a.toml", text.replace("layer_um = 60.0", "layer_um = 70.0"));
    let message = place.refuse(&["optimize", "a.toml", "-o", "cut", "--resume"]);
    assert!(message.contains("cut.study.jsonl:1: is a study of another design: its `layer` is "), "{message}");
    place.write("a.toml", text.replace("0.9]", "0.91]"));
    place.succeed(&["optimize", "a.toml", "-o", "cut", "--resume"]);
}

#[test]
fn what_keeps_a_target_out_of_reach_is_said_and_lifting_it_suffices() {
    let text = trusted(&free(&design("value = [0.9, 0.82]\ntolerance = 0.03", "min_bearing_area = 0.85")));
    let place = Place::with(&[("far.toml", &text)]);
    let (told, found) = optimized(&place, "far.toml", 3);
    assert!(found["advice"] == "cannot_be_met" && told.contains("keeps all limits"), "{told}");
    let blocked = &found["blocked_by"][0];
    assert_eq!(
        (&blocked["what"], &blocked["is_within_reach"]),
        (&"the limit of bearing area, 0.85".into(), &true.into())
    );
    assert!(number(&blocked["chance"]) > number(&found["chance"]), "{blocked}");
    let line = told.lines().find(|line| line.contains("without the limit of bearing area, 0.85: ")).unwrap();
    assert!(!line.contains("still out of reach"), "{line}");
    let page = place.read("out/far/report.html");
    assert!(page.contains("the limit of bearing area, 0.85"));
    // What is said to be within reach is.
    place.write("near.toml", text.replace("min_bearing_area = 0.85\n", ""));
    let (_, near) = optimized(&place, "near.toml", 0);
    // The table knows ends, tilt and time of the design itself but roughly.
    assert!((number(&near["chance"]) - number(&blocked["chance"])).abs() < 0.06, "{} {blocked}", near["chance"]);
}

#[test]
fn a_table_of_every_design_confirms_the_search() {
    let text = trusted(&design("value = [0.95, 0.9]\ntolerance = 0.02", "min_bearing_area = 0.6"))
        .replace("seed = 1", "seed = 1\ntable = true")
        .replace("spacing_um = 120.0", "spacing_um = [40.0, 200.0]");
    let place = Place::with(&[("all.toml", &text)]);
    let (_, found) = optimized(&place, "all.toml", 0);
    let csv = place.read("out/all/table.csv");
    // Widths 40 to 100, spacings 40 to 200.
    assert_eq!(csv.lines().count(), 1 + 7 * 17);
    let head = "width_um,spacing_um,depth_um,ratio_at_0.65_mpa,ratio_at_2.6_mpa,bearing_area,chance,keeps_limits";
    assert_eq!(csv.lines().next(), Some(head));
    let rows = csv.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>()).filter(|row| row[7] == "true");
    let rows: Vec<Vec<f64>> = rows.map(|row| row[..7].iter().map(|cell| cell.parse().unwrap()).collect()).collect();
    assert!(rows.iter().all(|row| row[5] >= 0.6));
    // None is likelier than the design, and the design is among them, but for how far the table is off.
    let best = rows.iter().map(|row| row[6]).fold(0.0, f64::max);
    assert!(best > 0.3 && best < number(&found["chance"]) + 0.1, "{best} {}", found["chance"]);
    let lengths = ["width_um", "spacing_um", "depth_um"].map(|key| number(&found["design"][key]));
    let own = rows.iter().find(|row| row[..3].iter().zip(lengths).all(|(a, b)| (a - b).abs() < 1e-6)).unwrap();
    assert!((own[4] - number(&found["expected"][1]["median"])).abs() < 0.01, "{own:?}");

    place.write("space.toml", text.replace("\"groove\"", "\"square\""));
    assert!(place.refuse(&["optimize", "space.toml"]).contains("a table takes the vertical plane"));
}

/// A stiff body at a light load slides in waves, in which blocks stick; the result warns that they are not resolved.
#[test]
fn sliding_that_waves_carry_is_told() {
    let text = small()
        .replace("youngs_modulus_gpa = 0.38", "youngs_modulus_gpa = 10.0")
        .replace("density_g_cm3 = 0.9", "density_g_cm3 = 2.0")
        .replace("pressure_mpa = [0.7, 1.3, 2.6, 10.0]", "pressure_mpa = [0.01, 0.03, 0.06, 1.0]")
        .replace("pressure_mpa = [0.65, 2.6]", "pressure_mpa = [0.02, 0.04]");
    let place = Place::with(&[("waves.toml", &text)]);
    let output = place.run(&["optimize", "waves.toml"]);
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.lines().any(|line| line.starts_with("! ") && line.contains("sliding is unstable to waves")), "{told}");
    let found = place.read("out/waves/result.json");
    assert!(found.contains("\"sliding_waves\""));
}
