//! Commands on valid input: exit codes, output and written files.

use std::fs;

use crate::common::{
    CALIBRATION, COMMANDS, FLAT, Place, SCENE, THREE_FORCES, json, patterned, patterned_calibration, small,
};
use serde_json::Value;

/// The object without the values that depend on time and threads.
fn timeless(mut value: Value) -> Value {
    if let Value::Object(fields) = &mut value {
        fields.retain(|key, _| !matches!(key.as_str(), "wall_s" | "threads" | "timings_s" | "site_updates_per_s"));
        fields.values_mut().for_each(|field| *field = timeless(field.take()));
    } else if let Value::Array(items) = &mut value {
        items.iter_mut().for_each(|item| *item = timeless(item.take()));
    }
    value
}

#[test]
fn the_interface_of_cavities_in_space_is_drawn_from_above() {
    let disc = SCENE.replace("\"groove\"", "\"disc\"\narrangement = \"staggered\"\nsliding_angle_deg = 30.0");
    let groove = format!("{SCENE}dimensions = 3\n");
    let place = Place::with(&[("disc.toml", &disc), ("groove.toml", SCENE), ("groove3.toml", &groove)]);
    let solve = |scene: &str| place.json(&["simulate", scene, "--json", "-o", "out"]);
    let ratio = |result: &Value| result["results"][1]["ratio"].as_f64().unwrap();
    let (plane, space) = (solve("groove.toml"), solve("groove3.toml"));
    assert!((ratio(&plane) - ratio(&space)).abs() < 1e-9);
    solve("disc.toml");
    let interface = place.read("out/interface.csv");
    assert_eq!(interface.lines().next().unwrap(), "load_mpa,surface,x_um,y_um,pressure_mpa,friction_mpa");
    // From above, with its colour scale.
    let map = place.read("out/interface-2.6mpa.svg");
    assert_eq!(map.matches("<image ").count(), 2);
    assert!(map.contains("MPa") && map.contains("sliding direction, 30° from x") && map.contains("y (µm)"));
}

#[test]
fn square_cavities_in_two_dimensions_are_a_section_model() {
    let square = format!("{}dimensions = 2\n", SCENE.replace("\"groove\"", "\"square\""));
    let place = Place::with(&[("scene.toml", &square), ("groove.toml", SCENE)]);
    let square = place.json(&["simulate", "scene.toml", "--json"]);
    let groove = place.json(&["simulate", "groove.toml", "--json"]);
    assert_eq!(square["section_model"], true);
    assert_eq!(groove["section_model"], false);
    assert_eq!(square["areal_density"], 0.0676);
    assert_eq!(square["section_density"], 0.26);
    let ratio = square["results"][1]["ratio"].as_f64().unwrap();
    assert_eq!(square["results"][1]["ratio"], groove["results"][1]["ratio"]);
    // 1 - (width / pitch)(1 - ratio)
    let strip = square["results"][1]["ratio_strip_estimate"].as_f64().unwrap();
    assert!((strip - (1.0 - 0.26 * (1.0 - ratio))).abs() < 1e-12);
    assert!(groove["results"][1].get("ratio_strip_estimate").is_none());
    assert!(square["model"].to_string().contains("section model"));
}

#[test]
fn results_go_to_a_folder() {
    let place = Place::with(&[("scene.toml", SCENE)]);
    let printed = place.succeed(&["simulate", "scene.toml", "--json", "-o", "out/scene"]);
    let folder = place.path("out/scene");
    let rest = "interface.csv result.json timings.json uncertainty.csv";
    assert_eq!(place.listed("out/scene"), format!("interface-0.65mpa.svg interface-2.6mpa.svg {rest}"));
    let kept = fs::read_to_string(folder.join("result.json")).unwrap();
    assert_eq!(json(&kept), timeless(json(&printed)), "all but times");
    let times = json(&fs::read_to_string(folder.join("timings.json")).unwrap());
    assert!(times["wall_s"].as_f64().unwrap() >= 0.0 && times["threads"].as_u64().unwrap() >= 1);
    let interface = fs::read_to_string(folder.join("interface.csv")).unwrap();
    assert_eq!(interface.lines().next().unwrap(), "load_mpa,surface,x_um,pressure_mpa,friction_mpa");
    assert!(interface.lines().any(|line| line.starts_with("2.6,patterned,")));

    // A second run replaces its files and leaves what is not its own.
    fs::write(folder.join("notes.txt"), "mine").unwrap();
    place.succeed(&["simulate", "scene.toml", "-o", "out/scene"]);
    assert_eq!(fs::read_to_string(folder.join("notes.txt")).unwrap(), "mine");
    // Pictures of other loads go.
    place.write("scene.toml", SCENE.replace("[0.65, 2.6]", "1e-320"));
    place.succeed(&["simulate", "scene.toml", "-o", "out/scene"]);
    let left = "interface-1e-320mpa.svg interface.csv notes.txt result.json timings.json uncertainty.csv";
    assert_eq!((place.listed("out/scene").as_str(), place.listed("out").as_str()), (left, "scene"));
}

