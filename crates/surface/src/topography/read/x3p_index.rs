//! The index of an X3P archive, `main.xml`.

use std::io::BufRead;

use quick_xml::Reader;
use quick_xml::events::Event;

use super::bytes::{Number, unreadable};
use super::entries::Entry;
use super::lines::{excerpt, number};
use super::{MapFormat, keep_comment};
use crate::topography::ReadError;

pub(super) const FORMAT: &str = MapFormat::X3p.name();
/// Deepest nesting of elements; the schema has six levels.
const MAX_LEVELS: usize = 32;

pub(super) fn refused(field: &'static str, value: String, expected: &'static str) -> ReadError {
    ReadError::Field { format: FORMAT, field, value, expected }
}

/// Location of the heights.
#[derive(Debug)]
pub(super) enum Heights {
    /// In a file of the archive, optionally with a bit file for the valid points.
    File { path: String, valid: Option<String> },
    /// In the index itself.
    List(Vec<f64>),
}

/// Content of the index.
#[derive(Debug)]
pub(super) struct Index {
    pub(super) rows: u64,
    pub(super) cols: u64,
    /// Increments of the axes x, y and z.
    pub(super) increment_m: [f64; 3],
    pub(super) offset_z_m: f64,
    pub(super) number: Number,
    pub(super) heights: Heights,
    pub(super) comments: Vec<String>,
}

impl Index {
    /// Number of points of the surface.
    pub(super) fn points(&self) -> u64 {
        self.rows.saturating_mul(self.cols)
    }

    pub(super) fn read(source: impl BufRead) -> Result<Self, ReadError> {
        let mut entries = Entries::default();
        let mut reader = Reader::from_reader(source);
        let (mut buffer, mut path, mut text) = (Vec::new(), Vec::<String>::new(), String::new());
        let broken = |error: String| unreadable(FORMAT, &format!("main.xml: {error}"));
        loop {
            buffer.clear();
            match reader.read_event_into(&mut buffer).map_err(|error| broken(error.to_string()))? {
                Event::Start(start) => {
                    if path.len() == MAX_LEVELS {
                        return Err(broken(format!("elements within elements more than {MAX_LEVELS} deep")));
                    }
                    path.push(excerpt(start.local_name().as_ref()));
                    text.clear();
                }
                Event::Empty(empty) => {
                    path.push(excerpt(empty.local_name().as_ref()));
                    entries.take(&path, "")?;
                    path.pop();
                }
                Event::Text(part) => text.push_str(&part.xml10_content()),
                Event::CData(part) => text.push_str(&part.xml10_content()),
                Event::GeneralRef(reference) => text.push_str(match &*reference {
                    "lt" => "<",
                    "gt" => ">",
                    "amp" => "&",
                    "quot" => "\"",
                    "apos" => "'",
                    // Entities defined by the document itself are never expanded.
                    _ => "?",
                }),
                Event::End(_) => {
                    entries.take(&path, text.trim())?;
                    path.pop();
                    text.clear();
                }
                Event::Eof if path.is_empty() => return entries.finish(),
                Event::Eof => return Err(broken("the file ends within an element".to_owned())),
                _ => {}
            }
        }
    }
}

/// Entries read so far.
#[derive(Default)]
struct Entries {
    sizes: [Option<u64>; 3],
    increment_m: [Option<f64>; 3],
    offset_z_m: f64,
    number: Option<Number>,
    feature: bool,
    path: Option<String>,
    valid: Option<String>,
    listed: Vec<f64>,
    comments: Vec<String>,
}

impl Entries {
    fn take(&mut self, path: &[String], text: &str) -> Result<(), ReadError> {
        let [.., parent, name] = path else { return Ok(()) };
        // Writers leave optional entries empty; an empty height is a missing point.
        if text.is_empty() && name != "Datum" {
            return Ok(());
        }
        let entry = |name| Entry::new(FORMAT, name, text);
        let whole = |name| entry(name).count().map(Some);
        let real = |name| entry(name).number(|_| true, "a number of metres");
        match (parent.as_str(), name.as_str()) {
            ("Record1", "FeatureType") => {
                if text != "SUR" {
                    let expected = if text == "PRF" { "SUR, a surface: this is a profile" } else { "SUR, a surface" };
                    return Err(entry("FeatureType").refused(expected));
                }
                self.feature = true;
            }
            ("CX", "AxisType") | ("CY", "AxisType") if text != "I" => {
                return Err(entry("AxisType of x and y").refused("I, equal steps"));
            }
            ("CX", "Increment") => self.increment_m[0] = Some(real("Increment of x")?),
            ("CY", "Increment") => self.increment_m[1] = Some(real("Increment of y")?),
            ("CZ", "Increment") => self.increment_m[2] = Some(real("Increment of z")?),
            ("CZ", "Offset") => self.offset_z_m = real("Offset of z")?,
            ("CZ", "DataType") => {
                self.number = Some(match text {
                    "I" => Number::I16,
                    "L" => Number::I32,
                    "F" => Number::F32,
                    "D" => Number::F64,
                    _ => return Err(entry("DataType of z").refused("I, L, F or D")),
                });
            }
            ("MatrixDimension", "SizeX") => self.sizes[0] = whole("SizeX")?,
            ("MatrixDimension", "SizeY") => self.sizes[1] = whole("SizeY")?,
            ("MatrixDimension", "SizeZ") => self.sizes[2] = whole("SizeZ")?,
            ("DataLink", "PointDataLink") => self.path = Some(text.to_owned()),
            ("DataLink", "ValidPointsLink") => self.valid = Some(text.to_owned()),
            ("DataList", "Datum") => self.listed.push(datum(text)?),
            ("Record2" | "Instrument", "Comment" | "Date" | "Creator" | "Manufacturer" | "Model") => {
                keep_comment(&mut self.comments, &format!("{name}: {text}"));
            }
            _ => {}
        }
        Ok(())
    }

    fn finish(self) -> Result<Index, ReadError> {
        let missing = |field| refused(field, String::new(), "to be given");
        let size = |axis: usize, field| self.sizes[axis].ok_or_else(|| missing(field));
        if !self.feature {
            return Err(missing("FeatureType"));
        }
        if size(2, "SizeZ")? != 1 {
            return Err(refused("SizeZ", size(2, "SizeZ")?.to_string(), "1, a single layer"));
        }
        let (cols, rows) = (size(0, "SizeX")?, size(1, "SizeY")?);
        let increment_m = [
            self.increment_m[0].ok_or_else(|| missing("Increment of x"))?,
            self.increment_m[1].ok_or_else(|| missing("Increment of y"))?,
            self.increment_m[2].unwrap_or(1.0),
        ];
        let heights = match self.path {
            Some(path) => Heights::File { path, valid: self.valid },
            None if self.listed.is_empty() => return Err(missing("PointDataLink")),
            None => Heights::List(self.listed),
        };
        let number = self.number.ok_or_else(|| missing("DataType of z"))?;
        let (offset_z_m, comments) = (self.offset_z_m, self.comments);
        Ok(Index { rows, cols, increment_m, offset_z_m, number, heights, comments })
    }
}

/// A height in the index: the last of several coordinates; a missing point if empty.
fn datum(text: &str) -> Result<f64, ReadError> {
    let last = text.rsplit(';').next().unwrap_or_default().trim();
    if last.is_empty() || last.eq_ignore_ascii_case("nan") {
        return Ok(f64::NAN);
    }
    let entry = Entry::new(FORMAT, "Datum", text);
    number(last).ok_or_else(|| entry.refused("a number, or nothing where it is missing"))
}
