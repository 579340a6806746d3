//! Studies that are damaged, shared by two runs, or left by a killed run.

use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use crate::common::{DESIGN, Place, small};
use crate::mutations::spoil;
use slipgrid_base::statistics::SplitMix64;

/// Exit code and stderr of a run within this process.
fn run(args: &[&str]) -> (u8, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let args = ["slipgrid", "--threads", "1", "-q"].iter().chain(args);
    let code = slipgrid_cli::run(args.map(ToString::to_string), &mut out, &mut err);
    (code, String::from_utf8_lossy(&err).into_owned())
}

#[test]
#[ignore = "takes ten to twenty seconds of both cores"]
fn a_spoiled_study_is_refused_by_its_line_or_used_and_never_ends_the_program() {
    let place = Place::with(&[("d.toml", &small())]);
    let [design, folder, study] = ["d.toml", "out", "out.study.jsonl"].map(|name| place.path(name));
    let [design, folder] = [design, folder].map(|path| path.display().to_string());
    let args = ["optimize", &design, "-o", &folder, "--resume"];
    let (code, message) = run(&args);
    assert_eq!(code, 0, "{message}");
    let good = fs::read_to_string(&study).unwrap();
    assert!(good.lines().count() > 8, "{good}");
    let mut dice = SplitMix64(3);
    let (mut refused, mut used) = (0, 0);
    for _ in 0..300 {
        let spoiled = spoil(&good, &mut dice);
        fs::write(&study, &spoiled).unwrap();
        let told = || String::from_utf8_lossy(&spoiled).into_owned();
        let (code, message) =
            catch_unwind(AssertUnwindSafe(|| run(&args))).unwrap_or_else(|_| panic!("a panic from {}", told()));
        if code == 2 {
            let line = message.split("out.study.jsonl:").nth(1).and_then(|rest| rest.split(':').next());
            let line: usize = line.and_then(|line| line.parse().ok()).unwrap_or_else(|| panic!("{message}"));
            assert!((1..=told().lines().count()).contains(&line), "{message}");
            assert!(message.contains("without --resume"), "{message}");
            assert_eq!(fs::read(&study).unwrap(), spoiled, "what is refused stays as it is");
            refused += 1;
        } else {
            assert!(code == 0 || code == 3 || code == 4, "{code} {message} from {}", told());
            used += 1;
        }
    }
    assert!(refused > 100 && used > 10, "{refused} refused, {used} used");
}

fn wait_for(path: &Path) {
    let began = Instant::now();
    while !path.exists() {
        assert!(began.elapsed() < Duration::from_secs(600), "{} never came", path.display());
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn of_two_runs_for_one_folder_the_second_is_refused_and_a_killed_one_blocks_nobody() {
    // The first run takes some seconds.
    let place = Place::with(&[("d.toml", DESIGN), ("small.toml", &small())]);
    let mut first = place.begin("optimize d.toml -o out/a --no-cache");
    wait_for(&place.path("out/a.study.jsonl"));
    let message = place.refuse("optimize d.toml -o out/a --resume");
    let who = format!("error: out/a.lock: another run works for this folder: process {};", first.id());
    assert!(message.starts_with(&who), "{message}");
    // Another folder is nobody else's.
    place.succeed("optimize small.toml -o out/b --no-cache");
    first.kill().unwrap();
    first.wait().unwrap();
    let left = place.read("out/a.study.jsonl");
    assert!(left.lines().count() > 0 && left.ends_with('\n'), "{left}");
    assert!(place.path("out/a.lock").exists() && !place.path("out/b.lock").exists());
    place.succeed("optimize small.toml -o out/a --no-cache");
    assert_eq!(place.listed("out"), "a a.study.jsonl b b.study.jsonl");
}

#[test]
#[cfg(unix)]
fn a_run_ended_from_the_keyboard_takes_its_lock_along() {
    if crate::common::ignores_ctrl_c() {
        return;
    }
    let place = Place::with(&[("d.toml", DESIGN)]);
    for signal in ["INT", "TERM"] {
        let mut run = place.begin("optimize d.toml -o out/a");
        wait_for(&place.path("out/a.lock"));
        let killed = Command::new("sh").args(["-c", &format!("kill -{signal} {}", run.id())]).status().unwrap();
        assert!(killed.success());
        assert_eq!(run.wait().unwrap().code(), Some(130), "{signal}");
        assert!(!place.path("out/a.lock").exists(), "{signal}");
    }
}

#[test]
fn many_runs_for_one_folder_leave_a_whole_study() {
    let place = Place::with(&[("d.toml", &small())]);
    let line = "optimize d.toml -o out/a --resume --threads 1";
    let runs: Vec<Child> = (0..4).map(|_| place.begin(line)).collect();
    let codes: Vec<Option<i32>> = runs.into_iter().map(|mut run| run.wait().unwrap().code()).collect();
    assert!(codes.iter().all(|code| matches!(code, Some(0 | 2))) && codes.contains(&Some(0)), "{codes:?}");
    place.succeed(line);
    assert_eq!(place.listed("out"), "a a.study.jsonl");
}
