//! Campaigns as a user runs them: planned, worked on by several processes, killed, merged.

use std::fs;
use std::process::Command;
use std::time::Duration;

use crate::common::{CALIBRATION, FLAT, Place, SCENE, measured, small};

const CAMPAIGN: &str = "base = \"scene.toml\"\n[[grid]]\nkey = \"pattern.width_um\"\nvalues = [40, 50, 60, 70, 80, 90]\n\
    [[grid]]\nkey = \"pattern.spacing_um\"\nvalues = [100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0]\n";

fn place(campaign: &str) -> Place {
    Place::with(&[("scene.toml", SCENE), ("campaign.toml", campaign)])
}

/// Table and results of a finished campaign in `folder`.
fn results(place: &Place, folder: &str) -> Vec<(String, String)> {
    let read = |path: String| (path.clone(), place.read(&path));
    let mut all = vec![("table".to_owned(), read(format!("{folder}/table.csv")).1)];
    let shelves = crate::common::names(&place.path(&format!("{folder}/results")));
    for shelf in shelves {
        for name in crate::common::names(&place.path(&format!("{folder}/results/{shelf}"))) {
            if name.ends_with(".json") {
                all.push((name.clone(), read(format!("{folder}/results/{shelf}/{name}")).1));
            }
        }
    }
    all
}

#[test]
fn workers_that_are_killed_lose_the_task_in_hand() {
    let place = place(CAMPAIGN);
    for folder in ["alone", "killed"] {
        let said = place.succeed(&["campaign", "plan", "campaign.toml", "-o", folder]);
        assert!(said.contains("campaign: 42 tasks") && said.contains("next: slipgrid campaign work"), "{said}");
    }
    // A shell takes the next command as it is printed.
    let said = place.succeed(&["campaign", "plan", "campaign.toml", "-o", "with a space"]);
    assert!(cfg!(windows) || said.ends_with("next: slipgrid campaign work 'with a space'\n"), "{said}");
    assert!(place.succeed(&["campaign", "work", "alone", "--threads", "2"]).contains("42 tasks: 42 done"));
    assert!(
        place.succeed(&["campaign", "merge", "alone"]).contains("42 tasks: 42 done, 0 refused, 0 failed, 0 missing")
    );
    for number in 0..10_u64 {
        let mut worker = place.begin(&["campaign", "work", "killed", "--threads", "1"]);
        std::thread::sleep(Duration::from_millis(5 + 37 * number % 60));
        worker.kill().unwrap();
        worker.wait().unwrap();
    }
    // Some are missing, most likely, and said to be; two shares do the rest at the same time.
    let merged = place.run(&["campaign", "merge", "killed"]);
    let missing = !String::from_utf8_lossy(&merged.stdout).contains(" 0 missing");
    assert_eq!(merged.status.code(), Some(i32::from(missing)));
    std::thread::scope(|scope| {
        for share in ["1/2", "2/2"] {
            scope.spawn(|| place.succeed(&["campaign", "work", "killed", "--share", share, "--threads", "1"]));
        }
    });
    place.succeed(&["campaign", "merge", "killed"]);
    assert_eq!(results(&place, "alone"), results(&place, "killed"));
}

