use super::*;
use crate::disk::{hold_writing, put_unless};

fn outputs(files: &[(&str, &str)]) -> Outputs {
    let mut outputs = Outputs::default();
    files.iter().for_each(|(name, text)| outputs.add(*name, *text));
    outputs
}

fn open(folder: &Path) -> Result<ResultFolder, Failure> {
    ResultFolder::open(Place::output(folder), &["result.json", "friction-*.svg", "next-*/a.svg", "table.csv"], &[])
}

fn replace(folder: &Path, files: &[(&str, &str)]) -> Result<(), WriteError> {
    open(folder).unwrap().replace(&outputs(files), &|| false)
}

fn names_in(folder: &Path) -> io::Result<BTreeSet<OsString>> {
    fs::read_dir(folder)?.map(|entry| Ok(entry?.file_name())).collect()
}

/// Names with contents, without the list.
fn content(folder: &Path) -> Vec<(String, String)> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if entry.path().is_dir() {
            all.extend(content(&entry.path()).into_iter().map(|(below, text)| (format!("{name}/{below}"), text)));
        } else if name != LIST {
            all.push((name, fs::read_to_string(entry.path()).unwrap()));
        }
    }
    all.sort();
    all
}

fn of(files: &[(&str, &str)]) -> Vec<(String, String)> {
    let mut files: Vec<_> = files.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect();
    files.sort();
    files
}

#[test]
fn an_input_that_changed_during_the_run_is_newer_than_the_result() {
    let place = tempfile::tempdir().unwrap();
    let [out, input] = ["out", "design.toml"].map(|name| place.path().join(name));
    let time = |path: &Path| fs::metadata(path).unwrap().modified().unwrap();
    // A new folder, and one with a result.
    for _ in 0..2 {
        fs::write(&input, "before").unwrap();
        let folder = open(&out).unwrap();
        let files = outputs(&[("result.json", "{}")]);
        folder.replace(&files, &|| false).unwrap();
        assert!(time(&out.join("result.json")) >= time(&input));
        std::thread::sleep(Duration::from_millis(30));
        fs::write(&input, "meanwhile").unwrap();
        folder.replace(&files, &|| false).unwrap();
        assert!(time(&out.join("result.json")) < time(&input));
    }
}

#[test]
fn a_result_is_replaced_as_a_whole_and_files_of_others_stay() {
    for has_folder in [false, true] {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("deep/out");
        replace(&folder, &[("result.json", "1"), ("friction-1mpa.svg", "1"), ("table.csv", "1")]).unwrap();
        let mut kept = vec![("notes.txt", "mine")];
        fs::write(folder.join("notes.txt"), "mine").unwrap();
        if has_folder {
            fs::create_dir(folder.join("own")).unwrap();
            fs::write(folder.join("own/a"), "mine").unwrap();
            kept.push(("own/a", "mine"));
        }
        let second = [("result.json", "2"), ("friction-2mpa.svg", "2")];
        replace(&folder, &second).unwrap();
        assert_eq!(content(&folder), of(&[&second[..], &kept].concat()), "pictures of the first result are gone");
        // A file changed by the user belongs to the user.
        fs::write(folder.join("friction-2mpa.svg"), "changed").unwrap();
        let refused = open(&folder).unwrap_err().to_string();
        assert!(
            refused.contains("holds friction-2mpa.svg, which was not written by slipgrid, or was changed"),
            "{refused}"
        );
        fs::remove_file(folder.join("friction-2mpa.svg")).unwrap();
        let third = [("result.json", "3"), ("next-1/a.svg", "3")];
        replace(&folder, &third).unwrap();
        open(&folder).unwrap().add(&outputs(&[("table.csv", "4")]), &|| false).unwrap();
        assert_eq!(content(&folder), of(&[&third[..], &[("table.csv", "4")], &kept].concat()));
        replace(&folder, &[("result.json", "5"), ("next-1/a.svg", "5")]).unwrap();
        assert_eq!(names_in(folder.parent().unwrap()).unwrap().len(), 1, "nothing is left beside it");
    }
}

