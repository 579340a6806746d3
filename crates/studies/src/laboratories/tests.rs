use super::*;
use slipgrid_monitor::Unwatched;

/// Prints the tables of the whole study.
#[test]
#[ignore = "a study of minutes: prints its tables"]
fn laboratories_in_full() {
    let steps = std::env::var("STEPS").ok().and_then(|s| s.parse().ok()).unwrap_or(24);
    let laboratories = std::env::var("LABS").ok().and_then(|s| s.parse().ok()).unwrap_or(225);
    let started = std::time::Instant::now();
    let policies = if std::env::var("ALL").is_ok() { Policy::ALL.to_vec() } else { vec![Policy::Mixture] };
    let found = run(&Options { steps, laboratories, ..Options::default() }, &policies, &Unwatched).unwrap();
    for line in found.lines() {
        println!("{line}");
    }
    println!("{:.1} s", started.elapsed().as_secs_f64());
}
