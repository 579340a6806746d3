//! Designs that must hold at several speeds and humidities, named one by one or as ranges.

use slipgrid_formats::run::Overrides;
use slipgrid_formats::scene::SceneInput;
use std::fs;

use crate::common::{CALIBRATION, DESIGN, Place, number, result};
use serde_json::Value;

/// A condition of the material: speed in mm/s, humidity in per cent, mean local dynamic coefficient.
type Measured = (f64, f64, f64);

/// A short sample at one pressure of a material with coefficients at `measured` conditions; `header` names conditions.
fn design(target: &str, measured: &[Measured], header: &str) -> String {
    let row = |(speed, humidity, mean): &Measured| {
        let at_rest = 1.1 * mean;
        format!(
            "[[material.friction.conditions]]\nspeed_mm_s = {speed}\nhumidity_pct = {humidity}\npressure_mpa = [2.6]\n\
             static_mean = {at_rest}\ndynamic_mean = {mean}\n"
        )
    };
    let rows: String = measured.iter().map(row).collect();
    DESIGN
        .replace("diameter_mm = 10.0", "diameter_mm = 2.0")
        .replace("[0.65, 2.6]", "[2.6]")
        .replace("quantity = \"ratio\"\n", "")
        .replace("value = 0.9\ntolerance = 0.01", target)
        .replace("[40.0, 400.0]", "[40.0, 100.0]")
        .replace("[40.0, 1000.0]", "[40.0, 200.0]")
        .replace("max_evaluations = 50", "max_evaluations = 2000")
        .replace("static_mean = 0.30\ndynamic_mean = 0.27\n", &format!("relative_std = 0.05\n{rows}"))
        .replace("[material]\n", &format!("{header}\n[material]\n"))
}

fn at(found: &Value) -> &Vec<Value> {
    found["conditions"]["at"].as_array().unwrap()
}

