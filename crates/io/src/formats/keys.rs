//! Keys of a table with their positions, for tables whose keys belong to several records.

use std::collections::BTreeMap;
use std::fmt;

use crate::formats::spanned::Spanned;
use serde::de::{DeserializeOwned, Error, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use toml::{Table, Value};

use super::values::Numbers;

/// Key of a table of textures whose value may be a list; every number of the list keeps its file position.
pub const SEVERAL: &str = "sliding_angle_deg";

/// Keys of a table with their values and file positions. Error messages are those of serde, preceded by the key at
/// fault in backticks.
#[derive(Default)]
pub struct Keys {
    rest: BTreeMap<String, Spanned<Value>>,
    /// Value of [`SEVERAL`]; `None` if absent.
    pub several: Option<Spanned<Numbers>>,
}

impl<'de> Deserialize<'de> for Keys {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Keys;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a table")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Keys, A::Error> {
                let mut keys = Keys::default();
                while let Some(key) = table.next_key::<String>()? {
                    if key == SEVERAL {
                        keys.several = Some(table.next_value()?);
                    } else {
                        let value: Spanned<Value> = table.next_value()?;
                        // A date would be read as a text.
                        if value.get_ref().is_datetime() {
                            return Err(A::Error::custom(format!(
                                "`{key}`: invalid type: date, expected a text in quotes, a number or a list"
                            )));
                        }
                        keys.rest.insert(key, value);
                    }
                }
                Ok(keys)
            }
        }
        deserializer.deserialize_map(Reader)
    }
}

impl Keys {
    /// Removes `key` and returns its value with its file position; `None` if absent.
    ///
    /// # Errors
    /// Message about a value of a wrong type.
    pub fn take<T: DeserializeOwned>(&mut self, key: &str) -> Result<Option<Spanned<T>>, String> {
        let Some(value) = self.rest.remove(key) else { return Ok(None) };
        let span = value.span();
        let read = T::deserialize(value.into_inner()).map_err(|error| format!("`{key}`: {}", error.message()))?;
        Ok(Some(Spanned::new(span, read)))
    }

    /// Converts the remaining keys to a record `T`, all keys of which are optional. `beside` are the other keys that
    /// the table may have, for messages about unknown keys.
    ///
    /// # Errors
    /// Message about an unknown key, or about a value of a wrong type.
    pub fn record<T: DeserializeOwned>(self, beside: &[&str]) -> Result<T, String> {
        let table: Table = self.rest.into_iter().map(|(key, value)| (key, value.into_inner())).collect();
        let error = match T::deserialize(table.clone()) {
            Ok(read) => return Ok(read),
            Err(error) => error.message().to_owned(),
        };
        // Converting one key at a time identifies the key that causes an error.
        for (key, value) in &table {
            let alone = Table::from_iter([(key.clone(), value.clone())]);
            if let Err(error) = T::deserialize(alone) {
                let message = error.message();
                let Some((_, known)) =
                    message.split_once("expected one of ").filter(|_| message.starts_with("unknown"))
                else {
                    return Err(format!("`{key}`: {message}"));
                };
                let beside: Vec<String> = beside.iter().map(|key| format!("`{key}`")).collect();
                let known = known.split(", ").filter(|key| !beside.iter().any(|other| other == key));
                let known: Vec<&str> = beside.iter().map(String::as_str).chain(known).collect();
                return Err(format!("unknown field `{key}`, expected one of {}", known.join(", ")));
            }
        }
        Err(error)
    }
}