#[test]
fn a_synthetic_map_and_its_area_law() {
    let place = Place::with(&[]);
    let args = ["synthesize", "--pixels", "64", "--waves", "2:8", "--sa-um", "0.3", "--seed", "7", "-o", "map.asc"];
    let said = place.succeed(&args);
    assert!(said.contains("synthetic") && said.contains("64 x 64 pixels"), "{said}");
    let first = fs::read(place.path("map.asc")).unwrap();
    place.succeed(&args);
    assert_eq!(fs::read(place.path("map.asc")).unwrap(), first);

    let line =
        "area-law map.asc --pressures-mpa 0.3,0.7,1.4 --threshold-mpa 0.7 --youngs-modulus-gpa 0.38 --json -o law";
    let law = json(&place.succeed_line(line));
    assert_eq!(law["synthetic_surface"], true);
    assert!((law["sa_um"].as_f64().unwrap() - 0.3).abs() < 1e-4);
    assert_eq!(law["pixel_um"], 15.625);
    assert!(law["rms_slope"].as_f64().unwrap() > 0.0);
    let points = law["results"].as_array().unwrap();
    let area = |n: usize| points[n]["area_fraction_corrected"].as_f64().unwrap();
    assert!(area(0) < area(1) && area(1) < area(2));
    assert_eq!((&points[0]["factor"], &points[1]["factor"]), (&Value::from(1.0), &Value::from(1.0)));
    // f(P) = [A(P)/A(P0)] / [P/P0], P = 2 P0
    assert!((points[2]["factor"].as_f64().unwrap() - area(2) / area(1) / 2.0).abs() < 1e-12);
    assert_eq!(place.listed("law"), "area-law.csv area-law.svg result.json timings.json");

    // Where no pressure reaches down to 0.7 MPa, the area there is computed beside the list.
    let above = ["area-law", "map.asc", "--pressures-mpa", "1.4", "--json"];
    let stated = place.json(&[&above[..], &["--threshold-mpa", "0.7"]].concat());
    assert_eq!(stated["results"].as_array().unwrap().len(), 1);
    assert_eq!(stated["results"][0]["factor"], points[2]["factor"]);
    // Without a threshold A/P counts from a small load, at which 400 of the 64 x 64 points touch or more.
    let light = place.json(&above);
    let scale_mpa = 427.5 * law["rms_slope"].as_f64().unwrap();
    assert!((light["threshold_mpa"].as_f64().unwrap() / scale_mpa / 0.0612 - 1.0).abs() < 0.01, "{light}");
}

