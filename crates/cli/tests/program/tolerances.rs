//! `optimize` with tolerances and trade-offs: content of its files.

use std::fs;

use crate::common::{DESIGN, Place, number, result, small, trusted};

/// Design of a short sample at one pressure, with standard errors as a calibration writes them.
fn design(more: &str) -> String {
    let text = DESIGN
        .replace("diameter_mm = 10.0", "diameter_mm = 4.0")
        .replace("layer_um = 200.0", "layer_um = 60.0")
        .replace("[40.0, 400.0]", "[40.0, 100.0]")
        .replace("[40.0, 1000.0]", "[40.0, 200.0]")
        .replace("[2.0, 50.0]", "[2.0, 20.0]")
        .replace("[0.65, 2.6]", "[2.6]")
        .replace("value = 0.9", "value = 0.88")
        .replace("tolerance = 0.01", "tolerance = 0.02")
        .replace("density_g_cm3 = 0.9\n", "density_g_cm3 = 0.9\nyoungs_modulus_std_gpa = 0.038\n")
        .replace("dynamic_mean = 0.27\n", "dynamic_mean = 0.27\ndynamic_std_error = 0.0027\n")
        .replace("spot_um = 23.0\n", "spot_um = 23.0\nrepetition_hz = 20000.0\nspeed_mm_s = 200.0\n");
    format!("{text}{more}")
}

const TOLERANCES: &str = "[tolerances]\nwidth_std_um = 8.0\nspacing_std_um = 13.0\ndepth_std_um = 1.3\n";

#[test]
fn trade_offs_are_compared_by_what_samples_do() {
    let trade_offs = "[trade_offs]\ngoals = [\"chance\", \"laser_time\", \"spread\"]\ndesigns = 30\n";
    let place = Place::with(&[("a.toml", &trusted(&design(&format!("{TOLERANCES}{trade_offs}"))))]);
    let summary = place.succeed(&["optimize", "a.toml"]);
    assert!(
        summary.contains("not beaten by another in every goal") && summary.contains("greatest chance: "),
        "{summary}"
    );

    let found = result(&place, "out/a");
    let traded = &found["trade_offs"];
    assert_eq!(traded["goals"], serde_json::json!(["chance", "laser_time_s", "spread_tolerances"]));
    assert!((number(&traded["chosen"][0]) - number(&found["chance"])).abs() < 1e-9, "{traded}");
    // How samples of the design scatter, in tolerances: that of the ends of 95 %, which are nearly normal.
    let ends = ["low_95", "high_95"].map(|key| number(&found["expected"][0][key]));
    let spread = (ends[1] - ends[0]) / (2.0 * 1.96) / 0.02;
    assert!((number(&traded["chosen"][2]) / spread - 1.0).abs() < 0.1, "{} {spread}", traded["chosen"]);
    let folder = place.path("out/a");
    let table = fs::read_to_string(folder.join("trade-offs.csv")).unwrap();
    let columns = "width_um,spacing_um,depth_um,areal_density,chance,laser_time_s,spread_tolerances,on_front,chosen";
    assert_eq!(table.lines().next().unwrap(), columns);
    let on_front = table.lines().filter(|line| line.ends_with(",1,0") || line.ends_with(",1,1")).count();
    assert_eq!(on_front, number(&traded["front"]) as usize);
    assert_eq!(table.lines().skip(1).filter(|line| line.ends_with(",1")).count(), 1, "one is chosen");
    let sheet: toml::Table = fs::read_to_string(folder.join("process.toml")).unwrap().parse().unwrap();
    let time_s = sheet["work"]["estimated_time_s"].as_float().unwrap();
    assert!((number(&traded["chosen"][1]) / time_s - 1.0).abs() < 1e-6);
    assert!((number(&found["laser_s"]) / time_s - 1.0).abs() < 1e-6);
    assert!(fs::read_to_string(folder.join("report.html")).unwrap().contains("Trade-offs"));
}

/// An error of the fitted depth per burst changes the depth of all samples alike, and counts as a limit.
#[test]
fn samples_count_a_fitted_depth_per_burst() {
    let fitted = "spot_um = 23.0\nfluence_j_cm2 = 10.0\n[laser.ablation]\nfluence_j_cm2 = [2.0, 5.0, 10.0, 20.0]\n\
                  depth_per_burst_um = [0.6, 1.9, 2.4, 3.6]\n";
    let text = small().replace("depth_per_burst_um = 2.6\n", "").replace("spot_um = 23.0\n", fitted);
    let text = text.replace("depth_um = 5.2", "depth_um = [2.0, 10.0]");
    let tolerances = "[tolerances]\nwidth_std_um = 1.0\ndepth_std_um = 0.5\n";
    let place = Place::with(&[("fitted.toml", &format!("{text}{tolerances}"))]);
    place.run(&["optimize", "fitted.toml", "-o", "out", "--no-explorer"]);
    let found = result(&place, "out");
    let limits = found["limited_by"].as_array().unwrap();
    let limit =
        |input: &str| limits.iter().find(|limit| limit["input"] == input).unwrap_or_else(|| panic!("{limits:?}"));
    let std = |input: &str| number(&limit(input)["std"][0]);
    let words = limit("depth per burst")["known_to"].as_str().unwrap();
    let percent: f64 = words.split([' ', '%']).find_map(|word| word.parse().ok()).unwrap();
    // dr / d ln(depth) = depth dr / d depth, for a percentage that is told rounded.
    let expected = std("depth") * 0.01 * percent * number(&found["design"]["depth_um"]) / 0.5;
    assert!(percent >= 1.0 && (std("depth per burst") / expected - 1.0).abs() < 0.6 / percent, "{limits:?}");
}
