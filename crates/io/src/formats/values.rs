//! Values that a key may hold in more than one form.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::de::value::MapAccessDeserializer;
use serde::de::{Error, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{Quantity, counted, is_same};

/// A number with its file position.
pub type Number = Spanned<f64>;
/// A list of numbers with their file positions.
pub type NumberList = Spanned<Vec<Number>>;

/// A list without file positions, for files to be written.
pub fn number_list(values: impl IntoIterator<Item = f64>) -> NumberList {
    Spanned::from(values.into_iter().map(Number::from).collect::<Vec<_>>())
}

/// Numbers, each for an entry of another list, without file positions, for files to be written.
pub fn each(values: impl IntoIterator<Item = f64>) -> Spanned<Numbers> {
    Numbers::Each(values.into_iter().map(Number::from).collect()).into()
}

/// One number for all, or one for each entry of another list.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Numbers {
    /// One number for all entries.
    One(f64),
    /// One number for each entry.
    Each(Vec<Number>),
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Numbers;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or a list of numbers")
            }
            fn visit_f64<E: Error>(self, value: f64) -> Result<Numbers, E> {
                Ok(Numbers::One(value))
            }
            fn visit_i64<E: Error>(self, value: i64) -> Result<Numbers, E> {
                Ok(Numbers::One(value as f64))
            }
            fn visit_u64<E: Error>(self, value: u64) -> Result<Numbers, E> {
                Ok(Numbers::One(value as f64))
            }
            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Numbers, A::Error> {
                let mut each = Vec::new();
                while let Some(value) = list.next_element()? {
                    each.push(value);
                }
                Ok(Numbers::Each(each))
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for Numbers {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        "Numbers".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let mut list = generator.subschema_for::<Vec<f64>>();
        list.insert("minItems".to_owned(), 1.into());
        json_schema!({ "anyOf": [generator.subschema_for::<f64>(), list] })
    }
}

/// Reads `values` as a list of at least one number, converted to SI units.
///
/// # Errors
/// [`Diagnostic`] if the list is empty or a number is refused.
pub fn list(document: &Document, values: &Spanned<Numbers>, quantity: Quantity) -> Result<Vec<f64>, Diagnostic> {
    match values.get_ref() {
        Numbers::One(value) => Ok(vec![document.number(&Spanned::new(values.span(), *value), quantity)?]),
        Numbers::Each(each) => document.numbers(&Spanned::new(values.span(), each.clone()), quantity),
    }
}

/// Reads the pressures `values` like [`list`], and refuses repeated ones and more than `most`.
///
/// # Errors
/// Errors of [`list`], or [`Diagnostic`] at a repeated pressure or at the first excess pressure.
pub fn distinct_pressures(
    document: &Document,
    values: &Spanned<Numbers>,
    quantity: Quantity,
    most: usize,
) -> Result<Vec<f64>, Diagnostic> {
    let pressures_pa = list(document, values, quantity)?;
    if pressures_pa.len() > most {
        let reason = format!("MPa is one of {} pressures", pressures_pa.len());
        return Err(document.refuse(number_span(values, most), reason).expected(format!("at most {most}")));
    }
    let mut order: Vec<usize> = (0..pressures_pa.len()).collect();
    order.sort_by(|a, b| pressures_pa[*a].total_cmp(&pressures_pa[*b]));
    // Results and pictures are identified by their pressure.
    let is_twice = |pair: &&[usize]| is_same(pressures_pa[pair[0]], pressures_pa[pair[1]]);
    if let Some(pair) = order.windows(2).find(is_twice) {
        let later = number_span(values, pair[0].max(pair[1]));
        return Err(document.refuse(later, "MPa is in the list twice").expected("each pressure once"));
    }
    Ok(pressures_pa)
}

/// Maximum number of pressures of a scene: the report on each takes a millisecond and some kilobytes.
pub const MAX_PRESSURES: usize = 10_000;
/// Maximum number of pressures of a design: a search solves every design at each pressure, and computes the correlation
/// of errors for all pairs of pressures.
pub const MAX_TARGET_PRESSURES: usize = 1000;

impl Numbers {
    /// Numbers as written, in the unit of the file.
    pub fn written(&self) -> Vec<f64> {
        match self {
            Self::One(value) => vec![*value],
            Self::Each(each) => each.iter().map(|value| *value.get_ref()).collect(),
        }
    }
}

/// File position of the number with the index `place` in `values`; a single number stands for all.
pub fn number_span(values: &Spanned<Numbers>, place: usize) -> Range<usize> {
    match values.get_ref() {
        Numbers::Each(each) if place < each.len() => each[place].span(),
        _ => values.span(),
    }
}

/// Reads the two ends of a range, converted to SI units; a single number stands for both. `expected` describes accepted
/// values.
///
/// # Errors
/// [`Diagnostic`] if a number is refused, if a list does not have two numbers, or has the larger number first.
pub fn range(
    document: &Document,
    values: &Spanned<Numbers>,
    quantity: Quantity,
    expected: &str,
) -> Result<[f64; 2], Diagnostic> {
    let read = list(document, values, quantity)?;
    let reason = match (values.get_ref(), &read[..]) {
        (Numbers::One(_), [one]) => return Ok([*one; 2]),
        (_, [lowest, highest]) if lowest <= highest => return Ok([*lowest, *highest]),
        (_, [_, _]) => "has its larger number first".to_owned(),
        _ => format!("has {}", counted(read.len(), "number")),
    };
    Err(document.refuse(values.span(), reason).expected(expected))
}

