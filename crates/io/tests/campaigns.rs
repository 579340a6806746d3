//! Campaigns in memory: tables that do not depend on who does which task, and errors.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use slipgrid_base::monitor::{Monitor, Unwatched};
use slipgrid_io::Failure;
use slipgrid_io::campaign::{Engine, Folder, Outcome, Planned, Results, Share, Store, Worker, plan};
use slipgrid_io::formats::source::{Entry, Files, Source};

const SCENE: &str = "material = \"m/material.toml\"\n[pattern]\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 20.0\n\
    planform = \"groove\"\n[sample]\nlength_um = 9960.0\nlayer_um = 200.0\nblock_um = 10.0\n[load]\n\
    pressure_mpa = [0.7, 2.6]\nspeed_mm_s = 2.0\n[run]\nfidelity = \"steady\"\nextent = \"cell\"\n";
const MATERIAL: &str = "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[friction]\nstatic_mean = 0.30\n\
    dynamic_mean = 0.27\n[area_law]\npressure_mpa = [0.7, 1.3, 2.6, 10.0]\nfactor = [1.0, 0.96, 0.90, 0.60]\n";
const CAMPAIGN: &str = "base = \"scene.toml\"\n[[grid]]\nkey = \"pattern.width_um\"\nvalues = [40.0, 60.0, 80.0]\n\
    [[list]]\n\"pattern.spacing_um\" = 200.0\n\"pattern.depth_um\" = 10.0\n[[list]]\n\"pattern.spacing_um\" = 400.0\n\
    \"pattern.depth_um\" = 20.0\n";

/// Files in memory that can be written.
#[derive(Debug, Default)]
struct Memory(Mutex<BTreeMap<PathBuf, Vec<u8>>>);

impl Memory {
    fn of(files: &[(&str, &str)]) -> Arc<Self> {
        let files = files.iter().map(|(path, text)| (PathBuf::from(path), text.as_bytes().to_vec()));
        Arc::new(Self(Mutex::new(files.collect())))
    }

    fn all(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        self.0.lock().unwrap().clone()
    }
}

impl Files for Memory {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        self.0.lock().unwrap().get(path).cloned().ok_or(io::ErrorKind::NotFound.into())
    }

    fn entry(&self, path: &Path) -> io::Result<Entry> {
        self.read(path).map(|_| Entry::File)
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        let files = self.0.lock().unwrap();
        let inside = files.keys().filter_map(|path| path.strip_prefix(folder).ok());
        let mut names: Vec<String> =
            inside.map(|path| path.iter().next().unwrap().to_string_lossy().into_owned()).collect();
        names.dedup();
        names
    }
}

impl Store for Memory {
    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        self.0.lock().unwrap().insert(path.to_owned(), bytes.to_vec());
        Ok(())
    }
}

fn given(scene: &str, campaign: &str) -> Arc<Memory> {
    Memory::of(&[("d/scene.toml", scene), ("d/m/material.toml", MATERIAL), ("d/campaign.toml", campaign)])
}

fn planned(files: &Arc<Memory>) -> Result<Planned, Failure> {
    plan(&(Arc::clone(files) as Source), Path::new("d/campaign.toml"), &Unwatched)
}

fn folder(store: &Arc<Memory>) -> Folder {
    Folder::new(Arc::clone(store) as Arc<dyn Store>, Path::new("out"))
}

fn table(store: &Arc<Memory>) -> String {
    folder(store).merge(|results| results.csv().to_owned()).unwrap()
}

#[test]
fn the_table_is_the_same_whoever_does_what() {
    let files = given(SCENE, CAMPAIGN);
    let planned = planned(&files).unwrap();
    assert_eq!(planned.tasks.len(), 6);
    let alone = Memory::of(&[]);
    folder(&alone).keep(&planned).unwrap();
    let worked = folder(&alone).work(Share::ALL, 1, None, 3, &Unwatched).unwrap();
    assert_eq!((worked.counts.done, worked.known, worked.counts.missing), (6, 0, 0));

    let shared = Memory::of(&[]);
    folder(&shared).keep(&planned).unwrap();
    let missing = folder(&shared).merge(|results| results.counts()).unwrap();
    assert_eq!(missing.words(), "6 tasks: 0 done, 0 refused, 0 failed, 6 missing");
    for number in [3, 1, 4, 2] {
        folder(&shared).work(Share { number, of: 4 }, 2, None, 0, &Unwatched).unwrap();
    }
    assert_eq!(alone.all(), shared.all());
    let table = table(&alone);
    let rows: Vec<&str> = table.lines().collect();
    // One row per load, in the order of the file, with the grid slowest.
    assert_eq!(rows.len(), 1 + 6 * 2);
    let expected = "task,pattern.width_um,pattern.depth_um,pattern.spacing_um,outcome,pressure_mpa,mu_dynamic,";
    assert!(rows[0].starts_with(expected), "{}", rows[0]);
    assert!(rows[1].contains(",40,10,200,done,0.7,") && rows[12].contains(",80,20,400,done,2.6,"), "{table}");

    // No task is done twice, and an equal campaign may be planned again.
    folder(&shared).keep(&planned).unwrap();
    let again = folder(&shared).work(Share::ALL, 1, None, 0, &Unwatched).unwrap();
    assert_eq!((again.counts.done, again.known), (0, 6));

    // In memory only, as other programs do it.
    let worker = Worker::new(&planned.campaign, planned.contents.clone());
    let done = worker.work(&planned.tasks[0], &Unwatched).unwrap();
    let kept = alone.read(&PathBuf::from(format!("out/results/{0}/{1}.json", &done.id[..2], done.id))).unwrap();
    assert_eq!(serde_json::to_string(&done).unwrap() + "\n", String::from_utf8(kept).unwrap());
}

