//! Unusual values are warned of before a run that they may cause to be refused.

use crate::common::{CALIBRATION, DESIGN, Place, SCENE, small};

/// Table with forces of 0.6 and 1 N entered in kN, and friction with its two forces exchanged.
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
fn what_is_doubtful_of_a_material_is_said_by_next_and_explore_as_by_optimize() {
    let text = small().replacen("[material]\n", "[material]\nwarnings = [\"slope: odd\"]\n", 1);
    let place = Place::with(&[("d.toml", &text)]);
    let doubt = "the material is doubtful: slope: odd\n";
    let said = |args: &[&str]| String::from_utf8(place.run(args).stdout).unwrap();
    // The screen leaves the source out.
    assert!(
        said(&["optimize", "d.toml"]).contains(&format!("! {doubt}"))
            && said(&["next", "d.toml"]).contains("! slope: odd\n")
    );
    let explored = place.run(&["explore", "d.toml", "-o", "e.html"]);
    let told = String::from_utf8(explored.stderr).unwrap();
    assert!(told.contains(&format!("warning: {doubt}")), "{told}");
    assert!(std::fs::read_to_string(place.path("e.html")).unwrap().contains("The material is doubtful: slope: odd."));
}
