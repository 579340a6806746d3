//! From the map of a cut sample to the friction of its face: the mean period of the map becomes the relief of a scene
//! and of a calibration.

use crate::common::{Place, SCENE, THREE_FORCES, patterned};

/// Options for a map of grooves 60/140/5.2 um with round rims 0.5 um high and 20 um wide, on pixels of 2 um.
const MADE: &str = "synthesize --pixels 512 --side-mm 1.024 --waves 4:128 --cavities 60,140,5.2 --wall-um 2 \
                    --cavity-std 0,0,0 --rims 0.5,20 --rim-profile round -o sample.asc --quiet";
const PATTERN: &str = "[pattern]\nplanform = \"groove\"\nwidth_um = 60.0\nspacing_um = 140.0\ndepth_um = 5.2\n";

fn scene(more: &str) -> String {
    let start = SCENE.find("[pattern]").unwrap();
    let end = SCENE[start + 1..].find("\n[").unwrap() + start + 2;
    format!("{}{PATTERN}{more}\n{}", &SCENE[..start], &SCENE[end..])
}

#[test]
fn the_mean_period_of_a_map_gives_the_friction_of_its_rims_in_scenes_and_calibrations() {
    let rims = "rim_height_um = 0.5\nrim_width_um = 20.0\nrim_profile = \"round\"\n";
    let relief = "relief = \"period.asc\"\n";
    let cut = THREE_FORCES.replace("0.25,", "0.22,").replace("0.26,", "0.22,");
    let place = Place::with(&[
        ("flat.toml", &scene("")),
        ("rims.toml", &scene(rims)),
        ("relief.toml", &scene(relief)),
        ("both.toml", &scene(&format!("{relief}{rims}"))),
        ("other.toml", &scene(relief).replace("140.0", "160.0")),
        ("none.toml", &scene("relief = \"none.asc\"\n")),
        ("flat.csv", THREE_FORCES),
        ("patterned.csv", &cut),
        ("c-flat.toml", &patterned(PATTERN)),
        ("c-relief.toml", &patterned(&format!("{PATTERN}{relief}"))),
        ("c-rims.toml", &patterned(&format!("{PATTERN}rim_height_um = 0.1\nrim_width_um = 10.0\n"))),
    ]);
    place.succeed(MADE);
    place.succeed("surface sample.asc --cavities --period-out period.asc");
    let [flat, rims, relief] = ["flat", "rims", "relief"].map(|name| place.ratios(&format!("{name}.toml")));
    for ((flat, rims), relief) in flat.iter().zip(&rims).zip(&relief) {
        // Roughness is left in the mean of few periods: a tenth of what the rims do.
        let (by_rims, by_relief) = (flat - rims, flat - relief);
        assert!(by_rims > 0.03 && (by_relief / by_rims - 1.0).abs() < 0.25, "{flat} {rims} {relief}");
    }
    place.refuse_all(
        "simulate both.toml => stands beside rims
         simulate other.toml => expected one period of the pattern
         simulate none.toml => cannot be read",
    );
    // ln(measured / modelled) of the samples of a calibration: what their rims do is no longer the model's error.
    let [flat, relief, rims] = ["c-flat", "c-relief", "c-rims"].map(|name| place.log_excess(name));
    assert!(relief > flat + 0.02 && rims > flat + 0.005, "{flat} {relief} {rims}");
}
