//! Edits of single values in a TOML text. Comments, order and all other values stay as they are.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::Value as Json;
use toml_edit::{Array, ArrayOfTables, DocumentMut, InlineTable, Item, RawString, Table, TableLike, Value};

use crate::error::Refused;

/// A step from a table to a value: a key, or a position in a list.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
pub enum Step {
    Index(usize),
    Key(String),
}

/// New value at the place `at`; null removes the present value.
#[derive(Debug, Deserialize)]
pub struct Edit {
    at: Vec<Step>,
    value: Json,
}

impl Edit {
    /// Sets or removes the value in `document`; missing tables on the way are added.
    ///
    /// # Errors
    /// [`Refused`] for a place that does not fit the document, and for a value that TOML cannot hold.
    fn apply(&self, document: &mut DocumentMut) -> Result<(), Refused> {
        let Some((last, way)) = self.at.split_last() else { return Err(Refused::bad("an edit without a place")) };
        if self.value.is_null() && !leads_somewhere(document.as_item(), way) {
            return Ok(());
        }
        let mut item = document.as_item_mut();
        for (number, step) in way.iter().enumerate() {
            let is_list = matches!(self.at.get(number + 1), Some(Step::Index(_)));
            item = enter(item, step, is_list).ok_or_else(|| self.refused())?;
        }
        set(item, last, &self.value).ok_or_else(|| self.refused())
    }

    fn refused(&self) -> Refused {
        let steps = self.at.iter().map(|step| match step {
            Step::Index(index) => index.to_string(),
            Step::Key(key) => key.clone(),
        });
        Refused::bad(format!("{}: no place for {}", steps.collect::<Vec<_>>().join("."), self.value))
    }
}

/// Makes `edits`. Comments at the end of a table, such as keys that are commented out, stay there: a new table begins
/// after them. Those of a removed table go to the end of the table before.
///
/// # Errors
/// [`Refused`] of the first edit that cannot be made.
pub fn apply_all(edits: &[Edit], document: &mut DocumentMut) -> Result<(), Refused> {
    let before = headers(document);
    edits.iter().try_for_each(|edit| edit.apply(document))?;
    let mut after = headers(document);
    let mut ends = BTreeMap::<_, String>::new();
    let mut table = START;
    for Header { position, comments, .. } in before {
        *ends.entry(table).or_default() += &comments;
        if after.iter().any(|kept| kept.position == position) {
            table = position;
        }
    }
    table = START;
    for Header { position, comments, own, .. } in &mut after {
        *comments = table.and_then(|_| ends.remove(&table)).unwrap_or_default();
        if comments.ends_with("\n\n") {
            *own = own.strip_prefix('\n').unwrap_or(own).to_owned();
        } else if table.is_none() && *position != END && !own.starts_with('\n') {
            own.insert(0, '\n');
        }
        table = *position;
    }
    document.set_trailing(after.pop().map(|end| end.comments).unwrap_or_default());
    after.sort_by_key(|header| header.number);
    let mut leads = after.into_iter().map(|header| header.comments + &header.own);
    each_header(document.as_table_mut(), &mut |table| table.decor_mut().set_prefix(leads.next().unwrap_or_default()));
    Ok(())
}

/// Positions of the start and the end of a document.
const START: Option<isize> = Some(-1);
const END: Option<isize> = Some(isize::MAX);

/// Header of a table, or the end of the document.
struct Header {
    /// Place in the order of the keys.
    number: usize,
    /// Place in the text; `None` for a new table.
    position: Option<isize>,
    /// Comments before the header that belong to the table before: up to the last blank line.
    comments: String,
    /// Rest of what stands before the header.
    own: String,
}

/// Headers in the order in which `toml_edit` writes them: a new table follows the one before it in the order of the
/// keys. The end of the document is the last.
fn headers(document: &mut DocumentMut) -> Vec<Header> {
    let (mut last, mut found) = (0, Vec::new());
    each_header(document.as_table_mut(), &mut |table| {
        last = table.position().unwrap_or(last);
        let lead = table.decor().prefix().and_then(RawString::as_str).unwrap_or("\n");
        let (comments, own) = lead.split_at(lead.rfind("\n\n").map_or(0, |at| at + 2));
        let [comments, own] = [comments, own].map(str::to_owned);
        found.push((last, Header { number: found.len(), position: table.position(), comments, own }));
    });
    found.sort_by_key(|(at, _)| *at);
    let comments = document.trailing().as_str().unwrap_or_default().to_owned();
    let end = Header { number: found.len(), position: END, comments, own: String::new() };
    found.into_iter().map(|(_, header)| header).chain([end]).collect()
}

