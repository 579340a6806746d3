//! Kept outputs, in files with lines of field, tab and value below `[case]`, and their comparison.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::PathBuf;

use serde_json::Value;

use crate::record::Record;

/// Environment variable that makes the tests rewrite the kept outputs.
pub const UPDATE: &str = "SLIPGRID_UPDATE_GOLDEN";

/// Maximum relative difference of equal numbers. Kept numbers have 10 digits, which is an error of up to 5e-10.
const MAX_RELATIVE_DIFFERENCE: f64 = 1e-9;

/// Numbers below this are rounding errors of vanishing sums: in their units, all quantities are above 1e-9.
const ZERO: f64 = 1e-13;

/// Minimum length of texts that are stored once per file and referenced by their hash.
const MIN_SHARED: usize = 60;

/// Kept outputs of a group.
pub struct Store {
    path: PathBuf,
    cases: BTreeMap<String, Record>,
}

impl Store {
    /// Reads the outputs in `kept/<name>.txt`; empty if the file is absent.
    pub fn read(name: &str) -> Self {
        let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/golden/kept")).join(name).with_extension("txt");
        let text = std::fs::read_to_string(&path).unwrap_or_default();
        let mut shared = BTreeMap::new();
        for line in text.lines().filter(|line| line.starts_with('#')) {
            let (hash, value) = line.split_once("\t").unwrap();
            shared.insert(hash.to_owned(), serde_json::from_str::<Value>(value).unwrap());
        }
        let mut cases = BTreeMap::new();
        let mut case = String::new();
        for line in text.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
            if let Some(name) = line.strip_prefix('[') {
                case = name.trim_end_matches(']').to_owned();
                cases.insert(case.clone(), Record::new());
            } else {
                let (field, value) = line.split_once("\t").unwrap();
                let value = expand(serde_json::from_str(value).unwrap(), &shared);
                cases.get_mut(&case).unwrap().insert(field.to_owned(), value);
            }
        }
        Self { path, cases }
    }

    /// Stores the outputs `found`, with `all` instead of all others, and writes the file.
    pub fn update(mut self, found: Vec<(String, Record)>, all: bool) {
        if all {
            self.cases.clear();
        }
        self.cases.extend(found);
        let mut shared = BTreeMap::new();
        let mut text = String::new();
        for (name, record) in &self.cases {
            writeln!(text, "[{name}]").unwrap();
            for (field, value) in record {
                writeln!(text, "{field}\t{}", shorten(value, &mut shared)).unwrap();
            }
        }
        for (hash, value) in shared {
            writeln!(text, "{hash}\t{}", Value::String(value)).unwrap();
        }
        std::fs::create_dir_all(self.path.parent().unwrap()).unwrap();
        std::fs::write(&self.path, text).unwrap();
    }

    /// Differences as lines `case: field: kept -> found`; with `all`, also for kept cases that were not found.
    pub fn differences(&self, found: &[(String, Record)], all: bool) -> Vec<String> {
        let mut differences = Vec::new();
        let empty = Record::new();
        for (name, record) in found {
            let kept = self.cases.get(name).unwrap_or(&empty);
            for field in kept.keys().chain(record.keys()).collect::<BTreeSet<_>>() {
                let [old, new] = [kept, record].map(|record| record.get(field).unwrap_or(&Value::Null));
                if !are_equal(old, new) {
                    differences.push(format!("{name}: {field}: {}", difference(old, new)));
                }
            }
        }
        let names: BTreeSet<&String> = found.iter().map(|(name, _)| name).collect();
        let missing = self.cases.keys().filter(|name| all && !names.contains(name));
        differences.extend(missing.map(|name| format!("{name}: is kept, and was not computed")));
        differences
    }
}

/// Formats a difference as `old -> new`; for two long lists of equal length only the first difference.
fn difference(old: &Value, new: &Value) -> String {
    if let (Value::Array(olds), Value::Array(news)) = (old, new)
        && olds.len() == news.len()
        && let Some(place) = (0..olds.len()).find(|place| !are_equal(&olds[*place], &news[*place]))
    {
        return format!("[{place}]: {}", difference(&olds[place], &news[place]));
    }
    let shown = |value: &Value| if value.is_null() { "(absent)".to_owned() } else { value.to_string() };
    format!("{} -> {}", shown(old), shown(new))
}

fn are_equal(old: &Value, new: &Value) -> bool {
    match (old, new) {
        (Value::Number(old), Value::Number(new)) => {
            let (Some(old), Some(new)) = (old.as_f64(), new.as_f64()) else { return old == new };
            let larger = old.abs().max(new.abs());
            larger < ZERO || (old - new).abs() <= MAX_RELATIVE_DIFFERENCE * larger
        }
        (Value::Array(old), Value::Array(new)) => {
            old.len() == new.len() && old.iter().zip(new).all(|(old, new)| are_equal(old, new))
        }
        _ => old == new,
    }
}

/// Replaces the references `#hash` in `value` by the shared texts.
fn expand(value: Value, shared: &BTreeMap<String, Value>) -> Value {
    match value {
        Value::String(text) if text.starts_with('#') => shared.get(&text).cloned().unwrap_or(Value::String(text)),
        Value::Array(items) => items.into_iter().map(|item| expand(item, shared)).collect(),
        other => other,
    }
}

/// Formats `value` as JSON with numbers of 10 digits; moves long texts to `shared`.
fn shorten(value: &Value, shared: &mut BTreeMap<String, String>) -> String {
    match value {
        Value::Number(number) if number.is_f64() => {
            let rounded: f64 = format!("{:.9e}", number.as_f64().unwrap()).parse().unwrap();
            let plain = serde_json::to_string(&rounded).unwrap();
            plain.strip_suffix(".0").map_or_else(|| plain.clone(), str::to_owned)
        }
        Value::String(text) if text.len() >= MIN_SHARED => {
            let hash = format!("#{:08x}", fnv(text));
            shared.insert(hash.clone(), text.clone());
            Value::String(hash).to_string()
        }
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(|item| shorten(item, shared)).collect();
            format!("[{}]", items.join(","))
        }
        other => other.to_string(),
    }
}

/// Hash by Fowler, Noll and Vo (FNV-1a) of 64 bits, folded to 32.
fn fnv(text: &str) -> u64 {
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
    (hash >> 32) ^ (hash & 0xffff_ffff)
}

#[test]
fn numbers_are_compared_by_their_relative_difference_and_all_else_exactly() {
    let value = |text: &str| serde_json::from_str::<Value>(text).unwrap();
    for (old, new) in [("1", "1.0000000005"), ("1e-14", "-3e-14"), ("[1,\"a\"]", "[1.0,\"a\"]"), ("2", "2.0")] {
        assert!(are_equal(&value(old), &value(new)), "{old} {new}");
    }
    for (old, new) in [("1", "1.000000002"), ("1e-9", "1.1e-9"), ("[1]", "[1,2]"), ("\"a\"", "\"b\""), ("0", "false")] {
        assert!(!are_equal(&value(old), &value(new)), "{old} {new}");
    }
    let differences = difference(&value("[1,2,3]"), &value("[1,2,4]"));
    assert_eq!(differences, "[2]: 3 -> 4");
}
