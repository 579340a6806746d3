//! Contradicting or impossible inputs are reported with file, line and key before any computation.

use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::design::Design;
use slipgrid_io::formats::document::Document;

use crate::common::{CALIBRATION, DESIGN, FLAT, Place, SCENE};

/// Messages about contradictions between a design and its calibration.
fn contradictions(design: &str, calibration: &str) -> Vec<String> {
    let place = Place::with(&[("c.toml", calibration), ("flat.csv", FLAT)]);
    let (head, rest) = design.split_once("[material]").unwrap();
    let design = format!("{head}material = \"c.toml\"\n[target]{}", rest.split_once("[target]").unwrap().1);
    place.write("d.toml", design);
    let design = Design::read(&slipgrid_io::disk::disk(), &place.path("d.toml")).unwrap();
    let calibration = Calibration::read(&slipgrid_io::disk::disk(), &place.path("c.toml")).unwrap();
    let folder = format!("{}/", place.path("").display()).replace("//", "/");
    design.contradictions(&calibration).iter().map(|told| told.to_string().replace(&folder, "")).collect()
}

#[test]
fn a_thickness_that_a_design_does_not_know_is_told() {
    let thick = |mm: &str| CALIBRATION.replace("radius_mm = 5.0\n", &format!("radius_mm = 5.0\nthickness_mm = {mm}\n"));
    let plain = DESIGN.replace("layer_um = 200.0\n", "");
    let told = contradictions(&plain, &thick("4.0"));
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].starts_with("d.toml: sample.thickness_mm: is not given, so that 7 mm is taken"), "{told:?}");
    assert!(
        told[0].contains("the specimen of the calibration is 4 mm thick; expected thickness_mm = 4 in [sample]"),
        "{told:?}"
    );
    let stated = plain.replace("[sample]\n", "[sample]\nthickness_mm = 6.0\n");
    let told = contradictions(&stated, &thick("4.0"));
    assert!(told[0].starts_with("d.toml:25: sample.thickness_mm: 6.0 mm is the thickness here"), "{told:?}");
    for (design, calibration) in [
        (&stated, thick("6.0")),
        (&plain, thick("7.0")),
        (&plain, CALIBRATION.to_owned()),
        (&DESIGN.to_owned(), thick("4.0")),
    ] {
        assert_eq!(contradictions(design, &calibration), [""; 0]);
    }
}

#[test]
fn a_holder_that_a_design_does_not_know_is_told() {
    let held = |holder: &str| format!("thickness_mm = 7.0\nholder = \"{holder}\"\n");
    let calibration = CALIBRATION.replace("radius_mm = 5.0\n", &format!("radius_mm = 5.0\n{}", held("rigid")));
    let design = |keys: &str| DESIGN.replace("layer_um = 200.0\n", keys);
    let told = contradictions(&design(""), &calibration);
    assert_eq!(
        told,
        ["d.toml: sample.holder: is not given, and the holder of the calibration's specimen is \"rigid\"; expected \
          holder = \"rigid\" beside thickness_mm in [sample], if the design is for a specimen that is held so"]
    );
    let told = contradictions(&design(&held("self-aligning")), &calibration);
    assert!(told[0].starts_with("d.toml:26: sample.holder: \"self-aligning\" is the holder here, and"), "{told:?}");
    // Nothing tilts a layer alone.
    for (design, calibration) in [
        (design(&held("rigid")), &calibration[..]),
        (DESIGN.to_owned(), &calibration),
        (design(&held("rigid")), CALIBRATION),
    ] {
        assert_eq!(contradictions(&design, calibration), [""; 0]);
    }
}

#[test]
fn a_speed_that_no_run_confirms_is_told_as_a_number() {
    let place = Place::with(&[]);
    let told = |text: &str| -> Vec<String> {
        let document = Document::within(&slipgrid_io::disk::disk(), place.path("d.toml"), text);
        Design::from_document(document).unwrap().told.iter().map(Diagnostic::to_string).collect()
    };
    // v = 0.1 P / sqrt(E rho) = 1.52 mm/s, and 2 mm/s is the speed without a condition.
    let slow = DESIGN.replace("[0.65, 2.6]", "[0.1, 2.6]").replace("= 0.38", "= 48.0");
    let said = told(&slow);
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(
        said[0].contains("youngs_modulus_gpa: 48.0 is unusual") && said[0].ends_with("would be 0.048 GPa"),
        "{said:?}"
    );
    assert!(said[1].contains("2 mm/s is too fast at 0.1 MPa with E = 48 GPa: no run in time confirms"), "{said:?}");
    assert!(said[1].ends_with("expected speed_mm_s of at most 1.5, or higher pressures"), "{said:?}");
    assert_eq!(told(DESIGN), [""; 0]);
}

#[test]
fn a_modulus_in_megapascals_is_named_before_anything_runs() {
    // 10 mm/s at 0.15 MPa: of 48 MPa, written as GPa.
    let text = CALIBRATION.replace("= 0.38", "= 48").replace("= 0.08", "= 4").replace("= 0.9", "= 1.21");
    let flat = FLAT.replace("50,2,15,0.248,0.002", "11.8,10,41,0.65,0.01");
    let place = Place::with(&[("c.toml", &text), ("flat.csv", &flat)]);
    let refused = place.refuse(&["calibrate", "c.toml"]);
    assert!(
        refused
            .contains("warning: c.toml:4: material.youngs_modulus_gpa: 48 is unusual: solids lighter than 1.4 g/cm3"),
        "{refused}"
    );
    let said = "error: flat.csv:2: (11.8 N, 10 mm/s, 41 %): 10 mm/s is too fast at 0.15 MPa with E = 48 GPa; expected force_n of at least 60, \
                speed_mm_s of at most 1.9, or youngs_modulus_gpa of at most 1.8 (in MPa, that would be 0.048 GPa)";
    assert!(refused.contains(said), "{refused}");
}

#[test]
fn forces_and_speeds_in_each_others_column_are_named() {
    let flat = FLAT.replace("50,2,15,0.248,0.002", "2,50,15,0.248,0.002");
    let place = Place::with(&[("c.toml", CALIBRATION), ("flat.csv", &flat)]);
    let refused = place.refuse(&["calibrate", "c.toml"]);
    assert!(refused.contains("flat.csv:2: (2 N, 50 mm/s, 15 %): 50 mm/s is too fast"), "{refused}");
    assert!(refused.contains("; with force_n and speed_mm_s in each other's place, 50 N at 2 mm/s"), "{refused}");
}

#[test]
fn full_contact_and_measured_friction_may_fall_with_pressure() {
    let scene = |factor: &str| SCENE.replace("factor = [1.0, 0.96, 0.90, 0.60]", &format!("factor = {factor}"));
    // Full contact, and friction that was measured, which may fall.
    let full = scene("[1.0, 0.539, 0.27, 0.07]");
    let measured =
        scene("[1.0, 0.5, 0.2, 0.04]").replace("[material.area_law]", "[material.area_law]\norigin = \"measured\"");
    let place = Place::with(&[("full.toml", &full), ("measured.toml", &measured)]);
    place.succeed(&["simulate", "full.toml"]);
    place.succeed(&["simulate", "measured.toml"]);
}
