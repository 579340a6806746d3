//! Ctrl-C ends every stage, reports the results that were kept, and leaves no half-written file.

#![cfg(unix)]

use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use crate::common::{CALIBRATION, DESIGN, FLAT, Place, SCENE, ignores_ctrl_c, many_squares};

/// Time after which a test has hung: runs end within about a second of Ctrl-C, but machines may be busy.
const HUNG: Duration = Duration::from_secs(600);

/// Folder with `files`; `None` where nothing is to be tested, because programs ignore Ctrl-C.
fn listening(files: &[(&str, &str)]) -> Option<Place> {
    (!ignores_ctrl_c()).then(|| Place::with(files))
}

fn start(place: &Place, args: &[&str]) -> Child {
    place.uncached(args).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

fn press(run: &Child) {
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
}

/// Starts the program, presses Ctrl-C after `after_s` seconds, and waits; `None` if the run had ended by itself.
fn interrupted(place: &Place, args: &[&str], after_s: f64) -> Option<Output> {
    let mut run = start(place, args);
    let started = Instant::now();
    while started.elapsed().as_secs_f64() < after_s {
        if run.try_wait().unwrap().is_some() {
            return None;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    if run.try_wait().unwrap().is_some() {
        return None;
    }
    press(&run);
    let output = run.wait_with_output().unwrap();
    // It may have ended by itself at that moment, with its result or because the map has no cavities.
    let has_ended = output.status.success() || String::from_utf8_lossy(&output.stderr).contains("no cavities found");
    (!has_ended).then_some(output)
}

/// Message of an interrupted run, which must leave no files but its study.
fn told(place: &Place, output: &Output) -> String {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{message}");
    assert!(message.contains("error: interrupted"), "{message}");
    let left: Vec<String> = place.names().into_iter().filter(|name| name == "out" || name.contains(".part")).collect();
    assert!(left.is_empty(), "{left:?} after {message}");
    message
}

#[test]
fn every_command_ends_and_writes_nothing() {
    let fine = SCENE.replace("block_um = 10.0", "block_um = 2.5").replace("\"cell\"", "\"sample\"");
    let dynamic = SCENE.replace("\"steady\"", "\"dynamic\"").replace("sliding_um = 2.0", "sliding_um = 90.0");
    let solid_dynamic = dynamic.replace("\"groove\"", "\"disc\"");
    let dynamic = dynamic.replace("\"cell\"", "\"sample\"");
    let solid = SCENE.replace("\"groove\"", "\"disc\"").replace("block_um = 10.0", "block_um = 5.0");
    let flat: String = FLAT.to_owned() + &FLAT.lines().nth(1).unwrap().replace("50,", "100,");
    let mapped = CALIBRATION.replace("persson_rms_slope = 0.0137", "map = \"map.asc\"");
    let files = [
        ("fine.toml", fine.as_str()),
        ("dynamic.toml", &dynamic),
        ("solid.toml", &solid),
        ("solid-dynamic.toml", &solid_dynamic),
        ("calibration.toml", CALIBRATION),
        ("mapped.toml", &mapped),
        ("flat.csv", &flat),
    ];
    let Some(place) = listening(&files) else { return };
    place.succeed(&["synthesize", "--pixels", "512", "-o", "map.asc"]);
    let simulate = |scene: &'static str| vec!["simulate", scene, "-o", "out"];
    let mut ended = 0;
    for (args, after_s) in [
        (simulate("fine.toml"), 0.3),
        (simulate("dynamic.toml"), 0.3),
        (simulate("solid.toml"), 0.3),
        (simulate("solid-dynamic.toml"), 0.5),
        (vec!["accuracy", "--full", "-o", "out"], 0.3),
        (vec!["area-law", "map.asc", "-o", "out"], 0.5),
        (vec!["surface", "map.asc", "--cavities", "-o", "out"], 0.2),
        (vec!["calibrate", "calibration.toml", "--report", "out"], 0.3),
        (vec!["calibrate", "mapped.toml", "--report", "out"], 0.5),
        (vec!["synthesize", "--pixels", "2048", "-o", "out"], 0.5),
    ] {
        // What a fast machine has done by then cannot be interrupted.
        match interrupted(&place, &args, after_s) {
            Some(output) => {
                let message = told(&place, &output);
                assert!(message.contains("no result was written"), "{args:?}: {message}");
                // What takes a quarter of an hour is said before.
                let is_long = args[1] == "dynamic.toml";
                assert!(!is_long || message.starts_with("this run takes about "), "{message}");
            }
            None => {
                // A quarter of an hour is too long for any machine to have ended by itself.
                assert_ne!(args[1], "dynamic.toml", "it went on after Ctrl-C");
                ended += 1;
                let _ = std::fs::remove_dir_all(place.path("out"));
                let _ = std::fs::remove_file(place.path("out"));
            }
        }
    }
    assert!(ended <= 5, "{ended} of them had ended before");
}

/// Design of discs with a target out of reach, which is searched, confirmed and explained in space.
fn discs() -> String {
    let asked = DESIGN.replace("value = 0.9", "value = 0.5");
    let bounded = asked.replace("\"groove\"", "\"disc\"");
    bounded.replace("[40.0, 1000.0]", "[60.0, 150.0]").replace("[40.0, 400.0]", "[40.0, 100.0]")
}

#[test]
fn every_stage_of_a_design_ends_and_names_what_goes_on() {
    let Some(place) = listening(&[("discs.toml", &discs())]) else { return };
    let mut stages = Vec::new();
    for after_s in [0.2, 0.6, 1.5, 3.0, 8.0, 20.0, 60.0] {
        let Some(output) = interrupted(&place, &["optimize", "discs.toml", "-o", "out"], after_s) else { break };
        let message = told(&place, &output);
        if message.contains("answers of the search's model are kept in out.study.jsonl") {
            assert!(message.contains("slipgrid optimize discs.toml -o out --resume"), "{message}");
            assert!(place.read("out.study.jsonl").lines().count() > 1);
        }
        stages.push(message);
    }
    assert!(stages.iter().any(|message| message.contains("--resume")), "{stages:?}");
}

#[test]
fn the_command_that_is_named_goes_on() {
    let Some(place) = listening(&[("design.toml", DESIGN)]) else { return };
    let output = interrupted(&place, &["optimize", "design.toml", "-o", "out"], 0.4);
    let kept = output.map(|output| told(&place, &output)).filter(|message| message.contains("--resume"));
    if let Some(message) = kept {
        let (before, _) = message.split_once(" answers of the search's model").unwrap();
        let answers = before.split_whitespace().next_back().unwrap();
        let again = place.run(&["optimize", "design.toml", "-o", "out", "--resume"]);
        let said = String::from_utf8_lossy(&again.stderr).into_owned();
        // No design lies within the one per cent that is asked for.
        assert!(
            matches!(again.status.code(), Some(0 | 3)) && said.contains(&format!("took over {answers} answers")),
            "{message}{said}"
        );
    }
}

#[test]
fn a_worker_of_a_campaign_says_what_is_kept_and_what_goes_on() {
    let scene = SCENE.replace("\"cell\"", "\"sample\"");
    let seeds: Vec<String> = (1..200).map(|seed| seed.to_string()).collect();
    let campaign = format!("base = \"scene.toml\"\n[[grid]]\nkey = \"run.seed\"\nvalues = [{}]\n", seeds.join(", "));
    let Some(place) = listening(&[("scene.toml", &scene), ("campaign.toml", &campaign)]) else { return };
    place.succeed(&["campaign", "plan", "campaign.toml", "-o", "my seeds"]);
    let work = ["campaign", "work", "my seeds", "--share", "1/2", "--threads", "1"];
    let results = || -> usize {
        let shelves = crate::common::names(&place.path("my seeds/results"));
        shelves.iter().map(|shelf| crate::common::names(&place.path(&format!("my seeds/results/{shelf}"))).len()).sum()
    };
    let run = start(&place, &work);
    let started = Instant::now();
    while !place.path("my seeds/results").exists() || results() < 2 {
        assert!(started.elapsed() < HUNG);
        std::thread::sleep(Duration::from_millis(5));
    }
    press(&run);
    let output = run.wait_with_output().unwrap();
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{message}");
    let kept =
        format!("error: interrupted during tasks: {} finished results are kept in my seeds/results, and\n", results());
    assert!(message.contains(&kept), "{kept}{message}");
    assert!(message.contains("\n  slipgrid campaign work 'my seeds' --share 1/2\ngoes on with them"), "{message}");
}

#[test]
fn a_second_one_ends_at_once() {
    let Some(place) = listening(&[("scene.toml", &SCENE.replace("block_um = 10.0", "block_um = 1.0"))]) else { return };
    let run = start(&place, &["simulate", "scene.toml", "-o", "out"]);
    std::thread::sleep(Duration::from_millis(700));
    press(&run);
    press(&run);
    let output = run.wait_with_output().unwrap();
    // One signal where the system took both for one; either way it ends.
    assert_eq!(output.status.code(), Some(130));
    assert!(!place.path("out").exists());
}

#[test]
fn files_are_whole_or_absent_whenever_it_is_pressed() {
    let Some(place) = listening(&[("result.json", &many_squares(20.0))]) else { return };
    let args = ["export", "result.json", "--format", "dxf,svg,csv,corners,hatch,plt,stl", "-o", "out"];
    let started = Instant::now();
    place.succeed(&args);
    let whole_s = started.elapsed().as_secs_f64();
    let files = crate::common::names(&place.path("out"));
    for moment in 1..6 {
        std::fs::remove_dir_all(place.path("out")).unwrap();
        if let Some(output) = interrupted(&place, &args, whole_s * f64::from(moment) / 6.0)
            && output.status.code() == Some(130)
        {
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(message.contains("interrupted"), "{message}");
        }
        if place.path("out").exists() {
            assert_eq!(crate::common::names(&place.path("out")), files);
        } else {
            std::fs::create_dir(place.path("out")).unwrap();
        }
        assert!(place.names().iter().all(|name| !name.contains(".part")), "{:?}", place.names());
    }
}
