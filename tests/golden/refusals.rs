//! Refused inputs and their messages: invalid values of every key of every file, combinations, flags, and damaged
//! files.

use serde_json::Value;
use toml::{Table, Value as Toml};

use crate::Case;
use crate::place::Place;
use crate::record::Record;

/// Kind of file and dotted key, one pair per line.
const KEYS: &str = include_str!("inputs/keys.txt");

/// Kind of file, and pairs of a text and its replacement, quoted and separated by tabs. Each file is refused before any
/// computation, and compared in every run.
const REPLACEMENTS: &str = include_str!("inputs/replacements.txt");

/// Arguments of commands, one command per line.
const FLAGS: &str = include_str!("inputs/flags.txt");

/// Values tried for each key, in TOML; `-` removes the key.
const VALUES: [&str; 8] = ["-", "-1", "0", "1e300", "nan", "\"text\"", "[]", "true"];

const SCENE: &str = include_str!("inputs/scene.toml");
const DESIGN: &str = include_str!("inputs/design.toml");
const CALIBRATION: &str = include_str!("inputs/calibration.toml");
const MATERIAL: &str = include_str!("inputs/material.toml");
const CAMPAIGN: &str = include_str!("inputs/campaign.toml");
const LEARNED: &str = include_str!("inputs/material-learned.toml");
const TABLE: &str = include_str!("inputs/flat.csv");

/// Kinds of files: name, text, and the command that reads the file.
const KINDS: [(&str, &str, &str); 10] = [
    ("scene", SCENE, "simulate @scene.toml"),
    ("design", DESIGN, "optimize @design.toml --no-explorer -o @out"),
    ("wide-design", include_str!("inputs/wide-design.toml"), "optimize @wide-design.toml --no-explorer -o @out"),
    ("calibration", CALIBRATION, "calibrate @calibration.toml"),
    ("calibration-traces", include_str!("inputs/calibration-traces.toml"), "calibrate @calibration-traces.toml"),
    ("calibration-trial", include_str!("inputs/calibration-trial.toml"), "calibrate @calibration-trial.toml"),
    (
        "design-conditions",
        include_str!("inputs/design-conditions.toml"),
        "optimize @design-conditions.toml --no-explorer -o @out",
    ),
    ("material-learned", LEARNED, "simulate @with-learned.toml"),
    ("material", MATERIAL, "simulate @with-material.toml"),
    ("campaign", CAMPAIGN, "campaign plan @campaign.toml -o @out"),
];

/// Every `QUICK_SHARE`-th key is tried in every run.
const QUICK_SHARE: usize = 48;

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (number, line) in KEYS.lines().enumerate() {
        let (kind, key) = line.split_once(' ').unwrap();
        cases.push(Case::new(line, number % QUICK_SHARE == 0, move || {
            VALUES.iter().map(|value| (format!("= {value}"), spoiled(kind, key, value))).collect()
        }));
    }
    for (number, line) in REPLACEMENTS.lines().enumerate() {
        let (kind, changes) = line.split_once('\t').unwrap();
        let changes: Vec<String> = changes.split('\t').map(|text| serde_json::from_str(text).unwrap()).collect();
        cases.push(Case::new(format!("{kind}, replaced {number:02}"), true, move || {
            let (_, text, command) = find(kind);
            let (mut spoiled, mut field) = (text.to_owned(), String::new());
            for [from, to] in changes.as_chunks().0 {
                assert!(spoiled.contains(from), "{from}");
                spoiled = spoiled.replacen(from, to, 1);
                // A field that began with a bracket would be read as the name of a case.
                field += &format!("from {from} to {to} ");
            }
            Record::from([(field.trim_end().replace('\n', "|"), outcome(kind, &spoiled, command))])
        }));
    }
    cases.push(Case::new("flags", true, || {
        let said = |line: &str| {
            let place = files();
            let words: Vec<String> = line
                .split(' ')
                .map(|word| {
                    if word.contains('.') && !word.starts_with(|c: char| c.is_ascii_digit()) {
                        format!("@{word}")
                    } else {
                        word.to_owned()
                    }
                })
                .collect();
            let (code, _, err) = place.run_raw(&words.join(" "));
            Value::from(format!("{code} {}", err.trim()))
        };
        FLAGS.lines().map(|line| (line.to_owned(), said(line))).collect()
    }));
    cases.push(Case::new("tables", true, || TABLES.iter().map(|(from, to)| table(from, to)).collect()));
    cases.push(Case::new("rows", true, || ROWS.iter().map(|text| row(text)).collect()));
    cases.push(Case::new("maps", true, || MAPS.iter().map(|(text, options)| map(text, options)).collect()));
    cases
}