#[test]
fn an_area_law_states_its_uncertainty() {
    let place = Place::with(&[]);
    place.succeed(&["synthesize", "--pixels", "128", "--waves", "4:16", "-o", "map.asc"]);
    let list = ["area-law", "map.asc", "--pressures-mpa", "0.3,0.7,2.6", "--resolutions", "--json", "-o", "law"];
    let list = [&list[..], &["--threshold-mpa", "0.7"]].concat();
    let law = place.json(&list);
    let points = law["results"].as_array().unwrap();
    assert_eq!((&points[0]["factor_std"], &points[1]["factor_std"]), (&Value::from(0.0), &Value::from(0.0)));
    let std = points[2]["factor_std"].as_f64().unwrap();
    let spread = law["windows"]["factor_spread"][2].as_f64().unwrap();
    // Four windows, which count as two: Student's t of three degrees of freedom over the normal deviate.
    assert!(std > 0.0 && (std / spread - 3.182_446 / 1.959_964 / 2.0_f64.sqrt()).abs() < 1e-6);
    assert_eq!((&law["windows"]["count"], &law["windows"]["rows"]), (&Value::from(4), &Value::from(64)));
    assert!(points[2]["area_error"].as_f64().unwrap() < 1e-4);
    // Coarser pixels see less slope, and so a lower f.
    let (slope, factor) = (law["rms_slope"].as_f64().unwrap(), points[2]["factor"].as_f64().unwrap());
    for coarse in law["resolutions"].as_array().unwrap() {
        assert!(coarse["rms_slope"].as_f64().unwrap() < slope);
        assert!(coarse["factor"][2].as_f64().unwrap() < factor);
    }
    assert_eq!(law["resolutions"][1]["pixel_um"], 4.0 * law["pixel_um"].as_f64().unwrap());
    let svg = place.read("law/area-law.svg");
    assert!(svg.contains("standard error"));

    let alone =
        ["area-law", "map.asc", "--pressures-mpa", "0.7,2.6", "--windows", "1", "--json", "--threshold-mpa", "0.7"];
    let alone = place.json(&alone);
    assert_eq!(alone["results"][1]["factor"], points[2]["factor"]);
    assert!(alone["windows"].is_null() && alone["results"][1]["factor_std"].is_null());

    let theory = ["area-law", "--persson-rms-slope", "0.0137", "--pressures-mpa", "0.7,2.6", "--json"];
    let theory = place.json(&theory);
    assert!(theory["map"].is_null() && theory["sa_um"].is_null());
    let area =
        |mpa: f64| slipgrid_surface::contact::closed_form::persson_area_fraction(mpa * 1e6, 427.5e6, 0.0137).unwrap();
    // P0 is a small load, 0.01 E* h'rms = 0.0586 MPa.
    assert_eq!(theory["threshold_mpa"], 0.0586);
    let expected = area(2.6) / area(0.0586) * 0.0586 / 2.6;
    assert!((theory["results"][1]["factor"].as_f64().unwrap() - expected).abs() < 1e-12);
    // With another threshold P0 = 2.6 MPa nothing falls short of proportionality.
    let late =
        ["area-law", "--persson-rms-slope", "0.0137", "--pressures-mpa", "0.7,2.6", "--threshold-mpa", "2.6", "--json"];
    assert_eq!(place.json(&late)["results"][1]["factor"], 1.0);
}

#[test]
fn measured_ratios_are_tabulated() {
    let more = "200,2,15,0.278,0.001\n50,2,40,0.269,0.004\n";
    let cut = "200,2,15,0.224,0.002\n50,2,40,0.211,0.002\n";
    let place = Place::with(&[
        ("calibration.toml", &patterned()),
        ("flat.csv", &format!("{FLAT}{more}")),
        ("patterned.csv", &format!("{}{cut}", FLAT.replace("0.248,0.002", "0.208,0.007"))),
    ]);
    let result = place.json(&["validate", "calibration.toml", "--json"]);
    // Only the speed and humidity of the first row.
    assert_eq!(result["results"].as_array().unwrap().len(), 2);
    let row = &result["results"][0];
    assert!((row["ratio"].as_f64().unwrap() - 0.208 / 0.248).abs() < 1e-12);
    // 0.8387 sqrt((7/208)^2 + (2/248)^2)
    assert!((row["ratio_std"].as_f64().unwrap() - 0.029_03).abs() < 1e-4);
    // Young's modulus moves the ratio, measured flat friction is known to 0.002 / 0.248 and hardly does.
    let modelled = &row["modelled"][0];
    let of = |key: &str| modelled[key].as_f64().unwrap();
    let expected = (of("ratio_groove") * 0.002).hypot(0.248 * of("ratio_groove_std"));
    assert!((of("mu_groove_std") / expected - 1.0).abs() < 0.05, "{modelled}");
    assert!(of("ratio_square_std") > 0.0 && of("ratio_square_std") < of("ratio_groove_std"), "{modelled}");
    assert!(result["errors"].as_str().unwrap().contains("Young's modulus, known to"));
    // 50 N on a radius of 5 mm: 50 N / (pi 25 mm^2) = 2/pi MPa.
    assert!((row["pressure_mpa"].as_f64().unwrap() - std::f64::consts::FRAC_2_PI).abs() < 1e-9);
    let all = place.json(&["validate", "calibration.toml", "--json", "--all"]);
    assert_eq!(all["results"].as_array().unwrap().len(), 3);
    assert_eq!(all["results"][1]["modelled"], result["results"][1]["modelled"]);

    let heavy = &result["results"][1];
    assert!((heavy["ratio_amontons_coulomb"].as_f64().unwrap() - 1.0).abs() < 1e-9);
    let modelled = heavy["modelled"].as_array().unwrap();
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();
    for (modelled, factor) in modelled.iter().zip([0.5, 1.0, 2.0]) {
        assert_eq!((number(modelled, "slope_factor"), &modelled["status"]), (factor, &Value::from("converged")));
        assert!((number(modelled, "rms_slope") - 0.0137 * factor).abs() < 1e-12);
        let flat = number(modelled, "dynamic_mean") * number(modelled, "area_law_factor");
        assert!((flat - 0.278).abs() < 1e-9, "the flat surface has its measured friction: {flat}");
        let groove = number(modelled, "ratio_groove");
        assert!((number(modelled, "ratio_square_estimate") - (1.0 - 0.26 * (1.0 - groove))).abs() < 1e-12);
    }
    // A smoother surface saturates earlier.
    let groove = |factor: usize| number(&modelled[factor], "ratio_groove");
    assert!(groove(0) < groove(1) && groove(1) < groove(2) && groove(2) < 1.0);

    let explained = (2.0 - number(&result["results"][0]["modelled"][1], "ratio_groove") - groove(1))
        / (2.0 - number(row, "ratio") - number(heavy, "ratio"));
    assert!((number(&result["summary"], "explained_by_grooves") - explained).abs() < 1e-12);
    let change = number(&heavy["modelled_at_measured_depth"], "ratio_groove") - groove(1);
    assert!(change != 0.0);
    let shallow = place.json(&["validate", "calibration.toml", "--json", "--depth-um", "5.2"]);
    assert_eq!(shallow["results"][1]["modelled"][1], heavy["modelled_at_measured_depth"]);
    assert!(shallow["results"][1]["modelled_at_measured_depth"].is_null());
}

