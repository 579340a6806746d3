//! Records of a campaign and its tasks.

use std::collections::BTreeMap;
use std::path::Path;

use crate::disk::hexadecimal;
use crate::formats::Diagnostic;
use serde::de::{Error, Unexpected};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value as Json;
use sha2::{Digest, Sha256};
use slipgrid_design::results::{MadeBy, SCHEMA, VERSION};
use toml::{Table, Value};

/// Number of hexadecimal digits of a task id. In a campaign of a million tasks, two ids coincide with a probability of
/// 10^-12.
const ID_DIGITS: usize = 20;

/// Number of hexadecimal digits of a SHA-256 hash.
const HASH_DIGITS: usize = 64;

/// Kind of the tasks of a campaign.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// A scene that is solved.
    Scene,
    /// A design that is searched and confirmed.
    Design,
}

/// Data common to all tasks of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Campaign {
    /// Program that planned the campaign; another version might give other results.
    #[serde(flatten)]
    pub made_by: MadeBy,
    /// Name of the campaign.
    pub name: String,
    /// Kind of all tasks.
    pub kind: Kind,
    /// Name of the base file: the scene or design whose keys the tasks vary.
    pub base: String,
    /// TOML text that the tasks vary: that of the base file, or for `work = "table"` of a steady scene of the design.
    pub text: String,
    /// Varied keys, in the order of the campaign file.
    pub keys: Vec<String>,
    /// SHA-256 hashes of the files that tasks read, by path relative to the folder of the base file.
    pub inputs: BTreeMap<String, String>,
}

/// A task of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// Hash of the task's text, of the files that it reads and of the program's version.
    #[serde(deserialize_with = "read_id")]
    pub id: String,
    /// Values of the varied keys, by dotted key.
    pub values: BTreeMap<String, Json>,
}

impl Campaign {
    /// Reads a campaign record.
    ///
    /// # Errors
    /// [`Diagnostic`] for a file that is no campaign record, for another version, and for invalid names in it.
    pub fn read(path: &Path, text: &str) -> Result<Self, Diagnostic> {
        let refuse = |reason: String| Diagnostic::file(path, reason);
        let read: Self = serde_json::from_str(text).map_err(|error| {
            refuse(format!("is no campaign: {error}")).expected("what `slipgrid campaign plan` writes")
        })?;
        let MadeBy { version, schema, .. } = &read.made_by;
        if (&**version, *schema) != (VERSION, SCHEMA) {
            let reason = format!("was planned by slipgrid {version}, schema {schema}");
            return Err(refuse(reason).expected(format!(
                "slipgrid {VERSION}, schema {SCHEMA}: results of two versions do not stand in one table"
            )));
        }
        let is_key = |key: &String| !key.is_empty() && !key.contains(char::is_control);
        if let Some(key) = read.keys.iter().find(|key| !is_key(key)) {
            return Err(
                refuse(format!("is no campaign: {key:?} is no key")).expected("what `slipgrid campaign plan` writes")
            );
        }
        if let Some(hash) = read.inputs.values().find(|hash| !is_hexadecimal(hash, HASH_DIGITS)) {
            return Err(refuse(format!("is no campaign: {hash:?} is no hash"))
                .expected(format!("{HASH_DIGITS} hexadecimal digits")));
        }
        Ok(read)
    }

    /// TOML text of the file `base` with the keys in `values` set.
    ///
    /// # Errors
    /// The key that cannot be set, or the name of the base file if its text is no valid TOML, and the reason.
    pub fn text_with(&self, values: &BTreeMap<String, Json>) -> Result<String, (String, String)> {
        let whole = |reason: String| (self.base.clone(), reason);
        let mut table: Table = toml::from_str(&self.text).map_err(|error| whole(error.message().to_owned()))?;
        for (key, value) in values {
            let failed = |reason: String| (key.clone(), reason);
            let value = Value::try_from(value).map_err(|error| failed(error.to_string()))?;
            set(&mut table, key, value).map_err(failed)?;
        }
        toml::to_string(&table).map_err(|error| whole(error.to_string()))
    }

    /// Id of a task with this `text` that reads `inputs`, given as hashes by path.
    pub fn id(&self, text: &str, inputs: &BTreeMap<String, String>) -> String {
        let content = serde_json::json!([self.made_by.version, self.made_by.schema, self.kind, text, inputs]);
        hash(content.to_string().as_bytes())[..ID_DIGITS].to_owned()
    }
}

/// Deserializes the id of a task, which becomes a file name and is therefore checked.
fn read_id<'de, D: Deserializer<'de>>(deserializer: D) -> Result<String, D::Error> {
    let id = String::deserialize(deserializer)?;
    let expected = format!("an id of {ID_DIGITS} hexadecimal digits");
    if is_hexadecimal(&id, ID_DIGITS) {
        Ok(id)
    } else {
        Err(D::Error::invalid_value(Unexpected::Str(&id), &expected.as_str()))
    }
}

/// Whether `text` consists of `digits` lower-case hexadecimal digits.
fn is_hexadecimal(text: &str, digits: usize) -> bool {
    text.len() == digits && text.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'))
}

/// Sets a dotted key, and creates its tables if needed.
fn set(table: &mut Table, key: &str, value: Value) -> Result<(), String> {
    match key.split_once('.') {
        None => {
            table.insert(key.to_owned(), value);
            Ok(())
        }
        Some((first, rest)) => match table.entry(first).or_insert_with(|| Value::Table(Table::new())) {
            Value::Table(inner) => set(inner, rest, value),
            _ => Err(format!("{first} is no table")),
        },
    }
}

/// SHA-256 of `bytes`, in hexadecimal digits.
pub fn hash(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// FIPS 180-2, appendix B.1.
    #[test]
    fn hashes_are_those_of_the_standard() {
        assert_eq!(hash(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    }

    #[test]
    fn keys_are_set_in_their_tables() {
        let mut table: Table = toml::from_str("a = 1\n[b]\nc = 2\nd = 3\n").unwrap();
        set(&mut table, "b.c", Value::from(5)).unwrap();
        set(&mut table, "e.f", Value::from("g")).unwrap();
        assert_eq!(table, toml::from_str::<Table>("a = 1\n[b]\nc = 5\nd = 3\n[e]\nf = 'g'\n").unwrap());
        assert_eq!(set(&mut table, "a.b", Value::from(1)), Err("a is no table".to_owned()));
    }
}
