//! From the map of a cut sample to the friction of its face: the mean period of the map becomes the relief of a scene
//! and of a calibration.

use crate::common::{Place, SCENE, THREE_FORCES, patterned_calibration};
use serde_json::Value;

/// Options for a map of grooves 60/140/5.2 um with round rims 0.5 um high and 20 um wide, on pixels of 2 um.
const MADE: &str = "synthesize --pixels 512 --side-mm 1.024 --waves 4:128 --cavities 60,140,5.2 --wall-um 2 \
                    --cavity-std 0,0,0 --rims 0.5,20 --rim-profile round -o sample.asc --quiet";

fn scene(more: &str) -> String {
    let pattern = "[pattern]\nplanform = \"groove\"\nwidth_um = 60.0\nspacing_um = 140.0\ndepth_um = 5.2\n";
    let start = SCENE.find("[pattern]").unwrap();
    let end = SCENE[start + 1..].find("\n[").unwrap() + start + 2;
    format!("{}{pattern}{more}\n{}", &SCENE[..start], &SCENE[end..])
}

fn ratios(place: &Place, name: &str) -> Vec<f64> {
    let result: Value = place.json(&["simulate", name, "--json"]);
    result["results"].as_array().unwrap().iter().map(|row| row["ratio"].as_f64().unwrap()).collect()
}

#[test]
fn the_mean_period_of_a_map_gives_the_friction_of_its_rims() {
    let rims = "rim_height_um = 0.5\nrim_width_um = 20.0\nrim_profile = \"round\"\n";
    let place = Place::with(&[
        ("flat.toml", &scene("")),
        ("rims.toml", &scene(rims)),
        ("relief.toml", &scene("relief = \"period.asc\"\n")),
        ("turned.toml", &scene("relief = \"turned.asc\"\n")),
        ("aside.toml", &scene("relief = \"aside.asc\"\n")),
        ("both.toml", &scene(&format!("relief = \"period.asc\"\n{rims}"))),
        ("other.toml", &scene("relief = \"period.asc\"\n").replace("140.0", "160.0")),
        ("none.toml", &scene("relief = \"none.asc\"\n")),
    ]);
    place.succeed_line(MADE);
    place.succeed(&["surface", "sample.asc", "--cavities", "--period-out", "period.asc"]);
    let [flat, rims, relief] = ["flat.toml", "rims.toml", "relief.toml"].map(|name| ratios(&place, name));
    for ((flat, rims), relief) in flat.iter().zip(&rims).zip(&relief) {
        // Roughness is left in the mean of few periods: a tenth of what the rims do.
        let (by_rims, by_relief) = (flat - rims, flat - relief);
        assert!(by_rims > 0.03 && (by_relief / by_rims - 1.0).abs() < 0.25, "{flat} {rims} {relief}");
    }
    // A map whose grooves run along its lines is turned: never ignored.
    let period = place.read("period.asc");
    let (header, rows): (Vec<&str>, Vec<&str>) = period.lines().partition(|line| line.starts_with('#'));
    let rows: Vec<Vec<&str>> = rows.iter().map(|row| row.split('\t').collect()).collect();
    let count = rows.len();
    let write = |name: &str, at: &dyn Fn(usize, usize) -> usize| {
        let lines =
            (0..count).map(|i| (0..count).map(|j| rows[at(i, j) / count][at(i, j) % count]).collect::<Vec<_>>());
        let lines: Vec<String> = lines.map(|line| line.join("\t")).collect();
        place.write(name, format!("{}\n{}\n", header.join("\n"), lines.join("\n")));
    };
    write("turned.asc", &|i, j| j * count + i);
    assert_eq!(ratios(&place, "turned.toml"), relief);
    // Half a period aside its cavity is where the pattern has land.
    write("aside.asc", &|i, j| i * count + (j + count / 2) % count);
    for (name, says) in [
        ("both.toml", "stands beside rims"),
        ("aside.toml", "a cavity in its middle"),
        ("other.toml", "expected one period of the pattern"),
        ("none.toml", "cannot be read"),
    ] {
        let said = place.refuse(&["simulate", name]);
        assert!(said.contains("pattern.relief") && said.contains(says), "{said}");
    }
}

#[test]
fn a_calibration_compares_its_samples_with_their_measured_relief() {
    let squares = "width_um = 60.0\nspacing_um = 140.0\ndepth_um = 5.2\n";
    let patterned = THREE_FORCES.replace("0.25,", "0.22,").replace("0.26,", "0.22,");
    let place = Place::with(&[
        ("flat.csv", THREE_FORCES),
        ("patterned.csv", &patterned),
        ("relief.toml", &patterned_calibration(&format!("{squares}relief = \"period.asc\"\n"))),
        ("flat.toml", &patterned_calibration(squares)),
    ]);
    place.succeed_line(MADE);
    place.succeed(&["surface", "sample.asc", "--cavities", "--period-out", "period.asc"]);
    let [relief, flat] = ["relief", "flat"].map(|name| place.log_excess(name));
    // ln(measured / modelled): what the rims of the map do is no longer the model's error.
    assert!(relief > flat + 0.02, "{relief} {flat}");
}
