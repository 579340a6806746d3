//! Commands on valid input: exit codes, output and written files.

use crate::common::{COMMANDS, FLAT, Place, SCENE, THREE_FORCES, at, column, json, patterned, small};
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
fn results_go_to_a_folder() {
    let place = Place::with(&[("scene.toml", SCENE)]);
    let printed = place.json("simulate scene.toml --json -o out/scene");
    let rest = "interface.csv result.json timings.json uncertainty.csv";
    assert_eq!(place.listed("out/scene"), format!("interface-0.65mpa.svg interface-2.6mpa.svg {rest}"));
    assert_eq!(place.result("out/scene"), timeless(printed), "all but times");
    let times = json(&place.read("out/scene/timings.json"));
    assert!(at(&times, "/wall_s") >= 0.0 && at(&times, "/threads") >= 1.0);
    let interface = place.read("out/scene/interface.csv");
    assert_eq!(interface.lines().next().unwrap(), "load_mpa,surface,x_um,pressure_mpa,friction_mpa");
    assert!(interface.lines().any(|line| line.starts_with("2.6,patterned,")));

    // A second run replaces its files and leaves what is not its own; pictures of other loads go.
    place.write("out/scene/notes.txt", "mine");
    place.write("scene.toml", SCENE.replace("[0.65, 2.6]", "1e-320"));
    place.succeed("simulate scene.toml -o out/scene");
    assert_eq!(place.read("out/scene/notes.txt"), "mine");
    let left = "interface-1e-320mpa.svg interface.csv notes.txt result.json timings.json uncertainty.csv";
    assert_eq!((place.listed("out/scene").as_str(), place.listed("out").as_str()), (left, "scene"));
}

#[test]
fn measured_ratios_are_tabulated() {
    let cut = "200,2,15,0.224,0.002\n50,2,40,0.211,0.002\n";
    let place = Place::with(&[
        ("calibration.toml", &patterned("")),
        ("flat.csv", &format!("{FLAT}200,2,15,0.278,0.001\n50,2,40,0.269,0.004\n")),
        ("patterned.csv", &format!("{}{cut}", FLAT.replace("0.248,0.002", "0.208,0.007"))),
    ]);
    let result = place.json("validate calibration.toml --json");
    // Only the speed and humidity of the first row.
    let [light, heavy] = &result["results"].as_array().unwrap()[..] else { panic!("{result}") };
    assert!((at(light, "/ratio") - 0.208 / 0.248).abs() < 1e-12);
    // 0.8387 sqrt((7/208)^2 + (2/248)^2)
    assert!((at(light, "/ratio_std") - 0.029_03).abs() < 1e-4);
    // Young's modulus moves the ratio, measured flat friction is known to 0.002 / 0.248 and hardly does.
    let modelled = &light["modelled"][0];
    let of = |key: &str| at(modelled, key);
    let expected = (of("/ratio_groove") * 0.002).hypot(0.248 * of("/ratio_groove_std"));
    assert!((of("/mu_groove_std") / expected - 1.0).abs() < 0.05, "{modelled}");
    assert!(of("/ratio_square_std") > 0.0 && of("/ratio_square_std") < of("/ratio_groove_std"), "{modelled}");
    // 50 N on a radius of 5 mm: 50 N / (pi 25 mm^2) = 2/pi MPa.
    assert!((at(light, "/pressure_mpa") - std::f64::consts::FRAC_2_PI).abs() < 1e-9);
    let all = place.json("validate calibration.toml --json --all");
    assert_eq!(all["results"].as_array().unwrap().len(), 3);
    assert_eq!(all["results"][1]["modelled"], heavy["modelled"]);

    assert!((at(heavy, "/ratio_amontons_coulomb") - 1.0).abs() < 1e-9);
    for (modelled, factor) in heavy["modelled"].as_array().unwrap().iter().zip([0.5, 1.0, 2.0]) {
        assert_eq!((at(modelled, "/slope_factor"), &modelled["status"]), (factor, &Value::from("converged")));
        assert!((at(modelled, "/rms_slope") - 0.0137 * factor).abs() < 1e-12);
        let square = 1.0 - 0.26 * (1.0 - at(modelled, "/ratio_groove"));
        assert!((at(modelled, "/ratio_square_estimate") - square).abs() < 1e-12);
    }
    // A smoother surface saturates earlier.
    let grooves = column(&heavy["modelled"], "/ratio_groove");
    assert!(grooves[0] < grooves[1] && grooves[1] < grooves[2] && grooves[2] < 1.0);

    assert_ne!(at(heavy, "/modelled_at_measured_depth/ratio_groove"), grooves[1]);
    let shallow = place.json("validate calibration.toml --json --depth-um 5.2");
    assert_eq!(shallow["results"][1]["modelled"][1], heavy["modelled_at_measured_depth"]);
    assert!(shallow["results"][1]["modelled_at_measured_depth"].is_null());
}

#[test]
fn a_validation_goes_to_a_folder() {
    let calibration = patterned("").replace("persson_rms_slope = 0.0137", "map = \"map.asc\"\nthreshold_mpa = 0.7");
    let flat = format!("{FLAT}200,2,15,0.278,0.001\n");
    let place = Place::with(&[
        ("calibration.toml", &calibration),
        ("flat.csv", &flat),
        ("patterned.csv", &flat.replace("0.248", "0.208").replace("0.278", "0.224")),
    ]);
    place.succeed("synthesize --pixels 32 --waves 2:8 -o map.asc");
    // A run of ten nanometres ends before sliding sets in: a trace, and no mean.
    place.succeed("validate calibration.toml --sliding-um 0.01 -o out");
    let files = "area-law.csv area-law.svg friction.csv friction.svg interface-end.svg interface-squares.svg \
                 interface.csv interface.svg ratios.csv ratios.svg report.html result.json rims.csv rims.svg timings.json";
    assert_eq!(place.listed("out"), files);
    let result = place.result("out");
    assert_eq!((&result["synthetic_surface"], &result["in_time"]["mu_flat"]), (&true.into(), &Value::Null));
    // The page holds every picture, every measurement with its deviation, and what time integration found.
    let page = place.read("out/report.html");
    assert_eq!(page.matches("<figure>").count(), files.matches(".svg").count() + 1);
    for said in ["0.278 ± 0.001", "0.224 ± 0.001", "no_onset"] {
        assert!(page.contains(said), "{said}");
    }
}

