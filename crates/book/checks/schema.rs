//! JSON schemas of files, and validation of files by them.
//!
//! A schema contains only these keywords of JSON Schema (draft 07, which TOML editors support): `type`, `properties`,
//! `required`, `additionalProperties`, `items`, `minItems`, `anyOf`, `enum`, `minimum`, `exclusiveMinimum`, `maximum`,
//! `description`, `default`.

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use crate::keys::{Key, Place, Shape, Types};

/// Values that a reader accepts, by the dotted path of the key, such as "a number above 0 up to 10 um" or "\"a\" or
/// \"b\"".
pub type Accepted = BTreeMap<String, String>;

/// Creates the schema of a file with the root structure `root`, a `title` and the `version` of the format.
///
/// # Errors
/// Message about an unknown structure or type.
pub fn schema(
    types: &Types,
    root: &Place,
    (title, version): (&str, u32),
    accepted: &Accepted,
) -> Result<Value, String> {
    let mut object = table(types, root, "", accepted)?;
    if let Some(object) = object.as_object_mut() {
        object.insert("$schema".to_owned(), json!("http://json-schema.org/draft-07/schema#"));
        // Taplo takes a schema only if this is an absolute URI.
        object.insert("$id".to_owned(), json!(format!("urn:slipgrid:schema:{title}-{version}")));
        object.insert("title".to_owned(), json!(format!("slipgrid {title}, schema {version}")));
    }
    Ok(object)
}

fn table(types: &Types, place: &Place, path: &str, accepted: &Accepted) -> Result<Value, String> {
    let table = types.table(place)?;
    let mut properties = Map::new();
    for key in &table.keys {
        let path = if path.is_empty() { key.name.clone() } else { format!("{path}.{}", key.name) };
        let mut property = value(types, &key.shape, &path, accepted)?;
        if types.is_record() && !key.is_required {
            property = json!({ "anyOf": [{ "type": "null" }, property] });
        }
        if let Some(object) = property.as_object_mut() {
            object.insert("description".to_owned(), json!(describe(key)));
            if let Some(default) = key.default().and_then(|words| literal(words, &key.shape)) {
                object.insert("default".to_owned(), default);
            }
        }
        properties.insert(key.name.clone(), property);
    }
    // What is not said is left out of a record or is null there.
    let is_required = |key: &&Key| key.is_required;
    let required: Vec<&str> = table.keys.iter().filter(is_required).map(|key| key.name.as_str()).collect();
    // A line `#:schema` is a comment; a key `$schema` would be refused.
    Ok(json!({
        "type": "object",
        "description": table.meaning,
        "additionalProperties": false,
        "properties": properties,
        "required": required,
    }))
}

/// Description of a key, with its unit.
fn describe(key: &Key) -> String {
    let unit = key.unit();
    if unit.is_empty() { key.meaning.clone() } else { format!("{} In {unit}.", key.meaning) }
}

fn value(types: &Types, shape: &Shape, path: &str, accepted: &Accepted) -> Result<Value, String> {
    let range = accepted.get(path).map(String::as_str);
    Ok(match shape {
        Shape::Number => number("number", range),
        Shape::Whole => number("integer", range),
        Shape::Flag => json!({ "type": "boolean" }),
        Shape::Text => match range.and_then(names) {
            Some(names) => json!({ "type": "string", "enum": names }),
            None => json!({ "type": "string" }),
        },
        Shape::Any => json!({}),
        Shape::OneOrMore => {
            json!({ "anyOf": [number("number", range), { "type": "array", "items": number("number", range), "minItems": 1 }] })
        }
        Shape::List(of) => json!({ "type": "array", "items": value(types, of, path, accepted)? }),
        Shape::OrNull(of) => json!({ "anyOf": [{ "type": "null" }, value(types, of, path, accepted)?] }),
        Shape::PathOr(of) => json!({ "anyOf": [{ "type": "string" }, value(types, of, path, accepted)?] }),
        Shape::Table(place) => table(types, place, path, accepted)?,
    })
}

/// Schema of a number within the range that a reader accepts.
fn number(kind: &str, range: Option<&str>) -> Value {
    let mut schema = Map::from_iter([("type".to_owned(), json!(kind))]);
    if let Some((from, above, most)) = range.and_then(ends) {
        let least = if above { "exclusiveMinimum" } else { "minimum" };
        schema.insert(least.to_owned(), json!(from));
        schema.insert("maximum".to_owned(), json!(most));
    } else if kind == "integer" {
        // Whole numbers are read without a sign.
        schema.insert("minimum".to_owned(), json!(0));
    }
    Value::Object(schema)
}

/// Whether the words of a refusal contain a range or names, which a schema can express.
#[must_use]
pub fn is_judged(range: &str) -> bool {
    ends(range).is_some() || names(range).is_some()
}