/// Calls `act` for the tables with a header in the order of the keys.
fn each_header(table: &mut Table, act: &mut impl FnMut(&mut Table)) {
    for (_, item) in table.iter_mut() {
        let below: Vec<&mut Table> = match item {
            Item::Table(below) => vec![below],
            Item::ArrayOfTables(all) => all.iter_mut().collect(),
            _ => Vec::new(),
        };
        for below in below {
            if !below.is_dotted() && !below.is_implicit() {
                act(below);
            }
            each_header(below, act);
        }
    }
}

/// Whether all steps of `way` exist.
fn leads_somewhere(mut item: &Item, way: &[Step]) -> bool {
    for step in way {
        let below = match step {
            Step::Index(index) => item.get(*index),
            Step::Key(key) => item.get(&key[..]),
        };
        let Some(below) = below else {
            // A table inside a list of values is reached by `enter` alone.
            return item.is_value();
        };
        item = below;
    }
    true
}

/// Returns the item at `step`. A missing key is added, as a list of tables if `is_list`, otherwise as a table; `None`
/// if `item` cannot hold the step.
fn enter<'a>(item: &'a mut Item, step: &Step, is_list: bool) -> Option<&'a mut Item> {
    match step {
        Step::Key(key) => {
            let table = item.as_table_like_mut()?;
            if table.get(key).is_none_or(Item::is_none) {
                let new = if is_list { Item::ArrayOfTables(ArrayOfTables::new()) } else { Item::Table(Table::new()) };
                table.insert(key, new);
            }
            table.get_mut(key)
        }
        Step::Index(index) => {
            if let Item::ArrayOfTables(tables) = item
                && tables.len() == *index
            {
                tables.push(Table::new());
            }
            item.get_mut(*index)
        }
    }
}

/// Sets the value at `last` of a table or list, or removes it for null; `None` if `item` cannot hold it.
fn set(item: &mut Item, last: &Step, value: &Json) -> Option<()> {
    match last {
        Step::Key(key) => set_key(item.as_table_like_mut()?, key, value),
        Step::Index(index) => match item {
            Item::ArrayOfTables(tables) => {
                if value.is_null() {
                    (*index < tables.len()).then(|| tables.remove(*index)).map(drop)
                } else {
                    let table = to_table(value)?;
                    match tables.get_mut(*index) {
                        Some(known) => *known = table,
                        None => tables.push(table),
                    }
                    Some(())
                }
            }
            Item::Value(Value::Array(array)) => {
                if value.is_null() {
                    (*index < array.len()).then(|| array.remove(*index)).map(drop)
                } else if *index < array.len() {
                    array.replace(*index, to_value(value)?);
                    Some(())
                } else {
                    array.push(to_value(value)?);
                    Some(())
                }
            }
            _ => None,
        },
    }
}

fn set_key(table: &mut dyn TableLike, key: &str, value: &Json) -> Option<()> {
    if value.is_null() {
        table.remove(key);
        return Some(());
    }
    match table.get_mut(key) {
        Some(Item::Value(known)) => {
            let mut new = to_value(value)?;
            // A comment behind the value stays there.
            *new.decor_mut() = known.decor().clone();
            *known = new;
        }
        _ => {
            let new = match value {
                Json::Object(_) => Item::Table(to_table(value)?),
                Json::Array(all) if !all.is_empty() && all.iter().all(Json::is_object) => {
                    Item::ArrayOfTables(all.iter().map(to_table).collect::<Option<_>>()?)
                }
                _ => Item::Value(to_value(value)?),
            };
            table.insert(key, new);
        }
    }
    Some(())
}

fn to_table(value: &Json) -> Option<Table> {
    let mut table = Table::new();
    for (key, value) in value.as_object()? {
        set_key(&mut table, key, value)?;
    }
    Some(table)
}

