use super::*;
use slipgrid_monitor::Unwatched;

/// Prints the tables of the whole study.
#[test]
#[ignore = "a study of minutes: prints its tables"]
fn laboratories_in_full() {
    let steps = std::env::var("STEPS").ok().and_then(|s| s.parse().ok()).unwrap_or(24);
    let laboratories = std::env::var("LABS").ok().and_then(|s| s.parse().ok()).unwrap_or(225);
    let started = std::time::Instant::now();
    let policies = if std::env::var("ALL").is_ok() { Policy::ALL.to_vec() } else { vec![Policy::Mixture, Policy::Truth] };
    let found = run(&Options { steps, laboratories, ..Options::default() }, &policies, &Unwatched).unwrap();
    for line in found.lines() {
        println!("{line}");
    }
    println!("{:.1} s", started.elapsed().as_secs_f64());
}

#[test]
#[ignore = "looks"]
fn look() {
    let textures = physics::textures(7, &Unwatched).unwrap();
    for of in textures.iter().filter(|of| (of.pattern.depth_m() * 1e6).round() == 10.0) {
        println!("{:?} {:.0} {:.0} a {:.3} e {:.0} R {:.3?} rims {:.3?} g {:.3?}", of.pattern.planform(), of.pattern.width_m()*1e6, of.pattern.spacing_m()*1e6,
            of.features.areal_density, of.features.edge_1_m, of.ratio, of.of_rims, of.sensitivity);
    }
}