/// Parses the limits of "a number above 0 up to 10 um", and whether the lower limit itself is refused.
fn ends(range: &str) -> Option<(f64, bool, f64)> {
    let words: Vec<&str> = range.split(|c: char| c.is_whitespace() || c == ';').collect();
    match words[..] {
        ["a", "number", side @ ("above" | "from"), from, "up", "to", most, ..] => {
            Some((from.parse().ok()?, side == "above", most.parse().ok()?))
        }
        _ => None,
    }
}

/// Parses the names in "\"a\" or \"b\"".
fn names(range: &str) -> Option<Vec<&str>> {
    let names: Vec<&str> = range.split(" or ").collect();
    names.into_iter().map(|name| name.strip_prefix('"')?.strip_suffix('"').filter(|name| !name.contains('"'))).collect()
}

/// Converts a default in words, such as "0.05", "`round`" or "false", into a value of the kind `shape`.
#[must_use]
pub fn literal(words: &str, shape: &Shape) -> Option<Value> {
    match shape {
        Shape::Number | Shape::OneOrMore => words.parse::<f64>().ok().map(|number| json!(number)),
        Shape::Whole => words.parse::<u64>().ok().map(|number| json!(number)),
        Shape::Flag => words.parse::<bool>().ok().map(|flag| json!(flag)),
        Shape::Text => words.strip_prefix('`')?.strip_suffix('`').map(|name| json!(name)),
        Shape::List(_) => serde_json::from_str(words).ok(),
        _ => None,
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
    if let Some(kind) = schema["type"].as_str() {
        let fits = match kind {
            "number" => value.is_number(),
            "integer" => value.is_u64() || value.is_i64(),
            "boolean" => value.is_boolean(),
            "string" => value.is_string(),
            "null" => value.is_null(),
            "array" => value.is_array(),
            _ => value.is_object(),
        };
        if !fits {
            found.push(format!("{path} is no {kind}"));
            return;
        }
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
        // Of several that do not fit the last, a table or a list, says most.
        if !tried.iter().any(Vec::is_empty) {
            found.extend(tried.into_iter().next_back().unwrap_or_default());
        }
    }
    if let Some(list) = value.as_array() {
        if schema["minItems"].as_u64().is_some_and(|least| (list.len() as u64) < least) {
            found.push(format!("{path} is too short"));
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
    fn what_a_reader_accepts_becomes_a_range_and_what_is_outside_violates_it() {
        let types = Types::new([(
            "a.rs",
            "#[derive(Deserialize)]\nstruct A {\n    /// Width; 3 when absent.\n    width_um: Option<Number>,\n    kind: String,\n    seed: Option<u64>,\n}\n",
        )]);
        let accepted = Accepted::from([
            ("width_um".to_owned(), "a number above 0 up to 10 um".to_owned()),
            ("kind".to_owned(), "\"x\" or \"y\"".to_owned()),
        ]);
        let root = ("a.rs".to_owned(), "A".to_owned());
        let schema = schema(&types, &root, ("a", 1), &accepted).unwrap();
        assert_eq!(schema["properties"]["width_um"]["default"], json!(3.0));
        let of = |text: &str| violations(&schema, &serde_json::from_str(text).unwrap());
        assert!(of(r#"{"width_um": 10.0, "kind": "x"}"#).is_empty());
        assert_eq!(of(r#"{"width_um": 0.0, "kind": "x"}"#), ["width_um is out of range"]);
        assert_eq!(of(r#"{"widht_um": 1.0, "kind": "x"}"#), ["widht_um is not a known key"]);
        assert_eq!(of(r#"{"kind": "x", "seed": -1}"#), ["seed is out of range"]);
        assert_eq!(of("{}"), ["kind is missing"]);
        assert_eq!(of(r#"{"kind": "z"}"#).len(), 1);
    }

    #[test]
    fn an_element_of_a_list_may_be_null_where_its_type_may_be_absent() {
        let text =
            "#[derive(Deserialize)]\nstruct A {\n    lowest_um: Vec<Option<f64>>,\n    highest_um: Vec<f64>,\n}\n";
        let types = Types::new([("a.rs", text)]).records();
        let root = ("a.rs".to_owned(), "A".to_owned());
        let known = schema(&types, &root, ("a", 1), &Accepted::new()).unwrap();
        let of = |text: &str| violations(&known, &serde_json::from_str(text).unwrap());
        assert!(of(r#"{"lowest_um": [null, 1.0], "highest_um": []}"#).is_empty());
        assert_eq!(of(r#"{"lowest_um": ["x"], "highest_um": [null]}"#).len(), 2);
        let keys = types.table(&root).unwrap().keys;
        assert_eq!((keys[0].unit(), &*keys[0].shape.words()), ("\u{b5}m", "list of numbers, or nulls"));
    }
}
