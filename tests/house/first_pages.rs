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

/// First page of every crate, and of every module that has one in a `mod.rs`.
fn pages(folder: &Path, found: &mut Vec<(PathBuf, String)>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        pages(&path, found);
        if ["lib.rs", "mod.rs"].iter().any(|name| path.ends_with(name)) {
            found.push((path.clone(), fs::read_to_string(&path).unwrap()));
        }
    }
}

#[test]
fn what_a_page_lists_as_modules_is_there() {
    let (mut found, mut names) = (Vec::new(), 0);
    for entry in fs::read_dir(crates()).unwrap().flatten() {
        pages(&entry.path().join("src"), &mut found);
    }
    for (path, text) in found {
        // Types have capitals.
        for name in listed(&text, "| module |").into_iter().filter(|name| name.starts_with(char::is_lowercase)) {
            let is_there =
                [format!("mod {name};"), format!("mod {name} {{")].iter().any(|own| text.contains(own.as_str()));
            assert!(is_there, "{}: {name}", path.display());
            names += 1;
        }
    }
    assert!(names > 70, "{names}");
}

#[test]
fn the_page_of_all_libraries_lists_every_one() {
    let text = fs::read_to_string(crates().join("slipgrid/src/lib.rs")).unwrap();
    let mut listed = listed(&text, "| room |");
    let exported = text.lines().filter_map(|line| line.strip_prefix("pub use ")?.strip_suffix(';'));
    let mut exported: Vec<&str> = exported
        .flat_map(|path| path.trim_end_matches('}').rsplit([':', '{']).next().unwrap().split(", "))
        .map(|name| name.rsplit(" as ").next().unwrap())
        .collect();
    listed.sort_unstable();
    exported.sort_unstable();
    assert_eq!(listed, exported);
}
