//! Work through the page: from traces to a material and from a target to laser files, with the bytes of the command line.

use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use serde_json::{Value, json};

use crate::client::Server;
use crate::{DESIGN, copy, root};

/// Runs the command line in `folder`.
fn run(folder: &Path, words: &[&str]) {
    let done = Command::new(env!("CARGO_BIN_EXE_slipgrid"))
        .args(words)
        .current_dir(folder)
        .env("SLIPGRID_CACHE", "")
        .output()
        .unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

#[test]
fn a_job_writes_what_the_command_line_writes() {
    let [page, line] = [(); 2].map(|()| tempfile::tempdir().unwrap());
    for folder in [&page, &line] {
        fs::write(folder.path().join("quick.toml"), DESIGN).unwrap();
    }
    let server = Server::start(page.path());
    let words = ["optimize", "quick.toml"];
    let job = server.job(&words);
    assert_eq!([&job["state"], &job["exit_code"]], [&json!("done"), &json!(0)], "{job}");
    run(line.path(), &words);
    let names: Vec<_> =
        fs::read_dir(line.path().join("out/quick")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(names.len() > 5);
    for name in names.iter().filter(|name| *name != "timings.json" && *name != "report.html") {
        let read = |folder: &Path| fs::read(folder.join("out/quick").join(name)).unwrap();
        if name == ".slipgrid-written" {
            continue;
        }
        assert!(read(page.path()) == read(line.path()), "{}", name.display());
    }
    // All files as one archive.
    let zip = server.ask("GET", "/api/zip?path=out/quick", b"");
    assert!(zip.status == 200 && zip.body.starts_with(b"PK"));
    // An input that is refused is a failed job with the message of the command line.
    fs::write(page.path().join("quick.toml"), DESIGN.replace("width_um", "widht_um")).unwrap();
    let job = server.job(&words);
    assert_eq!([&job["state"], &job["exit_code"]], [&json!("failed"), &json!(2)]);
    assert!(job["err"].as_str().unwrap().starts_with("error: quick.toml"), "{job}");
}

#[test]
fn a_job_is_followed_and_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    copy("calibration/synthetic-polymer", folder.path());
    let server = Server::start(folder.path());
    let mut lines = server.events();
    let words = json!({ "command": ["optimize", "design.toml"] });
    let id = server.send("POST", "/api/jobs", &words)["id"].clone();
    // A job that waits is told, so that it can be cancelled, and then the first stage that has begun.
    assert!(lines.any(|line| line.starts_with("data: ") && line.contains("\"queued\"")));
    let is_running = |line: &String| line.starts_with("data: ") && line.contains("\"running\"");
    assert!(lines.any(|line| is_running(&line)));
    server.send("POST", &format!("/api/jobs/{id}/cancel"), &json!({}));
    let job = server.ended(&id);
    assert_eq!(job["state"], "cancelled", "{job}");
    assert!(!folder.path().join("out/design/result.json").exists());
    assert!(lines.any(|line| line.contains("\"is_cancelled\":true")));
    assert!(lines.any(|line| line.contains("\"cancelled\"")));
    // The next job is not cancelled with it.
    assert_eq!(server.job(&["new", "design", "other.toml"])["state"], "done");
    // A file that appears is told.
    fs::write(folder.path().join("new.csv"), "a").unwrap();
    assert!(lines.any(|line| line == "event: folder"));
    // So is an edit of a trial that waits, which changes neither the length nor the time of its file.
    let edit = |notes: &str| {
        let digest = server.get("/api/text?path=calibration.toml")["digest"].clone();
        let pattern = json!({ "width_um": 9, "spacing_um": 90, "depth_um": 9 });
        let trial = json!({ "name": "cut-1", "pattern": pattern, "notes": notes });
        let edits = json!({ "digest": digest, "edits": [{ "at": ["trial", 0], "value": trial }] });
        server.send("POST", "/api/edit?path=calibration.toml", &edits);
    };
    edit("left");
    // The folder is seen as it is now, and another page is opened.
    std::thread::sleep(Duration::from_millis(2500));
    let mut lines = server.events();
    edit("back");
    assert!(lines.any(|line| line == "event: folder"));
}

#[test]
fn a_result_is_outdated_by_a_change_during_its_run() {
    let (folder, server) = Server::with_design();
    let words = ["optimize", "quick.toml"];
    let changed =
        |server: &Server| server.get("/api/changed?path=quick.toml&result=out/quick/result.json")["changed"].clone();
    let id = server.send("POST", "/api/jobs", &json!({ "command": words }))["id"].clone();
    while server.get("/api/jobs")["jobs"][0]["stage"] == "" {}
    fs::write(folder.path().join("quick.toml"), DESIGN.replace("value = 0.85", "value = 0.8")).unwrap();
    assert_eq!(server.ended(&id)["state"], "done");
    assert_eq!(changed(&server), json!(["quick.toml"]));
    // Another server says so too, until the texture is searched again.
    server.kill();
    let server = Server::start(folder.path());
    assert_eq!(changed(&server), json!(["quick.toml"]));
    assert_eq!(server.job(&words)["state"], "done");
    assert_eq!(changed(&server), json!([]));
}

#[test]
fn a_result_is_outdated_by_every_input() {
    let (folder, server) = Server::anywhere();
    copy("calibration/ldpe-cast-iron", &folder.path().join("m"));
    let design = fs::read_to_string(root().join("crates/studio/example/design.toml")).unwrap();
    let design = design.replace("ldpe-cast-iron/", "m/");
    let write = |name: &str, text: &[u8]| {
        std::thread::sleep(Duration::from_millis(20));
        fs::write(folder.path().join(name), text).unwrap();
    };
    let read = |name: &str| fs::read(folder.path().join(name)).unwrap();
    let changed_of =
        |path: &str| server.get(&format!("/api/changed?path={path}&result=result.json"))["changed"].clone();
    let changed = || changed_of("a.toml");
    let run = || {
        write("result.json", b"{}");
        assert_eq!(changed(), json!([]));
    };
    write("a.toml", design.as_bytes());
    for name in ["a.toml", "m/calibration.toml", "m/flat.csv", "m/flat-map.asc"] {
        run();
        write(name, &read(name));
        assert_eq!(changed(), json!([name]));
        assert_eq!(changed_of("m/calibration.toml"), json!(if name == "a.toml" { vec![] } else { vec![name] }));
    }
    // So does an older file that takes the place of one, as copies keep their time; a page is open.
    run();
    let mut lines = server.events();
    let mut until = |text: &str| assert!(lines.any(|line| line == text), "{text}");
    // The folder is known from the first event on.
    until("event: folder");
    let old = std::time::SystemTime::now() - Duration::from_secs(3600);
    let copy = |name: &str, text: &[u8]| {
        fs::write(folder.path().join(name), text).unwrap();
        fs::File::options().write(true).open(folder.path().join(name)).unwrap().set_modified(old).unwrap();
    };
    copy("m/flat.csv", &read("m/flat.csv"));
    until("event: folder");
    assert_eq!(changed(), json!(["m/flat.csv"]));
    // A trial changes nothing before it is measured.
    run();
    let edit = |at: Value, value: Value| {
        let digest = server.get("/api/text?path=m/calibration.toml")["digest"].clone();
        let edits = json!({ "digest": digest, "edits": [{ "at": at, "value": value }] });
        server.send("POST", "/api/edit?path=m/calibration.toml", &edits);
    };
    let pattern = json!({ "width_um": 9, "spacing_um": 90, "depth_um": 9 });
    edit(json!(["trial", 0]), json!({ "name": "cut-1", "pattern": pattern }));
    assert_eq!(changed(), json!([]));
    edit(json!(["trial", 0, "measurements"]), json!("patterned.csv"));
    assert_eq!(changed(), json!(["m/calibration.toml"]));
    // A design that cannot be read.
    run();
    write("a.toml", b"name = 1\n[target]\n[bounds]\n");
    assert_eq!(changed(), json!(["a.toml"]));
}

#[test]
fn a_killed_server_leaves_the_earlier_result_and_a_free_folder() {
    let (folder, server) = Server::with_design();
    let words = ["optimize", "quick.toml"];
    assert_eq!(server.job(&words)["state"], "done");
    let record = folder.path().join("out/quick/result.json");
    let before = fs::read(&record).unwrap();
    fs::write(folder.path().join("quick.toml"), DESIGN.replace("value = 0.85", "value = 0.8")).unwrap();
    let id = server.send("POST", "/api/jobs", &json!({ "command": words }))["id"].clone();
    while server.get("/api/jobs")["jobs"][0]["state"] == "queued" {}
    server.kill();
    assert!(fs::read(&record).unwrap() == before, "job {id}");
    let server = Server::start(folder.path());
    let again = server.job(&words);
    assert_eq!(again["state"], "done", "{again}");
    assert!(fs::read(&record).unwrap() != before);
}

#[test]
fn two_pages_at_once_share_jobs_and_lose_no_edit() {
    let (folder, server) = Server::with_design();
    let digest = server.get("/api/text?path=quick.toml")["digest"].clone();
    let edit = |key: &str, value: f64| {
        let edit = json!({ "digest": digest, "edits": [{ "at": ["target", key], "value": value }] });
        server.ask("POST", "/api/edit?path=quick.toml", edit.to_string().as_bytes()).status
    };
    // The second page has the text from before the edit of the first.
    assert_eq!([edit("value", 0.8), edit("tolerance", 0.2)], [200, 409]);
    let text = fs::read_to_string(folder.path().join("quick.toml")).unwrap();
    assert!(text.contains("value = 0.8 ") && text.contains("tolerance = 0.1"), "{text}");
    // Jobs of both run in turn.
    let ids = [(); 2].map(|()| {
        let words = json!({ "command": ["optimize", "quick.toml"] });
        server.send("POST", "/api/jobs", &words)["id"].clone()
    });
    for id in ids {
        assert_eq!(server.ended(&id)["state"], "done");
    }
}

#[test]
fn traces_are_understood_and_averaged_as_on_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    copy("calibration/synthetic-polymer", folder.path());
    let server = Server::start(folder.path());
    let found = server.get("/api/trace?path=traces/flat-80N-1.csv&calibration=calibration.toml");
    assert!(found["error"].is_null(), "{found}");
    let roles: Vec<&Value> = found["columns"].as_array().unwrap().iter().map(|column| &column["role"]).collect();
    assert_eq!(roles, ["time", "torque", "normal_force"], "{found}");
    let repeat = &found["repeats"][0];
    let count = |key: &str| repeat[key].as_array().unwrap().len();
    assert!(count("time_s") > 100 && count("time_s") == count("friction") && count("time_s") == count("force_n"));

    let averaged = server.get("/api/traces?path=calibration.toml");
    run(folder.path(), &["traces", "calibration.toml", "-o", "out/traces"]);
    let table = fs::read_to_string(folder.path().join("out/traces/flat.csv")).unwrap();
    let rows: Vec<Vec<f64>> = table
        .lines()
        .filter(|line| line.starts_with(|first: char| first.is_ascii_digit()))
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap_or(f64::NAN)).collect())
        .collect();
    let flat: Vec<&Value> =
        averaged["conditions"].as_array().unwrap().iter().filter(|one| one["surface"] == "flat").collect();
    assert_eq!(flat.len(), rows.len());
    for (condition, row) in flat.iter().zip(&rows) {
        assert_eq!(condition["force_n"], row[0]);
        assert!((condition["mu_dynamic"].as_f64().unwrap() - row[3]).abs() < 1e-4, "{condition} {row:?}");
        assert_eq!(condition["repeats"].as_array().unwrap().len(), 3);
    }
    // A calibration that lacks its map, and a spoilt trace: the other conditions are there, and the reason for the one that is not.
    let path = folder.path().join("calibration.toml");
    let text = fs::read_to_string(&path).unwrap().replace("[fit]", "[surface]\nmap = \"none.asc\"\n[fit]");
    fs::write(&path, text).unwrap();
    fs::write(folder.path().join("traces/flat-30N-1.csv"), "spoilt").unwrap();
    let partly = server.get("/api/traces?path=calibration.toml");
    assert_eq!(partly["conditions"].as_array().unwrap().len(), averaged["conditions"].as_array().unwrap().len() - 1);
    assert!(partly["error"]["message"].as_str().unwrap().contains("flat-30N-1.csv"), "{partly}");
    // A file that is no trace is named with the reason, and its columns are shown.
    fs::write(folder.path().join("wrong.csv"), "clock,F_tan\n0,1\n").unwrap();
    let wrong = server.get("/api/trace?path=wrong.csv");
    assert!(
        wrong["error"].as_str().unwrap().contains("wrong.csv") && wrong["columns"][0]["title"] == "clock",
        "{wrong}"
    );
}

