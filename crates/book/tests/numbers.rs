//! Numbers that the book quotes stand where it says.

use crate::{book, root, text};

/// Rows of tables that the evidence quotes stand in the page that the program wrote.
#[test]
fn the_laboratories_of_the_book_are_those_of_the_kept_page() {
    let page = text(&root().join("tests/accuracy/laboratories.md"));
    let chapter = text(&book().join("theory/trials.md"));
    let mut rows = 0;
    for line in chapter.lines().filter(|line| {
        line.starts_with("| nothing") || line.starts_with("| one groove") || line.starts_with("| the published")
    }) {
        for number in line.split('|').filter_map(|cell| cell.trim().parse::<f64>().ok()) {
            assert!(page.contains(&format!("{number:.2}")), "{number} of {line}");
            rows += 1;
        }
    }
    assert_eq!(rows, 15);
}