#[test]
fn a_validation_goes_to_a_folder_and_says_what_it_rests_on() {
    let calibration = patterned().replace("persson_rms_slope = 0.0137", "map = \"map.asc\"\nthreshold_mpa = 0.7");
    let heavy = "200,2,15,0.278,0.001\n";
    let place = Place::with(&[
        ("calibration.toml", &calibration),
        ("flat.csv", &format!("{FLAT}{heavy}")),
        ("patterned.csv", &format!("{FLAT}{heavy}").replace("0.248", "0.208").replace("0.278", "0.224")),
    ]);
    place.succeed(&["synthesize", "--pixels", "32", "--waves", "2:8", "-o", "map.asc"]);
    // A run of ten nanometres ends before sliding sets in: a trace, and no mean.
    let printed = place.succeed(&["validate", "calibration.toml", "--sliding-um", "0.01", "-o", "out"]);
    for said in
        ["synthetic", "Nothing was tuned", "20 um is modelled, 5.2 um was measured", "with squares", "slope x 0.5"]
    {
        assert!(printed.contains(said), "{said}: {printed}");
    }
    let folder = place.path("out");
    let files = "area-law.csv area-law.svg friction.csv friction.svg interface-end.svg interface-squares.svg \
                 interface.csv interface.svg ratios.csv ratios.svg report.html result.json rims.csv rims.svg timings.json";
    assert_eq!(place.listed("out"), files);
    let table = fs::read_to_string(folder.join("ratios.csv")).unwrap();
    // Two conditions at three slopes and at the measured depth.
    assert_eq!(table.lines().count(), 1 + 2 * 4);
    let result = json(&fs::read_to_string(folder.join("result.json")).unwrap());
    assert_eq!(result["synthetic_surface"], true);
    assert!(fs::read_to_string(folder.join("ratios.svg")).unwrap().contains("(synthetic surface)"));
    // The page holds every picture, every measurement with its deviation, and what time integration found.
    let page = fs::read_to_string(folder.join("report.html")).unwrap();
    assert_eq!(page.matches("<figure>").count(), files.matches(".svg").count() + 1);
    for said in [
        "0.278 ± 0.001",
        "0.224 ± 0.001",
        "no_onset",
        "altitude map behind the area law is synthetic",
        "Nothing was tuned",
        "What rims of unknown height can and cannot explain",
    ] {
        assert!(page.contains(said), "{said}");
    }
    // Grooves and squares without rims, and with four heights of two widths, at both pressures.
    assert_eq!(fs::read_to_string(folder.join("rims.csv")).unwrap().lines().count(), 1 + 2 * 9 * 2);
    let rims = result["rims"]["rows"].as_array().unwrap();
    let first = |height: f64| {
        let row = rims.iter().find(|row| row["planform"] == "square" && row["rim_height_um"] == height).unwrap();
        row["ratio"][0].as_f64().unwrap()
    };
    assert!(first(0.0) > first(0.1) && first(0.1) > first(0.5), "{rims:?}");
    // The source is another one: nothing that the LDPE paper says stands here.
    assert_eq!(result["published"], Value::Array(Vec::new()));
    assert_eq!(result["in_time"]["mu_flat"], Value::Null);
    // f(P0) = 1, and f = [A(P)/A(P0)] / [P/P0] of the areas listed beside it.
    let law = &result["area_laws"][1];
    let at = |key: &str, mpa: f64| {
        let pressures = law["pressure_mpa"].as_array().unwrap();
        let row = pressures.iter().position(|pressure| pressure.as_f64() == Some(mpa)).unwrap();
        law[key][row].as_f64().unwrap()
    };
    let factor = at("area_fraction", 2.6) / at("area_fraction", 0.7) * (0.7 / 2.6);
    assert!((at("factor", 2.6) - factor).abs() < 1e-9 && at("factor", 0.7) == 1.0, "{factor}");
}