#[test]
fn nothing_changes_where_a_result_is_refused_cancelled_or_has_a_name_twice() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("out");
    replace(&folder, &[("result.json", "1")]).unwrap();
    let held = open(&folder).unwrap();
    fs::write(folder.join("friction-1mpa.svg"), "<svg width=\"mine\"/>").unwrap();
    let before = content(&folder);
    let new = [("friction-1mpa.svg", "2"), ("result.json", "2")];
    let refused = held.replace(&outputs(&new), &|| false).unwrap_err().to_string();
    assert!(refused.contains("friction-1mpa.svg: cannot be written: slipgrid did not write"), "{refused}");
    assert!(held.replace(&outputs(&new[1..]), &|| true).is_err());
    let twice = held.replace(&outputs(&[new[1], new[1]]), &|| false).unwrap_err().to_string();
    assert!(twice.contains("two results would have the name result.json"), "{twice}");
    assert_eq!(content(&folder), before);
    let other = open(&folder).unwrap_err().to_string();
    assert!(
        other.contains("another run works for this folder") || other.contains("holds friction-1mpa.svg"),
        "{other}"
    );
    fs::remove_file(folder.join("friction-1mpa.svg")).unwrap();
    let other = open(&folder).unwrap_err().to_string();
    assert!(other.contains("another run works for this folder"), "{other}");
}

/// A killed run leaves files of two results, and a list of both.
#[test]
fn what_a_killed_run_left_is_replaced_and_old_unfinished_files_go() {
    let place = tempfile::tempdir().unwrap();
    let folder = place.path().join("out");
    replace(&folder, &[("result.json", "1"), ("table.csv", "1")]).unwrap();
    let list = fs::read_to_string(folder.join(LIST)).unwrap();
    replace(&folder, &[("result.json", "2"), ("table.csv", "2")]).unwrap();
    fs::write(folder.join(LIST), list + &fs::read_to_string(folder.join(LIST)).unwrap()).unwrap();
    fs::write(folder.join("table.csv"), "1").unwrap();
    for name in [".slipgrid-old.part", ".slipgrid-new.part", "other.part"] {
        fs::write(place.path().join(name), "").unwrap();
    }
    let old = File::options().write(true).open(place.path().join(".slipgrid-old.part")).unwrap();
    old.set_modified(SystemTime::now() - 2 * ABANDONED).unwrap();
    replace(&folder, &[("result.json", "3"), ("table.csv", "3")]).unwrap();
    assert_eq!(content(&folder), of(&[("result.json", "3"), ("table.csv", "3")]));
    let left: Vec<OsString> = names_in(place.path()).unwrap().into_iter().collect();
    assert_eq!(left, [".slipgrid-new.part", "other.part", "out"]);
}

/// A program that ended now would leave an unfinished file or folder.
#[test]
fn the_end_of_the_program_waits_until_what_is_unfinished_is_renamed_or_removed() {
    let place = tempfile::tempdir().unwrap();
    let folder = ResultFolder::open(Place::output(&place.path().join("out")), &["result.json"], &[]).unwrap();
    let outputs = outputs(&[("result.json", "1")]);
    let file = place.path().join("map.asc");
    let asked = std::cell::Cell::new(0);
    let is_cancelled = |answer: bool| {
        assert!(names_in(place.path()).unwrap().iter().any(|name| name.to_string_lossy().ends_with(UNFINISHED.1)));
        assert!(hold_writing().is_none());
        asked.set(asked.get() + 1);
        answer
    };
    let writes: [&dyn Fn(bool) -> bool; 2] =
        [&|cancel| folder.replace(&outputs, &|| is_cancelled(cancel)).is_ok(), &|cancel| {
            put_unless(&file, b"1", &|| is_cancelled(cancel)).is_ok()
        }];
    for write in writes {
        asked.set(0);
        assert!(!write(true) && asked.get() > 0);
        assert_eq!(
            names_in(place.path()).unwrap().len(),
            1 + usize::from(folder.path().exists()),
            "the lock's, and a result"
        );
        assert!(write(false));
    }
    assert!(file.exists() && folder.path().join("result.json").exists());
}
