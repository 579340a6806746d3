//! Full disks, write-protected folders and killed runs leave no half-written file.

#![cfg(unix)]

use std::fs;
use std::process::Command;
use std::time::Duration;

use crate::common::{Place, SCENE, many_squares, names, untimed};

/// Diameter of a specimen of many squares, in millimetres, whose files take a megabyte.
const MEGABYTE_MM: f64 = 6.0;

/// Drawing of an earlier run.
const EARLIER: &str = "999\nslipgrid 0.0.9: x\n";

const EXPORT: [&str; 6] = ["export", "result.json", "--format", "dxf,svg,csv,corners,hatch,plt,stl", "-o", "out"];

/// Runs a shell command line in the folder, with the program as `$0`.
fn shell(place: &Place, line: &str) -> std::process::Output {
    let mut command = Command::new("sh");
    command.env("SLIPGRID_CACHE", "");
    command.current_dir(place.path("")).args(["-c", line, env!("CARGO_BIN_EXE_slipgrid")]).output().unwrap()
}

/// Message of a run that must end with exit code 1.
fn fails(output: &std::process::Output) -> String {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    message
}

#[test]
fn a_full_disk_is_said_and_leaves_nothing() {
    let place = Place::with(&[("result.json", &many_squares(MEGABYTE_MM)), ("scene.toml", SCENE)]);
    // Files end at 64 blocks of 512 bytes; the signal that would kill the program is ignored.
    let full = "trap '' XFSZ; ulimit -f 64; exec \"$0\" export result.json -o out";
    let message = fails(&shell(&place, full));
    assert!(message.starts_with("error: out: cannot be written: "), "{message}");
    assert_eq!(place.names(), ["result.json", "scene.toml"]);

    // The same where the folder stands already: its files stay as they were.
    fs::create_dir(place.path("out")).unwrap();
    place.write("out/pattern.dxf", EARLIER);
    fails(&shell(&place, full));
    assert_eq!(names(&place.path("out")), ["pattern.dxf"]);
    assert_eq!(place.read("out/pattern.dxf"), EARLIER);
}

#[test]
fn a_place_that_takes_no_files_is_refused_at_once() {
    // Not even a superuser makes files there.
    if !fs::exists("/proc/self").unwrap_or(false) {
        return;
    }
    let place = Place::with(&[("scene.toml", SCENE), ("result.json", &many_squares(MEGABYTE_MM))]);

    for command in [
        vec!["simulate", "scene.toml", "-o", "/proc/out"],
        vec!["export", "result.json", "-o", "/proc/out"],
        vec!["synthesize", "--pixels", "32", "--waves", "2:8", "-o", "/proc/out"],
    ] {
        let message = fails(&place.run(&command));
        assert!(message.starts_with("error: /proc/out: cannot be written: "), "{message}");
    }
    assert_eq!(place.names(), ["result.json", "scene.toml"]);
    // A folder that holds a result stands for it.
    assert_eq!(place.succeed(&["export", ".", "--format", "csv"]).trim(), "./pattern.csv");
}

#[test]
fn a_device_is_written_to_and_not_replaced() {
    if !fs::exists("/dev/full").unwrap_or(false) {
        return;
    }
    let place = Place::with(&[("scene.toml", SCENE)]);
    let message = fails(&shell(&place, "exec \"$0\" simulate scene.toml --json > /dev/full"));
    assert!(message.starts_with("error: standard output: "), "{message}");
    let message = fails(&place.run(&["synthesize", "--pixels", "32", "--waves", "2:8", "-o", "/dev/full"]));
    assert!(message.contains("/dev/full: cannot be written"), "{message}");
    use std::os::unix::fs::FileTypeExt;
    assert!(fs::metadata("/dev/full").unwrap().file_type().is_char_device());
}

#[test]
fn a_link_stays_a_link() {
    let place = Place::with(&[("map.asc", "")]);
    std::os::unix::fs::symlink("map.asc", place.path("link.asc")).unwrap();
    place.succeed(&["synthesize", "--pixels", "32", "--waves", "2:8", "-o", "link.asc"]);
    assert!(fs::symlink_metadata(place.path("link.asc")).unwrap().is_symlink());
    assert!(place.read("map.asc").len() > 1000);
}

#[test]
fn a_folder_that_cannot_be_written_is_said() {
    use std::os::unix::fs::PermissionsExt;
    let place = Place::with(&[("scene.toml", SCENE)]);
    let closed = place.path("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    let mut folders = vec!["/proc/slipgrid/out"];
    // Who may do everything may write here too.
    if fs::write(closed.join("probe"), "").is_err() {
        folders.extend(["closed", "closed/out"]);
    }
    for folder in folders {
        let message = fails(&place.run(&["simulate", "scene.toml", "-o", folder]));
        assert!(message.contains("cannot be written"), "{message}");
    }
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o755)).unwrap();
}

#[test]
fn a_run_killed_at_any_moment_leaves_whole_files_or_none() {
    let place = Place::with(&[("result.json", &many_squares(MEGABYTE_MM))]);
    let started = std::time::Instant::now();
    place.succeed(&EXPORT);
    let whole = started.elapsed();
    let good = untimed(&place, "out");
    assert_eq!(good.len(), 7);
    // The files of an earlier result.
    place.write("earlier.json", many_squares(MEGABYTE_MM).replace("40.0", "30.0"));
    place.succeed(&[&["export", "earlier.json"], &EXPORT[2..5], &["earlier"]].concat());
    let before = untimed(&place, "earlier");
    const KILLS: u32 = 12;
    for fresh in [true, false] {
        for kill in 0..KILLS {
            fs::remove_dir_all(place.path("out")).unwrap();
            if !fresh {
                fs::create_dir(place.path("out")).unwrap();
                for entry in fs::read_dir(place.path("earlier")).unwrap().map(Result::unwrap) {
                    fs::copy(entry.path(), place.path("out").join(entry.file_name())).unwrap();
                }
            }
            let mut run = place.begin(&EXPORT);
            std::thread::sleep(Duration::from_secs_f64(whole.as_secs_f64() * f64::from(kill) / f64::from(KILLS - 1)));
            run.kill().unwrap();
            run.wait().unwrap();
            if !place.path("out").exists() {
                assert!(fresh);
                fs::create_dir(place.path("out")).unwrap();
                continue;
            }
            let mut there = untimed(&place, "out");
            // A killed run leaves the file that it was writing, under a name of its own.
            there.retain(|(name, _)| !name.starts_with(".slipgrid-"));
            assert!(there == good || (!fresh && there == before), "files missing, or of two results");
        }
    }
}