#[test]
fn a_dynamic_run_says_from_when_it_averaged() {
    let scene = SCENE
        .replace("[0.65, 2.6]", "2.6")
        .replace("speed_mm_s = 2.0", "speed_mm_s = 20.0")
        .replace("\"steady\"", "\"dynamic\"")
        .replace("sliding_um = 2.0", "sliding_um = 3.0");
    let place = Place::with(&[("scene.toml", &scene)]);
    let load = &place.json(&["simulate", "scene.toml", "--json", "-o", "out"])["results"][0];
    let travel_s = 3e-6 / 20e-3;
    let from_s = load["averaged_from_s"].as_f64().unwrap();
    // Stationary within the first half of the run.
    assert!(0.0 < from_s && from_s <= 0.5 * travel_s, "{from_s}");
    assert!(load["averaged_from_s_flat"].is_number());

    // The mean over the trace from there on is the reported one: every interval is as long.
    let trace = place.read("out/friction.csv");
    let points = trace.lines().filter_map(|line| {
        let cells: Vec<&str> = line.strip_prefix("2.6,patterned,")?.split(',').collect();
        Some((cells[0].parse::<f64>().unwrap() * 1e-6, cells[1].parse::<f64>().unwrap()))
    });
    let window: Vec<f64> = points.filter(|point| point.0 > from_s * (1.0 + 1e-9)).map(|point| point.1).collect();
    let mean = window.iter().sum::<f64>() / window.len() as f64;
    assert!((mean / load["mu_dynamic"].as_f64().unwrap() - 1.0).abs() < 1e-4, "{mean}");
    assert!(place.read("out/friction-2.6mpa.svg").contains("averaging window"));
}

#[test]
fn help_shows_examples_for_every_command() {
    let place = Place::with(&[]);
    let help = place.succeed(&["--help"]);
    for command in COMMANDS.split(' ') {
        assert!(help.contains(command), "{command}");
        let help = place.succeed(&[command, "--help"]);
        assert!(help.contains(&format!("slipgrid {command}")) && help.contains("Examples:"), "{help}");
        assert!(help.contains("--threads") && help.contains("--quiet"), "{help}");
    }
    assert_eq!(place.run(&["--version"]).stdout, format!("slipgrid {}\n", env!("CARGO_PKG_VERSION")).as_bytes());
}

