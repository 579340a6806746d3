//! Checks that crates depend only on earlier ones, and that only the command line and `disk` access anything outside
//! the process.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Crates in an order in which each depends only on earlier ones.
const ROOMS: [&str; 15] = [
    "base", "model", "surface", "traces", "laser", "infer", "design", "io", "report", "validate", "slipgrid", "studio",
    "cli", "book", "python",
];
/// Crate that accesses files, clock, console and environment.
const FRONT_DOOR: &str = "cli";
/// Crate that serves the page: it accesses files, clock, threads and network, but not the console.
const PAGE: &str = "studio";
/// Folder of the module for the access to files and to the cache, shared by the front ends.
const CELLAR: &str = "io/src/disk";
/// Crate whose `src` holds the chapters of the book, and its folder with the code for the tests.
const BOOK: [&str; 2] = ["book", "checks"];
/// Crate of the Python front end, which accesses files, threads and signals of Python's process.
const PYTHON: &str = "python";
/// Code that accesses files, clocks, the environment, the console, processes, or the global thread pool.
const OUTSIDE: [&str; 22] = [
    "std::fs",
    "File::open",
    "File::create",
    "OpenOptions",
    "canonicalize",
    ".is_file()",
    ".is_dir()",
    "std::env",
    "std::net",
    "thread::sleep",
    "dbg!",
    "Instant::now",
    "SystemTime",
    "println!",
    "print!(",
    "eprint",
    "io::stdout",
    "io::stderr",
    "std::process",
    "build_global",
    "rayon::spawn",
    "available_parallelism",
];

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

/// All Rust files below `folder`.
pub fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let below = |path: PathBuf| if path.is_dir() { sources(&path) } else { vec![path] };
    entries.flat_map(below).filter(|path| path.extension().is_some_and(|extension| extension == "rs")).collect()
}

/// Lines of `text`, numbered from 1, without comments and without items that are compiled only for tests. In formatted
/// text such an item ends with the first line of the same indentation that closes its brace, or its statement if it has
/// opened no brace: a string in its body may hold lines that end like a statement.
pub fn code(text: &str) -> Vec<(usize, &str)> {
    let mut kept = Vec::new();
    let mut lines = text.lines().enumerate();
    while let Some((place, line)) = lines.next() {
        if line.trim() != "#[cfg(test)]" {
            kept.push((place + 1, line.split("//").next().unwrap_or_default()));
            continue;
        }
        let indentation = line.len() - line.trim_start().len();
        let mut opened = false;
        for (_, line) in lines.by_ref().filter(|(_, line)| line.len() - line.trim_start().len() == indentation) {
            let ends = if opened { line.trim_start().starts_with('}') } else { line.ends_with(['}', ';', ',']) };
            if ends && !line.ends_with('{') {
                break;
            }
            opened |= line.ends_with('{');
        }
    }
    kept
}

#[test]
fn only_what_is_compiled_for_tests_alone_is_left_unread() {
    let text = "use a;\n#[cfg(test)]\nmod tests;\nfn b() {} // c\nimpl D {\n    #[cfg(test)]\n    fn e() {\n        f();\n    }\n}\n\
                #[cfg(test)]\nmod more {\n    const G: &str = \"\n{};\n\";\n    fn g() {}\n}\nfn h() {}\n";
    assert_eq!(code(text), [(1, "use a;"), (4, "fn b() {} "), (5, "impl D {"), (10, "}"), (18, "fn h() {}")]);
}

/// Asserts that no code of `files` contains one of `words`.
fn forbid(files: &[PathBuf], words: &[&str], advice: &str) {
    assert!(!files.is_empty(), "{words:?}");
    for file in files {
        for (line, code) in code(&fs::read_to_string(file).unwrap()) {
            let found = words.iter().find(|word| code.contains(*word));
            assert!(found.is_none(), "{}:{line}: {}{advice}", file.display(), found.unwrap_or(&""));
        }
    }
}

#[test]
fn libraries_touch_nothing_outside() {
    for room in ROOMS.into_iter().filter(|room| ![FRONT_DOOR, PAGE, PYTHON].contains(room)) {
        let folder = root().join("crates").join(room).join(if room == BOOK[0] { BOOK[1] } else { "src" });
        let mut files = sources(&folder);
        // The folder of the checkout itself may be called anything.
        files.retain(|file| !file.strip_prefix(&folder).unwrap().to_string_lossy().contains("test"));
        files.retain(|file| !file.starts_with(root().join("crates").join(CELLAR)));
        forbid(&files, &OUTSIDE, "");
    }
}

