//! Checks the example outside the workspace, which depends on one of its crates.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::rooms::root;

/// Target folder of cargo.
fn target() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().to_owned()
}

fn example() -> PathBuf {
    root().join("crates/design/examples/design_job")
}

/// Runs `program` to the end and with cancellation, and checks the files that it wrote.
fn try_out(program: &Path) {
    let folder = tempfile::tempdir().unwrap();
    let run =
        |argument: Option<&str>| Command::new(program).args(argument).current_dir(folder.path()).output().unwrap();
    let cancelled = run(Some("--cancel"));
    assert!(!cancelled.status.success() && String::from_utf8_lossy(&cancelled.stderr).contains("Cancelled"));
    assert!(!folder.path().join("pattern.dxf").exists());
    let done = run(None);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(String::from_utf8_lossy(&done.stdout).contains("chance that a cut sample is on target"));
    let drawing = fs::read_to_string(folder.path().join("pattern.dxf")).unwrap();
    assert!(drawing.starts_with("999\nslipgrid") && drawing.trim_end().ends_with("EOF"));
}

/// Compiles the example with the library that the workspace has built, without any other library on the command line.
#[test]
fn a_program_outside_does_the_main_job_and_cancels_it() {
    let compiled = target().join("release/deps");
    let is_library = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("libslipgrid_design-") && name.ends_with(".rlib")
    };
    let mut libraries: Vec<PathBuf> =
        fs::read_dir(&compiled).unwrap().map(|entry| entry.unwrap().path()).filter(is_library).collect();
    libraries.sort_by_key(|path| std::cmp::Reverse(fs::metadata(path).unwrap().modified().unwrap()));
    let folder = tempfile::tempdir().unwrap();
    let program = folder.path().join("design_job");
    // Older builds with other features may lie beside the newest.
    let build = |library: &PathBuf| -> Output {
        Command::new(Path::new(&std::env::var_os("CARGO").unwrap()).with_file_name("rustc"))
            .args(["--edition=2024", "-O"])
            .arg(example().join("src/main.rs"))
            .arg("--extern")
            .arg(format!("slipgrid_design={}", library.display()))
            .arg("-L")
            .arg(format!("dependency={}", compiled.display()))
            .arg("-o")
            .arg(&program)
            .output()
            .unwrap()
    };
    let mut said = Vec::new();
    for library in &libraries {
        let built = build(library);
        if built.status.success() {
            return try_out(&program);
        }
        said.push(String::from_utf8_lossy(&built.stderr).into_owned());
    }
    panic!("{}", said.join("\n"));
}

/// The lock file of the example contains every dependency of the crates. It belongs to another workspace and is not
/// updated with this one, but cargo with `--locked` refuses it if a dependency is missing.
#[test]
fn the_lock_file_outside_has_what_the_crates_depend_on() {
    let table = |path: PathBuf| -> toml::Table {
        fs::read_to_string(&path).unwrap().parse().unwrap_or_else(|error| panic!("{}: {error}", path.display()))
    };
    let mut compared = 0;
    for package in table(example().join("Cargo.lock"))["package"].as_array().unwrap() {
        let name = package["name"].as_str().unwrap();
        let Some(folder) = name.strip_prefix("slipgrid-") else { continue };
        let listed: Vec<&str> = package
            .get("dependencies")
            .map_or(Vec::new(), |all| all.as_array().unwrap().iter().map(|one| one.as_str().unwrap()).collect());
        // Where there are several versions, the version stands after the name.
        let is_listed = |needed: &str| listed.iter().any(|one| one.split(' ').next() == Some(needed));
        let manifest = table(root().join("crates").join(folder).join("Cargo.toml"));
        let needed = manifest.get("dependencies").and_then(toml::Value::as_table);
        let is_optional = |value: &toml::Value| value.get("optional").and_then(toml::Value::as_bool) == Some(true);
        for (needed, _) in needed.into_iter().flatten().filter(|(_, value)| !is_optional(value)) {
            compared += 1;
            assert!(is_listed(needed), "{name} lacks {needed}");
        }
    }
    assert!(compared > 30, "{compared}");
}

/// Builds the example with cargo, as its reader does; this compiles the libraries again if their features differ.
#[test]
#[ignore = "compiles the libraries again: two minutes"]
fn cargo_builds_the_program_outside() {
    let built = Command::new(env!("CARGO"))
        .args(["build", "--release", "--offline", "--locked", "--target-dir"])
        .arg(target())
        .current_dir(example())
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    try_out(&target().join("release").join(format!("design_job{}", std::env::consts::EXE_SUFFIX)));
}