/// Reads the two ends of an interval, converted to SI units; `None` if absent. `reason` refuses other numbers, and
/// `expected` describes accepted ones.
///
/// # Errors
/// [`Diagnostic`] if a number is refused, or unless there are two that increase.
pub fn interval(
    document: &Document,
    values: Option<&NumberList>,
    quantity: Quantity,
    [reason, expected]: [&str; 2],
) -> Result<Option<[f64; 2]>, Diagnostic> {
    let Some(values) = values else { return Ok(None) };
    match document.numbers(values, quantity)?[..] {
        [from, to] if from < to => Ok(Some([from, to])),
        _ => Err(document.refuse(values.span(), reason).expected(expected)),
    }
}

/// Reads `count` numbers, converted to SI units; a single number stands for all. `of_what` names an entry in messages.
///
/// # Errors
/// [`Diagnostic`] if the list's length is not `count` or a number is refused.
pub fn for_each(
    document: &Document,
    values: &Spanned<Numbers>,
    quantity: Quantity,
    count: usize,
    of_what: &str,
) -> Result<Vec<f64>, Diagnostic> {
    match values.get_ref() {
        Numbers::One(_) => Ok(vec![list(document, values, quantity)?[0]; count]),
        Numbers::Each(each) => column(document, &Spanned::new(values.span(), each.clone()), quantity, count, of_what),
    }
}

/// Reads a list of `count` numbers, converted to SI units. `of_what` names an entry in messages.
///
/// # Errors
/// [`Diagnostic`] if the list's length is not `count` or a number is refused.
pub fn column(
    document: &Document,
    values: &NumberList,
    quantity: Quantity,
    count: usize,
    of_what: &str,
) -> Result<Vec<f64>, Diagnostic> {
    let read = document.numbers(values, quantity)?;
    if read.len() == count {
        return Ok(read);
    }
    Err(document
        .refuse(values.span(), format!("has {} values", read.len()))
        .expected(format!("{count}, one for each {of_what}")))
}

/// Reads numbers that increase strictly, converted to SI units.
///
/// # Errors
/// [`Diagnostic`] if the list is empty, a number is refused, or a number does not exceed the one before.
pub fn increasing(document: &Document, values: &NumberList, quantity: Quantity) -> Result<Vec<f64>, Diagnostic> {
    let read = document.numbers(values, quantity)?;
    let Some(place) = read.windows(2).position(|pair| pair[1] <= pair[0]) else { return Ok(read) };
    let (before, value) = (values.get_ref()[place].get_ref(), &values.get_ref()[place + 1]);
    let refused = document.refuse(value.span(), format!("does not exceed the {before} before it"));
    Err(refused.expected("numbers that increase"))
}

/// A path to a file with the table, or the table itself.
#[derive(Clone, Debug, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum PathOr<T> {
    /// Path, relative to the file that states it.
    Path(String),
    /// The table.
    Table(Box<T>),
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for PathOr<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader<T>(std::marker::PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Reader<T> {
            type Value = PathOr<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a path in quotes or a table")
            }
            fn visit_str<E: Error>(self, path: &str) -> Result<PathOr<T>, E> {
                Ok(PathOr::Path(path.to_owned()))
            }
            fn visit_map<A: MapAccess<'de>>(self, table: A) -> Result<PathOr<T>, A::Error> {
                T::deserialize(MapAccessDeserializer::new(table)).map(|table| PathOr::Table(Box::new(table)))
            }
        }
        deserializer.deserialize_any(Reader(std::marker::PhantomData))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::units::{PRESSURE_MPA, TIME_S};

    #[derive(Deserialize)]
    struct File<T> {
        key: Spanned<T>,
    }

    fn read<T: for<'de> Deserialize<'de>, R>(
        value: &str,
        reader: impl Fn(&Document, &Spanned<T>) -> Result<R, Diagnostic>,
    ) -> Result<R, String> {
        let document = Document::new("a.toml", format!("key = {value}"));
        let file: File<T> = document.parse().unwrap();
        reader(&document, &file.key).map_err(|refused| refused.to_string())
    }

    #[test]
    fn pressures_are_distinct_and_not_too_many() {
        let read = |value: &str| read(value, |document, list| distinct_pressures(document, list, PRESSURE_MPA, 3));
        assert_eq!(read("[3.0, 1.0, 2.0]"), Ok(vec![3e6, 1e6, 2e6]));
        assert_eq!(read("2.0"), Ok(vec![2e6]));
        let many = "a.toml:1: key: 4.0 MPa is one of 5 pressures; expected at most 3";
        assert_eq!(read("[1.0, 2.0, 3.0, 4.0, 5.0]").unwrap_err(), many);
        let twice = "a.toml:1: key: 2 MPa is in the list twice; expected each pressure once";
        assert_eq!(read("[2.0, 1.0, 2]").unwrap_err(), twice);
    }

    #[test]
    fn an_interval_has_two_numbers_that_increase() {
        let words = ["is no window", "two times"];
        let read = |value: &str| read(value, |document, list| interval(document, Some(list), TIME_S, words));
        assert_eq!(read("[10, 40.5]"), Ok(Some([10.0, 40.5])));
        for wrong in ["[1.0]", "[2.0, 2.0]", "[2.0, 1.0]", "[1.0, 2.0, 3.0]"] {
            assert_eq!(read(wrong).unwrap_err(), format!("a.toml:1: key: {wrong} is no window; expected two times"));
        }
        assert!(read("[-1, 2]").unwrap_err().starts_with("a.toml:1: key: -1 is out of range"));
    }
}
