//! Separates times, rates and threads from results and puts them into a file of their own, so that all other files are
//! identical in every run.

use serde::Serialize;
use serde_json::{Map, Value};

use super::{MadeBy, NoJsonForm, SCHEMA, json};

/// Keys whose values differ from run to run: result.json does not have them.
pub const TIMES: [&str; 4] = ["timings_s", "wall_s", "threads", "site_updates_per_s"];

/// Formats `value` like [`json`], but as two texts: the result without times, rates and number of threads, for
/// result.json, and only these, under the same keys, for timings.json.
///
/// # Errors
/// [`NoJsonForm`] as for [`json`].
pub fn json_and_timings(value: &impl Serialize) -> Result<[String; 2], NoJsonForm> {
    let (result, times) = split(serde_json::to_value(value).map_err(NoJsonForm)?);
    let mut entries = serde_json::to_value(MadeBy::slipgrid(SCHEMA)).map_err(NoJsonForm)?;
    if let (Value::Object(entries), Some(Value::Object(times))) = (&mut entries, times) {
        entries.extend(times);
    }
    Ok([json(&result)?, json(&entries)?])
}

/// Splits a value into the part that does not depend on time and the part that does, if there is one.
fn split(whole: Value) -> (Value, Option<Value>) {
    match whole {
        Value::Array(items) => {
            let (rest, times): (Vec<Value>, Vec<Option<Value>>) = items.into_iter().map(split).unzip();
            let some = times.iter().any(Option::is_some);
            let times = times.into_iter().map(|times| times.unwrap_or_else(|| Map::new().into())).collect();
            (Value::Array(rest), some.then_some(Value::Array(times)))
        }
        Value::Object(entries) => {
            let (mut rest, mut times) = (Map::new(), Map::new());
            for (key, value) in entries {
                if TIMES.contains(&key.as_str()) {
                    times.insert(key, value);
                    continue;
                }
                let (own, timed) = split(value);
                times.extend(timed.map(|timed| (key.clone(), timed)));
                rest.insert(key, own);
            }
            (rest.into(), (!times.is_empty()).then_some(times.into()))
        }
        leaf => (leaf, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::VERSION;

    #[test]
    fn times_go_and_all_else_stays_in_its_order_to_the_last_digit() {
        let text = "{\"z\": 0.1, \"wall_s\": 2, \"a\": [{\"site_updates_per_s\": 1e9, \"b\": null}, {\"b\": -3}], \
                    \"big\": 18446744073709551615, \"third\": 0.30000000000000004, \"threads\": 2, \"of\": [1, \"x\", true]}";
        let whole: Value = serde_json::from_str(text).unwrap();
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