#[test]
fn an_id_stands_for_what_a_task_says_and_reads() {
    let ids = |files: &Arc<Memory>| -> Vec<String> {
        planned(files).unwrap().tasks.into_iter().map(|task| task.id).collect()
    };
    let first = ids(&given(SCENE, CAMPAIGN));
    assert_eq!(first, ids(&given(SCENE, CAMPAIGN)));
    // A comment does not change the id; another material or value does.
    assert_eq!(first, ids(&given(&format!("# twice\n{SCENE}"), CAMPAIGN)));
    let other = given(SCENE, CAMPAIGN);
    other.put(Path::new("d/m/material.toml"), MATERIAL.replace("0.27", "0.28").as_bytes()).unwrap();
    assert!(first.iter().all(|id| !ids(&other).contains(id)));
    let wider = ids(&given(SCENE, &CAMPAIGN.replace("80.0]", "80.0, 100.0, 40.0]")));
    assert_eq!((wider.len(), first.iter().all(|id| wider.contains(id))), (8, true));
}

#[test]
fn cavities_that_close_are_seen_in_the_table() {
    let scene = SCENE.replace("spacing_um = 370.0", "spacing_um = 100.0").replace("depth_um = 20.0", "depth_um = 2.0");
    let campaign = "base = \"scene.toml\"\n[[grid]]\nkey = \"pattern.width_um\"\nvalues = [20.0, 300.0]\n";
    let planned = planned(&given(&scene, campaign)).unwrap();
    let store = Memory::of(&[]);
    folder(&store).keep(&planned).unwrap();
    folder(&store).work(Share::ALL, 1, None, 0, &Unwatched).unwrap();
    let table = table(&store);
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let column = rows[0].iter().position(|name| *name == "cavity_closed").unwrap();
    // By width, then by load.
    let closed: Vec<&str> = rows[1..].iter().map(|row| row[column]).collect();
    assert_eq!(closed, ["false", "false", "false", "true"], "{table}");
}

#[test]
fn what_fails_is_a_result() {
    let files = given(SCENE, "base = \"scene.toml\"\n[[grid]]\nkey = \"run.seed\"\nvalues = [1, 2]\n");
    let planned = planned(&files).unwrap();
    let store = Memory::of(&[]);
    folder(&store).keep(&planned).unwrap();
    // A file of the campaign is damaged.
    let hash = planned.campaign.inputs["m/material.toml"].clone();
    store.put(&Path::new("out/inputs").join(hash), MATERIAL.replace("0.27", "0.28").as_bytes()).unwrap();
    let worked = folder(&store).work(Share::ALL, 2, None, 0, &Unwatched).unwrap();
    assert_eq!((worked.counts.refused, worked.counts.done), (2, 0));
    let table = table(&store);
    let reason = "m/material.toml: cannot be read: it is not what it was when the campaign was planned";
    assert!(table.contains(",refused,") && table.contains(reason), "{table}");
    let mut moved = planned.tasks[0].clone();
    moved.values.insert("run.seed".to_owned(), 7.into());
    let worker = Worker::new(&planned.campaign, planned.contents.clone());
    assert_eq!(worker.work(&moved, &Unwatched).unwrap().outcome, Outcome::Refused);
}

