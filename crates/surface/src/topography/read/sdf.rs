//! Surface data file (`.sdf`, ISO 25178-71, and its predecessor BCR): the same header as text or binary, then heights
//! profile by profile. All lengths are in metres; a height is the stored number times Zscale.
//!
//! | bytes | entry of the binary header | |
//! |---|---|---|
//! | 8 | version | `bISO-1.0`, `bISO-2.0`, `bBCR-1.0`; `a...` for text |
//! | 10, 12, 12 | maker, creation, last change | text |
//! | 2, 2 (4, 4 in version 2) | points in a profile, profiles | whole numbers |
//! | 8, 8, 8, 8 | Xscale, Yscale, Zscale, Zresolution | floats |
//! | 1, 1, 1 | compression, data type, checksum | 0, 0 to 7, any |
//!
//! Missing points are `BAD` in text. In binary files they are the smallest number of a signed type, the largest of an
//! unsigned type of more than one byte, or NaN.

use std::io::{BufRead, Read};

use super::bytes::{Number, array, exact, numbers, text};
use super::entries::Entry;
use super::lines::{Lines, height, not_a_number};
use super::overridden::Lengths;
use super::window::Window;
use super::{MapFormat, ReadMap, ReadOptions, keep_comment};
use crate::topography::ReadError;

const FORMAT: &str = MapFormat::Sdf.name();
/// First characters of the version, after the letter that distinguishes text and binary.
const VERSIONS: [&[u8]; 4] = [b"ISO-", b"BCR-", b"BC-", b"NPL-"];

/// Whether a file that begins with `start` is a surface data file.
pub(super) fn is_sdf(start: &[u8]) -> bool {
    matches!(start.first(), Some(b'a' | b'b')) && VERSIONS.iter().any(|version| start[1..].starts_with(version))
}

pub(super) fn read(mut source: impl BufRead, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let [kind]: [u8; 1] = exact(&mut source, FORMAT, "header")?;
    if kind == b'a' { read_text(source, options) } else { read_binary(source, options) }
}

/// Entries common to the text header and the binary header.
struct Header {
    points: u64,
    profiles: u64,
    /// Xscale, Yscale, Zscale, in metres.
    scale_m: [f64; 3],
    number: Number,
}

impl Header {
    fn new(points: u64, profiles: u64, scale_m: [f64; 3], [compression, kind]: [u64; 2]) -> Result<Self, ReadError> {
        let refused = |field, value: String, expected| Err(ReadError::Field { format: FORMAT, field, value, expected });
        if compression != 0 {
            return refused("Compression", compression.to_string(), "0, no compression");
        }
        let number = match kind {
            0 => Number::U8,
            1 => Number::U16,
            2 => Number::U32,
            3 => Number::F32,
            4 => Number::I8,
            5 => Number::I16,
            6 => Number::I32,
            7 => Number::F64,
            _ => return refused("DataType", kind.to_string(), "0 to 7"),
        };
        if points == 0 {
            return refused("NumPoints", "0".to_owned(), "a whole number from 1 up");
        }
        if !(scale_m[2].is_finite() && scale_m[2] != 0.0) {
            return refused("Zscale", scale_m[2].to_string(), "a number other than 0");
        }
        Ok(Self { points, profiles, scale_m, number })
    }

    fn window(&self, options: &ReadOptions) -> Result<Window, ReadError> {
        Window::new(Some(self.profiles), self.points, options.crop, options.decimation)
    }

    /// Whether a stored number marks a missing point.
    fn is_missing(&self, value: f64) -> bool {
        match self.number {
            Number::U16 => value == f64::from(u16::MAX),
            Number::U32 => value == f64::from(u32::MAX),
            Number::I8 => value == f64::from(i8::MIN),
            Number::I16 => value == f64::from(i16::MIN),
            Number::I32 => value == f64::from(i32::MIN),
            Number::F32 => value == f64::from(f32::MIN),
            Number::F64 => value == f64::MIN,
            Number::U8 | Number::U64 | Number::I64 => false,
        }
    }

    fn finish(&self, window: Window, options: &ReadOptions, comments: Vec<String>) -> Result<ReadMap, ReadError> {
        let [x, y, z] = self.scale_m;
        Lengths::metres([x, y]).map(window, |height| height * z, options, MapFormat::Sdf, comments)
    }
}

