//! Varied keys of a campaign with their values and positions in the campaign file.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::Path;

use crate::formats::spanned::Spanned;
use crate::formats::{Diagnostic, Document};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value as Json;
use toml::Value;

#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GridFile {
    /// Dotted key of the base file, whether the file has the key or not.
    pub(crate) key: Spanned<String>,
    /// Values of the key.
    #[schemars(with = "Vec<Json>")]
    pub(crate) values: Vec<Spanned<Value>>,
}

/// Maximum number of tasks of a campaign; each result is a file.
pub(crate) const MAX_TASKS: usize = 1_000_000;

/// One combination of values of the varied keys, by dotted key.
pub(crate) type Row = BTreeMap<String, Json>;

/// A value of a varied key, and its position in the campaign file.
struct Place {
    key: String,
    value: Json,
    span: Range<usize>,
}

/// All combinations of the values that a campaign varies, with the file positions of the values.
pub(crate) struct Varied<'a> {
    document: &'a Document,
    /// Varied keys, in the order of the campaign file.
    pub(crate) keys: Vec<String>,
    /// Every combination of all grids with every row of the list; the first grid varies slowest, the list fastest.
    pub(crate) rows: Vec<Row>,
    places: Vec<Place>,
}

impl<'a> Varied<'a> {
    /// Combines the tables `[[grid]]` and the rows `[[list]]` of the campaign file `document`.
    ///
    /// # Errors
    /// [`Diagnostic`] for keys and values that are invalid for every base file, and for more than `MAX_TASKS`
    /// combinations.
    pub(crate) fn new(
        document: &'a Document,
        grids: &[Spanned<GridFile>],
        list: &[Spanned<BTreeMap<String, Spanned<Value>>>],
    ) -> Result<Self, Diagnostic> {
        let mut varied = Self { document, keys: Vec::new(), rows: vec![Row::new()], places: Vec::new() };
        for grid in grids {
            let GridFile { key: named, values } = grid.get_ref();
            let key = named.get_ref();
            varied.check_key(key, named.span())?;
            if values.is_empty() || varied.keys.contains(key) {
                let reason = if values.is_empty() { "has no values" } else { "varies a key for the second time" };
                let refused = document.refuse(grid.span(), format!("{reason}: {key}"));
                return Err(refused.expected("a key of its own with one value or more"));
            }
            varied.keys.push(key.clone());
            if varied.rows.len().saturating_mul(values.len()) > MAX_TASKS {
                return Err(document.refuse(grid.span(), "makes more than a million tasks").expected("fewer values"));
            }
            let one = |value| Ok(Row::from([(key.clone(), varied.take(key, value)?)]));
            let each: Vec<Row> = values.iter().map(one).collect::<Result<_, Diagnostic>>()?;
            varied.rows = combinations(varied.rows, &each);
        }
        let mut each = Vec::new();
        for row in list {
            let mut values = Row::new();
            for (key, value) in row.get_ref() {
                varied.check_key(key, value.span())?;
                if grids.iter().any(|grid| grid.get_ref().key.get_ref() == key) {
                    let refused = document.refuse(row.span(), format!("varies {key}, and so does [[grid]]"));
                    return Err(refused.expected("a key in [[list]] or in [[grid]], not in both"));
                }
                if !varied.keys.contains(key) {
                    varied.keys.push(key.clone());
                }
                values.insert(key.clone(), varied.take(key, value)?);
            }
            each.push(values);
        }
        varied.rows = combinations(varied.rows, &each);
        Ok(varied)
    }

    fn check_key(&self, key: &str, span: Range<usize>) -> Result<(), Diagnostic> {
        if key.split('.').any(str::is_empty) {
            let refused = self.document.refuse(span, format!("is no key: \"{key}\""));
            return Err(refused.expected("a dotted key of the base, for instance \"pattern.width_um\""));
        }
        Ok(())
    }

