//! JSON schemas of files: units, defaults and ranges are added to the schemas of types, and files are validated.
//!
//! A schema contains only these keywords of JSON Schema (draft 07, which TOML editors support): `type`, `properties`,
//! `required`, `additionalProperties`, `items`, `minItems`, `maxItems`, `anyOf`, `enum`, `minimum`, `exclusiveMinimum`,
//! `maximum`, `description`, `default`.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::keys::{Key, has_type, keys};

/// Values that a reader accepts, by the dotted path of the key, such as "a number above 0 up to 10 um" or "\"a\" or
/// \"b\"".
pub type Accepted = BTreeMap<String, String>;

/// Completes the `schema` of a type to that of a file with a `title` and the `version` of the format: adds units,
/// defaults, and the ranges that are `accepted`.
#[must_use]
pub fn file_schema(schema: &Value, (title, version): (&str, u32), accepted: &Accepted) -> Value {
    let mut file = schema.clone();
    complete(&mut file, "", accepted);
    // Taplo takes a schema only if its id is an absolute URI.
    file["$id"] = json!(format!("urn:slipgrid:schema:{title}-{version}"));
    file["title"] = json!(format!("slipgrid {title}, schema {version}"));
    file
}

/// Completes the keys of the table with the schema `table`, at `path`.
fn complete(table: &mut Value, path: &str, accepted: &Accepted) {
    let own: Vec<(String, String, String, Option<Value>)> = keys(table)
        .map(|key| {
            let unit = key.unit();
            let meaning =
                if unit.is_empty() { key.meaning().to_owned() } else { format!("{} In {unit}.", key.meaning()) };
            (key.name.to_owned(), key.path(path), meaning, default(&key))
        })
        .collect();
    for (name, path, meaning, default) in own {
        let value = &mut table["properties"][&name];
        restrict(value, &path, accepted);
        if value.is_boolean() {
            *value = json!({});
        }
        value["description"] = json!(meaning);
        if let Some(default) = default {
            value["default"] = default;
        }
    }
}

/// Adds the range that is accepted at `path` to the schema `value`, and completes the tables in it.
fn restrict(value: &mut Value, path: &str, accepted: &Accepted) {
    // A key that takes any value has the schema `true`.
    if !value.is_object() {
        return;
    }
    if value["properties"].is_object() {
        complete(value, path, accepted);
    }
    for either in value.get_mut("anyOf").and_then(Value::as_array_mut).into_iter().flatten() {
        restrict(either, path, accepted);
    }
    if let Some(items) = value.get_mut("items") {
        restrict(items, path, accepted);
    }
    let Some(range) = accepted.get(path).filter(|_| value["anyOf"].is_null()) else { return };
    if let Some((from, is_above, most)) =
        ends(range).filter(|_| has_type(value, "number") || has_type(value, "integer"))
    {
        value.as_object_mut().into_iter().for_each(|value| drop(value.remove("minimum")));
        value[if is_above { "exclusiveMinimum" } else { "minimum" }] = json!(from);
        value["maximum"] = json!(most);
    } else if let Some(names) = names(range).filter(|_| has_type(value, "string")) {
        value["enum"] = json!(names);
    }
}

/// Whether the words of a refusal contain a range or names, which a schema can express.
#[must_use]
pub fn is_judged(range: &str) -> bool {
    ends(range).is_some() || names(range).is_some()
}

/// Parses words such as "a number above 0 up to 10 um": lower limit, whether the lower limit itself is refused, and
/// upper limit. `None` for other words.
fn ends(range: &str) -> Option<(f64, bool, f64)> {
    let words: Vec<&str> = range.split(|c: char| c.is_whitespace() || c == ';').collect();
    match words[..] {
        ["a", "number", side @ ("above" | "from"), from, "up", "to", most, ..] => {
            Some((from.parse().ok()?, side == "above", most.parse().ok()?))
        }
        _ => None,
    }
}

/// Parses the names in words such as "\"a\" or \"b\""; `None` for other words.
fn names(range: &str) -> Option<Vec<&str>> {
    let names: Vec<&str> = range.split(" or ").collect();
    names.into_iter().map(|name| name.strip_prefix('"')?.strip_suffix('"').filter(|name| !name.contains('"'))).collect()
}

/// Converts the default of `key` in words, such as "0.05", "`round`" or "false", to a value; `None` if the words are no
/// plain value.
#[must_use]
pub fn default(key: &Key<'_>) -> Option<Value> {
    let (words, has) = (key.default()?, |kind| has_type(key.schema, kind));
    let number = || words.parse::<f64>().ok().map(|number| json!(number));
    match () {
        () if has("number") => number(),
        () if has("integer") => words.parse::<u64>().ok().map(|number| json!(number)),
        () if has("boolean") => words.parse::<bool>().ok().map(|flag| json!(flag)),
        () if has("string") => words.strip_prefix('`')?.strip_suffix('`').map(|name| json!(name)),
        () if has("array") => serde_json::from_str(words).ok(),
        () => None,
    }
}

