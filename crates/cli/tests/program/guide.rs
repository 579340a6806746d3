//! The guide's commands, run as they stand, print what the guide shows.
//!
//! With `SLIPGRID_UPDATE_GUIDE` set the guide takes over what is printed now.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::Place;

const LEFT_OUT: &str = "[...]";
/// Numbers may differ by this share, beyond one unit of their last digit: other processors round differently.
const TOLERANCE: f64 = 2e-3;

/// A fenced block: what follows the fence, and its lines with their numbers in the guide.
struct Block {
    info: String,
    start: usize,
    lines: Vec<String>,
}

fn blocks(lines: &[String]) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (number, line) in lines.iter().enumerate() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(info), None) => open = Some(Block { info: info.to_owned(), start: number + 1, lines: Vec::new() }),
            (None, Some(block)) => block.lines.push(line.clone()),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "a block is not closed");
    blocks
}

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

/// Words and numbers of a line; numbers without the signs around them.
fn tokens(line: &str) -> Vec<&str> {
    line.split(|c: char| c.is_whitespace() || "(),:;%".contains(c)).filter(|token| !token.is_empty()).collect()
}

/// What a line is about: its tokens that are no numbers.
fn subject(line: &str) -> Vec<&str> {
    tokens(line).into_iter().filter(|token| token.parse::<f64>().is_err()).collect()
}

fn agree(shown: &str, printed: &str) -> bool {
    let (shown, printed) = (tokens(shown), tokens(printed));
    shown.len() == printed.len()
        && shown.iter().zip(&printed).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(x), Ok(y)) => {
                let decimals = a.split_once('.').map_or(0, |(_, digits)| digits.len() as i32);
                (x - y).abs() <= TOLERANCE * y.abs() + 1.5 * 10_f64.powi(-decimals)
            }
            _ => a == b,
        })
}

/// Compares `shown` with `printed`; returns what stands there now, passage by passage as it was chosen.
fn compare(command: &str, shown: &[String], printed: &str, differ: &mut Vec<String>) -> Vec<String> {
    let printed: Vec<&str> = printed.lines().collect();
    let mut now = Vec::new();
    let mut from = 0;
    for (order, passage) in shown.split(|line| line == LEFT_OUT).enumerate() {
        if order > 0 {
            now.push(LEFT_OUT.to_owned());
        }
        let Some(first) = passage.first() else { continue };
        // A passage begins at the next line about the same.
        let start = printed.iter().enumerate().skip(from).find(|(_, line)| {
            if order == 0 { true } else { subject(line).starts_with(&subject(first)[..subject(first).len().min(3)]) }
        });
        let Some((start, _)) = start else {
            differ.push(format!("{command}\n  no line like: {first}"));
            continue;
        };
        for (offset, line) in passage.iter().enumerate() {
            let own = printed.get(start + offset).copied().unwrap_or_default();
            if !agree(line, own) {
                differ.push(format!("{command}\n  guide:   {line}\n  printed: {own}"));
            }
            now.push(own.to_owned());
        }
        from = start + passage.len();
    }
    now
}

/// Goes through the guide `name` of the synthetic polymer in an empty folder, which it returns with the number of commands.
fn walk(name: &str) -> (Place, usize) {
    let root: PathBuf = [env!("CARGO_MANIFEST_DIR"), "..", ".."].iter().collect();
    let guide = root.join("calibration/synthetic-polymer").join(name);
    let text = fs::read_to_string(&guide).unwrap();
    let lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let place = Place::with(&[]);
    let (mut differ, mut commands) = (Vec::new(), 0);
    // Blocks as they would be now, by their place in the guide.
    let mut updated: Vec<(usize, usize, Vec<String>)> = Vec::new();
    for block in blocks(&lines) {
        match block.info.split_whitespace().collect::<Vec<_>>()[..] {
            ["toml" | "csv", name] => fs::write(place.path(name), block.lines.join("\n") + "\n").unwrap(),
            // At the end of a file.
            ["toml", name, "+"] => {
                let old = fs::read_to_string(place.path(name)).unwrap();
                fs::write(place.path(name), format!("{old}\n{}\n", block.lines.join("\n"))).unwrap();
            }
            // In place of the last lines of a file.
            ["toml", name, last] => {
                let last: usize = last.trim_start_matches('-').parse().unwrap();
                let old = fs::read_to_string(place.path(name)).unwrap();
                let kept: Vec<&str> = old.lines().collect();
                let kept = kept[..kept.len() - last].join("\n");
                fs::write(place.path(name), format!("{kept}\n{}\n", block.lines.join("\n"))).unwrap();
            }
            ["console"] => {
                let mut now = Vec::new();
                for shown in block.lines.chunk_by(|_, next| !next.starts_with("$ ")) {
                    let command = shown[0].strip_prefix("$ ").unwrap();
                    now.push(shown[0].clone());
                    let words: Vec<&str> = command.split_whitespace().collect();
                    let printed = match words[..] {
                        ["cp", "-r", from, to] => {
                            copy_folder(&root.join(from), &place.path(to));
                            String::new()
                        }
                        ["slipgrid", ..] => place.succeed(&words[1..]),
                        _ => panic!("{command}"),
                    };
                    commands += 1;
                    now.extend(compare(command, &shown[1..], &printed, &mut differ));
                }
                updated.push((block.start, block.lines.len(), now));
            }
            _ => panic!("a block of unknown kind: {}", block.info),
        }
    }
    if std::env::var_os("SLIPGRID_UPDATE_GUIDE").is_some() {
        let mut lines = lines;
        for (start, count, now) in updated.into_iter().rev() {
            lines.splice(start..start + count, now);
        }
        fs::write(&guide, lines.join("\n") + "\n").unwrap();
        return (place, commands);
    }
    assert!(differ.is_empty(), "{}", differ.join("\n"));
    (place, commands)
}

#[test]
fn the_guide_is_true() {
    let (place, commands) = walk("guide.md");
    // What the last section speaks of is there.
    for name in [
        "out/design/report.html",
        "out/design/process.toml",
        "out/laser/pattern.gcode",
        "out/laser/height-map.png",
        "out/fit/fit.json",
        "out/fit/report.html",
    ] {
        assert!(place.path(name).is_file(), "{name}");
    }
    assert_eq!(commands, 8);
}

#[test]
fn three_cuts_are_as_the_walk_says() {
    let (place, commands) = walk("trials.md");
    for name in ["out/trials/trials.svg", "out/trials/trials.csv", "out/trials/report.html"] {
        assert!(place.path(name).is_file(), "{name}");
    }
    assert_eq!(commands, 8);
}
