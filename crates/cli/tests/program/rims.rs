//! Rims along the edges of cavities: in scenes and designs, and in all files written for them.

use crate::common::{DESIGN, Place, at, limit, row};

const RIMS: &str = "rim_height_um = 0.1\nrim_width_um = 20.0\nrim_profile = \"flat\"\n";

/// Design of a short sample at one pressure and one spacing.
fn design(rims: &str, tolerances: &str) -> String {
    let text = DESIGN
        .replace("diameter_mm = 10.0", "diameter_mm = 2.0")
        .replace("layer_um = 200.0", "layer_um = 60.0")
        .replace("[2.0, 50.0]", "[2.0, 30.0]")
        .replace("[0.65, 2.6]", "[1.3]")
        .replace("value = 0.9\ntolerance = 0.01", "value = 0.88\ntolerance = 0.03")
        .replace("[40.0, 400.0]", "[60.0, 150.0]")
        .replace("[40.0, 1000.0]", "[170.0, 170.0]")
        .replace("planform = \"groove\"\n", &format!("planform = \"groove\"\n{rims}"));
    format!("{text}[tolerances]\nwidth_std_um = 2.0\n{tolerances}")
}

#[test]
fn a_design_with_rims_carries_them_and_their_tolerance_into_every_file() {
    let rims = "rim_heights_um = [[2.6, 0.07], [20.0, 0.13]]\nrim_width_um = 20.0\nrim_profile = \"ramp\"\n\
                rim_height_std_um = 0.01\n";
    let text = design(rims, "rim_height_std_um = 0.02\n");
    let place = Place::with(&[("d.toml", &text)]);
    place.succeed("optimize d.toml -o out");
    let found = place.result("out");
    assert_eq!(found["design"]["rim_heights_um"], serde_json::json!([[2.6, 0.07], [20.0, 0.13]]));
    assert_eq!(limit(&found, "rim height")["known_to"], "made to 0.02 um");
    // The scene is the design, to the last digit; so is what is exported of the result.
    let written = &place.json("simulate out/scene.toml --json --fidelity steady --extent cell")["pattern"];
    let sheet = serde_json::to_value(place.toml("out/process.toml")).unwrap();
    for key in ["rim_heights_um", "rim_width_um", "rim_profile", "rim_height_std_um", "width_um", "depth_um"] {
        assert_eq!(written[key], found["design"][key], "{key}");
        assert!(key == "rim_heights_um" || sheet["pattern"][key] == found["design"][key], "{key}: {sheet}");
    }
    place.succeed("export out -o again");
    assert_eq!(place.read("again/process.toml"), place.read("out/process.toml"));
    // Rims of other heights have other answers.
    place.write("d.toml", text.replace(rims, RIMS));
    assert!(place.refuse("optimize d.toml -o out --resume").contains("rim"));
}

/// A scatter of rim heights about zero is accepted. Rims cannot be lower than the land, so that it scatters samples by
/// half as much as elsewhere.
#[test]
fn rims_of_no_height_may_have_some() {
    let half = design("rim_height_um = 0\nrim_width_um = 20.0\n", "rim_height_std_um = 0.02\n");
    let found = Place::with(&[("half.toml", &half)]).optimized("half", 0).1;
    assert!(found["design"].get("rim_width_um").is_none(), "{}", found["design"]);
    assert!(row(&found["limited_by"], "input", "rim height").is_some_and(|limit| at(limit, "/std/0") > 0.0), "{found}");
}