fn read_binary(mut source: impl Read, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let version: [u8; 7] = exact(&mut source, FORMAT, "header")?;
    let names: [u8; 34] = exact(&mut source, FORMAT, "header")?;
    let mut comments = Vec::new();
    keep_comment(&mut comments, &format!("ManufacID: {}", text(&names[..10])));
    keep_comment(&mut comments, &format!("CreateDate: {}", text(&names[10..22])));
    // Version 2 counts in 32 bits, earlier versions in 16.
    let counts: [u64; 2] = if version.starts_with(b"ISO-2") {
        let bytes: [u8; 8] = exact(&mut source, FORMAT, "header")?;
        [0, 4].map(|at| u64::from(u32::from_le_bytes(array(&bytes[at..]))))
    } else {
        let bytes: [u8; 4] = exact(&mut source, FORMAT, "header")?;
        [0, 2].map(|at| u64::from(u16::from_le_bytes(array(&bytes[at..]))))
    };
    let bytes: [u8; 35] = exact(&mut source, FORMAT, "header")?;
    let scale_m = [0, 8, 16].map(|at| f64::from_le_bytes(array(&bytes[at..])));
    let header = Header::new(counts[0], counts[1], scale_m, [bytes[32].into(), bytes[33].into()])?;
    let mut window = header.window(options)?;
    let height = |value| Ok(if header.is_missing(value) { f64::NAN } else { value });
    numbers(&mut source, FORMAT, (header.number, false), counts[0] * counts[1], &mut window, height)?;
    header.finish(window, options, comments)
}

/// Entries of the text header read so far.
#[derive(Default)]
struct Entries {
    counts: [Option<u64>; 2],
    scale_m: [Option<f64>; 3],
    kind: [Option<u64>; 2],
}

impl Entries {
    /// Stores the entry in `text`; returns whether `text` was an entry.
    fn take(&mut self, text: &str) -> Result<bool, ReadError> {
        let Some((key, value)) = text.split_once('=') else { return Ok(false) };
        let value = value.trim();
        let entry = |name| Entry::new(FORMAT, name, value);
        let whole = |name| value.parse().map(Some).map_err(|_| entry(name).refused("a whole number"));
        let real = |name| entry(name).number(|_| true, "a number with a decimal point").map(Some);
        match key.trim() {
            "NumPoints" => self.counts[0] = whole("NumPoints")?,
            "NumProfiles" => self.counts[1] = whole("NumProfiles")?,
            "Xscale" => self.scale_m[0] = real("Xscale")?,
            "Yscale" => self.scale_m[1] = real("Yscale")?,
            "Zscale" => self.scale_m[2] = real("Zscale")?,
            "Compression" => self.kind[0] = whole("Compression")?,
            "DataType" => self.kind[1] = whole("DataType")?,
            _ => {}
        }
        Ok(true)
    }

    fn finish(&self) -> Result<Header, ReadError> {
        let missing = |name| Entry::new(FORMAT, name, "").refused("a number");
        let [points, profiles] = self.counts;
        let [x, y, z] = self.scale_m;
        Header::new(
            points.ok_or_else(|| missing("NumPoints"))?,
            profiles.ok_or_else(|| missing("NumProfiles"))?,
            [
                x.ok_or_else(|| missing("Xscale"))?,
                y.ok_or_else(|| missing("Yscale"))?,
                z.ok_or_else(|| missing("Zscale"))?,
            ],
            // Heights written as text are read directly, whatever their original data type.
            [self.kind[0].unwrap_or(0), self.kind[1].unwrap_or(7)],
        )
    }
}

fn read_text(source: impl BufRead, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let mut lines = Lines::new(source);
    let (mut entries, mut comments) = (Entries::default(), Vec::new());
    let rest = loop {
        let line = lines.line() + 1;
        let Some(text) = lines.next()? else {
            return Err(ReadError::Ended { format: FORMAT, what: "header", expected: 1, found: 0 });
        };
        if let Some(rest) = text.strip_prefix('*') {
            break rest.to_owned();
        }
        keep_comment(&mut comments, text);
        // The first line is the version; empty lines are ignored.
        if !entries.take(text)? && line > 1 && !text.is_empty() {
            return Err(Entry::new(FORMAT, "header", text).refused("lines name = value, then a line with *"));
        }
    };
    let header = entries.finish()?;
    let mut window = header.window(options)?;
    let expected = header.points.saturating_mul(header.profiles);
    let mut found = 0;
    let mut ended = take_heights(&rest, lines.line(), &header, &mut window, &mut found)?;
    while !ended && found < expected && !window.is_full() {
        let line = lines.line() + 1;
        let Some(text) = lines.next()? else { break };
        ended = take_heights(text, line, &header, &mut window, &mut found)?;
    }
    if found < expected && !window.is_full() || found > expected {
        return Err(ReadError::Ended { format: FORMAT, what: "heights", expected, found });
    }
    header.finish(window, options, comments)
}