    /// Converts a value of `key` to JSON and records the file position of the value.
    fn take(&mut self, key: &str, value: &Spanned<Value>) -> Result<Json, Diagnostic> {
        let taken = json(value.get_ref()).map_err(|reason| {
            let refused = self.document.refuse(value.span(), reason);
            let refused =
                Diagnostic { key: Some(key.into()), value: Some(value.get_ref().to_string().into()), ..refused };
            refused.expected("finite numbers, texts, true, false, and lists of them")
        })?;
        self.places.push(Place { key: key.to_owned(), value: taken.clone(), span: value.span() });
        Ok(taken)
    }

    /// Refuses the varied `key`, at the file position of its first value.
    pub(crate) fn refuse_key(&self, key: &str, reason: &str, expected: &str) -> Diagnostic {
        let place = self.places.iter().find(|place| place.key == key);
        let refused = self.document.refuse(place.map_or(0..0, |place| place.span.clone()), reason);
        let value = place.map(|place| place.value.to_string().into());
        Diagnostic { key: Some(key.into()), value, ..refused }.expected(expected)
    }

    /// Converts `refused`, an error of the file `base` with `values` set, to an error at the value in the campaign file
    /// that caused it; `None` if no varied value caused the error.
    pub(crate) fn locate(&self, refused: &Diagnostic, values: &Row, base: &Path) -> Option<Diagnostic> {
        let named = refused.key.as_deref().unwrap_or_default();
        let within = |inner: &str, outer: &str| {
            inner == outer || inner.strip_prefix(outer).is_some_and(|rest| rest.starts_with('.'))
        };
        let is_about = |key: &&String| within(named, key) || within(key, named);
        let about = self.keys.iter().filter(is_about).max_by_key(|key| key.len());
        let key = about.or_else(|| self.keys.first().filter(|_| self.keys.len() == 1))?;
        let value = values.get(key)?;
        let place = self.places.iter().find(|place| place.key == *key && place.value == *value)?;
        let mut reason = refused.reason.clone();
        if named != key {
            let of = refused.value.as_deref().map_or_else(String::new, |value| format!(" {value}"));
            reason = format!("does not fit: {named}:{of} {reason}");
        }
        let others: Vec<String> =
            values.iter().filter(|(other, _)| *other != key).map(|(key, value)| format!("{key} = {value}")).collect();
        let others = if others.is_empty() { String::new() } else { format!(", where {}", others.join(", ")) };
        reason += &format!(" (in {}{others})", base.display());
        let at = self.document.refuse(place.span.clone(), reason);
        let (expected, suggestion) = (refused.expected.clone(), refused.suggestion.clone());
        Some(Diagnostic {
            key: Some(key.as_str().into()),
            value: Some(value.to_string().into()),
            expected,
            suggestion,
            ..at
        })
    }
}

/// Combines each of `rows` with each of `more`, `rows` varying slowest; returns `rows` if `more` is empty.
pub(crate) fn combinations(rows: Vec<Row>, more: &[Row]) -> Vec<Row> {
    if more.is_empty() {
        return rows;
    }
    let with =
        |row: Row| more.iter().map(move |own| row.iter().chain(own).map(|(k, v)| (k.clone(), v.clone())).collect());
    rows.into_iter().flat_map(with).collect()
}

/// Converts a TOML value to JSON.
///
/// # Errors
/// Reason why the value cannot be converted.
fn json(value: &Value) -> Result<Json, &'static str> {
    match value {
        Value::Float(number) => {
            Ok(Json::from(Some(*number).filter(|number| number.is_finite()).ok_or("is not finite")?))
        }
        Value::Datetime(_) => Err("is a date"),
        Value::Array(values) => values.iter().map(json).collect(),
        Value::Table(table) => table.iter().map(|(key, value)| Ok((key.clone(), json(value)?))).collect(),
        Value::String(text) => Ok(Json::from(text.as_str())),
        Value::Integer(number) => Ok(Json::from(*number)),
        Value::Boolean(truth) => Ok(Json::from(*truth)),
    }
}