/// Violations of `schema` by `value`, one sentence each, with the dotted path of the key.
#[must_use]
pub fn violations(schema: &Value, value: &Value) -> Vec<String> {
    let mut found = Vec::new();
    check(schema, value, "", &mut found);
    found
}

fn check(schema: &Value, value: &Value, path: &str, found: &mut Vec<String>) {
    let fits = |kind: &str| match kind {
        "number" => value.is_number(),
        "integer" => value.is_u64() || value.is_i64(),
        "boolean" => value.is_boolean(),
        "string" => value.is_string(),
        "null" => value.is_null(),
        "array" => value.is_array(),
        _ => value.is_object(),
    };
    let kinds: Vec<&str> = match &schema["type"] {
        Value::Array(kinds) => kinds.iter().filter_map(Value::as_str).collect(),
        kind => kind.as_str().into_iter().collect(),
    };
    if !kinds.is_empty() && !kinds.iter().any(|kind| fits(kind)) {
        found.push(format!("{path} is no {}", kinds.join(" or ")));
        return;
    }
    if let Some(names) = schema["enum"].as_array().filter(|names| !names.contains(value)) {
        found.push(format!("{path} is none of {names:?}"));
    }
    if let Some(number) = value.as_f64() {
        let above = schema["exclusiveMinimum"].as_f64().is_none_or(|least| number > least);
        let from = schema["minimum"].as_f64().is_none_or(|least| number >= least);
        let most = schema["maximum"].as_f64().is_none_or(|most| number <= most);
        if !(above && from && most) {
            found.push(format!("{path} is out of range"));
        }
    }
    if let Some(either) = schema["anyOf"].as_array() {
        let tried: Vec<Vec<String>> = either
            .iter()
            .map(|schema| {
                let mut found = Vec::new();
                check(schema, value, path, &mut found);
                found
            })
            .collect();
        // If none fits, the violations of the last, a table or a list, are the most specific.
        if !tried.iter().any(Vec::is_empty) {
            found.extend(tried.into_iter().next_back().unwrap_or_default());
        }
    }
    if let Some(list) = value.as_array() {
        let count = list.len() as u64;
        if schema["minItems"].as_u64().is_some_and(|least| count < least) {
            found.push(format!("{path} is too short"));
        }
        if schema["maxItems"].as_u64().is_some_and(|most| count > most) {
            found.push(format!("{path} is too long"));
        }
        for item in list {
            check(&schema["items"], item, path, found);
        }
    }
    if let (Some(object), Some(properties)) = (value.as_object(), schema["properties"].as_object()) {
        let inside = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        for (key, value) in object {
            match properties.get(key) {
                Some(property) => check(property, value, &inside(key), found),
                None => found.push(format!("{} is not a known key", inside(key))),
            }
        }
        for key in schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            if !object.contains_key(key) {
                found.push(format!("{} is missing", inside(key)));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn accepted_values_become_a_range_and_values_outside_violate_it() {
        let table = json!({
            "type": "object",
            "properties": {
                "width_um": { "type": "number", "description": "Width; 3 when absent." },
                "kind": { "type": "string" },
                "seed": { "type": "integer", "minimum": 0 },
                "lowest_um": { "type": "array", "items": { "type": ["number", "null"] } },
            },
            "required": ["kind"],
        });
        let accepted = Accepted::from([
            ("width_um".to_owned(), "a number above 0 up to 10 um".to_owned()),
            ("kind".to_owned(), "\"x\" or \"y\"".to_owned()),
        ]);
        let schema = file_schema(&table, ("a", 1), &accepted);
        assert_eq!(schema["properties"]["width_um"]["default"], json!(3.0));
        let of = |text: &str| violations(&schema, &serde_json::from_str(text).unwrap());
        assert!(of(r#"{"width_um": 10.0, "kind": "x", "lowest_um": [null, 1.0]}"#).is_empty());
        assert_eq!(of(r#"{"width_um": 0.0, "kind": "x"}"#), ["width_um is out of range"]);
        assert_eq!(of(r#"{"widht_um": 1.0, "kind": "x"}"#), ["widht_um is not a known key"]);
        assert_eq!(of(r#"{"kind": "x", "seed": -1}"#), ["seed is out of range"]);
        assert_eq!(of(r#"{"kind": "x", "lowest_um": ["x"]}"#), ["lowest_um is no number or null"]);
        assert_eq!(of("{}"), ["kind is missing"]);
        assert_eq!(of(r#"{"kind": "z"}"#).len(), 1);
    }
}
