//! Runs the commands of each chapter in a folder of its own and compares their output with the chapter.
//!
//! A block `toml NAME` or `csv NAME` is a file that is written; `toml NAME +` is appended to it, and `toml NAME -4`
//! replaces its last four lines. A block `console` contains commands with their output, `console whole` one command
//! with its complete output. Blocks `python = PATH` and `rust = PATH` contain lines of that file of the repository.
//! Blocks `text`, and blocks indented by four spaces, are ignored.
//!
//! A number of the prose that a command above it prints has a comment after it, for example
//! `56 %<!-- printed: # % chance -->`: a part of the printed line, with `#` in place of the number.

use std::collections::BTreeSet;
use std::fs;
use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;
use std::time::Instant;

use serde_json::Value;
use slipgrid_book::console::{LEFT_OUT, blocks, compare, compare_prose};
use tempfile::TempDir;

use crate::{book, files, pictures, program, root, tables, text, updates};

/// Start of the line after the output of a command with an exit code other than 0.
const EXIT_CODE: &str = "[exit code ";

/// Files that must exist after the chapter from raw files to a pattern.
const LEFT_BY_WALK: [&str; 6] = [
    "out/design/report.html",
    "out/design/process.toml",
    "out/laser/pattern.gcode",
    "out/laser/height-map.png",
    "out/fit/fit.json",
    "out/fit/report.html",
];

