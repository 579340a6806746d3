//! Separates times, rates and threads from results and puts them into a file of their own, so that all other files are
//! identical in every run.

use std::fmt;

use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};
use serde::ser::{Serialize, SerializeMap, Serializer};
use serde_json::Value;

use super::{NoJsonForm, SCHEMA, VERSION, json};

/// Keys whose values differ from run to run: result.json does not have them.
pub const TIMES: [&str; 4] = ["timings_s", "wall_s", "threads", "site_updates_per_s"];

/// JSON value whose objects keep the order of their keys.
#[derive(Clone, Debug, PartialEq)]
enum Json {
    Leaf(Value),
    Array(Vec<Json>),
    Object(Vec<(String, Json)>),
}

/// Formats `value` like [`json`], but as two texts: the result without times, rates and number of threads, for
/// result.json, and only these, under the same keys, for timings.json.
///
/// # Errors
/// [`NoJsonForm`] as for [`json`].
pub fn json_and_timings(value: &impl Serialize) -> Result<[String; 2], NoJsonForm> {
    let whole: Json = serde_json::from_str(&json(value)?).map_err(NoJsonForm)?;
    let (result, times) = split(whole);
    let head = [("program", Value::from("slipgrid")), ("version", VERSION.into()), ("schema", SCHEMA.into())];
    let mut entries: Vec<_> = head.into_iter().map(|(key, value)| (key.to_owned(), Json::Leaf(value))).collect();
    if let Some(Json::Object(times)) = times {
        entries.extend(times);
    }
    Ok([json(&result)?, json(&Json::Object(entries))?])
}

/// Splits a value into the part that does not depend on time and the part that does, if there is one.
fn split(whole: Json) -> (Json, Option<Json>) {
    match whole {
        Json::Leaf(_) => (whole, None),
        Json::Array(items) => {
            let (rest, times): (Vec<Json>, Vec<Option<Json>>) = items.into_iter().map(split).unzip();
            let some = times.iter().any(Option::is_some);
            let times = times.into_iter().map(|times| times.unwrap_or(Json::Object(Vec::new()))).collect();
            (Json::Array(rest), some.then_some(Json::Array(times)))
        }
        Json::Object(entries) => {
            let (mut rest, mut times) = (Vec::new(), Vec::new());
            for (key, value) in entries {
                if TIMES.contains(&key.as_str()) {
                    times.push((key, value));
                    continue;
                }
                let (own, timed) = split(value);
                times.extend(timed.map(|timed| (key.clone(), timed)));
                rest.push((key, own));
            }
            (Json::Object(rest), (!times.is_empty()).then_some(Json::Object(times)))
        }
    }
}

impl Serialize for Json {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Leaf(value) => value.serialize(serializer),
            Self::Array(items) => items.serialize(serializer),
            Self::Object(entries) => {
                let mut map = serializer.serialize_map(Some(entries.len()))?;
                for (key, value) in entries {
                    map.serialize_entry(key, value)?;
                }
                map.end()
            }
        }
    }
}

impl<'de> Deserialize<'de> for Json {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reader)
    }
}

struct Reader;

impl<'de> Visitor<'de> for Reader {
    type Value = Json;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Json, E> {
        Ok(Json::Leaf(value.into()))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Json, E> {
        Ok(Json::Leaf(value.into()))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Json, E> {
        Ok(Json::Leaf(value.into()))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Json, E> {
        Ok(Json::Leaf(value.into()))
    }

    fn visit_str<E>(self, value: &str) -> Result<Json, E> {
        Ok(Json::Leaf(value.into()))
    }

    fn visit_unit<E>(self) -> Result<Json, E> {
        Ok(Json::Leaf(Value::Null))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut access: A) -> Result<Json, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = access.next_element()? {
            items.push(item);
        }
        Ok(Json::Array(items))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut access: A) -> Result<Json, A::Error> {
        let mut entries = Vec::new();
        while let Some(entry) = access.next_entry()? {
            entries.push(entry);
        }
        Ok(Json::Object(entries))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_go_and_all_else_stays_in_its_order_to_the_last_digit() {
        let text = "{\"z\": 0.1, \"wall_s\": 2, \"a\": [{\"site_updates_per_s\": 1e9, \"b\": null}, {\"b\": -3}], \
                    \"big\": 18446744073709551615, \"third\": 0.30000000000000004, \"threads\": 2, \"of\": [1, \"x\", true]}";
        let whole: Json = serde_json::from_str(text).unwrap();
        assert_eq!(
            serde_json::to_string(&whole).unwrap().replace("1000000000.0", "1e9"),
            text.replace(": ", ":").replace(", ", ",")
        );
        let [result, times] = json_and_timings(&whole).unwrap();
        let plain = |text: &str| text.split_whitespace().collect::<String>();
        assert_eq!(
            plain(&result),
            "{\"z\":0.1,\"a\":[{\"b\":null},{\"b\":-3}],\"big\":18446744073709551615,\"third\":0.30000000000000004,\
             \"of\":[1,\"x\",true]}"
        );
        assert_eq!(
            plain(&times),
            format!(
                "{{\"program\":\"slipgrid\",\"version\":\"{VERSION}\",\"schema\":{SCHEMA},\"wall_s\":2,\
                 \"a\":[{{\"site_updates_per_s\":1000000000.0}},{{}}],\"threads\":2}}"
            )
        );
    }
}
