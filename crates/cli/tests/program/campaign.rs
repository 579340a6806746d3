//! Campaigns as a user runs them: planned, worked on by several processes, killed, merged.

use std::fs;
use std::process::Command;
use std::time::Duration;

use crate::common::{CALIBRATION, FLAT, Place, SCENE, at, measured, names, small};

const CAMPAIGN: &str = "base = \"scene.toml\"\n[[grid]]\nkey = \"pattern.width_um\"\nvalues = [40, 50, 60, 70, 80, 90]\n\
    [[grid]]\nkey = \"pattern.spacing_um\"\nvalues = [100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0]\n";

/// Table and results of a finished campaign in `folder`.
fn results(place: &Place, folder: &str) -> Vec<(String, String)> {
    let mut all = vec![("table".to_owned(), place.read(&format!("{folder}/table.csv")))];
    for shelf in names(&place.path(&format!("{folder}/results"))) {
        let shelf = format!("{folder}/results/{shelf}");
        let records = names(&place.path(&shelf)).into_iter().filter(|name| name.ends_with(".json"));
        all.extend(records.map(|name| (name.clone(), place.read(&format!("{shelf}/{name}")))));
    }
    all
}

#[test]
fn workers_that_are_killed_lose_the_task_in_hand() {
    let place = Place::with(&[("scene.toml", SCENE), ("campaign.toml", CAMPAIGN)]);
    for folder in ["alone", "killed"] {
        let said = place.succeed(&format!("campaign plan campaign.toml -o {folder}"));
        assert!(said.contains("campaign: 42 tasks") && said.contains("next: slipgrid campaign work"), "{said}");
    }
    assert!(place.succeed("campaign work alone --threads 2").contains("42 tasks: 42 done"));
    assert!(place.succeed("campaign merge alone").contains("42 tasks: 42 done, 0 refused, 0 failed, 0 missing"));
    for number in 0..10_u64 {
        let mut worker = place.begin("campaign work killed --threads 1");
        std::thread::sleep(Duration::from_millis(5 + 37 * number % 60));
        worker.kill().unwrap();
        worker.wait().unwrap();
    }
    // Some are missing, most likely, and said to be; two shares do the rest at the same time.
    let (code, said, _) = place.run("campaign merge killed");
    assert_eq!(code, i32::from(!said.contains(" 0 missing")), "{said}");
    std::thread::scope(|scope| {
        for share in ["1/2", "2/2"] {
            let place = &place;
            scope.spawn(move || place.succeed(&format!("campaign work killed --share {share} --threads 1")));
        }
    });
    place.succeed("campaign merge killed");
    assert_eq!(results(&place, "alone"), results(&place, "killed"));
}

#[test]
fn a_design_is_searched_or_tabulated() {
    let place = Place::with(&[
        ("design.toml", &small()),
        ("search.toml", "base = \"design.toml\"\n[[grid]]\nkey = \"target.value\"\nvalues = [0.9, 0.95]\n"),
        ("table.toml", "base = \"design.toml\"\nwork = \"table\"\n[[grid]]\nkey = \"run.seed\"\nvalues = [1]\n"),
    ]);
    let worked = |name: &str| {
        place.succeed(&format!("campaign plan {name}.toml -o {name}"));
        let done = place.succeed(&format!("campaign work {name}"));
        place.succeed(&format!("campaign merge {name} -o {name}.csv"));
        (done, place.read(&format!("{name}.csv")))
    };
    let (_, table) = worked("search");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][1..6], ["target.value", "outcome", "found", "chance", "width_um"]);
    assert_eq!((rows.len(), rows[1][1], rows[1][2], rows[1][3]), (3, "0.9", "done", "trial"));
    // As optimize finds it.
    place.run("optimize design.toml -o own --table");
    let own = place.result("own");
    for (cell, pointer) in [(rows[1][4], "/chance"), (rows[1][5], "/design/width_um")] {
        assert_eq!(cell.parse(), Ok(at(&own, pointer)), "{pointer}");
    }
    assert_eq!(fs::read_dir(place.path("search/results")).unwrap().count(), 2);

    // Every design of whole blocks and bursts, as --table has them.
    let (done, table) = worked("table");
    let nodes = place.read("own/table.csv").lines().skip(1).filter(|line| !line.starts_with('#')).count();
    assert!(done.contains(&format!("{nodes} tasks: {nodes} done")), "{done}");
    assert_eq!(table.lines().count(), 1 + 2 * nodes);

    // Scenes vary, not the design that their table was made of.
    for (key, says) in [("bounds.width_um", "is no key of the scenes"), ("pattern.width_um", "is what the rows of the")]
    {
        let text = format!("base = \"design.toml\"\nwork = \"table\"\n[[grid]]\nkey = \"{key}\"\nvalues = [60.0]\n");
        place.write("wrong.toml", text);
        let told = place.refuse("campaign plan wrong.toml -o wrong");
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
    place.succeed("campaign plan campaign.toml -o out");
    // Nothing else of this folder is needed.
    fs::remove_dir_all(place.path("m")).unwrap();
    assert!(place.succeed("campaign work out").contains("1 task: 1 done"));
}

#[test]
fn job_scripts_say_and_do_what_they_should() {
    let text = format!("{CAMPAIGN}[[list]]\n\"run.seed\" = 2\n");
    let place = Place::with(&[("scene.toml", SCENE), ("campaign.toml", &text)]);
    place.succeed("campaign plan campaign.toml -o it's --emit slurm --workers 20 --cores 2 --at-once 5");
    let script = place.read("it's/slurm.sh");
    assert!(script.contains("#SBATCH --array=1-20%5\n") && script.contains("#SBATCH --cpus-per-task=2\n"), "{script}");
    let mut bash = Command::new("bash");
    bash.arg(place.path("it's/slurm.sh")).env("SLURM_ARRAY_TASK_ID", "3");
    let ended = bash.env("SLIPGRID", env!("CARGO_BIN_EXE_slipgrid")).output().unwrap();
    assert!(String::from_utf8_lossy(&ended.stdout).contains("2 tasks: 2 done"), "{ended:?}");
    place.refuse_all(
        "campaign work it's --share 3/2 => expected i/n with i from 1 to n
         campaign merge it's -o campaign.toml => was not written by slipgrid",
    );
}
