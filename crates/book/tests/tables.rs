//! Checks that the column titles of every table that the program writes are in the book.

use std::collections::BTreeSet;
use std::path::Path;

use crate::{book, files, root, text};

/// Source files that write the tables of commands that no chapter runs.
const WRITERS: [&str; 5] = [
    "crates/validate/src/accuracy/output.rs",
    "crates/validate/src/validation/rims.rs",
    "crates/validate/src/validation/figures.rs",
    "crates/laser/src/export/csv.rs",
    "crates/report/src/area_law.rs",
];

/// Ending of titles that are followed by more columns.
const MORE: &str = ",...";

/// Name and column titles of every table listed in the chapter.
pub fn listed() -> BTreeSet<(String, String)> {
    let chapter = text(&book().join("reference/files.md"));
    let rows = chapter.lines().filter_map(|line| {
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let [_, names, _, titles, _] = cells[..] else { return None };
        let code = |cell: &str| cell.strip_prefix('`').and_then(|cell| cell.strip_suffix('`')).map(str::to_owned);
        let titles = code(titles).filter(|titles| titles.contains(','))?;
        Some(names.split(", ").map(|name| (code(name).unwrap(), titles.clone())).collect::<Vec<_>>())
    });
    rows.flatten().collect()
}

/// Compares the tables below `folder` with the chapter: returns the rows that match one, and messages about tables that
/// are not listed.
pub fn compare(folder: &Path, listed: &BTreeSet<(String, String)>) -> (BTreeSet<(String, String)>, Vec<String>) {
    let (mut seen, mut missing) = (BTreeSet::new(), Vec::new());
    for path in files(folder, ".csv") {
        let table = text(&path);
        let titles = table.lines().find(|line| !line.starts_with('#')).unwrap_or_default();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let row = listed.iter().find(|(known, row)| {
            let is_named = known
                .split_once('*')
                .map_or(*known == name, |(before, after)| name.starts_with(before) && name.ends_with(after));
            is_named && row.strip_suffix(MORE).map_or(row == titles, |row| titles.starts_with(row))
        });
        match row {
            Some(row) => {
                seen.insert(row.clone());
            }
            None => missing.push(format!("reference/files.md does not list {name}: {titles}")),
        }
    }
    (seen, missing)
}

/// Whether the code that writes the tables of commands without a chapter contains these titles, in one text or column
/// by column.
pub fn is_written_by_code(titles: &str) -> bool {
    let titles = titles.trim_end_matches(MORE);
    WRITERS.iter().any(|file| {
        let code: String = text(&root().join(file)).split("\\\n").map(str::trim_start).collect();
        // Titles of a table that is written column by column.
        let by_column = |table: &str| {
            let each = table.split("(\"").skip(1).filter_map(|rest| Some(rest.split_once("\",")?.0));
            each.collect::<Vec<_>>().join(",").starts_with(titles)
        };
        code.contains(&format!("\"{titles}")) || code.split("Table::of(").skip(1).any(by_column)
    })
}
