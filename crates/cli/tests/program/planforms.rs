//! Polygons and crossing grooves from the input file to the laser's file.

use std::fs;
use std::path::Path;

use crate::common::{Place, SCENE, result, small};
use serde_json::Value;

fn shipped(name: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("../../designs").join(name)).unwrap()
}

/// Scene of coarse blocks with the lines `keys` instead of the planform.
fn scene(keys: &str) -> String {
    SCENE
        .replace("planform = \"groove\"", keys)
        .replace("width_um = 130.0\nspacing_um = 370.0", "width_um = 100.0\nspacing_um = 60.0")
        .replace("block_um = 10.0", "block_um = 20.0")
}

fn simulated(place: &Place, text: &str) -> Value {
    place.write("a.toml", text);
    place.json(&["simulate", "a.toml", "--json"])
}

/// Result of the search of the design `text`, the scene and all laser files of which are made as well.
fn searched(place: &Place, text: &str) -> Value {
    place.write("design.toml", text);
    place.succeed(&["optimize", "design.toml", "-o", "out"]);
    // The confirming run is a scene that reads back.
    place.succeed(&["simulate", "out/scene.toml", "--json"]);
    let formats = "dxf,svg,csv,process,plt,gcode,corners,hatch,png,stl";
    place.succeed(&["export", "out/result.json", "--format", formats, "-o", "files"]);
    result(place, "out")
}

