//! Checks that `Debug` is derived. Keys of cached results are hashes of `Debug` texts, so that a text without one of
//! the fields would give two contents the same key.

use std::fs;

use crate::rooms::{root, sources};

/// Files that implement `Debug` by hand, and the reason why no key misses a field.
const BY_HAND: [(&str, &str); 4] = [
    ("io/src/outputs.rs", "is written after all is computed, and is in no key"),
    ("model/src/springblock/space/layer.rs", "is a solver's work space, and is in no key"),
    ("surface/src/topography/fourier.rs", "is a plan of transforms, and is in no key"),
    ("surface/src/topography/map.rs", "names every field: heights as their bits"),
];

#[test]
fn debug_is_derived_but_where_no_key_can_miss_a_field() {
    let crates = root().join("crates");
    let is_by_hand = |text: &str| {
        text.lines().any(|line| {
            let line = line.trim_start();
            line.starts_with("impl") && (line.contains(" Debug for ") || line.contains("::Debug for "))
        })
    };
    let mut found: Vec<String> = sources(&crates)
        .iter()
        .filter(|path| is_by_hand(&fs::read_to_string(path).unwrap()))
        .map(|path| path.strip_prefix(&crates).unwrap().to_string_lossy().replace('\\', "/"))
        .collect();
    found.sort();
    assert_eq!(found, BY_HAND.map(|(path, _)| path));
    // The one that is in keys is taken apart field by field, so that a new field does not compile without its text.
    let map = fs::read_to_string(crates.join("surface/src/topography/map.rs")).unwrap();
    assert!(map.contains("let Self { rows, cols, dx_m, dy_m, height_m } = self;"));
}
