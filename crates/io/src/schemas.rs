//! JSON schemas of files and records, from their types.

use schemars::generate::SchemaSettings;
use schemars::transform::transform_subschemas;
use schemars::{JsonSchema, Schema};
use serde_json::{Map, Value};
use slipgrid_design::results::TIMES;

use crate::campaign::plan::CampaignFile;
use crate::formats::calibration_file::CalibrationFile;
use crate::formats::design::DesignFile;
use crate::formats::material::MaterialFile;
use crate::formats::scene::SceneFile;

/// Schemas of the files that are read, by the kind of file. Schemas describe types; the readers check the ranges of
/// numbers.
pub fn schemas() -> [(&'static str, Value); 5] {
    [
        ("material", read_schema::<MaterialFile>()),
        ("design", read_schema::<DesignFile>()),
        ("scene", read_schema::<SceneFile>()),
        ("calibration", read_schema::<CalibrationFile>()),
        ("campaign", read_schema::<CampaignFile>()),
    ]
}

/// Schema of the TOML file that is read as a `T`.
fn read_schema<T: JsonSchema>() -> Value {
    // TOML has no null: an optional key is absent.
    schema::<T>(SchemaSettings::draft07().with_transform(without_null))
}

/// Schema of the JSON record that a `T` is written as, without the keys of wall times.
pub fn record_schema<T: JsonSchema>() -> Value {
    schema::<T>(SchemaSettings::draft07().for_serialize().with_transform(as_written))
}

/// Schema of the TOML sheet that a `T` is written as.
pub fn sheet_schema<T: JsonSchema>() -> Value {
    schema::<T>(SchemaSettings::draft07().for_serialize().with_transform(without_null))
}

/// JSON schema of `T` without references, in draft 07, which editors of TOML support.
fn schema<T: JsonSchema>(settings: SchemaSettings) -> Value {
    let settings = settings.with(|settings| settings.inline_subschemas = true);
    settings.with_transform(plain).into_generator().into_root_schema_for::<T>().to_value()
}

/// Reduces a schema to what editors use: descriptions on one line, without the links of rustdoc, tables without
/// additional keys, and no formats or defaults of Rust types.
fn plain(schema: &mut Schema) {
    transform_subschemas(&mut plain, schema);
    for key in ["format", "default", "unevaluatedProperties"] {
        schema.remove(key);
    }
    if let Some(Value::String(words)) = schema.get_mut("description") {
        *words = words.split_whitespace().collect::<Vec<_>>().join(" ").replace("[`", "`").replace("`]", "`");
    }
    if schema.get("properties").is_some() {
        schema.insert("additionalProperties".to_owned(), Value::Bool(false));
    }
    // An enumeration whose names are described one by one is reduced to the list of its names.
    let names = schema.get("oneOf").and_then(Value::as_array);
    let names: Option<Vec<Value>> = names.and_then(|all| all.iter().map(|one| one.get("const").cloned()).collect());
    if let Some(names) = names {
        schema.remove("oneOf");
        schema.insert("type".to_owned(), "string".into());
        schema.insert("enum".to_owned(), names.into());
    }
}

/// Keeps those required keys for which `is_needed`, called with name and schema of a key, is true.
fn require(schema: &mut Schema, is_needed: impl Fn(&str, &Value) -> bool) {
    let properties = schema.get("properties").cloned().unwrap_or_default();
    if let Some(Value::Array(required)) = schema.get_mut("required") {
        required.retain(|key| key.as_str().is_some_and(|key| is_needed(key, &properties[key])));
    }
}

/// Removes the keys of times, and the type null from keys that may be absent.
fn as_written(schema: &mut Schema) {
    transform_subschemas(&mut as_written, schema);
    require(schema, |key, _| !TIMES.contains(&key));
    let required = schema.get("required").cloned().unwrap_or_default();
    let Some(Value::Object(properties)) = schema.get_mut("properties") else { return };
    properties.retain(|key, _| !TIMES.contains(&key.as_str()));
    for (key, value) in properties {
        let is_required = required.as_array().is_some_and(|required| required.iter().any(|name| name == key));
        if let (false, Ok(value)) = (is_required, value.try_into()) {
            drop_null(value);
        }
    }
}

/// Removes the type null and makes keys that may be null optional: TOML has no null.
fn without_null(schema: &mut Schema) {
    let has_null =
        |value: &Value| [&value["type"], &value["anyOf"]].into_iter().flat_map(Value::as_array).flatten().any(is_null);
    require(schema, |_, value| !has_null(value));
    transform_subschemas(&mut without_null, schema);
    drop_null(schema);
}

/// Whether `value` is the type null, or its schema.
fn is_null(value: &Value) -> bool {
    value == "null" || value["type"] == "null"
}

/// Removes null from the types of `schema`.
fn drop_null(schema: &mut Schema) {
    for key in ["type", "anyOf"] {
        let Some(Value::Array(several)) = schema.get_mut(key) else { continue };
        several.retain(|one| !is_null(one));
        let [one] = &several[..] else { continue };
        let one = one.clone();
        schema.remove(key);
        // The description of the key takes precedence over that of the key's type.
        for (key, value) in if let Value::Object(one) = one { one } else { Map::from_iter([(key.to_owned(), one)]) } {
            if schema.get(&key).is_none() {
                schema.insert(key, value);
            }
        }
    }
}