fn copy_folder(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy_folder(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// Output of `command` in `folder`, followed by a line with the exit code if that is not 0.
fn print(folder: &Path, command: &str) -> String {
    let words: Vec<&str> = command.split_whitespace().collect();
    match words[..] {
        ["cp", "-r", from, to] => {
            copy_folder(&root().join(from), &folder.join(to));
            String::new()
        }
        ["slipgrid", ..] => {
            let output = program().current_dir(folder).args(&words[1..]).output().unwrap();
            let mut printed = String::from_utf8(output.stdout).unwrap();
            match output.status.code() {
                Some(0) => {}
                // A refusal is written to the other stream.
                Some(code) => {
                    if printed.is_empty() {
                        printed = String::from_utf8(output.stderr).unwrap();
                    }
                    printed += &format!("{EXIT_CODE}{code}]\n");
                }
                None => panic!("{command}"),
            }
            printed
        }
        _ => panic!("a command that no test runs: {command}"),
    }
}

/// Part of a chapter as it would be now: its first line, the number of lines that it replaces, and the new lines.
type Part = (usize, usize, Vec<String>);

/// Compares the numbers in the `range` of lines between two blocks with the output `printed` of the commands above.
fn prose(lines: &[String], range: Range<usize>, printed: &str, differ: &mut Vec<String>) -> Part {
    let now = compare_prose(&lines[range.clone()].join("\n"), printed, differ);
    (range.start, range.len(), now.split('\n').map(str::to_owned).take(range.len()).collect())
}

/// Runs the commands of the chapter at `path`; returns their folder, their number, and the differences.
fn walk(path: &Path) -> (TempDir, usize, Vec<String>) {
    let chapter = text(path);
    let lines: Vec<String> = chapter.lines().map(str::to_owned).collect();
    let (found, is_closed) = blocks(&lines);
    assert!(is_closed, "{}: a block is not closed", path.display());
    let place = tempfile::tempdir().unwrap();
    let (mut differ, mut commands, mut all) = (Vec::new(), 0, String::new());
    let mut updated: Vec<Part> = Vec::new();
    if found.iter().any(|block| block.info.starts_with("console")) {
        for folder in ["designs", "calibration"] {
            copy_folder(&root().join(folder), &place.path().join(folder));
        }
    }
    let mut from = 0;
    for block in found {
        updated.push(prose(&lines, from..block.start, &all, &mut differ));
        from = block.start + block.lines.len();
        let own = block.lines.join("\n") + "\n";
        match block.info.split_whitespace().collect::<Vec<_>>()[..] {
            [] | ["text"] => {}
            ["python" | "rust" | "toml" | "sh", "=", file] => {
                assert!(
                    text(&root().join(file)).contains(&own),
                    "{}: {file} has no such lines:\n{own}",
                    path.display()
                );
            }
            ["toml" | "csv", name] => fs::write(place.path().join(name), own).unwrap(),
            ["toml", name, "+"] => {
                let old = text(&place.path().join(name));
                fs::write(place.path().join(name), format!("{old}\n{own}")).unwrap();
            }
            ["toml", name, last] => {
                let last: usize = last.trim_start_matches('-').parse().unwrap();
                let old = text(&place.path().join(name));
                let kept: Vec<&str> = old.lines().collect();
                let kept = kept[..kept.len() - last].join("\n");
                fs::write(place.path().join(name), format!("{kept}\n{own}")).unwrap();
            }
            ["console", "whole"] => {
                let command = block.lines[0].strip_prefix("$ ").unwrap();
                let printed = print(place.path(), command);
                all += &printed;
                let now = std::iter::once(block.lines[0].as_str()).chain(printed.lines().map(str::trim_end));
                let now: Vec<String> = now.map(str::to_owned).collect();
                if now != block.lines {
                    differ.push(format!("{command}\n  is shown whole and prints something else now"));
                }
                commands += 1;
                updated.push((block.start, block.lines.len(), now));
            }
            ["console"] => {
                let mut now = Vec::new();
                for shown in block.lines.chunk_by(|_, next| !next.starts_with("$ ")) {
                    let command = shown[0].strip_prefix("$ ").unwrap();
                    now.push(shown[0].clone());
                    let printed = print(place.path(), command);
                    all += &printed;
                    let ended = printed.lines().last().filter(|line| line.starts_with(EXIT_CODE));
                    let told = shown.last().filter(|line| line.starts_with(EXIT_CODE)).map(String::as_str);
                    if ended != told {
                        differ.push(format!("{command}\n  ended with {ended:?}:\n{printed}"));
                    }
                    commands += 1;
                    now.extend(compare(command, &shown[1..], &printed, &mut differ));
                }
                updated.push((block.start, block.lines.len(), now));
            }
            _ => panic!("{}: a block of unknown kind: {}", path.display(), block.info),
        }
    }
    updated.push(prose(&lines, from..lines.len(), &all, &mut differ));
    if updates() {
        let mut lines = lines;
        for (start, count, now) in updated.into_iter().rev() {
            lines.splice(start..start + count, now);
        }
        fs::write(path, lines.join("\n") + "\n").unwrap();
        differ.clear();
    }
    (place, commands, differ)
}

/// Checks what the main job of the README wrote into `results`: evidence, and files for the laser that agree.
fn check_main_job(results: &Path) {
    let read = |name: &str| text(&results.join(name));
    let result: Value = serde_json::from_str(&read("result.json")).unwrap();
    let list = |key: &str| result[key].as_array().unwrap().as_slice();
    let number = |value: &Value| value.as_f64().unwrap_or_else(|| panic!("{value} is no number"));
    let (expected, modelled, confirmed) = (list("expected"), list("modelled"), list("confirmed"));
    assert_eq!((expected.len(), modelled.len(), confirmed.len()), (4, 4, 4));
    for (modelled, confirmed) in modelled.iter().zip(confirmed) {
        assert!((number(&modelled["ratio"]) - number(&confirmed["ratio"])).abs() < 1e-6);
        assert!(number(&confirmed["mu_dynamic_stderr"]) < 1e-3 * number(&confirmed["mu_dynamic"]));
    }
    assert!(result["advice"] == "trial" && number(&result["chance"]) > 0.01 && !result["trade_offs"].is_null());
    // The flat sample of the model slides as the measured one does: 0.278 at 2.546 MPa, 15 % humidity.
    let flat = number(&confirmed[3]["mu_flat"]);
    assert!((flat - 0.278).abs() < 0.003, "{flat}");
    assert_eq!(result["material"]["synthetic_surface"], true);

    // The scene runs as it is; steady sliding of its specimen lies near what was confirmed.
    let steady = print(results, "slipgrid simulate scene.toml --fidelity steady --json");
    let steady: Value = serde_json::from_str(&steady).unwrap();
    for (steady, confirmed) in steady["results"].as_array().unwrap().iter().zip(confirmed) {
        let (steady, confirmed) = (number(&steady["ratio"]), number(&confirmed["ratio"]));
        assert!((steady / confirmed - 1.0).abs() < 0.01, "{steady} {confirmed}");
    }
    // Rows of cavities in CSV, polygons in DXF and count on the process sheet agree.
    let process: toml::Table = read("process.toml").parse().unwrap();
    let cavities = process["specimen"]["cavities"].as_integer().unwrap();
    assert_eq!(read("pattern.csv").lines().count() as i64, cavities + 1);
    assert_eq!(read("pattern.dxf").matches("\nPOLYLINE\n").count() as i64, cavities);
    for name in ["target.svg", "pattern.svg", "friction-2.6mpa.svg", "interface-2.6mpa.svg"] {
        assert!(read(name).trim_end().ends_with("</svg>"), "{name}");
    }
}

/// Result of a page: number of commands, tables of the book that they wrote, and differences.
type Walked = (usize, BTreeSet<(String, String)>, Vec<String>);

fn walk_page(page: &Path, listed: &BTreeSet<(String, String)>) -> Walked {
    let (place, commands, found) = walk(page);
    let mut differ: Vec<String> = found.into_iter().map(|found| format!("{}: {found}", page.display())).collect();
    // The files named at the end of the walk exist.
    for name in LEFT_BY_WALK.iter().filter(|_| page.ends_with("from-raw-files.md")) {
        assert!(place.path().join(name).is_file(), "{name}");
    }
    if page.ends_with("README.md") {
        check_main_job(&place.path().join("out/ldpe-lower-friction"));
    }
    pictures::compare_shown(page, place.path());
    let out = place.path().join("out");
    let mut seen = BTreeSet::new();
    if out.is_dir() {
        let (written, missing) = tables::compare(&out, listed);
        seen.extend(written);
        differ.extend(missing);
        differ.extend(pictures::compare(&out));
    }
    (commands, seen, differ)
}

/// Runs the commands of all chapters and of the README, several pages at a time; returns the number of commands and the
/// tables of the book that they wrote.
fn walk_all() -> (usize, BTreeSet<(String, String)>) {
    let listed = tables::listed();
    let mut pages = files(&book(), ".md");
    pages.push(root().join("README.md"));
    let (waiting, walked) = (Mutex::new(pages.iter()), Mutex::new(Vec::<Walked>::new()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                loop {
                    let Some(page) = waiting.lock().unwrap().next() else { break };
                    let started = Instant::now();
                    let found = walk_page(page, &listed);
                    println!("{:7.2} s  {}", started.elapsed().as_secs_f64(), page.display());
                    walked.lock().unwrap().push(found);
                }
            });
        }
    });
    let (mut commands, mut seen, mut differ) = (0, BTreeSet::new(), Vec::new());
    for (number, written, found) in walked.into_inner().unwrap() {
        commands += number;
        seen.extend(written);
        differ.extend(found);
    }
    assert!(differ.is_empty(), "{}", differ.join("\n"));
    (commands, seen)
}

#[test]
fn every_command_of_the_book_prints_what_the_book_shows_and_writes_tables_as_it_lists() {
    let (commands, seen) = walk_all();
    assert!(commands > 30, "{commands} commands");
    for (name, titles) in tables::listed() {
        let is_seen = seen.iter().any(|(_, known)| *known == titles);
        assert!(is_seen || tables::is_written_by_code(&titles), "nothing writes {name}: {titles}");
    }
    assert!(seen.len() > 12, "{seen:?}");
}

#[test]
fn a_command_that_prints_something_else_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page.md");
    fs::write(&page, format!("```console\n$ slipgrid --version\nslipgrid 99\n{LEFT_OUT}\n```\n")).unwrap();
    if !updates() {
        assert_eq!(walk(&page).2.len(), 1);
    }
}
