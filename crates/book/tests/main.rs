//! Checks that the book is true: its commands print what it shows, its links have targets, its keys and schemas are
//! those of the readers, and the numbers that it quotes are in their sources.
//!
//! If `SLIPGRID_UPDATE_GUIDE` is set, the current output and generated text are written into the book.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test that unwraps in vain fails, as it should, and tells what it measured"
)]

mod chapters;
mod keys;
mod numbers;
mod pictures;
mod probes;
mod tables;
mod theory;
mod walks;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Root folder of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap().to_owned()
}

/// Folder of the chapters.
fn book() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Command of the program, with its cache in the target folder instead of the user's folder.
fn program() -> Command {
    let mut program = Command::new(env!("CARGO_BIN_EXE_slipgrid-of-the-book"));
    program.env("SLIPGRID_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("kept-of-the-book"));
    program
}

/// Reads a text file.
fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Files below `folder` whose names end with `ending`, sorted.
fn files(folder: &Path, ending: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path, ending));
        } else if path.to_string_lossy().ends_with(ending) {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// Whether the book is updated instead of checked.
fn updates() -> bool {
    std::env::var_os("SLIPGRID_UPDATE_GUIDE").is_some()
}

/// Checks that the file at `path` contains `now`, or writes it in an update.
fn keep(path: &Path, now: &str) {
    if updates() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, now).unwrap();
    } else {
        let kept = text(path);
        let line = kept.lines().zip(now.lines()).find(|(kept, now)| kept != now);
        assert!(kept == now, "{} is not what the program says now; first: {line:?}", path.display());
    }
}