/// Crates and modules that read files and hold values, and must not use rayon: their callers have no thread pool, and
/// rayon's global pool would outlive the call and not survive a fork.
const WITHOUT_THREADS: [&str; 11] = [
    "base/src",
    "model/src/material",
    "model/src/pattern",
    "surface/src/topography",
    "traces/src",
    "laser/src",
    "infer/src/discrepancy/mixture.rs",
    "design/src/optimize",
    "design/src/results",
    "io/src/formats",
    "io/src/disk",
];
/// Files of the Python crate that release the interpreter; all others call these functions, which use the pool of the
/// process.
const DETACHING: [&str; 3] = ["threads.rs", "progress.rs", "output.rs"];

#[test]
fn nothing_uses_a_pool_that_no_front_door_has_made() {
    let crates = root().join("crates");
    for place in WITHOUT_THREADS.map(|place| crates.join(place)) {
        let files = if place.is_file() { vec![place] } else { sources(&place) };
        forbid(&files, &["rayon"], "");
    }
    let mut files = sources(&crates.join(PYTHON).join("src"));
    files.retain(|file| !DETACHING.iter().any(|name| file.ends_with(name)));
    assert!(files.len() > DETACHING.len());
    forbid(&files, &[".detach("], ": expected threads::detached or threads::in_pool");
}

#[test]
fn every_room_uses_only_those_before_it() {
    let mut there: Vec<String> = fs::read_dir(root().join("crates"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    there.sort();
    let mut known = ROOMS.map(str::to_owned);
    known.sort();
    assert_eq!(there, known);
    for (place, room) in ROOMS.into_iter().enumerate() {
        let manifest = fs::read_to_string(root().join("crates").join(room).join("Cargo.toml")).unwrap();
        let own = manifest.split("[dev-dependencies]").next().unwrap();
        for used in own.lines().filter_map(|line| line.strip_prefix("slipgrid-")?.split(['.', ' ']).next()) {
            let at = ROOMS.into_iter().position(|other| other == used);
            assert!(at.is_some_and(|at| at < place), "{room} uses {used}");
        }
    }
}

/// Code that decides or compares the number of dimensions of a model; other crates ask `springblock` instead.
const DIMENSIONS: [&str; 8] = [
    "Dimension::Plane",
    "Dimension::Space",
    "is_spatial",
    "dimensions ==",
    "dimensions >",
    "dimensions() ==",
    "dimensions() >",
    ".dimensions.unwrap_or",
];

#[test]
fn only_the_physics_decides_in_how_many_dimensions() {
    let mut files: Vec<PathBuf> =
        ROOMS.iter().flat_map(|room| sources(&root().join("crates").join(room).join("src"))).collect();
    files.retain(|file| !file.starts_with(root().join("crates/model/src/springblock")) && !file.ends_with("tests.rs"));
    forbid(&files, &DIMENSIONS, "");
}

/// Versions of every package in the lock file of `workspace`, by name.
fn locked(workspace: &str) -> BTreeMap<String, BTreeSet<String>> {
    let text = fs::read_to_string(root().join(workspace).join("Cargo.lock")).unwrap();
    let file: toml::Table = text.parse().unwrap();
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for package in file["package"].as_array().unwrap() {
        let word = |key: &str| package[key].as_str().unwrap().to_owned();
        versions.entry(word("name")).or_default().insert(word("version"));
    }
    versions
}

/// Packages in both lock files have the same versions, so that a shared target folder compiles them once, and the
/// example runs the tested versions.
#[test]
fn the_workspace_outside_uses_the_same_versions() {
    let (own, theirs) = (locked(""), locked("crates/design/examples/design_job"));
    let shared = theirs.iter().filter(|(name, _)| own.contains_key(*name));
    let other: Vec<_> = shared.clone().filter(|(name, versions)| !versions.is_subset(&own[*name])).collect();
    assert!(shared.count() > 50 && other.is_empty(), "{other:?}");
}
