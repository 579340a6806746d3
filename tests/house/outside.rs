//! The example outside the workspace, built as its reader would, with what the workspace has compiled.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Where cargo puts what it builds.
fn target() -> PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap().to_owned()
}

#[test]
fn a_program_outside_does_the_main_job_and_cancels_it() {
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("examples/design_job");
    let built = Command::new(env!("CARGO"))
        .args(["build", "--release", "--offline", "--locked", "--target-dir"])
        .arg(target())
        .current_dir(&example)
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let program = target().join("release").join(format!("design_job{}", std::env::consts::EXE_SUFFIX));
    let folder = tempfile::tempdir().unwrap();
    let run =
        |argument: Option<&str>| Command::new(&program).args(argument).current_dir(folder.path()).output().unwrap();
    let cancelled = run(Some("--cancel"));
    assert!(!cancelled.status.success() && String::from_utf8_lossy(&cancelled.stderr).contains("Cancelled"));
    assert!(!folder.path().join("pattern.dxf").exists());
    let done = run(None);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(String::from_utf8_lossy(&done.stdout).contains("target met"));
    let drawing = std::fs::read_to_string(folder.path().join("pattern.dxf")).unwrap();
    assert!(drawing.starts_with("999\nslipgrid") && drawing.trim_end().ends_with("EOF"));
}