#[test]
fn a_dynamic_run_says_from_when_it_averaged() {
    let scene = SCENE
        .replace("[0.65, 2.6]", "2.6")
        .replace("speed_mm_s = 2.0", "speed_mm_s = 20.0")
        .replace("\"steady\"", "\"dynamic\"")
        .replace("sliding_um = 2.0", "sliding_um = 3.0");
    let place = Place::with(&[("scene.toml", &scene)]);
    let load = &place.json("simulate scene.toml --json -o out")["results"][0];
    let from_s = at(load, "/averaged_from_s");
    // Stationary within the first half of the run.
    assert!(0.0 < from_s && from_s <= 0.5 * 3e-6 / 20e-3, "{from_s}");
    assert!(load["averaged_from_s_flat"].is_number());
    // The mean over the trace from there on is the reported one: every interval is as long.
    let trace = place.read("out/friction.csv");
    let points = trace.lines().filter_map(|line| {
        let cells: Vec<&str> = line.strip_prefix("2.6,patterned,")?.split(',').collect();
        Some((cells[0].parse::<f64>().unwrap() * 1e-6, cells[1].parse::<f64>().unwrap()))
    });
    let window: Vec<f64> = points.filter(|point| point.0 > from_s * (1.0 + 1e-9)).map(|point| point.1).collect();
    let mean = window.iter().sum::<f64>() / window.len() as f64;
    assert!((mean / at(load, "/mu_dynamic") - 1.0).abs() < 1e-4, "{mean}");
}

#[test]
fn help_shows_examples_for_every_command() {
    let place = Place::with(&[]);
    let all = place.succeed("--help");
    for command in COMMANDS.split(' ') {
        let help = place.succeed(&format!("{command} --help"));
        assert!(all.contains(command) && help.contains(&format!("slipgrid {command}")), "{help}");
        assert!(["Examples:", "--threads", "--quiet"].iter().all(|said| help.contains(said)), "{help}");
    }
    assert_eq!(place.succeed("--version"), format!("slipgrid {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn a_page_explores_a_design_or_a_material_before_any_search() {
    let material =
        "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[friction]\nstatic_mean = 0.30\ndynamic_mean = 0.27\n";
    let of = |pressures: &str| small().replace("[0.65, 2.6]", pressures);
    let (up, mixed) = (of("[0.65, 1.3, 2.6]"), of("[2.6, 0.65, 1.3]"));
    let place = Place::with(&[("up.toml", &up), ("mixed.toml", &mixed), ("material.toml", material)]);
    // Numbers of the sliders on the page of a file.
    let explored = |name: &str| {
        place.succeed(&format!("explore {name}.toml -o {name}.html"));
        let page = place.read(&format!("{name}.html"));
        // On paper, where nothing slides, a table says what is expected where the sliders start.
        let (_, paper) = page.split_once("<div class=\"print\">").unwrap();
        assert!(paper.matches("<tr>").count() > 2, "{name}: a title and pressures");
        let (_, data) = page.split_once("id=\"explorer-data\"").unwrap();
        json(data.split_once('>').unwrap().1.split_once("</script>").unwrap().0)
    };
    // A material has no target, and its flat friction is known.
    assert!((at(&explored("material"), "/flat_mu/0") - 0.27).abs() < 0.01);
    assert!(!place.read("material.html").contains("chance on target"));
    // The order in which a target lists its pressures does not matter to the sliders.
    let (up, mixed) = (explored("up"), explored("mixed"));
    for key in ["pressure_mpa", "lowest", "highest", "flat_mu", "medians", "lower", "upper"] {
        assert!(up[key] == mixed[key] && !up[key].is_null(), "{key}");
    }
    // A folder takes the page, which is the same when it is written again.
    place.succeed("explore up.toml -o out/page");
    assert_eq!(place.read("up.html"), place.read("out/page/explore.html"));
    // Reports have the explorer, unless it is left out.
    place.run("optimize up.toml -o without --no-explorer");
    assert!(!place.read("without/report.html").contains("explorer-data"));
}

/// Without `--details` an answer fits on one screen; the details are in addition to it.
#[test]
fn answers_fit_on_the_screen() {
    let pattern = "[pattern]\nplanform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 20.0\n";
    let place = Place::with(&[
        ("scene.toml", SCENE),
        ("calibration.toml", &patterned(pattern)),
        ("flat.csv", THREE_FORCES),
        ("patterned.csv", THREE_FORCES),
        ("design.toml", &small()),
    ]);
    for (line, most) in [
        ("simulate scene.toml", 20),
        ("calibrate calibration.toml", 20),
        ("trials calibration.toml", 20),
        ("optimize design.toml", 28),
    ] {
        let screen = place.succeed(line);
        assert!(screen.lines().count() <= most, "{line}: {screen}");
        assert!(screen.lines().all(|line| line.chars().count() <= 100), "{line}: {screen}");
        assert!(screen.len() < place.succeed(&format!("{line} --details")).len(), "{line}: {screen}");
    }
}
