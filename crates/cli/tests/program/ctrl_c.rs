//! Ctrl-C ends every stage, reports the results that were kept, and leaves no half-written file.

#![cfg(unix)]

use std::fs;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{CALIBRATION, FLAT, Place, SCENE, discs, free, ignores_ctrl_c, names, short};

/// Time after which a test has hung: runs end within about a second of Ctrl-C, but machines may be busy.
const HUNG: Duration = Duration::from_secs(600);

/// Folder with `files`; `None` where nothing is to be tested, because programs ignore Ctrl-C.
fn listening(files: &[(&str, &str)]) -> Option<Place> {
    (!ignores_ctrl_c()).then(|| Place::with(files))
}

fn start(place: &Place, line: &str) -> Child {
    place.uncached(line).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Waits until `is_reached` or the end of the run.
fn wait_until(run: &mut Child, is_reached: impl Fn() -> bool) {
    let started = Instant::now();
    while !is_reached() && run.try_wait().unwrap().is_none() {
        assert!(started.elapsed() < HUNG);
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Presses Ctrl-C and waits; `None` if the run had ended by itself before or at that moment.
fn press(mut run: Child) -> Option<Output> {
    if run.try_wait().unwrap().is_none() {
        assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    }
    let output = run.wait_with_output().unwrap();
    // A map without cavities is refused when it has been read.
    let has_ended = output.status.success() || String::from_utf8_lossy(&output.stderr).contains("no cavities found");
    (!has_ended).then_some(output)
}

/// Starts the program and presses Ctrl-C after `after_s` seconds.
fn interrupted(place: &Place, line: &str, after_s: f64) -> Option<Output> {
    let mut run = start(place, line);
    let started = Instant::now();
    wait_until(&mut run, || started.elapsed().as_secs_f64() >= after_s);
    press(run)
}

/// Message of an interrupted run, which must leave no files but its study.
fn told(place: &Place, output: &Output) -> String {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert!(message.contains("error: interrupted"), "{message}");
    let left: Vec<String> =
        names(&place.path("")).into_iter().filter(|name| name == "out" || name.contains(".part")).collect();
    assert!(left.is_empty(), "{left:?} after {message}");
    message
}

#[test]
fn every_command_ends_and_writes_nothing() {
    let fine = SCENE.replace("block_um = 10.0", "block_um = 2.5").replace("\"cell\"", "\"sample\"");
    let dynamic = SCENE.replace("\"steady\"", "\"dynamic\"").replace("sliding_um = 2.0", "sliding_um = 90.0");
    let solid = SCENE.replace("\"groove\"", "\"disc\"").replace("block_um = 10.0", "block_um = 5.0");
    let flat = FLAT.to_owned() + &FLAT.lines().nth(1).unwrap().replace("50,", "100,");
    let files = [
        ("fine.toml", fine.as_str()),
        ("dynamic.toml", &dynamic.replace("\"cell\"", "\"sample\"")),
        ("solid.toml", &solid),
        ("solid-dynamic.toml", &dynamic.replace("\"groove\"", "\"disc\"")),
        ("calibration.toml", CALIBRATION),
        ("mapped.toml", &CALIBRATION.replace("persson_rms_slope = 0.0137", "map = \"map.asc\"")),
        ("flat.csv", &flat),
    ];
    let Some(place) = listening(&files) else { return };
    place.succeed("synthesize --pixels 512 -o map.asc");
    let mut ended = 0;
    for (line, after_s) in [
        ("simulate fine.toml -o out", 0.3),
        ("simulate dynamic.toml -o out", 0.3),
        ("simulate solid.toml -o out", 0.3),
        ("simulate solid-dynamic.toml -o out", 0.5),
        ("accuracy --full -o out", 0.3),
        ("area-law map.asc -o out", 0.5),
        ("surface map.asc --cavities -o out", 0.2),
        ("calibrate calibration.toml --report out", 0.3),
        ("calibrate mapped.toml --report out", 0.5),
        ("synthesize --pixels 2048 -o out", 0.5),
    ] {
        // A quarter of an hour is said before, and is too long for any machine to have ended by itself.
        let is_long = line.contains(" dynamic.toml");
        if let Some(output) = interrupted(&place, line, after_s) {
            let message = told(&place, &output);
            assert!(message.contains("no result was written"), "{line}: {message}");
            assert!(!is_long || message.starts_with("this run takes about "), "{message}");
        } else {
            // What a fast machine has done by then cannot be interrupted.
            assert!(!is_long, "it went on after Ctrl-C");
            ended += 1;
            let _ = fs::remove_dir_all(place.path("out"));
            let _ = fs::remove_file(place.path("out"));
        }
    }
    assert!(ended <= 5, "{ended} of them had ended before");
}

#[test]
fn every_stage_of_a_design_ends() {
    let Some(place) = listening(&[("discs.toml", &discs())]) else { return };
    let started = Instant::now();
    place.uncached("optimize discs.toml -o whole").output().unwrap();
    let whole_s = started.elapsed().as_secs_f64();
    for moment in 1..8 {
        // Before a fifth of a second the program may not listen yet.
        let after_s = (whole_s * f64::from(moment) / 8.0).max(0.2);
        if let Some(output) = interrupted(&place, "optimize discs.toml -o out", after_s) {
            told(&place, &output);
        }
        let _ = fs::remove_dir_all(place.path("out"));
    }
}

#[test]
fn the_command_that_is_named_goes_on_with_the_answers_that_are_counted() {
    let Some(place) = listening(&[("design.toml", &free(&short()))]) else { return };
    let mut run = start(&place, "optimize design.toml -o out");
    let study = place.path("out.study.jsonl");
    wait_until(&mut run, || fs::metadata(&study).is_ok_and(|file| file.len() > 1000));
    let message = told(&place, &press(run).expect("it takes seconds"));
    let (before, rest) = message.split_once(" answers of the search's model are kept in out.study.jsonl").unwrap();
    assert!(rest.contains("slipgrid optimize design.toml -o out --resume"), "{message}");
    let answers = before.split_whitespace().next_back().unwrap();
    let (code, _, said) = place.run("optimize design.toml -o out --resume --no-cache");
    assert!(matches!(code, 0 | 3) && said.contains(&format!("took over {answers} answers")), "{message}{said}");
}

#[test]
fn a_worker_of_a_campaign_says_what_is_kept_and_what_goes_on() {
    let scene = SCENE.replace("\"cell\"", "\"sample\"");
    let seeds: Vec<String> = (1..200).map(|seed| seed.to_string()).collect();
    let campaign = format!("base = \"scene.toml\"\n[[grid]]\nkey = \"run.seed\"\nvalues = [{}]\n", seeds.join(", "));
    let Some(place) = listening(&[("scene.toml", &scene), ("campaign.toml", &campaign)]) else { return };
    place.succeed("campaign plan campaign.toml -o it's");
    let results = || -> usize {
        let shelves = place.path("it's/results");
        if !shelves.exists() {
            return 0;
        }
        names(&shelves).iter().map(|shelf| names(&shelves.join(shelf)).len()).sum()
    };
    let mut run = start(&place, "campaign work it's --share 1/2 --threads 1");
    wait_until(&mut run, || results() >= 2);
    let output = press(run).unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{message}");
    let kept =
        format!("error: interrupted during tasks: {} finished results are kept in it's/results, and\n", results());
    assert!(message.contains(&kept), "{kept}{message}");
    assert!(message.contains("\n  slipgrid campaign work 'it'\\''s' --share 1/2\ngoes on with them"), "{message}");
}

#[test]
fn a_second_one_ends_at_once() {
    let sample = SCENE.replace("block_um = 10.0", "block_um = 2.5").replace("\"cell\"", "\"sample\"");
    let Some(place) = listening(&[("scene.toml", &sample)]) else { return };
    let run = start(&place, "simulate scene.toml -o out");
    std::thread::sleep(Duration::from_millis(700));
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    // One signal where the system took both for one; either way it ends.
    assert_eq!(press(run).unwrap().status.code(), Some(130));
    assert!(!place.path("out").exists());
}