fn to_value(value: &Json) -> Option<Value> {
    Some(match value {
        Json::Null => return None,
        Json::Bool(flag) => (*flag).into(),
        Json::String(text) => text.as_str().into(),
        Json::Number(number) => match number.as_i64() {
            Some(whole) => whole.into(),
            None => number.as_f64().filter(|number| number.is_finite())?.into(),
        },
        Json::Array(all) => Value::Array(all.iter().map(to_value).collect::<Option<Array>>()?),
        Json::Object(all) => {
            let pairs = all.iter().map(|(key, value)| Some((key.as_str(), to_value(value)?)));
            Value::InlineTable(pairs.collect::<Option<InlineTable>>()?)
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    const TEXT: &str = "# head\nname = \"a\"  # kept\nat = { speed = 2.0, humidity = 15.0 }\nalso = [{ speed = 1.0 }]\n\n\
                        [target]\n# above\nvalue = 0.88  # behind\n\n[[trial]]\nname = \"one\"\n";

    fn edited(edits: &Json) -> Result<String, Refused> {
        edited_in(TEXT, edits)
    }

    fn edited_in(text: &str, edits: &Json) -> Result<String, Refused> {
        let edits: Vec<Edit> = serde_json::from_value(edits.clone()).unwrap();
        let mut document: DocumentMut = text.parse().unwrap();
        apply_all(&edits, &mut document)?;
        Ok(document.to_string())
    }

    #[test]
    fn a_value_changes_and_all_else_stays() {
        let text = edited(&json!([
            {"at": ["target", "value"], "value": [0.9, 0.8]},
            {"at": ["name"], "value": "b"},
            {"at": ["at", "speed"], "value": 4},
            {"at": ["also", 0, "speed"], "value": 0.4},
        ]));
        let expected = TEXT
            .replace("value = 0.88", "value = [0.9, 0.8]")
            .replace("\"a\"", "\"b\"")
            .replace("speed = 2.0", "speed = 4")
            .replace("speed = 1.0", "speed = 0.4");
        assert_eq!(text.unwrap(), expected);
        assert_eq!(edited(&json!([])).unwrap(), TEXT);
    }

    #[test]
    fn tables_are_made_and_removed() {
        let text = edited(&json!([
            {"at": ["trial", 1], "value": {"name": "two", "pattern": {"width_um": 40.0}}},
            {"at": ["traces", "condition", 0, "force_n"], "value": 50},
            {"at": ["limits", "min_land_um"], "value": 40.5},
            {"at": ["target", "value"], "value": null},
            {"at": ["nothing", "there"], "value": null},
        ]))
        .unwrap();
        let read: Json = serde_json::to_value(toml::from_str::<toml::Table>(&text).unwrap()).unwrap();
        assert_eq!(read["trial"][1], json!({"name": "two", "pattern": {"width_um": 40.0}}));
        assert_eq!(read["traces"]["condition"], json!([{"force_n": 50}]));
        assert_eq!(read["limits"], json!({"min_land_um": 40.5}));
        assert!(read["target"].get("value").is_none() && read.get("nothing").is_none());
        let text = edited(&json!([{"at": ["trial", 0], "value": null}])).unwrap();
        assert!(!text.contains("one"), "{text}");
    }

    #[test]
    fn comments_at_the_end_of_a_table_stay_there() {
        let (traces, fit) = ("[traces]\n# window_s = [1, 2]\n\n# zero_s = 1\n\n", "# of the fit\n[fit]\n# share = 1\n");
        let text = format!("{traces}{fit}\n# [trial]\n");
        let condition = json!({"at": ["traces", "condition", 0], "value": {"force_n": 50, "at": {"rh": 1}}});
        let second = json!({"at": ["traces", "condition", 1, "force_n"], "value": 60});
        let search = json!({"at": ["search", "seed"], "value": 1});
        let new = "[[traces.condition]]\nforce_n = 50\n\n[traces.condition.at]\nrh = 1\n\n";
        let last = "[[traces.condition]]\nforce_n = 60\n\n";
        let all = format!("{traces}{new}{last}{fit}\n# [trial]\n\n[search]\nseed = 1\n");
        assert_eq!(edited_in(&text, &json!([condition, second, search])).unwrap(), all);
        // One after another they come to the same, and the text comes back once they are removed.
        let one = edited_in(&text, &json!([search])).unwrap();
        let two = edited_in(&one, &json!([condition])).unwrap();
        assert_eq!(edited_in(&two, &json!([second])).unwrap(), all);
        let none = json!({"at": ["traces", "condition"], "value": null});
        let back = edited_in(&all, &json!([none, {"at": ["search"], "value": null}])).unwrap();
        assert_eq!(back.trim_end(), text.trim_end());
        // A table without a comment has one blank line before it.
        let text = edited_in("a = 1\n", &json!([search])).unwrap();
        assert_eq!(text, "a = 1\n\n[search]\nseed = 1\n");
    }

    #[test]
    fn places_that_cannot_be_are_refused() {
        for edit in [
            json!({"at": [], "value": 1}),
            json!({"at": ["name", "below"], "value": 1}),
            json!({"at": ["trial", 5, "name"], "value": 1}),
            json!({"at": ["target", 0], "value": 1}),
            json!({"at": ["trial", 0], "value": 1}),
        ] {
            assert!(edited(&json!([edit])).is_err(), "{edit}");
        }
    }
}
