//! Unusual values are warned of before a run that they may cause to be refused.

use crate::common::{CALIBRATION, DESIGN, Place, SCENE, measured, small};

/// Table with forces of 0.6 and 1 N entered in kN, and friction with its two forces exchanged.
const SLIPS: &str =
    "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n0.0006,20,15,2.5,0.02\n0.001,20,15,2.0,0.02\n";

const EXCHANGED: &str = "2 of 2 friction coefficients are above 1, as of rubber; if friction force and normal force stand in each other's \
                         place, friction would be 0.4 to 0.5";

#[test]
fn slips_of_units_and_columns_are_told_before_a_run_is_refused() {
    let design = measured(DESIGN, "c.toml").replace("speed_mm_s = 2.0", "speed_mm_s = 20.0");
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", SLIPS), ("d.toml", &design)]);
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
fn an_unusual_scene_is_told_of_and_solved() {
    let scene = SCENE.replace("youngs_modulus_gpa = 0.38", "youngs_modulus_gpa = 380.0");
    let place = Place::with(&[("s.toml", &scene), ("usual.toml", SCENE)]);
    let told = place.told(&["simulate", "s.toml"]);
    assert!(told.contains("warning: s.toml:2: material.youngs_modulus_gpa: 380.0 is unusual"), "{told}");
    assert!(!place.told(&["simulate", "usual.toml"]).contains("warning"));
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
    assert!(place.read("e.html").contains("The material is doubtful: slope: odd."));
}
