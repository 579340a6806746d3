//! Designs for several speeds and humidities, given one by one or as ranges.

use std::fs;

use crate::common::{Place, free, measured, number, patterned_calibration, result, short, trusted};
use serde_json::Value;

/// Condition of the material: speed in mm/s, humidity in percent, mean local dynamic coefficient.
type Measured = (f64, f64, f64);

/// Design of a short sample at one pressure with coefficients at `measured` conditions; `header` gives the conditions.
fn design(target: &str, measured: &[Measured], header: &str) -> String {
    let row = |(speed, humidity, mean): &Measured| {
        let at_rest = 1.1 * mean;
        format!(
            "[[material.friction.conditions]]\nspeed_mm_s = {speed}\nhumidity_pct = {humidity}\npressure_mpa = [2.6]\n\
             static_mean = {at_rest}\ndynamic_mean = {mean}\n"
        )
    };
    let rows: String = measured.iter().map(row).collect();
    short()
        .replace("[0.65, 2.6]", "[2.6]")
        .replace("quantity = \"ratio\"\n", "")
        .replace("value = 0.9\ntolerance = 0.01", target)
        .replace("static_mean = 0.30\ndynamic_mean = 0.27\n", &format!("relative_std = 0.05\n{rows}"))
        .replace("[material]\n", &format!("{header}\n[material]\n"))
}

/// Predicted values at every condition; the condition of the design is the first.
fn at(found: &Value) -> &Vec<Value> {
    found["expected"].as_array().unwrap()
}

/// Discrepancy factor at every condition: predicted median over modelled ratio.
fn factors(found: &Value) -> Vec<f64> {
    let modelled = found["modelled"].as_array().unwrap();
    at(found).iter().zip(modelled).map(|(at, modelled)| number(&at["median"]) / number(&modelled["ratio"])).collect()
}

fn is_within(at: &Value) -> bool {
    (number(&at["target_low"])..=number(&at["target_high"])).contains(&number(&at["median"]))
}

/// Ratio and peak pressure of the design in `folder` from a steady cell with the mean local dynamic coefficient `mean`.
fn steady(place: &Place, folder: &str, mean: f64) -> [f64; 2] {
    let scene = fs::read_to_string(place.path(folder).join("scene.toml")).unwrap();
    let lines = scene.lines().map(|line| match line.split_once(" = ") {
        Some(("dynamic_mean", _)) => format!("dynamic_mean = {mean}"),
        _ => line.to_owned(),
    });
    place.write("steady.toml", lines.collect::<Vec<_>>().join("\n"));
    let told = place.succeed(&["simulate", "steady.toml", "--fidelity", "steady", "--extent", "cell", "--json"]);
    let told: Value = serde_json::from_str(&told).unwrap();
    ["ratio", "peak_pressure_mpa"].map(|key| number(&told["results"][0][key]))
}

const FIRST: &str = "condition = { speed_mm_s = 2.0, humidity_pct = 15.0 }";

#[test]
fn a_friction_target_holds_at_every_condition() {
    let measured = [(2.0, 15.0, 0.27), (8.0, 15.0, 0.324)];
    let wanted = |tolerance: f64, header: &str| {
        trusted(&design(
            &format!("quantity = \"mu_dynamic\"\nvalue = 0.17\ntolerance = {tolerance}"),
            &measured,
            header,
        ))
    };
    let also = |at: &str| format!("{FIRST}\nalso_at = [{{ speed_mm_s = {at}, humidity_pct = 15.0 }}]");
    let place = Place::with(&[("a.toml", &wanted(0.018, &also("4.0"))), ("narrow.toml", &wanted(0.005, &also("8.0")))]);

    let told = place.succeed(&["optimize", "a.toml"]);
    let found = result(&place, "out/a");
    assert!(told.contains("2 mm/s, 15 %") && told.contains("4 mm/s, 15 %"), "{told}");
    // The target stays as it was asked.
    assert_eq!((number(&found["target"]["value"][0]), number(&found["target"]["tolerance"])), (0.17, 0.018));
    let [first, second] = &at(&found)[..] else { panic!("{found}") };
    assert_eq!((&first["speed_mm_s"], &second["speed_mm_s"]), (&2.0.into(), &4.0.into()));
    assert!(is_within(first) && is_within(second), "{first} {second}");
    // Half way from 2 to 8 mm/s friction is 1.1 times that at 2: aimed at from both sides.
    let share = number(&second["median"]) / number(&first["median"]);
    assert!((share - 1.1).abs() < 0.011 && number(&first["median"]) < 0.17, "{first} {second}");
    // Beyond a steady cell of the other friction the model has what the run in time and the face add at the first.
    let beyond = |place_of: usize, mean: f64| {
        (number(&found["modelled"][place_of]["ratio"]) / steady(&place, "out/a", mean)[0]).ln()
    };
    assert!((beyond(0, 0.27) - beyond(1, 0.297)).abs() < 1e-3, "{} {}", beyond(0, 0.27), beyond(1, 0.297));

    // What no pattern can do is said, beside the likeliest design: flat friction of the one is 1.2 times that of the other.
    let output = place.run(&["optimize", "narrow.toml"]);
    assert_eq!(output.status.code(), Some(0));
    let found = result(&place, "out/narrow");
    assert!(found["words"].as_str().unwrap().contains("no texture is expected to lie within it"), "{found}");
    let [first, second] = &at(&found)[..] else { panic!("{found}") };
    let share = number(&second["median"]) / number(&first["median"]);
    assert!((share - 1.2).abs() < 0.03 && share > 0.175 / 0.165, "{first} {second}");
}