#[test]
fn a_page_explores_a_design_or_a_material_before_any_search() {
    let material =
        "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[friction]\nstatic_mean = 0.30\ndynamic_mean = 0.27\n";
    let place = Place::with(&[("design.toml", &small()), ("material.toml", material), ("scene.toml", SCENE)]);
    place.write("calibration.toml", CALIBRATION);
    place.write("flat.csv", FLAT);
    for (file, page) in [("design.toml", "explore.html"), ("material.toml", "m.html")] {
        place.succeed(&["explore", file, "-o", page]);
        let text = place.read(page);
        assert!(text.contains("id=\"explorer-data\""), "{page}");
        let said = [
            "What is expected of a cut sample of any design within the bounds",
            " is interpolated between computed designs: of ",
        ];
        assert_eq!(said.into_iter().find(|said| !text.contains(said)), None, "{page}");
        assert!(text.contains("no files belong to it") && !text.contains("files beside this page"), "{page}");
        // What there is not is not spoken of; flat friction is known.
        assert_eq!(text.contains("chance on target"), page == "explore.html", "{page}");
        assert!(page == "explore.html" || !text.contains("Hatched"), "{page}");
        // On paper, where nothing slides, a table says what is expected where the sliders start.
        let (_, paper) = text.split_once("<div class=\"print\">").unwrap();
        assert!(
            paper.contains("Where the sliders start, in µm: width ") && paper.contains("95 % of samples"),
            "{page}"
        );
        assert!(paper.matches("<tr>").count() > 2, "{page}: a title and pressures");
        assert!(text.contains("\"flat_mu\":[0.27") || page == "explore.html", "{page}");
    }
    // The order in which a target lists its pressures does not matter to the sliders.
    let data = |page: &str| -> serde_json::Value {
        let text = place.read(page);
        let from = text.find("id=\"explorer-data\"").unwrap();
        let from = from + text[from..].find('>').unwrap() + 1;
        serde_json::from_str(&text[from..from + text[from..].find("</script>").unwrap()]).unwrap()
    };
    for (file, listed) in [("up.toml", "[0.65, 1.3, 2.6]"), ("mixed.toml", "[2.6, 0.65, 1.3]")] {
        let design = small().replace("pressure_mpa = [0.65, 2.6]", &format!("pressure_mpa = {listed}"));
        place.write(file, design);
        place.succeed(&["explore", file, "-o", &file.replace("toml", "html")]);
    }
    let (up, mixed) = (data("up.html"), data("mixed.html"));
    for key in ["pressure_mpa", "lowest", "highest", "flat_mu", "medians", "lower", "upper"] {
        assert_eq!(up[key], mixed[key], "{key}");
    }
    // A folder takes the page, which is the same when it is written again.
    let text = place.read("explore.html");
    place.succeed(&["explore", "design.toml", "-o", "out/page"]);
    assert_eq!(text, place.read("out/page/explore.html"));
    // A material's condition is asked for by name.
    let conditions = "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[[friction.conditions]]\nspeed_mm_s = 2.0\nhumidity_pct = 50.0\n\
        pressure_mpa = [0.65, 2.6]\nstatic_mean = [0.3, 0.3]\ndynamic_mean = [0.27, 0.27]\n[[friction.conditions]]\nspeed_mm_s = 10.0\nhumidity_pct = 50.0\n\
        pressure_mpa = [0.65, 2.6]\nstatic_mean = [0.33, 0.33]\ndynamic_mean = [0.3, 0.3]\n";
    place.write("conditions.toml", conditions);
    let said = place.refuse(&["explore", "conditions.toml"]);
    assert!(said.contains("conditions.toml: ") && said.contains("--speed-mm-s"), "{said}");
    // Reports have the explorer, unless it is left out.
    place.run(&["optimize", "design.toml", "-o", "without", "--no-explorer"]);
    assert!(!place.read("without/report.html").contains("explorer-data"));
}

/// Without `--details` an answer fits on one screen; the details are in addition to it.
#[test]
fn answers_fit_on_the_screen() {
    let calibration =
        patterned_calibration("planform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 20.0\n");
    let place = Place::with(&[
        ("scene.toml", SCENE),
        ("calibration.toml", &calibration),
        ("flat.csv", THREE_FORCES),
        ("patterned.csv", THREE_FORCES),
    ]);
    for args in [["simulate", "scene.toml"], ["calibrate", "calibration.toml"], ["trials", "calibration.toml"]] {
        let output = place.command(&args).output().unwrap();
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
        let screen = String::from_utf8(output.stdout).unwrap();
        assert!(screen.lines().count() <= 20, "{args:?}: {screen}");
        assert!(screen.lines().all(|line| line.chars().count() <= 100), "{args:?}: {screen}");
        assert!(screen.contains("--details") && screen.len() < place.succeed(&args).len(), "{args:?}: {screen}");
    }
}