/// Ratio and peak pressure of the design in `folder` by a steady cell whose mean local dynamic coefficient is `mean`.
fn steady(place: &Place, folder: &str, mean: f64) -> [f64; 2] {
    let scene = fs::read_to_string(place.path(folder).join("scene.toml")).unwrap();
    let lines = scene.lines().map(|line| match line.split_once(" = ") {
        Some(("dynamic_mean", _)) => format!("dynamic_mean = {mean}"),
        _ => line.to_owned(),
    });
    fs::write(place.path("steady.toml"), lines.collect::<Vec<_>>().join("\n")).unwrap();
    let told = place.succeed(&["simulate", "steady.toml", "--fidelity", "steady", "--extent", "cell", "--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    ["ratio", "peak_pressure_mpa"].map(|key| number(&told["results"][0][key]))
}

const FIRST: &str = "condition = { speed_mm_s = 2.0, humidity_pct = 15.0 }";

#[test]
fn a_friction_target_holds_at_every_condition_and_each_that_decides_is_run_at_its_own_speed() {
    let measured = [(2.0, 15.0, 0.27), (8.0, 15.0, 0.324)];
    let wanted = |tolerance: f64, header: &str| {
        design(&format!("quantity = \"mu_dynamic\"\nvalue = 0.17\ntolerance = {tolerance}"), &measured, header)
    };
    let also = |at: &str| format!("{FIRST}\nalso_at = [{{ speed_mm_s = {at}, humidity_pct = 15.0 }}]");
    let place = Place::with(&[
        ("a.toml", &wanted(0.018, &also("4.0"))),
        ("narrow.toml", &wanted(0.005, &also("8.0"))),
        ("outside.toml", &wanted(0.018, &also("9.0"))),
        ("beyond.toml", &wanted(0.018, &also("[3.0, 9.0]"))),
        ("reversed.toml", &wanted(0.018, &also("[4.0, 2.0]"))),
        ("short.toml", &wanted(0.018, &also("[4.0]"))),
        ("alone.toml", &wanted(0.018, "also_at = [{ speed_mm_s = 4.0, humidity_pct = 15.0 }]")),
    ]);
    for (file, says) in [
        ("outside.toml", "also_at: "),
        ("outside.toml", "no coefficients for 9 mm/s at 15 % humidity, which is not between measured ones"),
        ("beyond.toml", "beyond.toml:3: also_at: "),
        ("beyond.toml", "no coefficients for 9 mm/s at 15 % humidity"),
        ("reversed.toml", "reversed.toml:3: also_at.speed_mm_s: [4.0, 2.0] has its larger number first"),
        (
            "short.toml",
            "short.toml:3: also_at.speed_mm_s: [4.0] is a list of 1; expected one number, or [lowest, highest]",
        ),
        ("alone.toml", "without the condition that is designed for"),
    ] {
        let message = place.refuse(&["optimize", file]);
        assert!(message.contains(says), "{message}");
    }

    let told = place.succeed(&["optimize", "a.toml"]);
    let found = result(&place, "out/a");
    assert!(told.contains("4 mm/s, 15 %: ratio") && told.contains("worst: "), "{told}");
    // The target stays as it was asked.
    assert_eq!((number(&found["target"]["value"][0]), number(&found["target"]["tolerance"])), (0.17, 0.018));
    let [first, second] = &at(&found)[..] else { panic!("{found}") };
    assert_eq!(
        (&first["in_time"], &second["in_time"], &found["conditions"]["held"]),
        (&true.into(), &true.into(), &true.into())
    );
    assert_eq!(found["conditions"]["conflict"], Value::Null);
    let value = |at: &Value, key: &str| number(&at["by_pressure"][0][key]);
    assert_eq!(value(first, "mu"), number(&found["errors"]["by_pressure"][0]["mu"]["value"]));
    for at in [first, second] {
        let misfit = (value(at, "mu") - 0.17).abs() / 0.018;
        assert!(misfit <= 1.0 && (misfit - number(&at["misfit"])).abs() < 1e-6, "{at}");
    }
    let worst = number(&first["misfit"]).max(number(&second["misfit"]));
    assert!((number(&found["misfit"]["confirmed"]) - worst).abs() < 1e-9);
    // Half way from 2 to 8 mm/s friction is 1.1 times that at 2: aimed at from both sides.
    assert!((value(second, "mu") / value(first, "mu") - 1.1).abs() < 0.011 && value(first, "mu") < 0.17);

    // The same run by hand: the scene of the design with the speed and the coefficients of the other condition.
    let scene = fs::read_to_string(place.path("out/a/scene.toml")).unwrap();
    let other = scene.replace("speed_mm_s = 2.0", "speed_mm_s = 4.0");
    let other: Vec<String> = other
        .lines()
        .map(|line| match line.split_once(" = ") {
            Some((key @ ("dynamic_mean" | "static_mean"), mean)) => {
                format!("{key} = {}", (mean.parse::<f64>().unwrap() * 1.1 * 1e12).round() / 1e12)
            }
            _ => line.to_owned(),
        })
        .collect();
    fs::write(place.path("other.toml"), other.join("\n")).unwrap();
    // At twice the speed a run goes as many periods of the layer.
    let overrides = Overrides::default();
    let read = SceneInput::read(&slipgrid_disk::disk(), &place.path("other.toml"), overrides).unwrap().scene;
    let law = (&read.elastic, read.area_law.as_ref());
    let travel_um = 1e6 * slipgrid_springblock::warm_travel_m(law, &read.layer, &read.loads, read.speed_m_s);
    let other = other.iter().map(|line| match line.split_once(" = ") {
        Some(("sliding_um", _)) => format!("sliding_um = {travel_um:.3}"),
        _ => line.clone(),
    });
    fs::write(place.path("other.toml"), other.collect::<Vec<_>>().join("\n")).unwrap();
    let told: Value = serde_json::from_str(&place.succeed(&["simulate", "other.toml", "--json"])).unwrap();
    for (key, theirs) in [("mu", "mu_dynamic"), ("ratio", "ratio"), ("mu_flat", "mu_flat")] {
        assert!((value(second, key) - number(&told["results"][0][theirs])).abs() < 1e-6, "{key} {second} {told}");
    }
    assert!(
        fs::read_to_string(place.path("out/a/report.html"))
            .unwrap()
            .contains("At every condition, the one designed for first")
    );
    assert!(fs::read_to_string(place.path("out/a/target.svg")).unwrap().contains("all conditions"));

    // What no pattern can do is said with numbers, beside the nearest design.
    let output = place.run(&["optimize", "narrow.toml"]);
    assert_eq!(output.status.code(), Some(3));
    let found = result(&place, "out/narrow");
    let conflict = &found["conditions"]["conflict"];
    assert_eq!((&conflict["lowest_at"], &conflict["highest_at"]), (&"2 mm/s, 15 %".into(), &"8 mm/s, 15 %".into()));
    assert!((number(&conflict["flat_factor"]) - 1.2).abs() < 1e-6);
    // The ratio falls a little as friction grows; 0.17 (1 +- (q - 1) / (q + 1)).
    let factor = number(&conflict["factor"]);
    assert!((factor - 1.2).abs() < 0.03 && factor > 0.175 / 0.165, "{conflict}");
    assert!((number(&conflict["needed"][0]) - 0.17 * 2.0 / (factor + 1.0)).abs() < 1e-6, "{conflict}");
    assert!((number(&conflict["needed"][1]) - 0.17 * 2.0 * factor / (factor + 1.0)).abs() < 1e-6, "{conflict}");
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(
        told.contains("why: at 2.6 MPa flat friction at 8 mm/s, 15 % is 1.200 times that at 2 mm/s, 15 %"),
        "{told}"
    );
    assert!(fs::read_to_string(place.path("out/narrow/report.html")).unwrap().contains("Not to be met together"));
}

#[test]
fn shares_of_samples_count_all_conditions_together() {
    // Friction of the flat surface is known to 1 % at either, and 1 % separates the second from its limit.
    let measured = [(2.0, 15.0, 0.20), (2.0, 80.0, 0.27)];
    let both = format!("{FIRST}\nalso_at = [{{ speed_mm_s = 2.0, humidity_pct = 80.0 }}]");
    let text = |target: &str| {
        let known = |mean: f64| format!("dynamic_mean = {mean}\n");
        let text = design(target, &measured, &both)
            .replace("width_um = [40.0, 100.0]", "width_um = 60.0")
            .replace("spacing_um = [40.0, 200.0]", "spacing_um = 100.0")
            .replace("depth_um = [2.0, 50.0]", "depth_um = 20.8");
        let text = [0.20, 0.27].into_iter().fold(text, |text, mean| {
            text.replace(&known(mean), &format!("{}dynamic_std_error = {}\n", known(mean), 0.01 * mean))
        });
        format!("{text}[tolerances]\nwidth_std_um = 0.1\ndraws = 300\n")
    };
    let place = Place::with(&[("wide.toml", &text("quantity = \"mu_dynamic\"\nhighest = 0.5"))]);
    place.succeed(&["optimize", "wide.toml"]);
    let found = result(&place, "out/wide");
    let mu = |condition: usize| number(&at(&found)[condition]["by_pressure"][0]["mu"]);
    assert!(mu(1) > 1.2 * mu(0), "{found}");
    let highest = 1.005 * mu(1);
    fs::write(place.path("near.toml"), text(&format!("quantity = \"mu_dynamic\"\nhighest = {highest}"))).unwrap();
    let told = place.succeed(&["optimize", "near.toml"]);
    let found = result(&place, "out/near");
    let robustness = &found["robustness"];
    // A normal distribution is below half its standard deviation with 69 %.
    let share = number(&robustness["with_material"]["probability"]);
    assert!((share - 0.69).abs() < 0.12, "{share}");
    assert_eq!(robustness["condition"], "2 mm/s, 15 %");
    let spread = &robustness["samples"]["by_pressure"];
    assert_eq!(spread.as_array().unwrap().len(), 1);
    assert!((number(&spread[0]["mu"]["mean"]) / mu(0) - 1.0).abs() < 0.01, "{spread}");
    assert!(
        told.contains("within the tolerance at all pressures of all conditions, from tolerances alone: "),
        "{told}"
    );
    assert!(told.contains(", at the condition designed for, 2 mm/s, 15 %\n"), "{told}");
}

#[test]
fn a_ratio_target_and_a_peak_pressure_hold_at_the_worst_condition() {
    let measured = [(2.0, 15.0, 0.15), (2.0, 80.0, 0.5)];
    let both = format!("{FIRST}\nalso_at = [{{ speed_mm_s = 2.0, humidity_pct = 80.0 }}]");
    let second = "condition = { speed_mm_s = 2.0, humidity_pct = 80.0 }";
    let target = "quantity = \"ratio\"\nvalue = 0.84\ntolerance = 0.015";
    let with = |target: &str, header: &str| design(target, &measured, header);
    let lowest = |header: &str| {
        with("quantity = \"ratio\"\ngoal = \"lowest\"", header)
            .replace("max_peak_pressure_mpa = 20.0", "max_peak_pressure_mpa = 9.0")
            .replace("max_evaluations = 2000", "max_evaluations = 4000")
    };
    let place = Place::with(&[
        ("first.toml", &with(target, FIRST)),
        ("second.toml", &with(target, second)),
        // Deep grooves side by side, whose ratio depends on friction most.
        (
            "deep.toml",
            &with(target, FIRST)
                .replace("width_um = [40.0, 100.0]", "width_um = [40.0, 50.0]")
                .replace("depth_um = [2.0, 50.0]", "depth_um = [46.0, 50.0]"),
        ),
        ("both.toml", &with(target, &both)),
        ("low-first.toml", &lowest(FIRST)),
        ("low-both.toml", &lowest(&both)),
    ]);
    for file in ["first", "second", "both"] {
        place.succeed(&["optimize", &format!("{file}.toml"), "--table"]);
    }
    place.succeed(&["optimize", "deep.toml"]);
    // What holds at the first condition alone may miss at the second; that for both holds at both.
    let alone = [0.15, 0.5].map(|mean| steady(&place, "out/deep", mean)[0]);
    assert!((alone[0] - 0.84).abs() <= 0.015 && (alone[1] - 0.84).abs() > 0.015, "{alone:?}");
    let together = [0.15, 0.5].map(|mean| steady(&place, "out/both", mean)[0]);
    let found = result(&place, "out/both");
    for at in at(&found) {
        assert!((number(&at["by_pressure"][0]["ratio"]) - 0.84).abs() <= 0.015, "{at}");
    }
    assert_eq!((&found["status"], at(&found).len()), (&"met".into(), 2));
    // Between them ratios lie between: the ends of a range of friction stand for it.
    let ends = [together[0].min(together[1]), together[0].max(together[1])];
    for mean in [0.2, 0.25, 0.3, 0.35, 0.4, 0.45] {
        let between = steady(&place, "out/both", mean)[0];
        assert!((ends[0]..=ends[1]).contains(&between), "{mean} {between} {ends:?}");
    }

    // Every design of the lattice, solved at each condition alone, says so too.
    let table = |folder: &str| -> Vec<Vec<f64>> {
        let text = fs::read_to_string(place.path(folder).join("table.csv")).unwrap();
        let row = |line: &str| line.split(',').take(4).map(|cell| cell.parse().unwrap_or(f64::NAN)).collect();
        text.lines().skip(1).map(row).collect()
    };
    let (one, two) = (table("out/first"), table("out/second"));
    assert!(one.len() == two.len() && one.len() > 1000);
    assert!(one.iter().zip(&two).all(|(one, two)| one[..3] == two[..3]));
    assert_eq!((&found["table"]["by_chance"], &found["table"]["confirms_search"]), (&true.into(), &true.into()));
    let header = fs::read_to_string(place.path("out/both/table.csv")).unwrap();
    assert!(header.starts_with("width_um,spacing_um,depth_um,ratio_at_2.6_mpa,ratio_at_2.6_mpa_2_mm_s_80_pct,"));

    // Pressures are highest where friction is: the limit holds there.
    for file in ["low-first.toml", "low-both.toml"] {
        place.succeed(&["optimize", file]);
    }
    assert!(steady(&place, "out/low-first", 0.15)[1] <= 9.0 && steady(&place, "out/low-first", 0.5)[1] > 9.0);
    assert!(steady(&place, "out/low-both", 0.15)[1] <= 9.0 && steady(&place, "out/low-both", 0.5)[1] <= 9.0);
    let found = result(&place, "out/low-both");
    let peak = number(&at(&found)[1]["by_pressure"][0]["peak_pressure_mpa"]);
    assert!((peak - steady(&place, "out/low-both", 0.5)[1]).abs() < 1e-6 && peak > 8.0, "{peak}");
}

#[test]
fn a_range_is_the_list_of_its_conditions_and_each_humidity_has_its_own_discrepancy() {
    let measured = [
        (1.0, 15.0, 0.25),
        (2.0, 15.0, 0.27),
        (4.0, 15.0, 0.28),
        (1.0, 80.0, 0.26),
        (2.0, 80.0, 0.3),
        (4.0, 80.0, 0.31),
    ];
    let trial = "[material.learned]\nreference_pressure_mpa = 2.6\nlowest_pressure_mpa = 2.6\nreference_speed_mm_s = 2.0\n\
        modulus_relative_std = 0.0\n[material.learned.prior]\n[[material.learned.trial]]\nname = \"first\"\n\
        areal_density = 0.4\nedge_per_mm = 10.0\nwidth_um = 80.0\npitch_um = 200.0\ndepth_um = 15.0\n\
        pressure_mpa = [2.6, 2.6]\nspeed_mm_s = [2.0, 2.0]\nhumidity_pct = [15.0, 80.0]\nmeasured_ratio = [0.81, 0.73]\n\
        modelled_ratio = [0.87, 0.87]\npatterned_std = [0.002, 0.002]\nflat_std = [0.002, 0.002]\n\
        modulus_sensitivity = [0.0, 0.0]\n[target]";
    let with = |header: &str| {
        let target = "quantity = \"ratio\"\nvalue = 0.78\ntolerance = 0.04\ndiscrepancy = true";
        design(target, &measured, header).replace("[target]", trial)
    };
    let range = "condition = { speed_mm_s = [1.5, 4.0], humidity_pct = [15.0, 80.0] }";
    let each = [(1.5, 15.0), (1.5, 80.0), (2.0, 80.0), (4.0, 15.0), (4.0, 80.0), (2.0, 80.0)];
    let each = each.map(|(speed, humidity)| format!("{{ speed_mm_s = {speed}, humidity_pct = {humidity} }}"));
    let list = format!("{FIRST}\nalso_at = [{}]", each.join(", "));
    let place = Place::with(&[("range.toml", &with(range)), ("list.toml", &with(&list))]);
    let told = place.succeed(&["optimize", "range.toml", "-o", "out/one", "--no-explorer"]);
    assert!(told.contains("1.5 to 4 mm/s and 15 to 80 % of humidity"), "{told}");
    assert!(told.contains("designed for and reported at 2 mm/s, 15 %"), "{told}");
    place.succeed(&["optimize", "list.toml", "-o", "out/two", "--no-explorer"]);
    let [mut one, mut two] = ["out/one", "out/two"].map(|folder| result(&place, folder));
    for found in [&mut one, &mut two] {
        found.as_object_mut().unwrap().remove("model").unwrap();
    }
    assert_eq!(one, two);
    for name in ["scene.toml", "target.svg", "process.toml", "friction.csv"] {
        let [one, two] = ["out/one", "out/two"].map(|folder| fs::read(place.path(folder).join(name)).unwrap());
        assert_eq!(one, two, "{name}");
    }
    // Once each: the measured one in the middle first, then by speed.
    let places: Vec<[f64; 2]> =
        at(&one).iter().map(|at| [number(&at["speed_mm_s"]), number(&at["humidity_pct"])]).collect();
    assert_eq!(places, [[2.0, 15.0], [1.5, 15.0], [1.5, 80.0], [2.0, 80.0], [4.0, 15.0], [4.0, 80.0]]);
    assert!(fs::read_to_string(place.path("out/one/scene.toml")).unwrap().contains("speed_mm_s = 2.0"));
    // Each humidity has what was measured there; of the speed nothing is known, which moves a median by little.
    let factors = |humidity: f64| -> Vec<f64> {
        let own = at(&one).iter().filter(|at| at["humidity_pct"] == humidity);
        own.map(|at| number(&at["by_pressure"][0]["factor"])).collect()
    };
    let (dry, humid) = (factors(15.0), factors(80.0));
    for own in [&dry, &humid] {
        assert!(own.len() == 3 && own.iter().all(|factor| (factor - own[0]).abs() < 2e-3), "{own:?}");
    }
    assert!((humid[0] / dry[0] - 0.73 / 0.81).abs() < 0.05 && humid[0] < dry[0] - 0.04, "{dry:?} {humid:?}");
    for at in at(&one) {
        let value = &at["by_pressure"][0];
        assert!((number(&value["ratio"]) - 0.78).abs() <= 0.04, "{value}");
        assert!(
            (number(&value["mu"]) / number(&value["mu_flat"]) / number(&value["ratio"]) - 1.0).abs() < 0.01,
            "{value}"
        );
    }
    // Some are not run in time, and say so.
    assert!(at(&one).iter().any(|at| at["in_time"] == false) && told.contains("by the steady model about the first"));
}

#[test]
fn a_calibration_takes_in_every_condition_of_a_range() {
    let calibration =
        CALIBRATION.replace("flat = \"flat.csv\"", "flat = \"flat.csv\"\npatterned = \"patterned.csv\"").replace(
            "[fit]",
            "[pattern]\nplanform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 20.0\n[fit]",
        );
    // At 5 mm/s nothing is needed: the range ends before.
    let table = |dry: f64, humid: f64| {
        let mut text = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n".to_owned();
        for (humidity, mu) in [(15, 0.25 * dry), (80, 0.28 * humid)] {
            for (force, more) in [(100, 0.99), (150, 1.0), (205, 1.01)] {
                text += &format!("{force},2,{humidity},{},0.0025\n", mu * more);
            }
        }
        text + &format!("205,5,15,{},0.0025\n", 0.3 * dry)
    };
    let text =
        design("quantity = \"ratio\"\nvalue = 0.8\ntolerance = 0.08\ndiscrepancy = true", &[(2.0, 15.0, 0.27)], "");
    let (from, to) = (text.find("[material]").unwrap(), text.find("[target]").unwrap());
    let named = format!("{}{}", &text[..from], &text[to..]);
    let with = |humidity: &str| {
        let header = format!(
            "name = \"test design\"\nmaterial = \"c.toml\"\ncondition = {{ speed_mm_s = 2.0, humidity_pct = {humidity} }}\n"
        );
        named.replace("name = \"test design\"\n", &header)
    };
    let place = Place::with(&[
        ("a.toml", &with("[15.0, 80.0]")),
        ("outside.toml", &with("[15.0, 81.0]")),
        ("c.toml", &calibration),
        ("flat.csv", &table(1.0, 1.0)),
        ("patterned.csv", &table(0.9, 0.8)),
    ]);
    let message = place.refuse(&["optimize", "outside.toml"]);
    assert!(message.contains("outside.toml:3: condition: ") && message.contains("2 mm/s at 81 %"), "{message}");
    place.succeed(&["optimize", "a.toml"]);
    let found = result(&place, "out/a");
    let [dry, humid] = &at(&found)[..] else { panic!("{}", found["conditions"]) };
    let value = |at: &Value, key: &str| number(&at["by_pressure"][0][key]);
    assert!((value(dry, "mu_flat") / (0.25 * 1.01) - 1.0).abs() < 0.02, "{dry}");
    assert!((value(humid, "mu_flat") / (0.28 * 1.01) - 1.0).abs() < 0.02, "{humid}");
    // Measured ratios are 0.9 at 15 % and 0.8 at 80 %; modelled ones hardly differ.
    assert!((value(humid, "factor") / value(dry, "factor") / (0.8 / 0.9) - 1.0).abs() < 0.05, "{dry} {humid}");
    assert!((number(&found["discrepancy"]["by_pressure"][0]["factor"]) - value(dry, "factor")).abs() < 1e-9);
    assert!(value(humid, "ratio") < 0.95 * value(dry, "ratio") && found["status"] == "met");
}