#[test]
fn a_design_is_searched_or_tabulated() {
    let designs = Place::with(&[
        ("design.toml", &small()),
        ("search.toml", "base = \"design.toml\"\n[[grid]]\nkey = \"target.value\"\nvalues = [0.9, 0.95]\n"),
        ("table.toml", "base = \"design.toml\"\nwork = \"table\"\n[[grid]]\nkey = \"run.seed\"\nvalues = [1]\n"),
    ]);
    designs.succeed(&["campaign", "plan", "search.toml", "-o", "search"]);
    designs.succeed(&["campaign", "work", "search"]);
    designs.succeed(&["campaign", "merge", "search"]);
    let table = designs.read("search/table.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][1..6], ["target.value", "outcome", "found", "chance", "width_um"]);
    assert_eq!((rows.len(), rows[1][1], rows[1][2], rows[1][3]), (3, "0.9", "done", "trial"));
    // As optimize finds it.
    designs.run(&["optimize", "design.toml", "-o", "own"]);
    let own = crate::common::result(&designs, "own");
    for (cell, at) in [(rows[1][4], "/chance"), (rows[1][5], "/design/width_um")] {
        assert_eq!(cell.parse().ok(), own.pointer(at).and_then(serde_json::Value::as_f64), "{at}");
    }
    let record = fs::read_dir(designs.path("search/results")).unwrap().count();
    assert_eq!(record, 2);

    // Every design of whole blocks and bursts, as --table has them.
    designs.succeed(&["campaign", "plan", "table.toml", "-o", "table"]);
    let done = designs.succeed(&["campaign", "work", "table"]);
    let merged = designs.succeed(&["campaign", "merge", "table", "-o", "all.csv"]);
    let lines = designs.read("all.csv");
    designs.run(&["optimize", "design.toml", "-o", "own", "--table"]);
    let table = designs.read("own/table.csv");
    let nodes = table.lines().skip(1).filter(|line| !line.starts_with('#')).count();
    assert!(done.contains(&format!("{nodes} tasks: {nodes} done")), "{done}");
    assert!(merged.contains("0 missing, in all.csv") && lines.lines().count() == 1 + 2 * nodes, "{merged}");

    // Scenes vary, not the design that their table was made of.
    for (key, says) in [
        (
            "bounds.width_um",
            "is no key of the scenes that work = \"table\" makes of the design; expected a key of material, ",
        ),
        ("pattern.width_um", "is what the rows of the design's table vary already; expected another key"),
    ] {
        let text = format!("base = \"design.toml\"\nwork = \"table\"\n[[grid]]\nkey = \"{key}\"\nvalues = [60.0]\n");
        designs.write("wrong.toml", text);
        let told = designs.refuse(&["campaign", "plan", "wrong.toml", "-o", "wrong"]);
        assert!(told.starts_with(&format!("error: wrong.toml:5: {key}: 60.0 {says}")), "{told}");
    }
}

#[test]
fn a_material_that_is_calibrated_travels_with_the_campaign() {
    let design = measured(&small(), "m/calibration.toml").replace("[0.65, 2.6]", "0.7");
    let place = Place::with(&[("design.toml", &design), ("campaign.toml", "base = \"design.toml\"\n")]);
    fs::create_dir(place.path("m")).unwrap();
    place.write("m/calibration.toml", CALIBRATION);
    place.write("m/flat.csv", FLAT);
    place.succeed(&["campaign", "plan", "campaign.toml", "-o", "out"]);
    // Nothing else of this folder is needed.
    fs::remove_dir_all(place.path("m")).unwrap();
    let worked = place.succeed(&["campaign", "work", "out"]);
    assert!(worked.contains("1 task: 1 done"), "{worked}");
}

#[test]
fn job_scripts_and_refusals_say_what_they_should() {
    let place = place(&format!("{CAMPAIGN}[[list]]\n\"run.seed\" = 2\n"));
    let flags = ["--emit", "slurm", "--workers", "20", "--cores", "2", "--at-once", "5"];
    place.succeed(&[&["campaign", "plan", "campaign.toml", "-o", "it's"][..], &flags].concat());
    let script = place.read("it's/slurm.sh");
    assert!(script.contains("#SBATCH --array=1-20%5\n") && script.contains("#SBATCH --cpus-per-task=2\n"), "{script}");
    assert!(script.contains("it'\\''s' --share \"$SLURM_ARRAY_TASK_ID/20\""), "{script}");
    let mut bash = Command::new("bash");
    bash.arg(place.path("it's/slurm.sh")).env("SLURM_ARRAY_TASK_ID", "3");
    let ended = bash.env("SLIPGRID", env!("CARGO_BIN_EXE_slipgrid")).output().unwrap();
    assert!(String::from_utf8_lossy(&ended.stdout).contains("2 tasks: 2 done"), "{ended:?}");

    for (args, says) in [
        (&["campaign", "work", "it's", "--share", "3/2"][..], "expected i/n with i from 1 to n"),
        (&["campaign", "merge", "it's", "-o", "campaign.toml"], "was not written by slipgrid"),
    ] {
        let told = place.refuse(args);
        assert!(told.contains(says), "{args:?}: {told}");
    }
}