fn find(kind: &str) -> (&'static str, &'static str, &'static str) {
    *KINDS.iter().find(|(name, ..)| *name == kind).unwrap()
}

/// Folder with a file of each kind.
fn files() -> Place {
    let rest = &SCENE[SCENE.find("[pattern]").unwrap()..];
    let with_material = format!("material = \"material.toml\"\n{rest}");
    let condition = "condition = { speed_mm_s = 2.0, humidity_pct = 15.0 }";
    let with_learned = format!("material = \"material-learned.toml\"\n{condition}\n{rest}");
    Place::with(&[
        ("scene.toml", SCENE),
        ("design.toml", DESIGN),
        ("calibration.toml", CALIBRATION),
        ("material.toml", MATERIAL),
        ("campaign.toml", CAMPAIGN),
        ("design-conditions.toml", include_str!("inputs/design-conditions.toml")),
        ("calibration-traces.toml", include_str!("inputs/calibration-traces.toml")),
        ("flat.csv", TABLE),
        ("trial.csv", include_str!("inputs/trial.csv")),
        ("trace.csv", include_str!("inputs/trace.csv")),
        ("with-material.toml", &with_material),
        ("material-learned.toml", LEARNED),
        ("with-learned.toml", &with_learned),
        ("map.txt", "1 2 3 4\n1 2 3 5\n"),
        ("holed.asc", "# Width: 3 um\n# Height: 3 um\n# Value units: nm\n1 2 3\n4 NaN 6\n7 8 9\n"),
        ("two.svg", "<svg><circle r=\"1\"/>\n<circle r=\"2\"/></svg>"),
        ("result.json", "{\"design\": {}}"),
    ])
}

/// Message about a file of this kind, or `accepted` with the exit code.
fn outcome(kind: &str, text: &str, command: &str) -> Value {
    let place = files();
    place.write(&format!("{kind}.toml"), text.as_bytes());
    let (code, _, err) = place.run_raw(command);
    // The calibration's table has a row that is refused after the file, as what it takes is hours: nothing is computed.
    let accepted = code != 2 || err.contains("its run in time takes");
    let code = if err.contains("its run in time takes") { 0 } else { code };
    if accepted { format!("accepted, {code}").into() } else { err.trim().into() }
}

/// Outcome for the file of this kind with a changed value of a key.
fn spoiled(kind: &str, key: &str, value: &str) -> Value {
    let (_, text, command) = find(kind);
    let mut table: Table = text.parse().unwrap();
    let value = (value != "-").then(|| format!("v = {value}").parse::<Table>().unwrap()["v"].clone());
    if !replace(&mut table, &key.split('.').collect::<Vec<_>>(), value) {
        return Value::Null;
    }
    outcome(kind, &toml::to_string(&table).unwrap(), command)
}

/// Sets or removes a key; `false` if there was nothing to remove.
fn replace(table: &mut Table, keys: &[&str], value: Option<Toml>) -> bool {
    let [first, rest @ ..] = keys else { return false };
    if rest.is_empty() {
        return match value {
            Some(value) => table.insert((*first).to_owned(), value).is_none_or(|_| true),
            None => table.remove(*first).is_some(),
        };
    }
    let below = table.entry((*first).to_owned()).or_insert_with(|| Table::new().into());
    match below {
        Toml::Table(table) => replace(table, rest, value),
        Toml::Array(items) => {
            items.first_mut().and_then(Toml::as_table_mut).is_some_and(|table| replace(table, rest, value))
        }
        _ => false,
    }
}

