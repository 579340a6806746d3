//! Polygons and crossing grooves from the input file to the laser's file.

use std::fs;

use crate::common::{Place, SCENE, at, column, small};
use serde_json::Value;

/// Scene of coarse blocks with the lines `keys` instead of the planform.
fn scene(keys: &str) -> String {
    SCENE
        .replace("planform = \"groove\"", keys)
        .replace("width_um = 130.0\nspacing_um = 370.0", "width_um = 100.0\nspacing_um = 60.0")
        .replace("block_um = 10.0", "block_um = 20.0")
}

/// Result of the search of the design `text`, the scene and all laser files of which are made as well.
fn searched(place: &Place, text: &str) -> Value {
    place.write("design.toml", text);
    place.succeed("optimize design.toml -o out");
    // The confirming run is a scene that reads back.
    place.succeed("simulate out/scene.toml --json");
    place.succeed("export out/result.json --format dxf,svg,csv,process,plt,gcode,corners,hatch,png,stl -o files");
    for name in ["pattern.gcode", "removed.stl", "height-map.png", "corners.csv"] {
        assert!(fs::metadata(place.path("files").join(name)).unwrap().len() > 500, "{name}");
    }
    place.result("out")
}

#[test]
fn crossing_grooves_and_polygons_are_searched_confirmed_and_exported() {
    let place = Place::with(&[]);
    let with = |keys: &str| {
        small().replace("\"groove\"", keys).replace("spot_um = 23.0", "spot_um = 15.0\nspeed_mm_s = 100.0")
    };
    // Grooves that cross take more than half of the face.
    let crossing = with("\"crosshatch\"\nangle_deg = -30.0\ncrossing_angle_deg = 60.0");
    let result = searched(&place, &crossing.replace("value = 0.9", "value = [0.8, 0.65]"));
    let [width, spacing] = ["/design/width_um", "/design/spacing_um"].map(|pointer| at(&result, pointer));
    let density = 1.0 - (spacing / (width + spacing)).powi(2);
    assert!((at(&result, "/design/areal_density") - density).abs() < 1e-9);
    assert_eq!((at(&result, "/design/crossing_angle_deg"), at(&result, "/dimensions")), (60.0, 3.0));
    assert_eq!(place.toml("out/process.toml")["pattern"]["crossing_angle_deg"].as_float(), Some(60.0));

    let polygon = with(
        "\"polygon\"\nvertices_um = [[0, 0], [10, 1], [9, 6], [6, 5], [6, 11], [0, 10]]\narrangement = \"staggered\"",
    );
    let result = searched(&place, &polygon);
    let x = column(&result["design"]["vertices_um"], "/0");
    let extent = x.iter().copied().fold(f64::NEG_INFINITY, f64::max) - x.iter().copied().fold(f64::INFINITY, f64::min);
    assert!(x.len() == 6 && (extent - at(&result, "/design/width_um")).abs() < 1e-9);
    let rows = |name: &str| place.read(name).lines().count() - 1;
    assert_eq!(rows("files/corners.csv"), 6 * rows("files/pattern.csv"));
    // A study of another outline is not taken over.
    place.write("design.toml", polygon.replace("[6, 5]", "[5, 5]"));
    assert!(place.refuse("optimize design.toml -o out --resume").contains("vertices_um"));
}

#[test]
fn a_strip_in_space_is_drawn_from_end_to_end() {
    let text = scene("planform = \"square\"").replace("\"cell\"", "\"strip\"").replace("layer_um = 200.0\n", "");
    let text = text.replace("length_um = 9960.0", "length_um = 960.0\nlayer_um = 100.0");
    let place = Place::with(&[("a.toml", &text)]);
    let told = place.json("simulate a.toml --json -o out/a");
    assert_eq!((told["dimensions"].as_u64(), told["extent"].as_str()), (Some(3), Some("strip")));
    let table = place.read("out/a/interface.csv");
    let reach = |column: usize| {
        let places = table.lines().skip(1).map(|line| line.split(',').nth(column).unwrap().parse::<f64>().unwrap());
        places.fold(0.0, f64::max)
    };
    // The last of 48 columns along, and of 8 across.
    assert_eq!((reach(2), reach(3)), (950.0, 150.0));
    assert!(place.path("out/a/interface-2.6mpa.svg").is_file());
}
