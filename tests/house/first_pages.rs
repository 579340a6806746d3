//! Checks that the modules listed on the first page of a crate exist, and that lists that claim to be complete are.

use std::fs;

use crate::rooms::{root, sources};

/// Names in backticks in the first column of the table under `heading`, on the first page of a crate.
fn listed<'a>(text: &'a str, heading: &str) -> Vec<&'a str> {
    let page = text.lines().filter_map(|line| line.strip_prefix("//! "));
    let rows = page.skip_while(|line| !line.starts_with(heading)).skip(2).take_while(|line| line.starts_with('|'));
    rows.flat_map(|row| row.split('|').nth(1).unwrap_or_default().split('`').skip(1).step_by(2)).collect()
}

#[test]
fn what_a_page_lists_as_modules_is_there() {
    let mut names = 0;
    let mut pages = sources(&root().join("crates"));
    pages.retain(|path| path.ends_with("lib.rs") || path.ends_with("mod.rs"));
    for path in pages {
        let text = fs::read_to_string(&path).unwrap();
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
    let text = fs::read_to_string(root().join("crates/slipgrid/src/lib.rs")).unwrap();
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
