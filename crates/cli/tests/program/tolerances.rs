//! `optimize` with tolerances and trade-offs: content of its files.

use crate::common::{DESIGN, Place, at, column, free, limit, row, short_at_one_pressure, small, trusted};

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
    format!("{text}[tolerances]\nwidth_std_um = 8.0\nspacing_std_um = 13.0\ndepth_std_um = 1.3\n{more}")
}

#[test]
fn trade_offs_are_compared_by_what_samples_do() {
    let trade_offs = "[trade_offs]\ngoals = [\"chance\", \"laser_time\", \"spread\"]\ndesigns = 30\n";
    let place = Place::with(&[("a.toml", &trusted(&design(trade_offs)))]);
    let found = place.optimized("a", 0).1;
    let traded = &found["trade_offs"];
    assert_eq!(traded["goals"], serde_json::json!(["chance", "laser_time_s", "spread_tolerances"]));
    let chosen = |goal: usize| at(traded, &format!("/chosen/{goal}"));
    assert!((chosen(0) - at(&found, "/chance")).abs() < 1e-9, "{traded}");
    // How samples of the design scatter, in tolerances: that of the ends of 95 %, which are nearly normal.
    let width = at(&found, "/expected/0/high_95") - at(&found, "/expected/0/low_95");
    let spread = width / (2.0 * 1.96) / 0.02;
    assert!((chosen(2) / spread - 1.0).abs() < 0.1, "{traded} {spread}");
    let table = place.read("out/a/trade-offs.csv");
    let columns = "width_um,spacing_um,depth_um,areal_density,chance,laser_time_s,spread_tolerances,on_front,chosen";
    assert_eq!(table.lines().next().unwrap(), columns);
    let ending = |ends: &[&str]| table.lines().filter(|line| ends.iter().any(|end| line.ends_with(end))).count();
    assert_eq!((ending(&[",1,0", ",1,1"]), ending(&[",0,1", ",1,1"])), (at(traded, "/front") as usize, 1));
    let time_s = place.toml("out/a/process.toml")["work"]["estimated_time_s"].as_float().unwrap();
    assert!((chosen(1) / time_s - 1.0).abs() < 1e-6 && (at(&found, "/laser_s") / time_s - 1.0).abs() < 1e-6);
    assert!(place.read("out/a/report.html").contains("Trade-offs"));
}

/// An error of the fitted depth per burst changes the depth of all samples alike, and counts as a limit.
#[test]
fn samples_count_a_fitted_depth_per_burst() {
    let fitted = "spot_um = 23.0\nfluence_j_cm2 = 10.0\n[laser.ablation]\nfluence_j_cm2 = [2.0, 5.0, 10.0, 20.0]\n\
                  depth_per_burst_um = [0.6, 1.9, 2.4, 3.6]\n";
    let text = small().replace("depth_per_burst_um = 2.6\n", "").replace("spot_um = 23.0\n", fitted);
    let text = text.replace("depth_um = 5.2", "depth_um = [2.0, 10.0]");
    let place = Place::with(&[("a.toml", &format!("{text}[tolerances]\nwidth_std_um = 1.0\ndepth_std_um = 0.5\n"))]);
    place.run("optimize a.toml -o out --no-explorer");
    let found = place.result("out");
    let std = |input: &str| at(limit(&found, input), "/std/0");
    let words = limit(&found, "depth per burst")["known_to"].as_str().unwrap();
    let percent: f64 = words.split([' ', '%']).find_map(|word| word.parse().ok()).unwrap();
    // dr / d ln(depth) = depth dr / d depth, for a percentage that is told rounded.
    let expected = std("depth") * 0.01 * percent * at(&found, "/design/depth_um") / 0.5;
    assert!(percent >= 1.0 && (std("depth per burst") / expected - 1.0).abs() < 0.6 / percent, "{found}");
}

/// Contributions of the inputs add up to the scatter of samples. The chosen designs hardly depend on the modulus to
/// first order, so that the second order dominates and is listed.
#[test]
fn the_limits_are_all_that_scatters_samples() {
    let tolerances = "[tolerances]\nwidth_std_um = 6.0\nspacing_std_um = 1.0\ndepth_std_um = 0.2\n";
    let modulus = "density_g_cm3 = 0.9\nyoungs_modulus_std_gpa = 0.08\n";
    let text = free(&trusted(&short_at_one_pressure("value = 0.88\ntolerance = 0.02", tolerances)))
        .replace("density_g_cm3 = 0.9\n", modulus);
    let found = Place::with(&[("a.toml", &text)]).optimized("a", 0).1;
    let sum = column(&found["limited_by"], "/std/0").iter().map(|std| std.powi(2)).sum::<f64>().sqrt();
    let width = at(&found, "/expected/0/high_95") - at(&found, "/expected/0/low_95");
    assert!((width / (2.0 * 1.96) / sum - 1.0).abs() < 0.1, "{width} {}", found["limited_by"]);
    // In the order of what they cost in whole per cent, and none lowers the chance once it is known.
    let known = column(&found["limited_by"], "/chance_if_known");
    assert!(known.is_sorted_by(|a, b| *a > b - 0.01) && known.iter().all(|known| *known >= at(&found, "/chance")));
    // A texture made to 6 um scatters by six times what its median changes along a micrometre.
    let along = 6.0 * at(row(&found["slopes"], "dimension", "width_um").unwrap(), "/per_um/0").abs();
    assert!((at(limit(&found, "width"), "/std/0") / along - 1.0).abs() < 0.1, "{along} {}", found["limited_by"]);
    let first = &found["limited_by"][0];
    assert!(first["input"] == "Young's modulus" && at(first, "/chance_if_known") > 1.5 * at(&found, "/chance"));
}
