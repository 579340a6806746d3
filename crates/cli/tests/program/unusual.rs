//! What is unusual is said before a run that it may be the reason to refuse.

use crate::common::{CALIBRATION, DESIGN, Place, SCENE, small};

/// Loads that were entered in kN, 0.6 and 1 N, and friction whose two forces stand in each other's place.
const SLIPS: &str =
    "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n0.0006,20,15,2.5,0.02\n0.001,20,15,2.0,0.02\n";

const EXCHANGED: &str = "2 of 2 friction coefficients are above 1, as of rubber; if friction force and normal force stand in each other's \
                         place, friction would be 0.4 to 0.5";

#[test]
fn slips_of_units_and_columns_are_told_before_a_run_is_refused() {
    let (_, task) = DESIGN.split_once("[target]").unwrap();
    let at = "condition = { speed_mm_s = 20.0, humidity_pct = 15.0 }";
    let place = Place::with(&[
        ("c.toml", CALIBRATION),
        ("flat.csv", SLIPS),
        ("d.toml", &format!("name = \"slips\"\nmaterial = \"c.toml\"\n{at}\n[target]{task}")),
    ]);
    for command in [&["calibrate", "c.toml"][..], &["optimize", "d.toml"], &["next", "d.toml"]] {
        let message = place.refuse(command);
        let refused = message.find("error: flat.csv:").unwrap_or_else(|| panic!("{command:?}: {message}"));
        for says in ["warning: flat.csv:2: force_n: 0.0006", "in kN, that would be 0.6 N", EXCHANGED] {
            assert!(message.find(says).is_some_and(|told| told < refused), "{command:?}: {says}\n{message}");
        }
        assert_eq!(message.matches(EXCHANGED).count(), 1, "{message}");
    }
    assert!(!place.refuse(&["calibrate", "c.toml", "-q"]).contains("warning"));
}

#[test]
fn a_material_whose_coefficients_are_all_above_1_is_asked_about() {
    let high = |text: &str| {
        text.replace("static_mean = 0.30", "static_mean = 2.8").replace("dynamic_mean = 0.27", "dynamic_mean = 2.5")
    };
    let place = Place::with(&[("s.toml", &high(SCENE)), ("usual.toml", SCENE), ("d.toml", &high(&small()))]);
    let says = "in each other's place, friction would be 0.4";
    let told = |args: &[&str]| String::from_utf8(place.run(args).stderr).unwrap();
    let simulated = told(&["simulate", "s.toml"]);
    assert!(simulated.contains("warning: s.toml:6: material.friction.dynamic_mean: 2.5 is unusual"), "{simulated}");
    assert!(simulated.contains(says), "{simulated}");
    assert!(!told(&["simulate", "usual.toml"]).contains("warning"));
    let designed = told(&["optimize", "d.toml"]);
    assert!(designed.contains("warning: d.toml:7: material.friction.dynamic_mean: 2.5 is unusual"), "{designed}");
    assert!(designed.contains(says), "{designed}");
}

#[test]
fn designs_that_no_search_can_meet_are_refused_as_they_are_read() {
    let loads = "pressure_mpa = [0.65, 2.6]";
    for (from, to, key, says) in [
        (
            loads,
            "pressure_mpa = [0.65, 200.0]",
            "target.pressure_mpa: 200.0 MPa is above 0.5 of Young's modulus",
            "in kPa",
        ),
        (
            "max_peak_pressure_mpa = 20.0",
            "max_peak_pressure_mpa = 2.0",
            "target.pressure_mpa: 2.6 MPa is not below",
            "in line ",
        ),
        ("block_um = 20.0", "block_um = 0.01", "sample.block_um: 0.01 divides the layer into", "at most 4e7"),
    ] {
        let text = small().replace(from, to).replace("max_peak_pressure_mpa = 20.0", "max_peak_pressure_mpa = 2000.0");
        let place = Place::with(&[("d.toml", &text)]);
        let refused = place.run(&["optimize", "d.toml"]);
        let said = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(2), "{said}");
        assert!(said.contains("error: d.toml:") && said.contains(key) && said.contains(says), "{said}");
    }
    // A law that leaves no contact.
    let design = small();
    let (law, _) = design.split_once("factor = [1.0,").unwrap();
    let place = Place::with(&[("d.toml", &design.replacen("factor = [1.0,", "factor = [0.0,", 1))]);
    let said = place.refuse(&["optimize", "d.toml"]);
    let line = law.lines().count() + 1;
    assert!(said.contains(&format!("d.toml:{line}: material.area_law.factor: 0.0 leaves no contact")), "{said}");
}

#[test]
fn what_is_doubtful_of_a_material_is_said_by_next_and_explore_as_by_optimize() {
    let text = small().replacen("[material]\n", "[material]\nwarnings = [\"slope: odd\"]\n", 1);
    let place = Place::with(&[("d.toml", &text)]);
    let doubt = "the material is doubtful: slope: odd\n";
    let said = |args: &[&str]| String::from_utf8(place.run(args).stdout).unwrap();
    for command in ["optimize", "next"] {
        assert!(said(&[command, "d.toml"]).contains(&format!("! {doubt}")), "{command}");
    }
    let explored = place.run(&["explore", "d.toml", "-o", "e.html"]);
    let told = String::from_utf8(explored.stderr).unwrap();
    assert!(told.contains(&format!("warning: {doubt}")), "{told}");
    assert!(std::fs::read_to_string(place.path("e.html")).unwrap().contains("The material is doubtful: slope: odd."));
}
