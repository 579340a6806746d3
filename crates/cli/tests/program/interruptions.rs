//! Full disks, write-protected folders and killed runs leave no half-written file.

#![cfg(unix)]

use std::fs;
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::process::Command;
use std::time::Duration;

use crate::common::{Place, SCENE, ignores_ctrl_c, many_squares};

/// Diameter of a specimen of many squares, in millimetres, whose files take a megabyte.
const MEGABYTE_MM: f64 = 6.0;

/// Drawing of an earlier run.
const EARLIER: &str = "999\nslipgrid 0.0.9: x\n";

const MAP: &str = "synthesize --pixels 32 --waves 2:8 -o";

/// Message of a shell command line in the folder, with the program as `$0`, which must end with exit code 1.
fn shell_fails(place: &Place, line: &str) -> String {
    let mut command = Command::new("sh");
    command.env("SLIPGRID_CACHE", "").current_dir(place.path(""));
    let output = command.args(["-c", line, env!("CARGO_BIN_EXE_slipgrid")]).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_full_disk_is_said_and_leaves_nothing() {
    let place = Place::with(&[("result.json", &many_squares(MEGABYTE_MM))]);
    // Files end at 64 blocks of 512 bytes; the signal that would kill the program is ignored.
    let full = "trap '' XFSZ; ulimit -f 64; exec \"$0\" export result.json -o out";
    let message = shell_fails(&place, full);
    assert!(message.starts_with("error: out: cannot be written: "), "{message}");
    assert_eq!(place.listed(""), "result.json");
    // The same where the folder stands already: its files stay as they were.
    fs::create_dir(place.path("out")).unwrap();
    place.write("out/pattern.dxf", EARLIER);
    shell_fails(&place, full);
    assert_eq!((place.listed("out").as_str(), place.read("out/pattern.dxf").as_str()), ("pattern.dxf", EARLIER));
}

#[test]
fn a_place_that_takes_no_files_is_refused_at_once() {
    let place = Place::with(&[("scene.toml", SCENE), ("result.json", &many_squares(MEGABYTE_MM))]);
    let closed = place.path("closed");
    fs::create_dir(&closed).unwrap();
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o555)).unwrap();
    let mut folders = Vec::new();
    // Not even a superuser makes files there.
    if fs::exists("/proc/self").unwrap_or(false) {
        folders.extend(["/proc/out", "/proc/slipgrid/out"]);
    }
    // Who may do everything may write here too.
    if fs::write(closed.join("probe"), "").is_err() {
        folders.extend(["closed", "closed/out"]);
    }
    for folder in folders {
        // A folder is no place for a map, whoever may write into it.
        let commands = ["simulate scene.toml -o", "export result.json -o", MAP];
        for command in &commands[..if folder == "closed" { 2 } else { 3 }] {
            let message = place.ends(&format!("{command} {folder}"), 1).1;
            assert!(message.starts_with("error: ") && message.contains(": cannot be written: "), "{message}");
        }
    }
    fs::set_permissions(&closed, fs::Permissions::from_mode(0o755)).unwrap();
    assert_eq!(place.listed(""), "closed result.json scene.toml");
    // A folder that holds a result stands for it.
    assert_eq!(place.succeed("export . --format csv").trim(), "./pattern.csv");
}

#[test]
fn a_device_is_written_to_and_not_replaced_and_a_link_stays_a_link() {
    let place = Place::with(&[("scene.toml", SCENE), ("map.asc", "")]);
    if fs::exists("/dev/full").unwrap_or(false) {
        let message = shell_fails(&place, "exec \"$0\" simulate scene.toml --json > /dev/full");
        assert!(message.starts_with("error: standard output: "), "{message}");
        let message = place.ends(&format!("{MAP} /dev/full"), 1).1;
        assert!(message.contains("/dev/full: cannot be written"), "{message}");
        assert!(fs::metadata("/dev/full").unwrap().file_type().is_char_device());
    }
    symlink("map.asc", place.path("link.asc")).unwrap();
    place.succeed(&format!("{MAP} link.asc"));
    assert!(place.path("link.asc").is_symlink() && place.read("map.asc").len() > 1000);
}

#[test]
fn a_run_ended_at_any_moment_leaves_whole_files_or_none() {
    const KILLS: u32 = 8;
    let result = many_squares(MEGABYTE_MM);
    let place = Place::with(&[("result.json", &result), ("earlier.json", &result.replace("40.0", "30.0"))]);
    let export =
        |file: &str, folder: &str| format!("export {file}.json --format dxf,svg,csv,corners,hatch,plt,stl -o {folder}");
    let started = std::time::Instant::now();
    place.succeed(&export("result", "out"));
    let whole_s = started.elapsed().as_secs_f64();
    let good = place.untimed("out");
    assert_eq!(good.len(), 7);
    // The files of an earlier result.
    place.succeed(&export("earlier", "earlier"));
    let before = place.untimed("earlier");
    let signals = if ignores_ctrl_c() { &["KILL"][..] } else { &["KILL", "INT"] };
    for (signal, fresh) in signals.iter().flat_map(|signal| [(signal, true), (signal, false)]) {
        for moment in 0..KILLS {
            fs::remove_dir_all(place.path("out")).unwrap();
            if !fresh {
                fs::create_dir(place.path("out")).unwrap();
                for entry in fs::read_dir(place.path("earlier")).unwrap().map(Result::unwrap) {
                    fs::copy(entry.path(), place.path("out").join(entry.file_name())).unwrap();
                }
            }
            let mut run = place.begin(&export("result", "out"));
            std::thread::sleep(Duration::from_secs_f64(whole_s * f64::from(moment) / f64::from(KILLS - 1)));
            let _ = Command::new("kill").args([&format!("-{signal}"), &run.id().to_string()]).status();
            let code = run.wait().unwrap().code();
            assert!(matches!(code, None | Some(0 | 130)), "{signal}: {code:?}");
            if !place.path("out").exists() {
                assert!(fresh);
                fs::create_dir(place.path("out")).unwrap();
                continue;
            }
            let mut there = place.untimed("out");
            // A killed run leaves the file that it was writing, under a name of its own.
            there.retain(|(name, _)| *signal == "INT" || !name.starts_with(".slipgrid-"));
            assert!(there == good || (!fresh && there == before), "files missing, or of two results");
        }
    }
}
