//! Folder in which the program is run within this process.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;
use slipgrid_tests::{repository, slipgrid};
use tempfile::TempDir;

use crate::record::{Record, insert, insert_csv, insert_drawing, insert_picture};

/// Names of the files of `designs/` that begin with `start`, without their extension.
pub fn shipped(start: &str) -> Vec<String> {
    let entries = fs::read_dir(repository().join("designs")).unwrap().map(|entry| entry.unwrap().file_name());
    let names = entries.filter_map(|name| Some(name.to_str()?.strip_suffix(".toml")?.to_owned()));
    names.filter(|name| name.starts_with(start)).collect()
}

/// Folder of files, deleted when dropped.
pub struct Place(TempDir);

impl Place {
    pub fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub fn with(files: &[(&str, &str)]) -> Self {
        let place = Self::new();
        for (name, text) in files {
            place.write(name, text.as_bytes());
        }
        place
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn write(&self, name: &str, bytes: &[u8]) {
        fs::create_dir_all(self.path(name).parent().unwrap()).unwrap();
        fs::write(self.path(name), bytes).unwrap();
    }

    /// Runs the program with these arguments, in which `@` stands for this folder. Records exit code, messages, and
    /// JSON on stdout.
    pub fn run(&self, arguments: &str, record: &mut Record) {
        let (code, out, err) = self.run_raw(arguments);
        record.insert("exit".into(), code.into());
        let told: Vec<Value> =
            err.lines().filter(|line| !line.starts_with("wrote ")).map(|line| Value::String(line.to_owned())).collect();
        if !told.is_empty() {
            record.insert("stderr".into(), Value::Array(told));
        }
        if let Ok(value) = serde_json::from_str::<Value>(&out) {
            insert(record, "", &value);
        } else if !out.is_empty() {
            record.insert("stdout".into(), out.lines().map(|line| Value::String(line.to_owned())).collect());
        }
    }

    /// Exit code, stdout and stderr of a run, without the path of this folder.
    pub fn run_raw(&self, arguments: &str) -> (u8, String, String) {
        let folder = format!("{}/", self.0.path().display());
        let words = arguments.split_whitespace().map(|word| word.replace('@', &folder));
        let program = ["--no-cache", "--threads", "1"].map(str::to_owned);
        let (code, out, err) = slipgrid(&program.into_iter().chain(words).collect::<Vec<_>>());
        let [out, err] =
            [out, err].map(|text| text.replace(&folder, "").replace(&repository().display().to_string(), "REPOSITORY"));
        (code, out, err)
    }

    /// Records the files of a folder by type: texts and marks of pictures, names of pages, fields of JSON and TOML,
    /// columns of CSV, and number of lines and sum of the others.
    pub fn record_folder(&self, folder: &str, record: &mut Record) {
        let Ok(entries) = fs::read_dir(self.path(folder)) else { return };
        let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        // The list of what was written beside the results has hashes of pages, which hold times.
        names.retain(|name| !name.starts_with('.'));
        names.sort();
        for name in &names {
            self.record_file(&format!("{folder}/{name}"), name, record);
        }
        record.insert("files".into(), Value::from(names));
    }

    /// Records one file under `field`.
    pub fn record_file(&self, file: &str, field: &str, record: &mut Record) {
        let Ok(text) = fs::read_to_string(self.path(file)) else { return };
        match Path::new(file).extension().and_then(|extension| extension.to_str()) {
            // Written beside stdout, which has the same.
            Some("html" | "png") => {}
            Some("svg") => insert_picture(record, field, &text),
            Some("json") if field == "result.json" || field == "timings.json" => {}
            Some("json") => insert(record, field, &serde_json::from_str(&text).unwrap()),
            Some("toml") => {
                let table: toml::Table = text.parse().unwrap();
                insert(record, field, &serde_json::to_value(table).unwrap());
            }
            Some("csv") => insert_csv(record, field, &text),
            _ => insert_drawing(record, field, &text),
        }
    }
}