#[test]
fn a_worker_stops_when_told_and_goes_on_later() {
    /// Cancels, or lets a minute pass, at every call from the third on.
    struct Told {
        asked: AtomicUsize,
        cancels: bool,
    }
    impl Monitor for Told {
        fn cancelled(&self) -> bool {
            self.cancels && self.asked.fetch_add(1, Ordering::Relaxed) > 2
        }
        fn seconds(&self) -> f64 {
            if self.cancels { 0.0 } else { 60.0 * self.asked.fetch_add(1, Ordering::Relaxed) as f64 }
        }
    }
    let files = given(SCENE, CAMPAIGN);
    let planned = planned(&files).unwrap();
    for cancels in [true, false] {
        let store = Memory::of(&[]);
        folder(&store).keep(&planned).unwrap();
        let told = Told { asked: AtomicUsize::new(0), cancels };
        match folder(&store).work(Share::ALL, 1, Some(150.0), 0, &told) {
            Err(Failure::Cancelled) => assert!(cancels),
            Ok(worked) => assert!(!cancels && worked.counts.missing > 0 && worked.counts.done > 0, "{worked:?}"),
            Err(error) => panic!("{error}"),
        }
        folder(&store).work(Share::ALL, 2, None, 1, &Unwatched).unwrap();
        assert_eq!(table(&store).matches(",done,").count(), 12);
    }
}

#[test]
fn another_campaign_or_program_is_refused() {
    let store = Memory::of(&[]);
    folder(&store).keep(&planned(&given(SCENE, CAMPAIGN)).unwrap()).unwrap();
    let other = planned(&given(SCENE, &CAMPAIGN.replace("80.0", "90.0"))).unwrap();
    let refused = folder(&store).keep(&other).unwrap_err().to_string();
    assert!(refused.contains("out: holds another campaign"), "{refused}");
    let nothing = folder(&Memory::of(&[])).work(Share::ALL, 1, None, 0, &Unwatched).unwrap_err().to_string();
    assert!(nothing.contains("expected the folder of a campaign"), "{nothing}");
    let json = store.read(Path::new("out/campaign.json")).unwrap();
    let later = String::from_utf8(json).unwrap().replace("\"version\": \"", "\"version\": \"9");
    store.put(Path::new("out/campaign.json"), later.as_bytes()).unwrap();
    let refused = folder(&store).work(Share::ALL, 1, None, 0, &Unwatched).unwrap_err().to_string();
    assert!(refused.contains("was planned by slipgrid 9"), "{refused}");
}

#[test]
fn of_many_tasks_that_are_refused_the_first_is_named() {
    let values: Vec<String> =
        (0..40).map(|value| if value < 9 { "40.0".to_owned() } else { format!("-{value}.0") }).collect();
    let campaign =
        format!("base = \"scene.toml\"\n[[grid]]\nkey = \"pattern.width_um\"\nvalues = [{}]\n", values.join(", "));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
    for _ in 0..10 {
        let refused = pool.install(|| planned(&given(SCENE, &campaign)).unwrap_err().to_string());
        assert!(refused.contains("pattern.width_um: -9.0 is out of range"), "{refused}");
    }
}

#[test]
fn a_base_that_is_refused_whatever_varies_keeps_its_own_line() {
    let scene = SCENE.replace("depth_um = 20.0", "depth_um = -20.0");
    let campaign = "base = \"scene.toml\"\n[[grid]]\nkey = \"run.seed\"\nvalues = [1, 2]\n";
    let refused = planned(&given(&scene, campaign)).unwrap_err().to_string();
    assert!(refused.starts_with("d/scene.toml:5: pattern.depth_um: -20.0 "), "{refused}");
}

#[test]
fn names_in_a_folder_lead_nowhere_else_and_shift_no_columns() {
    let planned = planned(&given(SCENE, CAMPAIGN)).unwrap();
    let id = planned.tasks[0].id.as_str();
    let hash = planned.campaign.inputs.values().next().unwrap().as_str();
    for (file, from, to, says) in [
        ("out/tasks.jsonl", id, "../../made/outside", "out/tasks.jsonl:1: is no task: invalid value: string"),
        ("out/tasks.jsonl", id, &id[1..], "expected an id of 20 hexadecimal digits"),
        ("out/tasks.jsonl", id, &id.to_uppercase().replace(char::is_numeric, "A"), "expected an id of 20"),
        ("out/campaign.json", "\"pattern.width_um\"", "\"pattern\\nwidth_um\"", "\"pattern\\nwidth_um\" is no key"),
        ("out/campaign.json", hash, "../../secret", "\"../../secret\" is no hash; expected 64 hexadecimal digits"),
    ] {
        let store = Memory::of(&[]);
        folder(&store).keep(&planned).unwrap();
        let text = String::from_utf8(store.read(Path::new(file)).unwrap()).unwrap();
        assert!(text.contains(from), "{text}");
        store.put(Path::new(file), text.replace(from, to).as_bytes()).unwrap();
        let before = store.all();
        let worked = folder(&store).work(Share::ALL, 1, None, 0, &Unwatched).unwrap_err().to_string();
        let merged = folder(&store).merge(|results| results.counts()).unwrap_err().to_string();
        assert!(worked.contains(says) && merged.contains(says), "{to}: {worked}");
        assert!(store.all() == before, "{to}");
    }
    // All rows have as many columns as the header, whatever a key or a text holds.
    let mut campaign = planned.campaign;
    campaign.keys = vec!["a,b".to_owned(), "=c".to_owned()];
    let mut results = Results::new(&campaign);
    results.add(&planned.tasks[0], None);
    let header = "task,\"a,b\",'=c,outcome,pressure_mpa,";
    assert!(results.csv().starts_with(header), "{}", results.csv());
    let cells = |line: &str| line.replace("\"a,b\"", "").matches(',').count();
    let counts: Vec<usize> = results.csv().lines().map(cells).collect();
    assert_eq!(counts[0], counts[1]);
}

