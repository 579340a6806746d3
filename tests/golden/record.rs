//! Record of outputs: fields by path with numbers, booleans and texts.

use std::collections::BTreeMap;

use serde_json::Value;

/// Keys of values that cannot be compared: times, machines, versions, and residuals, which are rounding errors.
const VOLATILE: [&str; 17] = [
    "date",
    "dt_error",
    "finished",
    "memory_bytes",
    "residual",
    "seconds",
    "site_updates_per_s",
    "slipgrid_version",
    "started",
    "threads",
    "timings",
    "timings_s",
    "version",
    "wall_s",
    "program",
    "created",
    "residual_mean",
];

/// Maximum number of list elements that are kept; of a longer list as many evenly spaced elements, and its length.
const MAX_KEPT: usize = 8;

/// Fields by path. A list of tables is stored as a table of lists.
pub type Record = BTreeMap<String, Value>;

/// Inserts `value` under `path`; null, empty texts and empty lists are omitted.
pub fn insert(record: &mut Record, path: &str, value: &Value) {
    match value {
        Value::Null => {}
        Value::String(text) if text.is_empty() => {}
        Value::Array(items) if items.is_empty() => {}
        Value::Object(fields) => {
            for (key, value) in fields.iter().filter(|(key, _)| !VOLATILE.contains(&key.as_str())) {
                let below = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                insert(record, &below, value);
            }
        }
        Value::Array(items) if items.iter().any(Value::is_object) => {
            let mut columns: BTreeMap<String, Vec<Value>> = BTreeMap::new();
            for (place, item) in items.iter().enumerate() {
                let mut row = Record::new();
                insert(&mut row, "", item);
                for (key, value) in row {
                    let column = columns.entry(key).or_default();
                    column.resize(place, Value::Null);
                    column.push(value);
                }
            }
            for (key, mut column) in columns {
                column.resize(items.len(), Value::Null);
                let below = if key.is_empty() { path.to_owned() } else { format!("{path}.{key}") };
                insert(record, &below, &Value::Array(column));
            }
        }
        Value::Array(items) if items.len() > MAX_KEPT && items.iter().all(|item| !item.is_string()) => {
            record.insert(format!("{path}#"), items.len().into());
            let kept = (0..MAX_KEPT).map(|place| items[place * (items.len() - 1) / (MAX_KEPT - 1)].clone());
            record.insert(path.to_owned(), Value::Array(kept.collect()));
        }
        _ => {
            record.insert(path.to_owned(), value.clone());
        }
    }
}

/// Inserts the columns of a comma-separated table.
pub fn insert_csv(record: &mut Record, path: &str, text: &str) {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let titles: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    let mut columns = vec![Vec::new(); titles.len()];
    for line in lines {
        for (column, field) in columns.iter_mut().zip(line.split(',')) {
            let number = field.parse::<f64>().ok().and_then(serde_json::Number::from_f64);
            column.push(number.map_or_else(|| Value::String(field.to_owned()), Value::Number));
        }
    }
    for (title, column) in titles.iter().zip(columns) {
        let kept = column.len() > MAX_KEPT && column.iter().any(Value::is_string);
        let column = if kept { column.into_iter().take(MAX_KEPT).collect() } else { column };
        insert(record, &format!("{path}.{title}"), &Value::Array(column));
    }
}

/// Inserts the texts of a picture and the number of its marks of each kind.
pub fn insert_picture(record: &mut Record, path: &str, svg: &str) {
    let tags: Vec<&str> = svg.split('<').collect();
    let texts = tags.iter().filter(|tag| tag.starts_with("text ")).filter_map(|tag| tag.split('>').nth(1));
    record.insert(format!("{path}.texts"), texts.map(|text| Value::from(text.trim())).collect());
    let count = |mark: &str| tags.iter().filter(|tag| tag.split(' ').next() == Some(mark)).count();
    let marks = ["circle", "polygon", "polyline", "line", "rect", "path", "image"];
    record.insert(format!("{path}.marks"), marks.map(|mark| count(mark).to_string()).join(" ").into());
}

/// Inserts the number of lines of a drawing or program, and the sum of all its numbers.
pub fn insert_drawing(record: &mut Record, path: &str, text: &str) {
    let numbers = text.split(|c: char| !(c.is_ascii_digit() || c == '.')).filter_map(|word| word.parse::<f64>().ok());
    record.insert(format!("{path}.lines"), text.lines().count().into());
    record
        .insert(format!("{path}.sum"), serde_json::Number::from_f64(numbers.sum()).map_or(Value::Null, Value::Number));
}
