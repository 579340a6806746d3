//! Checks that every chapter is in the summary, that every link has a target, and that every equation can be drawn.

use std::path::{Path, PathBuf};

use slipgrid_book::equations::convert;
use slipgrid_book::links::{anchors, targets};

use crate::{book, files, root, text};

/// Maximum number of lines of the README, and of characters per line.
const README: [usize; 2] = [100, 125];

/// Chapters and other pages whose links are checked.
fn pages() -> Vec<PathBuf> {
    let mut pages = files(&book(), ".md");
    for page in [
        "README.md",
        "crates/book/CHANGELOG.md",
        "crates/python/README.md",
        "calibration/ldpe-cast-iron/README.md",
        "calibration/synthetic-polymer/README.md",
        "tests/accuracy/accuracy.md",
        "tests/accuracy/laboratories.md",
    ] {
        pages.push(root().join(page));
    }
    pages
}

#[test]
fn every_chapter_stands_in_the_summary_and_every_name_there_is_a_chapter() {
    let named = targets(&text(&book().join("SUMMARY.md")));
    let mut named: Vec<PathBuf> = named.iter().map(|name| book().join(name)).collect();
    named.push(book().join("SUMMARY.md"));
    named.sort();
    assert_eq!(named, files(&book(), ".md"));
}

#[test]
fn every_link_leads_to_a_file_and_every_anchor_to_a_heading() {
    let (mut broken, mut checked) = (Vec::new(), 0);
    for page in pages() {
        let own = text(&page);
        for target in targets(&own) {
            if target.contains("://") || target.is_empty() {
                continue;
            }
            checked += 1;
            let (path, anchor) = target.split_once('#').unwrap_or((&target, ""));
            let file = if path.is_empty() { page.clone() } else { page.parent().unwrap().join(path) };
            let leads = file.exists() && (anchor.is_empty() || anchors(&text(&file)).iter().any(|own| own == anchor));
            // Files outside the chapters are missing in a book that was built.
            let stays = !page.starts_with(book()) || file.canonicalize().is_ok_and(|file| file.starts_with(book()));
            if !leads || !stays {
                broken.push(format!("{}: {target}", page.strip_prefix(root()).unwrap().display()));
            }
        }
    }
    assert!(broken.is_empty(), "{}", broken.join("\n"));
    assert!(checked > 60, "{checked}");
}

#[test]
fn every_equation_becomes_mathml_and_numbers_of_equations_are_unique() {
    let (mut found, mut numbers) = (0, Vec::new());
    for page in files(&book(), ".md") {
        let own = text(&page);
        let converted = convert(&own).unwrap_or_else(|fault| panic!("{}: {fault}", page.display()));
        assert!(!converted.contains("<merror"), "{}", page.display());
        found += converted.matches("<math ").count();
        numbers.extend(own.split("\\tag{").skip(1).map(|rest| rest.split('}').next().unwrap().to_owned()));
    }
    assert!(found > 250, "{found}");
    numbers.sort();
    assert_eq!(numbers, ["1", "2", "3", "4", "5", "6"]);
}

#[test]
fn what_a_chapter_includes_is_there_and_has_no_links_of_its_own() {
    let mut included = 0;
    for page in files(&book(), ".md") {
        for name in
            text(&page).split("{{#include ").skip(1).filter_map(|rest| rest.split("}}").next().map(str::to_owned))
        {
            let own = text(&page.parent().unwrap().join(&name));
            assert!(targets(&own).is_empty(), "{name}");
            included += 1;
        }
    }
    assert_eq!(included, 2);
}

#[test]
fn pages_name_files_that_there_are() {
    let mut missing = Vec::new();
    for page in pages().iter().filter(|page| !page.ends_with("CHANGELOG.md")) {
        for word in text(page).split('`').skip(1).step_by(2) {
            let is_path =
                ["designs/", "calibration/", "crates/", "tests/"].iter().any(|folder| word.starts_with(folder));
            if is_path && !word.contains(['*', ' ', '<']) && !root().join(word).exists() {
                missing.push(format!("{}: {word}", page.display()));
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
}

#[test]
fn the_readme_fits_on_two_screens() {
    let readme = text(&root().join("README.md"));
    let [lines, letters] = README;
    assert!(readme.lines().count() <= lines, "{} lines", readme.lines().count());
    // Lines that the program prints may be longer.
    let own = readme.split("```").step_by(2).flat_map(str::lines).filter(|line| !line.starts_with(['<', '|']));
    let longest = own.map(|line| line.chars().count()).max();
    assert!(longest.unwrap() <= letters, "{longest:?}");
}

/// The entries of the glossary are in alphabetical order and unique.
#[test]
fn the_glossary_is_in_order() {
    let glossary = text(&book().join("glossary.md"));
    let terms: Vec<String> =
        glossary.lines().filter_map(|line| Some(line.strip_prefix("**")?.split_once("**")?.0.to_lowercase())).collect();
    let mut sorted = terms.clone();
    sorted.sort();
    sorted.dedup();
    assert_eq!(terms, sorted);
    assert!(terms.len() > 30);
}

#[test]
fn citation_and_introduction_name_the_version() {
    let citation = text(&root().join("crates/book/CITATION.cff"));
    assert!(citation.contains(&format!("\nversion: {}\n", env!("CARGO_PKG_VERSION"))), "{citation}");
    assert!(citation.contains("\nlicense: MIT\n"));
    let introduction = text(&book().join("introduction.md"));
    assert!(introduction.contains(&format!("This book describes slipgrid {};", env!("CARGO_PKG_VERSION"))));
    let changes = text(Path::new(env!("CARGO_MANIFEST_DIR")).join("CHANGELOG.md").as_path());
    assert!(changes.contains(env!("CARGO_PKG_VERSION")));
}