/// Replacements in the table of measurements.
const TABLES: [(&str, &str); 18] = [
    ("mu_dynamic,", "mu_dynamik,"),
    ("force_n", "force_kn"),
    ("0.248", "24.8"),
    ("0.248", "-0.1"),
    ("0.248", "abc"),
    ("0.248", ""),
    ("0.248", "0,248"),
    ("0.248", "NaN"),
    ("_std\n50,0.0001,15,0.248,0.002\n", "_std,mu_static_std\n50,0.0001,15,0.248,0.002,0.1\n"),
    ("50,", "0,"),
    ("50,", "-50,"),
    ("50,", "1e9,"),
    (",15,", ",150,"),
    (",0.0001,", ",-2,"),
    (",0.002\n", ",-0.002\n"),
    (",0.002\n", "\n"),
    (",0.002\n", ",0.002,7\n"),
    ("50,0.0001,15,0.248,0.002\n", ""),
];

fn table(from: &str, to: &str) -> (String, Value) {
    assert!(TABLE.contains(from), "{from}");
    let place = files();
    place.write("flat.csv", TABLE.replacen(from, to, 1).as_bytes());
    let (code, _, err) = place.run_raw("calibrate @calibration.toml");
    (format!("{from} -> {to}").replace('\n', "|"), format!("{code} {}", err.trim()).into())
}

/// Rows for a table with a static peak.
const ROWS: [&str; 13] = [
    "50,2,15,0.248,0.002,0.20,0.01",
    "50,2,15,0.248,0.002,0.3,",
    "50,2,15,0.248,0.002,1.5,0.01",
    "50,2,15,0.248,0,,",
    "50,2,15,0.248,0.3,,",
    "50,2,15,0.0005,0.0001,,",
    "0.001,2,15,0.248,0.002,,",
    "500000,2,15,0.248,0.002,,",
    "0.000005,2,15,0.248,0.002,,",
    "10000,2,15,4.5,0.002,,",
    "50,2,15,0.248,0.002,,|50,2,15,0.25,0.002,,",
    "50,2,15,0.248,0.002,0.3,0.9",
    "50,2000000,15,0.248,0.002,,",
];

fn row(text: &str) -> (String, Value) {
    let place = files();
    let header = TABLE.lines().next().unwrap();
    place.write("flat.csv", format!("{header},mu_static,mu_static_std\n{}\n", text.replace('|', "\n")).as_bytes());
    let (code, _, err) = place.run_raw("calibrate @calibration.toml");
    (format!("row {text}"), format!("{code} {}", err.trim()).into())
}

/// Refused or doubtful maps, and options.
const MAPS: [(&str, &str); 22] = [
    ("", ""),
    ("# nothing\n", ""),
    ("1 2\n3 4\n", ""),
    ("1 2\n3 4\n", "--pixel-um 1"),
    ("1 2\n3 4\n", "--height-unit um"),
    ("1 2 3\n4 5\n", "--pixel-um 1 --height-unit um"),
    ("1 x\n3 4\n", "--pixel-um 1 --height-unit um"),
    ("1 2\n", "--pixel-um 1 --height-unit um"),
    ("nan nan\nnan nan\n", "--pixel-um 1 --height-unit um"),
    ("1 nan\n2 3\n", "--pixel-um 1 --height-unit um --missing refuse"),
    ("1 2\n3 4\n", "--pixel-um 0 --height-unit um"),
    ("1 2\n3 4\n", "--pixel-um 1e9 --height-unit um"),
    ("1 2\n3 4\n", "--pixel-um 1 --height-unit km"),
    ("1 2\n3 4\n", "--pixel-um 1 --height-unit m"),
    ("1 1\n1 1\n", "--pixel-um 1 --height-unit um"),
    ("1 2\n3 4\n", "--pixel-um 1 --height-unit um --crop 0,0,5,5"),
    ("1 2\n3 4\n", "--pixel-um 1 --height-unit um --decimate 2"),
    ("# Width: wide\n1 2\n3 4\n", ""),
    ("0 0 1\n1 0 2\n0 1 3\n", "--height-unit um --lateral-unit um"),
    ("0 0 1\n0 0 2\n0 1 3\n1 1 4\n", "--height-unit um --lateral-unit um"),
    ("Gwyddion Simple Field 1.0\nXRes = 2\nYRes = 2\n", ""),
    ("\u{93}NUMPY", ""),
];

fn map(text: &str, options: &str) -> (String, Value) {
    let place = Place::with(&[("map.txt", text)]);
    let (code, _, err) = place.run_raw(&format!("surface @map.txt {options}"));
    (format!("map {text}: {options}").replace('\n', "|"), format!("{code} {}", err.trim()).into())
}
