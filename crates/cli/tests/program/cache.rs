//! Results kept from earlier runs change nothing but the time of a run.

use std::fs;
use std::path::Path;

use crate::common::{CALIBRATION, FLAT, Place, measured, names, short};

/// A short sample whose material is calibrated first.
fn place() -> Place {
    let design = measured(&short(), "calibration.toml")
        .replace("[0.65, 2.6]", "[0.65]")
        .replace("value = 0.9", "value = 0.95")
        .replace("tolerance = 0.01", "tolerance = 0.03");
    Place::with(&[("design.toml", &design), ("calibration.toml", CALIBRATION), ("flat.csv", FLAT)])
}

/// Runs the design into the folder `out`, with the results in `cache`.
fn optimize(place: &Place, out: &str, cache: &Path, flags: &str) {
    let mut command = place.uncached(&format!("optimize design.toml -o {out} -q {flags}"));
    let ended = command.env("SLIPGRID_CACHE", cache).output().unwrap();
    assert!(matches!(ended.status.code(), Some(0 | 3 | 4)), "{}", String::from_utf8_lossy(&ended.stderr));
}

#[test]
fn kept_results_give_the_same_bytes_as_computed_ones() {
    let place = place();
    let cache = place.path("cache");
    optimize(&place, "first", &cache, "");
    let kept = names(&cache);
    assert!(kept.iter().any(|name| name.starts_with("material-")), "{kept:?}");
    assert!(kept.iter().filter(|name| name.starts_with("run-")).count() >= 3, "{kept:?}");
    let first = place.untimed("first");
    assert!(first.len() > 10);

    optimize(&place, "again", &cache, "");
    assert_eq!(place.untimed("again"), first);
    assert_eq!(names(&cache), kept, "nothing is computed twice");

    // Broken files are computed anew.
    for (number, name) in kept.iter().enumerate() {
        let bytes = fs::read(cache.join(name)).unwrap();
        fs::write(cache.join(name), &bytes[..bytes.len() * number / kept.len()]).unwrap();
    }
    optimize(&place, "broken", &cache, "");
    assert_eq!(place.untimed("broken"), first);

    let none = place.path("none");
    optimize(&place, "without", &none, "--no-cache --threads 1");
    assert_eq!(place.untimed("without"), first);
    assert!(!none.exists());
}

#[test]
fn a_named_folder_that_keeps_nothing_is_told() {
    let place = place();
    fs::write(place.path("file"), "").unwrap();
    for (cache, told) in [("file", true), ("new", false)] {
        let mut command = place.uncached("calibrate calibration.toml");
        let ended = command.env("SLIPGRID_CACHE", place.path(cache)).output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(said.contains("SLIPGRID_CACHE keeps no result"), told, "{said}");
        assert_eq!(ended.status.code(), Some(0), "{said}");
    }
}