/// Reads the heights on a line; returns whether the line ends them.
fn take_heights(
    text: &str,
    line: usize,
    header: &Header,
    window: &mut Window,
    found: &mut u64,
) -> Result<bool, ReadError> {
    for (n, field) in text.split_whitespace().enumerate() {
        if field.starts_with('*') {
            return Ok(true);
        }
        let expected = "a height with a decimal point, or BAD where it is missing";
        let value = height(field).ok_or_else(|| not_a_number(line, n, field, expected))?;
        let value = value.filter(|value| !header.is_missing(*value)).unwrap_or(f64::NAN);
        *found += 1;
        window.push(&[value])?;
    }
    Ok(false)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::read::plainly;

    const TEXT: &str = "aISO-1.0\r\nManufacID = test\r\nNumPoints = 3\r\nNumProfiles = 2\r\nXscale = 1e-6\r\n\
                        Yscale = 2e-6\r\nZscale = 1.0E-9\r\nZresolution = -1\r\nCompression = 0\r\nDataType = 7\r\n\
                        CheckType = 0\r\n*\r\n1 2\r\n3.5 BAD -5 6\r\n*\r\nOperator = x\r\n*\r\n";

    fn binary(version: &[u8; 8], kind: u8, heights: &[u8]) -> Vec<u8> {
        let mut bytes = version.to_vec();
        bytes.extend_from_slice(b"test\0junk 010120261200010120261200");
        if version.ends_with(b"2.0") {
            bytes.extend([3_u32, 2].into_iter().flat_map(u32::to_le_bytes));
        } else {
            bytes.extend([3_u16, 2].into_iter().flat_map(u16::to_le_bytes));
        }
        bytes.extend([1e-6_f64, 2e-6, 1e-9, -1.0].into_iter().flat_map(f64::to_le_bytes));
        bytes.extend_from_slice(&[0, kind, 0]);
        bytes.extend_from_slice(heights);
        bytes
    }

    fn check(bytes: &[u8], third: f64) {
        let heights_m = [1e-9, f64::NAN, 2e-9, -5e-9, third, 6e-9];
        let read = plainly::check(bytes, MapFormat::Sdf, [1e-6, 2e-6], heights_m, 1e-24);
        assert!(read.comments.iter().any(|comment| comment.contains("test")));
    }

    #[test]
    fn text_and_binary_of_every_version_and_type_give_the_same_map() {
        check(TEXT.as_bytes(), 3.5e-9);
        check(TEXT.replace("aISO", "aBCR").as_bytes(), 3.5e-9);
        let doubles: Vec<u8> = [1.0, 2.0, 3.5, f64::MIN, -5.0, 6.0].into_iter().flat_map(f64::to_le_bytes).collect();
        check(&binary(b"bISO-1.0", 7, &doubles), 3.5e-9);
        check(&binary(b"bISO-2.0", 7, &doubles), 3.5e-9);
        let floats: Vec<u8> = [1.0, 2.0, 3.5, f32::NAN, -5.0, 6.0].into_iter().flat_map(f32::to_le_bytes).collect();
        check(&binary(b"bBCR-1.0", 3, &floats), 3.5e-9);
        let shorts: Vec<u8> = [1, 2, 3, i16::MIN, -5, 6].into_iter().flat_map(i16::to_le_bytes).collect();
        check(&binary(b"bISO-1.0", 5, &shorts), 3e-9);
        let longs: Vec<u8> = [1, 2, 3, i32::MIN, -5, 6].into_iter().flat_map(i32::to_le_bytes).collect();
        check(&binary(b"bISO-1.0", 6, &longs), 3e-9);
    }

    #[test]
    fn headers_that_lie_are_refused_by_name() {
        let refused = |from: &str, to: &str| plainly::refused(TEXT.replace(from, to));
        assert!(refused("NumPoints = 3", "NumPoints = 4000000000").contains("expected at most"));
        assert!(refused("NumPoints = 3", "NumPoints = 4").contains("after 6 of 8"));
        assert!(refused("NumPoints = 3", "NumPoints = 2").contains("6 of 4"));
        assert!(refused("NumPoints = 3", "NumPoints = -3").contains("NumPoints"));
        assert!(refused("Zscale = 1.0E-9", "Zscale = 0").contains("Zscale"));
        assert!(refused("Xscale = 1e-6\r\n", "").contains("Xscale"));
        assert!(refused("Compression = 0", "Compression = 1").contains("Compression"));
        assert!(refused("3.5", "3,5").contains("\"3,5\""));
        let short = binary(b"bISO-1.0", 7, &[0; 40]);
        assert!(plainly::refused(short).contains("after 5 of 6"));
        let kind = binary(b"bISO-1.0", 9, &[0; 48]);
        assert!(plainly::refused(kind).contains("DataType"));
    }
}
