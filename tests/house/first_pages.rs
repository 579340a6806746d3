//! Checks that the modules listed on the first page of a crate exist, and that lists that claim to be complete are.

use std::fs;
use std::path::{Path, PathBuf};

fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("crates")
}

/// Names in backticks in the first column of the table under `heading`, on the first page of a crate.
fn listed<'a>(text: &'a str, heading: &str) -> Vec<&'a str> {
    let page = text.lines().filter_map(|line| line.strip_prefix("//! "));
    let rows = page.skip_while(|line| !line.starts_with(heading)).skip(2).take_while(|line| line.starts_with('|'));
    rows.flat_map(|row| row.split('|').nth(1).unwrap_or_default().split('`').skip(1).step_by(2)).collect()
}

#[test]
fn what_a_page_lists_as_modules_is_there() {
    let mut pages = 0;
    for entry in fs::read_dir(crates()).unwrap().flatten() {
        let Ok(text) = fs::read_to_string(entry.path().join("src/lib.rs")) else { continue };
        // Types have capitals.
        for name in listed(&text, "| module |").into_iter().filter(|name| name.starts_with(char::is_lowercase)) {
            let is_there =
                [format!("mod {name};"), format!("mod {name} {{")].iter().any(|own| text.contains(own.as_str()));
            assert!(is_there, "{}: {name}", entry.path().display());
            pages += 1;
        }
    }
    assert!(pages > 50, "{pages}");
}

#[test]
fn the_page_of_all_libraries_lists_every_one() {
    let text = fs::read_to_string(crates().join("slipgrid/src/lib.rs")).unwrap();
    let mut listed = listed(&text, "| room |");
    let exported =
        text.lines().filter_map(|line| line.strip_prefix("pub use ")?.strip_suffix(';')?.split(" as ").nth(1));
    let mut exported: Vec<&str> = exported.collect();
    listed.sort_unstable();
    exported.sort_unstable();
    assert_eq!(listed, exported);
}