#[test]
fn shares_of_samples_count_all_conditions_together() {
    // Friction of the flat surface is known to 1 % at either, and 1 % separates the second from its limit.
    let measured = [(2.0, 15.0, 0.20), (2.0, 80.0, 0.27)];
    let both = format!("{FIRST}\nalso_at = [{{ speed_mm_s = 2.0, humidity_pct = 80.0 }}]");
    let text = |target: &str| {
        let known = |mean: f64| format!("dynamic_mean = {mean}\n");
        let text = design(target, &measured, &both).replace("width_um = [40.0, 100.0]", "width_um = 60.0");
        let text = [0.20, 0.27].into_iter().fold(text, |text, mean| {
            text.replace(&known(mean), &format!("{}dynamic_std_error = {}\n", known(mean), 0.01 * mean))
        });
        trusted(&text)
    };
    let place = Place::with(&[("wide.toml", &text("quantity = \"mu_dynamic\"\nhighest = 0.5"))]);
    place.run(&["optimize", "wide.toml"]);
    let found = result(&place, "out/wide");
    let median = |found: &Value, condition: usize| number(&at(found)[condition]["median"]);
    assert!(median(&found, 1) > 1.2 * median(&found, 0), "{found}");
    let highest = 1.01 * median(&found, 1);
    place.write("near.toml", text(&format!("quantity = \"mu_dynamic\"\nhighest = {highest}")));
    place.succeed(&["optimize", "near.toml"]);
    let found = result(&place, "out/near");
    assert_eq!((median(&found, 0), at(&found).len()), (median(&result(&place, "out/wide"), 0), 2));
    // A normal distribution is below its standard deviation with 84 %; the little else that is not known widens it.
    let share = number(&found["chance"]);
    assert!((0.7..0.84).contains(&share), "{share}");
    let limits = found["limited_by"].as_array().unwrap();
    let flat = limits.iter().find(|limit| limit["input"] == "flat friction").unwrap();
    assert!(number(&flat["chance_if_known"]) > share + 0.02 && flat["known_to"] == "known to 1.0 %", "{flat}");
    let relative = number(&flat["std"][1]) / number(&found["modelled"][1]["ratio"]);
    assert!((relative - 0.01).abs() < 5e-4, "{relative}");
}