#[test]
fn hexagons_of_a_drawing_are_those_of_a_list_of_vertices() {
    let place = Place::with(&[]);
    // Coarser, and with nothing behind the layer: in a second.
    let coarse = shipped("scene-hexagon.toml").replace("block_um = 20.0", "block_um = 20.0\nlayer_um = 40.0");
    place.write("scene-hexagon.toml", coarse.replace("depth_um = 20.0", "depth_um = 15.0"));
    place.write("hexagon.svg", shipped("hexagon.svg"));
    let drawn = place.json(&["simulate", "scene-hexagon.toml", "--json"]);
    assert_eq!((drawn["dimensions"].as_u64(), drawn["pattern"]["vertices_um"].as_array().unwrap().len()), (Some(3), 6));
    // Hexagons within hexagons one pitch apart.
    assert!((drawn["areal_density"].as_f64().unwrap() - (100.0_f64 / 160.0).powi(2)).abs() < 1e-9);
    let ratios = |told: &Value| -> Vec<f64> {
        told["results"].as_array().unwrap().iter().map(|load| load["ratio"].as_f64().unwrap()).collect()
    };
    assert!(ratios(&drawn)[1] < 0.95 && ratios(&drawn)[1] < ratios(&drawn)[0], "{drawn}");
    // The same by a list of vertices at another scale, and by a DXF drawing.
    let corners: Vec<[f64; 2]> = (0..6)
        .map(|k| (f64::from(k) * 60.0 + 30.0_f64).to_radians())
        .map(|angle| [7.0 * angle.cos(), 7.0 * angle.sin()])
        .collect();
    let list = format!("vertices_um = {}", serde_json::to_string(&corners).unwrap());
    let vertices: String = corners.iter().map(|[x, y]| format!("0\nVERTEX\n8\nHEX\n10\n{x}\n20\n{y}\n")).collect();
    let dxf =
        format!("0\nSECTION\n2\nENTITIES\n0\nPOLYLINE\n8\nHEX\n66\n1\n70\n1\n{vertices}0\nSEQEND\n0\nENDSEC\n0\nEOF\n");
    place.write("hexagon.dxf", dxf);
    for other in [list.as_str(), "outline = \"hexagon.dxf\"\noutline_layer = \"HEX\""] {
        let text = place
            .read("scene-hexagon.toml")
            .lines()
            .map(|line| if line.starts_with("outline") { other } else { line })
            .collect::<Vec<_>>()
            .join("\n");
        let told = simulated(&place, &text);
        for (a, b) in ratios(&drawn).iter().zip(ratios(&told)) {
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
    }
}

#[test]
fn plain_planforms_as_polygons_and_crossings_as_they_should_be() {
    let place = Place::with(&[]);
    let ratio = |keys: &str| simulated(&place, &scene(keys))["results"][1]["ratio"].as_f64().unwrap();
    let square = ratio("planform = \"square\"");
    assert!((ratio("planform = \"polygon\"\nvertices_um = [[0, 0], [0, 2], [2, 2], [2, 0]]") - square).abs() < 1e-12);
    let groove = ratio("planform = \"groove\"");
    let crossed = simulated(&place, &scene("planform = \"crosshatch\""));
    assert!((crossed["areal_density"].as_f64().unwrap() - (1.0 - (60.0_f64 / 160.0).powi(2))).abs() < 1e-12);
    let found = crossed["results"][1]["ratio"].as_f64().unwrap();
    assert!(found < groove && groove < square, "{found} {groove} {square}");
    // Along one family or along the other is one by symmetry; turned as one is the same.
    for keys in ["sliding_angle_deg = 90", "angle_deg = 25\nsliding_angle_deg = 25"] {
        let same = ratio(&format!("planform = \"crosshatch\"\n{keys}"));
        assert!((same - found).abs() < 1e-9, "{keys}: {same} {found}");
    }
}

#[test]
fn crossing_grooves_are_searched_confirmed_and_exported() {
    let place = Place::with(&[]);
    let keys = "\"crosshatch\"\nangle_deg = -30.0\ncrossing_angle_deg = 60.0";
    let text = small().replace("\"groove\"", keys).replace("spot_um = 23.0", "spot_um = 23.0\nspeed_mm_s = 100.0");
    // Grooves that cross take more than half of the face.
    let text = text.replace("value = 0.9", "value = [0.8, 0.65]");
    let result = searched(&place, &text);
    let design = &result["design"];
    let [width, spacing] = ["width_um", "spacing_um"].map(|key| design[key].as_f64().unwrap());
    let density = 1.0 - (spacing / (width + spacing)).powi(2);
    assert!((design["areal_density"].as_f64().unwrap() - density).abs() < 1e-9);
    assert_eq!((design["crossing_angle_deg"].as_f64(), result["dimensions"].as_u64()), (Some(60.0), Some(3)));
    let process = place.read("out/process.toml");
    assert!(
        process.contains("crossing_angle_deg = 60.0") && process.contains("crossings are marked once"),
        "{process}"
    );
    for name in ["pattern.gcode", "removed.stl", "height-map.png", "corners.csv"] {
        assert!(fs::metadata(place.path("files").join(name)).unwrap().len() > 500, "{name}");
    }
}

#[test]
fn polygons_are_searched_confirmed_and_exported() {
    let place = Place::with(&[]);
    let keys =
        "\"polygon\"\nvertices_um = [[0, 0], [10, 1], [9, 6], [6, 5], [6, 11], [0, 10]]\narrangement = \"staggered\"";
    let text = small().replace("\"groove\"", keys).replace("spot_um = 23.0", "spot_um = 15.0\nspeed_mm_s = 100.0");
    let result = searched(&place, &text);
    let corners = result["design"]["vertices_um"].as_array().unwrap();
    let x = |corner: &Value| corner[0].as_f64().unwrap();
    let extent =
        corners.iter().map(x).fold(f64::NEG_INFINITY, f64::max) - corners.iter().map(x).fold(f64::INFINITY, f64::min);
    assert!(corners.len() == 6 && (extent - result["design"]["width_um"].as_f64().unwrap()).abs() < 1e-9);
    let rows = place.read("files/corners.csv").lines().count() - 1;
    let cavities = place.read("files/pattern.csv").lines().count() - 1;
    assert_eq!(rows, 6 * cavities);
    // A study of another outline is not taken over.
    place.write("design.toml", text.replace("[6, 5]", "[5, 5]"));
    let refused = place.refuse(&["optimize", "design.toml", "-o", "out", "--resume"]);
    assert!(refused.contains("vertices_um"), "{refused}");
}

#[test]
fn a_strip_in_space_is_drawn_from_end_to_end() {
    let place = Place::with(&[]);
    let strip = |keys: &str| {
        scene(keys)
            .replace("\"cell\"", "\"strip\"")
            .replace("length_um = 9960.0", "length_um = 960.0\nlayer_um = 100.0")
    };
    place.write("a.toml", strip("planform = \"square\"").replace("layer_um = 200.0", ""));
    let told = place.json(&["simulate", "a.toml", "--json", "-o", "out/a"]);
    assert_eq!((told["dimensions"].as_u64(), told["extent"].as_str()), (Some(3), Some("strip")));
    let table = place.read("out/a/interface.csv");
    let reach = |column: usize| {
        let places = table.lines().skip(1).map(|line| line.split(',').nth(column).unwrap().parse::<f64>().unwrap());
        places.fold(0.0, f64::max)
    };
    // The last of 48 columns along, and of 8 across.
    assert_eq!((reach(2), reach(3)), (950.0, 150.0));
    let svg = fs::read_dir(place.path("out/a")).unwrap().map(|entry| entry.unwrap().path());
    let mut svg = svg.filter(|path| path.to_string_lossy().contains("interface-"));
    assert!(fs::read_to_string(svg.next().unwrap()).unwrap().contains("Pressure through cavities"));
}