#[test]
fn sliders_read_what_the_bounds_were_computed_for() {
    let (folder, server) = Server::with_design();
    let at = |width_um: f64| {
        let target = format!("/api/predict?path=quick.toml&width_um={width_um}&spacing_um=300&depth_um=10");
        server.ask("GET", &target, b"")
    };
    assert_eq!(at(150.0).status, 409);
    let explored = |server: &Server| {
        let id = server.send("POST", "/api/explore", &json!({ "path": "quick.toml" }))["id"].clone();
        server.ended(&id)
    };
    let job = explored(&server);
    assert_eq!(job["state"], "done", "{job}");
    let found = at(150.0).json();
    let [low, median, high] = ["lower_95", "expected", "upper_95"].map(|key| found[key][0].as_f64().unwrap());
    assert!(low < median && median < high && (0.5..1.1).contains(&median), "{found}");
    let chance = found["chance"].as_f64().unwrap();
    assert!((0.0..=1.0).contains(&chance));
    assert_eq!(found["bounds_um"][0], json!([100.0, 200.0]));
    // Beyond the bounds there is no number.
    assert!(at(250.0).json()["expected"].is_null());
    // After a change of the target the old numbers are not shown; a wider band has a higher chance.
    fs::write(folder.path().join("quick.toml"), DESIGN.replace("tolerance = 0.1", "tolerance = 0.25")).unwrap();
    assert_eq!(at(150.0).status, 409);
    assert_eq!(explored(&server)["state"], "done");
    let wider = at(150.0).json();
    assert!(wider["chance"].as_f64().unwrap() > chance);
    assert!((wider["expected"][0].as_f64().unwrap() - median).abs() < 0.02);
}

#[test]
fn the_example_is_the_published_material() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("example");
    for (name, original) in [
        ("calibration.toml", "calibration/ldpe-cast-iron/calibration.toml"),
        ("flat.csv", "calibration/ldpe-cast-iron/flat.csv"),
        ("patterned.csv", "calibration/ldpe-cast-iron/patterned.csv"),
    ] {
        let kept = root().join("crates/studio/example").join(name);
        assert!(fs::read(kept).unwrap() == fs::read(root().join(original)).unwrap(), "{name}");
    }
    let design = fs::read_to_string(root().join("designs/ldpe-lower-friction.toml")).unwrap();
    let design = design.replace("../calibration/", "");
    assert_eq!(fs::read_to_string(root().join("crates/studio/example/design.toml")).unwrap(), design);
    // The map is made anew, and is the one of the repository.
    fs::create_dir(&place).unwrap();
    let map = place.join("flat-map.asc");
    run(&place, &["--quiet", "synthesize", "-o", map.to_str().unwrap()]);
    let original = fs::read(root().join("calibration/ldpe-cast-iron/flat-map.asc")).unwrap();
    assert!(fs::read(map).unwrap() == original);
}