#[test]
fn a_ratio_target_and_a_peak_pressure_hold_at_the_worst_condition() {
    let measured = [(2.0, 15.0, 0.15), (2.0, 80.0, 0.5)];
    let both = format!("{FIRST}\nalso_at = [{{ speed_mm_s = 2.0, humidity_pct = 80.0 }}]");
    let target = "quantity = \"ratio\"\nvalue = 0.84\ntolerance = 0.03";
    let limited = |header: &str| {
        let text = design("quantity = \"ratio\"\ngoal = \"lowest\"", &measured, header);
        free(&text).replace("max_peak_pressure_mpa = 20.0", "max_peak_pressure_mpa = 9.0")
    };
    let place = Place::with(&[
        ("both.toml", &trusted(&design(target, &measured, &both))),
        ("low-first.toml", &limited(FIRST)),
        ("low-both.toml", &limited(&both)),
    ]);
    place.succeed(&["optimize", "both.toml", "--table"]);
    let found = result(&place, "out/both");
    assert!(at(&found).len() == 2 && at(&found).iter().all(is_within), "{found}");
    // Between them ratios lie between: the ends of a range of friction stand for it.
    let of = |mean: f64| steady(&place, "out/both", mean)[0];
    let ends = [of(0.15).min(of(0.5)), of(0.15).max(of(0.5))];
    for mean in [0.2, 0.25, 0.3, 0.35, 0.4, 0.45] {
        assert!((ends[0]..=ends[1]).contains(&of(mean)), "{mean} {} {ends:?}", of(mean));
    }
    let table = place.read("out/both/table.csv");
    assert!(table.starts_with("width_um,spacing_um,depth_um,ratio_at_2.6_mpa,ratio_at_2.6_mpa_2_mm_s_80_pct,"));

    // Pressures are highest where friction is: the limit holds there.
    for file in ["low-first.toml", "low-both.toml"] {
        place.succeed(&["optimize", file]);
    }
    let peak = |folder: &str| [0.15, 0.5].map(|mean| steady(&place, folder, mean)[1]);
    assert!(peak("out/low-first")[0] <= 9.0 && peak("out/low-first")[1] > 9.0, "{:?}", peak("out/low-first"));
    assert!(peak("out/low-both")[1] <= 9.0 && peak("out/low-both")[1] > 8.0, "{:?}", peak("out/low-both"));
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
        let target = "quantity = \"ratio\"\nvalue = 0.78\ntolerance = 0.04";
        free(&design(target, &measured, header)).replace("[target]", trial)
    };
    let range = "condition = { speed_mm_s = [1.5, 4.0], humidity_pct = [15.0, 80.0] }";
    // Humidities at most 20 % apart.
    let humidities = [15.0, 31.25, 47.5, 63.75, 80.0];
    let all: Vec<[f64; 2]> = [1.5, 2.0, 4.0].iter().flat_map(|speed| humidities.map(|at| [*speed, at])).collect();
    let further: Vec<[f64; 2]> = all.into_iter().filter(|at| *at != [2.0, 15.0]).collect();
    let named = further.iter().chain(&further[..1]);
    let each: Vec<String> =
        named.map(|[speed, humidity]| format!("{{ speed_mm_s = {speed}, humidity_pct = {humidity} }}")).collect();
    let list = format!("{FIRST}\nalso_at = [{}]", each.join(", "));
    let place = Place::with(&[("range.toml", &with(range)), ("list.toml", &with(&list))]);
    let told = place.succeed(&["optimize", "range.toml", "-o", "out/one", "--no-explorer"]);
    assert!(told.contains("1.5 mm/s, 80 %") && told.contains("4 mm/s, 80 %"), "{told}");
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
    assert_eq!(places, [vec![[2.0, 15.0]], further].concat());
    assert!(place.read("out/one/scene.toml").contains("speed_mm_s = 2.0"));
    // Each humidity has what was measured there; of the speed nothing is known, which moves a median by little.
    let of = |humidity: f64| -> Vec<f64> {
        let own = at(&one).iter().zip(factors(&one)).filter(|(at, _)| at["humidity_pct"] == humidity);
        own.map(|(_, factor)| factor).collect()
    };
    let (dry, humid) = (of(15.0), of(80.0));
    for own in [&dry, &humid] {
        assert!(own.len() == 3 && own.iter().all(|factor| (factor - own[0]).abs() < 2e-3), "{own:?}");
    }
    assert!((humid[0] / dry[0] - 0.73 / 0.81).abs() < 0.05 && humid[0] < dry[0] - 0.04, "{dry:?} {humid:?}");
}

#[test]
fn a_calibration_takes_in_every_condition_of_a_range() {
    let calibration =
        patterned_calibration("planform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 20.0\n");
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
    let text = free(&design("quantity = \"ratio\"\nvalue = 0.8\ntolerance = 0.08", &[(2.0, 15.0, 0.27)], ""));
    let with = |humidity: &str| measured(&text, "c.toml").replace("_pct = 15.0", &format!("_pct = {humidity}"));
    let place = Place::with(&[
        ("a.toml", &with("[15.0, 80.0]")),
        ("outside.toml", &with("[15.0, 81.0]")),
        ("c.toml", &calibration),
        ("flat.csv", &table(1.0, 1.0)),
        ("patterned.csv", &table(0.9, 0.8)),
    ]);
    let message = place.refuse(&["optimize", "outside.toml"]);
    assert!(message.contains("outside.toml:4: condition: ") && message.contains("2 mm/s at 81 %"), "{message}");
    place.succeed(&["optimize", "a.toml"]);
    let found = result(&place, "out/a");
    assert_eq!((found["trials"].as_u64(), at(&found).len()), (Some(1), 5));
    // Measured ratios are 0.9 at 15 % and 0.8 at 80 %; modelled ones hardly differ.
    let factors = factors(&found);
    let of = |humidity: f64| at(&found).iter().position(|at| at["humidity_pct"] == humidity).unwrap();
    let [dry, humid] = [15.0, 80.0].map(|humidity| factors[of(humidity)]);
    assert!((humid / dry / (0.8 / 0.9) - 1.0).abs() < 0.05, "{dry} {humid}");
    let flat = number(&found["confirmed"][0]["mu_flat"]);
    assert!((flat / (0.25 * 1.01) - 1.0).abs() < 0.02, "{flat}");
}