#[test]
fn a_folder_with_a_line_break_in_its_name_has_no_script() {
    for engine in Engine::ALL {
        let of = |folder: &str| engine.script(Path::new(folder), 2, 1, None);
        assert!(of("/a b/it's").unwrap().contains("campaign work '/a b/it'\\''s' --share"));
        let refused = of("/a\n#SBATCH --wrap=x\n/b").unwrap_err().to_string();
        assert!(refused.contains("cannot stand in a job script"), "{refused}");
    }
}

#[test]
fn a_result_that_is_done_and_has_no_record_is_damaged() {
    let store = Memory::of(&[]);
    let planned = planned(&given(SCENE, CAMPAIGN)).unwrap();
    folder(&store).keep(&planned).unwrap();
    folder(&store).work(Share::ALL, 2, None, 0, &Unwatched).unwrap();
    let id = &planned.tasks[0].id;
    let path = result_path(id);
    let text = format!("{{\"schema\":1,\"id\":\"{id}\",\"outcome\":\"done\",\"reason\":null,\"record\":null}}");
    store.put(&path, text.as_bytes()).unwrap();
    let refused = folder(&store).merge(|results| results.counts()).unwrap_err().to_string();
    assert!(refused.starts_with("1 damaged result; `slipgrid campaign work` on the same folder"), "{refused}");
    assert!(refused.contains(id.as_str()) && refused.contains("is damaged"), "{refused}");
}

fn result_path(id: &str) -> PathBuf {
    PathBuf::from(format!("out/results/{}/{id}.json", &id[..2]))
}

/// Records notes.
#[derive(Default)]
struct Notes(Mutex<Vec<String>>);

impl Monitor for Notes {
    fn note(&self, text: &str) {
        self.0.lock().unwrap().push(text.to_owned());
    }
}

#[test]
fn every_damaged_result_is_named_and_done_again() {
    let store = Memory::of(&[]);
    let planned = planned(&given(SCENE, CAMPAIGN)).unwrap();
    folder(&store).keep(&planned).unwrap();
    folder(&store).work(Share::ALL, 2, None, 0, &Unwatched).unwrap();
    let whole = store.all();
    let ids: Vec<&str> = planned.tasks.iter().map(|task| task.id.as_str()).collect();
    let half = whole[&result_path(ids[1])][..40].to_vec();
    store.put(&result_path(ids[1]), &half).unwrap();
    store.put(&result_path(ids[2]), b"").unwrap();
    store.put(&result_path(ids[4]), &whole[&result_path(ids[5])]).unwrap();
    let refused = folder(&store).merge(|results| results.counts()).unwrap_err().to_string();
    let lines: Vec<&str> = refused.lines().collect();
    assert_eq!(lines.len(), 4, "{refused}");
    assert!(lines[0].starts_with("3 damaged results; `slipgrid campaign work` "), "{refused}");
    let says = ["is no result: EOF", "is no result: EOF", "is the result of another task"];
    for ((line, place), says) in lines[1..].iter().zip([1, 2, 4]).zip(says) {
        assert!(line.contains(ids[place]) && line.contains(says), "{line}");
    }

    // A worker reports the damaged results of its share and does these tasks again.
    for (share, damaged, known) in [(Share { number: 2, of: 3 }, 2, 0), (Share::ALL, 1, 5), (Share::ALL, 0, 6)] {
        let notes = Notes::default();
        let worked = folder(&store).work(share, 2, None, 0, &notes).unwrap();
        assert_eq!((worked.damaged, worked.counts.done, worked.known), (damaged, damaged, known));
        let notes = notes.0.into_inner().unwrap();
        assert_eq!(notes.len(), damaged, "{notes:?}");
        assert!(notes.iter().all(|note| note.starts_with("warning: out/results/")), "{notes:?}");
    }
    assert_eq!(store.all(), whole);
}
