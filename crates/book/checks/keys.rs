//! Keys of a file, from the JSON schema of its table.

use serde_json::Value;

/// A key of a table.
#[derive(Clone, Copy, Debug)]
pub struct Key<'a> {
    /// Name of the key.
    pub name: &'a str,
    /// Schema of the value.
    pub schema: &'a Value,
    /// Whether the key is required.
    pub is_required: bool,
}

/// Keys of the table with the schema `table`, in the order of the file's type.
pub fn keys(table: &Value) -> impl Iterator<Item = Key<'_>> {
    let required = table["required"].as_array();
    let own = table["properties"].as_object().into_iter().flatten();
    own.map(move |(name, schema)| {
        let is_required = required.is_some_and(|required| required.iter().any(|key| key == name));
        Key { name, schema, is_required }
    })
}

/// All keys of the table and of the tables in it, each after its dotted path.
#[must_use]
pub fn all_keys(table: &Value) -> Vec<(String, Key<'_>)> {
    let mut found = Vec::new();
    let mut open = vec![(String::new(), table)];
    while let Some((path, table)) = open.pop() {
        for key in keys(table) {
            let path = key.path(&path);
            open.extend(key.table().map(|inner| (path.clone(), inner)));
            found.push((path, key));
        }
    }
    found
}

impl<'a> Key<'a> {
    /// Dotted path of the key in the table at `table`.
    #[must_use]
    pub fn path(&self, table: &str) -> String {
        if table.is_empty() { self.name.to_owned() } else { format!("{table}.{}", self.name) }
    }

    /// Description of the key in sentences.
    #[must_use]
    pub fn meaning(&self) -> &'a str {
        self.schema["description"].as_str().unwrap_or_default()
    }

    /// Default of the key according to its description: the words before "when absent"; `None` without these words.
    #[must_use]
    pub fn default(&self) -> Option<&'a str> {
        let (before, _) = self.meaning().split_once(" when absent")?;
        Some(before.rsplit("; ").next().unwrap_or(before))
    }

    /// Unit given by the name of the key; empty for pure numbers and for other kinds of values.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        const UNITS: [(&str, &str); 18] = [
            ("_gw_cm2", "GW/cm²"),
            ("_j_cm2", "J/cm²"),
            ("_g_cm3", "g/cm³"),
            ("_mm_s", "mm/s"),
            ("_per_mm", "1/mm"),
            ("_gpa", "GPa"),
            ("_mpa", "MPa"),
            ("_pct", "%"),
            ("_deg", "°"),
            ("_um", "µm"),
            ("_mm", "mm"),
            ("_nm", "nm"),
            ("_ns", "ns"),
            ("_hz", "Hz"),
            ("seconds", "s"),
            ("_time_s", "s"),
            ("window_s", "s"),
            ("force_n", "N"),
        ];
        let found = UNITS.into_iter().find(|(ending, _)| self.name.ends_with(ending));
        found.filter(|_| is_of_numbers(self.schema)).map_or("", |(_, unit)| unit)
    }

    /// Schema of the table that the key holds, or of the tables in its list; `None` for other values.
    #[must_use]
    pub fn table(&self) -> Option<&'a Value> {
        table_in(self.schema)
    }
}

/// Alternative schemas, of which a value must fit one: those of `anyOf`, or `schema` itself.
fn either(schema: &Value) -> &[Value] {
    schema["anyOf"].as_array().map_or(std::slice::from_ref(schema), Vec::as_slice)
}

/// Types of the values of `schema`, such as `number` and `null`.
fn types(schema: &Value) -> Vec<&str> {
    match &schema["type"] {
        Value::Array(several) => several.iter().filter_map(Value::as_str).collect(),
        one => one.as_str().into_iter().collect(),
    }
}

/// Whether `schema` has values of the type `kind`.
#[must_use]
pub fn has_type(schema: &Value, kind: &str) -> bool {
    either(schema).iter().any(|one| types(one).contains(&kind))
}

fn table_in(schema: &Value) -> Option<&Value> {
    either(schema)
        .iter()
        .find_map(|one| if one["properties"].is_object() { Some(one) } else { one.get("items").and_then(table_in) })
}

/// Whether the value is a number, or a list of numbers, possibly nested.
fn is_of_numbers(schema: &Value) -> bool {
    either(schema).iter().any(|one| types(one).contains(&"number") || one.get("items").is_some_and(is_of_numbers))
}

/// Names the kind of value in words.
#[must_use]
pub fn words(schema: &Value) -> String {
    let kinds: Vec<&str> = either(schema).iter().flat_map(types).filter(|kind| *kind != "null").collect();
    let items = || either(schema).iter().find_map(|one| one.get("items")).map_or(String::new(), words);
    let one = match kinds[..] {
        ["number", "array"] => "number or list".to_owned(),
        ["string", "object"] => "path or table".to_owned(),
        ["number"] => "number".to_owned(),
        ["integer"] => "whole number".to_owned(),
        ["boolean"] => "true or false".to_owned(),
        ["string"] => "text".to_owned(),
        ["object"] => "table".to_owned(),
        ["array"] => match items().split_once(" or null").map_or(items(), |(kind, _)| format!("{kind}s or null")) {
            kind if kind == "table" => "tables".to_owned(),
            kind if kind.is_empty() || kind == "anything" => "list".to_owned(),
            kind if kind.starts_with("list") => format!("list of: {kind}"),
            kind if kind.ends_with("null") => format!("list of {kind}"),
            kind => format!("list of {kind}s"),
        },
        _ => "anything".to_owned(),
    };
    if has_type(schema, "null") { format!("{one} or null") } else { one }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn keys_have_a_meaning_default_unit_and_kind() {
        let table = json!({
            "properties": {
                "width_um": { "type": ["number", "null"], "description": "How wide it is; 3 when absent." },
                "parts": { "type": "array", "items": { "type": "object", "properties": {
                    "width_um": { "anyOf": [{ "type": "number" }, { "type": "array", "items": { "type": "number" } }] },
                } } },
                "lowest_um": { "type": "array", "items": { "type": ["number", "null"] } },
            },
            "required": ["parts"],
        });
        let found: Vec<Key> = keys(&table).collect();
        let [width, parts, lowest] = found[..] else { panic!("{found:?}") };
        assert_eq!((width.default(), width.unit(), width.is_required), (Some("3"), "µm", false));
        assert!(parts.is_required && parts.table().is_some() && parts.unit().is_empty());
        assert_eq!(
            [width, parts, lowest].map(|key| words(key.schema)),
            ["number or null", "tables", "list of numbers or null"]
        );
        let all: Vec<String> = all_keys(&table).into_iter().map(|(path, _)| path).collect();
        assert_eq!(all, ["width_um", "parts", "lowest_um", "parts.width_um"]);
        assert_eq!(words(all_keys(&table)[3].1.schema), "number or list");
    }
}
