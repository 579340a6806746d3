//! What comment lines before the data say: sizes, units, titles.

use super::comma::header_length;
use super::keep_comment;
use super::lines::{Delimiter, excerpt, height, number};
use crate::unit::unit_names;
use crate::{LengthUnit, ReadError};

/// What the header said.
#[derive(Clone, Debug, Default)]
pub(crate) struct Header {
    /// Extent across the columns, in metres.
    pub(crate) width_m: Option<f64>,
    /// Extent across the rows, in metres.
    pub(crate) height_m: Option<f64>,
    /// Largest part of each of them that their rounding leaves open.
    pub(crate) rounding: [f64; 2],
    pub(crate) value_unit: Option<LengthUnit>,
    /// Nanometres of a height of 1, where a header says that instead of a unit.
    pub(crate) value_nm: Option<f64>,
    /// The first line was SPIP's: other programs use the same words with other units.
    spip: bool,
    /// Titles of the columns x, y and z were met.
    pub(crate) titled: bool,
    /// Lines of the matrix, and values on each.
    pub(crate) pixels: [Option<u64>; 2],
    pub(crate) lateral_unit: Option<LengthUnit>,
    /// Comment lines without their mark.
    pub(crate) comments: Vec<String>,
}

impl Header {
    /// Takes `text` in if it is a line of header: a comment, or titles of the columns x, y, z.
    pub(crate) fn take(&mut self, text: &str, line: usize) -> Result<bool, ReadError> {
        if let Some(comment) = text.strip_prefix(['#', '%']) {
            self.comment(comment.trim(), line)?;
            return Ok(true);
        }
        Ok(self.titles(text, line)? || self.units_below_titles(text, line)?)
    }

    /// Takes in what a line without a mark says that names a value above the data, as `Operator: Anna`. Programs write any words there:
    /// where the value is none that we know, as of `Height: 480`, the line is a comment and nothing else.
    pub(super) fn unmarked(&mut self, text: &str, line: usize) {
        // What is refused was kept among the comments before it was read.
        self.comment(text, line).ok();
    }

    /// Takes in what a comment says.
    fn comment(&mut self, comment: &str, line: usize) -> Result<(), ReadError> {
        keep_comment(&mut self.comments, comment);
        let Some((key, value)) = comment.split_once([':', '=']) else { return Ok(()) };
        let value = value.trim();
        match key.trim().to_ascii_lowercase().as_str() {
            "width" => {
                self.width_m = Some(length(line, "Width", value)?);
                self.rounding[1] = rounding(value);
            }
            "height" => {
                self.height_m = Some(length(line, "Height", value)?);
                self.rounding[0] = rounding(value);
            }
            // Of other programs' words whatever counts lines.
            "rows" => self.pixels[0] = value.parse().ok().filter(|count| *count > 0).or(self.pixels[0]),
            "value units" | "z units" => self.value_unit = Some(unit(line, "Value units", value)?),
            "xy units" | "lateral units" => self.lateral_unit = Some(unit(line, "XY units", value)?),
            "file format" => self.spip = value.eq_ignore_ascii_case("ascii"),
            key if self.spip => self.spip_entry(key, value, line)?,
            _ => {}
        }
        Ok(())
    }

    /// An entry of a header by SPIP: lengths in nanometres, heights in their unit or, without one, times Bit2nm.
    fn spip_entry(&mut self, key: &str, value: &str, line: usize) -> Result<(), ReadError> {
        match key {
            "x-pixels" => self.pixels[1] = Some(whole(line, "x-pixels", value)?),
            "y-pixels" => self.pixels[0] = Some(whole(line, "y-pixels", value)?),
            "x-length" => self.width_m = Some(nanometres(line, "x-length", value)?),
            "y-length" => self.height_m = Some(nanometres(line, "y-length", value)?),
            "z-unit" => self.value_unit = Some(unit(line, "z-unit", value)?),
            "bit2nm" => self.value_nm = Some(positive(line, "Bit2nm", value)?),
            "voidpixels" if value.parse() != Ok(0_u64) => {
                let expected = "0, with NaN for points that are missing";
                return Err(ReadError::Header { line, key: "voidpixels", value: excerpt(value), expected });
            }
            _ => {}
        }
        Ok(())
    }

    /// Titles such as `x_um,y_um,z_nm`, `X [um]  Y [um]  Z [nm]` or `"X (mm)","Y (mm)","Height (um)"`.
    fn titles(&mut self, text: &str, line: usize) -> Result<bool, ReadError> {
        let joined = text.replace(" [", "_").replace(" (", "_");
        let titles: Vec<&str> = Delimiter::of(&joined).fields(&joined).take(4).collect();
        let [x, y, z] = titles[..] else { return Ok(false) };
        /// What follows the word that a title begins with, where it is one of `names`.
        fn behind<'a>(title: &'a str, names: &[&str]) -> Option<&'a str> {
            let end = title.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(title.len());
            names.iter().any(|name| title[..end].eq_ignore_ascii_case(name)).then_some(&title[end..])
        }
        let (Some(x), Some(y), Some(z)) = (behind(x, &["x"]), behind(y, &["y"]), behind(z, &["z", "height"])) else {
            return Ok(false);
        };
        self.titled = true;
        self.take_units([x, y, z], line)?;
        Ok(true)
    }

    /// Units in a line of their own below the titles, as `um,um,nm` or `[um] [um] [nm]`.
    fn units_below_titles(&mut self, text: &str, line: usize) -> Result<bool, ReadError> {
        let cells: Vec<&str> = Delimiter::of(text).fields(text).take(4).collect();
        let [x, y, z] = cells[..] else { return Ok(false) };
        let is_row = self.titled && [x, y, z].iter().all(|cell| bare(cell).parse::<LengthUnit>().is_ok());
        if is_row {
            self.take_units([x, y, z], line)?;
        }
        Ok(is_row)
    }

    /// Takes the units of x, y and z; nothing where none is named.
    fn take_units(&mut self, cells: [&str; 3], line: usize) -> Result<(), ReadError> {
        let [x, y, z] = cells.map(bare);
        if x != y {
            let value = excerpt(&format!("{x} and {y}"));
            return Err(ReadError::Header { line, key: "unit of x and y", value, expected: "the same unit for both" });
        }
        if !x.is_empty() {
            self.lateral_unit = Some(unit(line, "unit of x and y", x)?);
        }
        if !z.is_empty() {
            self.value_unit = Some(unit(line, "unit of z", z)?);
        }
        Ok(())
    }
}

/// A unit without its brackets.
fn bare(cell: &str) -> &str {
    cell.trim_matches(['_', '[', ']', '(', ')', ' ', '/'])
}

/// A length with its unit, as `1.5 mm`, in metres.
fn length(line: usize, key: &'static str, value: &str) -> Result<f64, ReadError> {
    let refused = || ReadError::Header {
        line,
        key,
        value: excerpt(value),
        expected: concat!("a positive length with its unit (", unit_names!(), "), for instance 1.5 mm"),
    };
    let value = &header_length(value);
    let split = value.find(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E')).ok_or_else(refused)?;
    let (amount, name) = value.split_at(split);
    let amount = number(amount.trim()).filter(|amount| *amount > 0.0).ok_or_else(refused)?;
    let unit: LengthUnit = name.parse().map_err(|_| refused())?;
    Ok(unit.to_metres(amount))
}

/// Half a unit of the last digit of a length that was accepted, over the length.
fn rounding(value: &str) -> f64 {
    let value = &header_length(value);
    let digits = value.split(|c: char| c.is_alphabetic() || c.is_whitespace()).next().unwrap_or_default();
    let decimals = digits.split_once('.').map_or(0, |(_, decimals)| decimals.len());
    // The cast saturates: nothing is rounded to so many digits.
    let unit = 0.1_f64.powi(i32::try_from(decimals).unwrap_or(i32::MAX));
    number(digits).map_or(0.0, |amount| 0.5 * unit / amount)
}

/// A length in nanometres, in metres.
fn nanometres(line: usize, key: &'static str, value: &str) -> Result<f64, ReadError> {
    Ok(LengthUnit::Nanometre.to_metres(positive(line, key, value)?))
}

fn positive(line: usize, key: &'static str, value: &str) -> Result<f64, ReadError> {
    let refused = || ReadError::Header { line, key, value: excerpt(value), expected: "a number of nanometres above 0" };
    number(value).filter(|amount| *amount > 0.0).ok_or_else(refused)
}

fn whole(line: usize, key: &'static str, value: &str) -> Result<u64, ReadError> {
    let refused = || ReadError::Header { line, key, value: excerpt(value), expected: "a whole number from 1 up" };
    value.parse().ok().filter(|count| *count > 0).ok_or_else(refused)
}

fn unit(line: usize, key: &'static str, value: &str) -> Result<LengthUnit, ReadError> {
    value.parse().map_err(|_| ReadError::Header {
        line,
        key,
        value: excerpt(value),
        expected: concat!("one of ", unit_names!()),
    })
}

/// What lines above data without titles must be.
pub(super) const ABOVE_DATA: &str =
    "a number; lines above the data begin with #, or name a value, as \"Operator: Anna\"";

/// Whether a line that begins with a word names a value behind it, as `Operator: Anna` or `Gain = 20`.
pub(super) fn names_a_value(text: &str) -> bool {
    text.split_once([':', '=']).is_some_and(|(key, _)| !key.contains([';', ',', '\t']))
}

/// Whether a line begins with a word other than those for a missing height.
pub(super) fn begins_with_a_word(text: &str) -> bool {
    let first = Delimiter::of(text).fields(text).next().unwrap_or_default();
    first.starts_with(char::is_alphabetic) && height(first).is_none()
}

#[cfg(test)]
mod tests {
    use super::super::GIVEN;
    use super::*;
    use crate::{MapFormat, ReadOptions, read_map};

    fn header(lines: &[&str]) -> Result<Header, ReadError> {
        let mut header = Header::default();
        for (n, text) in lines.iter().enumerate() {
            assert!(header.take(text, n + 1)?, "{text} is a header line");
        }
        Ok(header)
    }

    #[test]
    fn sizes_and_units_are_understood() {
        let read = header(&["# Channel: Topography", "# Width: 1.5 mm", "# Height: 1e3 \u{b5}m", "# Value units: nm"]);
        let read = read.unwrap();
        assert_eq!((read.width_m, read.height_m), (Some(1.5e-3), Some(1e-3)));
        assert_eq!(read.value_unit, Some(LengthUnit::Nanometre));
        assert_eq!(read.comments.len(), 4);
    }

    #[test]
    fn headers_of_spip_are_in_nanometres() {
        let lines =
            ["# File Format = ASCII", "# x-pixels = 4", "# y-pixels = 3", "# x-length = 2000", "# y-length = 1500.5"];
        let read =
            header(&[&lines[..], &["# Bit2nm = 0.25", "# voidpixels = 0", "# Start of Data:"]].concat()).unwrap();
        assert_eq!((read.pixels, read.value_nm, read.value_unit), ([Some(3), Some(4)], Some(0.25), None));
        let close = |found: Option<f64>, expected: f64| (found.unwrap() / expected - 1.0).abs() < 1e-15;
        assert!(close(read.width_m, 2e-6) && close(read.height_m, 1.5005e-6));
        let in_unit = header(&["# File Format = ASCII", "# z-unit = um"]).unwrap();
        assert_eq!(in_unit.value_unit, Some(LengthUnit::Micrometre));
        // The same words mean other units elsewhere.
        let other = header(&["# Daisy frame view snapshot", "# x-length: 40.0", "# x-unit: um"]).unwrap();
        assert_eq!((other.width_m, other.pixels), (None, [None; 2]));
    }

    #[test]
    fn column_titles_carry_units() {
        for titles in [
            &["x_um,y_um,z_nm"][..],
            &["X [um]\tY [um]\tZ [nm]"],
            &["x (\u{b5}m); y (\u{b5}m); z (nm)"],
            &["X(um)\tY(um)\tZ(nm)"],
            &["\"X (um)\",\"Y (um)\",\"Height (nm)\""],
            &["X,Y,Z", "um,um,nm"],
            &["x y z", "[um] [um] [nm]"],
        ] {
            let read = header(titles).unwrap();
            assert_eq!(read.lateral_unit, Some(LengthUnit::Micrometre), "{titles:?}");
            assert_eq!(read.value_unit, Some(LengthUnit::Nanometre), "{titles:?}");
        }
        let read = header(&["x y z"]).unwrap();
        assert_eq!((read.lateral_unit, read.value_unit), (None, None));
        assert!(!Header::default().take("1 2 3", 1).unwrap());
        assert!(!Header::default().take("xerox yes zero", 1).unwrap());
        // Units mean nothing without titles.
        assert!(!Header::default().take("um,um,nm", 1).unwrap());
    }

    #[test]
    fn header_entries_that_mean_nothing_are_refused_with_line_and_value() {
        for (text, needle) in [
            ("# Width: wide", "wide"),
            ("# Width: -1 mm", "-1 mm"),
            ("# Height: 3", "\"3\""),
            ("# Value units: inch", "one of m"),
            ("x_um,y_mm,z_um", "um and mm"),
            ("# x-pixels = -4", "\"-4\""),
            ("# y-length = 0", "above 0"),
            ("# voidpixels = 12", "NaN"),
        ] {
            let message = header(&["# File Format = ASCII", text]).unwrap_err().to_string();
            assert!(message.starts_with("line 2: ") && message.contains(needle), "{message}");
        }
    }

    #[test]
    fn what_an_instrument_writes_above_the_titles_is_passed_over_and_nothing_else_is() {
        let refused = |text: &str| read_map(text.as_bytes(), &GIVEN).unwrap_err().to_string();
        let points = "0,0,1\n1,0,2\n0,1,3\n1,1,4\n";
        let text = format!("Measurement 17\nOperator,Anna\n\nX,Y,Z\num,um,nm\n{points}");
        let read = read_map(text.as_bytes(), &ReadOptions::NONE).unwrap();
        assert_eq!((read.format, read.map.dx_m()), (MapFormat::Xyz, 1e-6));
        assert_eq!(read.map.heights_m(), [1e-9, 3e-9, 2e-9, 4e-9]);
        // Lines that name a value are comments, and may say what comments do.
        let named = "Instrument: Profiler 9\nOperator: AN\nWidth: 2 um\nHeight: 2 um\nValue units: nm\n1;2\n3;4\n";
        let named = read_map(named.as_bytes(), &ReadOptions::NONE).unwrap();
        assert_eq!((named.map.dx_m(), named.map.heights_m()), (1e-6, &[1e-9, 3e-9, 2e-9, 4e-9][..]));
        assert_eq!(named.comments[0], "Instrument: Profiler 9");
        // Words of the instrument's own size neither refuse the points below titles nor make a matrix of them.
        for words in ["Height: 480\nWidth: 640", "Width: 10 mm\nHeight: 10 mm", "Value units: counts"] {
            let read =
                read_map(format!("{words}\nX [um],Y [um],Z [nm]\n{points}").as_bytes(), &ReadOptions::NONE).unwrap();
            assert_eq!((read.format, read.map.heights_m()), (MapFormat::Xyz, &[1e-9, 3e-9, 2e-9, 4e-9][..]), "{words}");
            assert_eq!(read.comments[0], words.lines().next().unwrap());
        }
        assert!(refused(&format!("Measurement,17\n{points}")).contains("lines above the data begin with #"));
        for text in [format!("Measurement,17\n{points}"), format!("a,b,c\n{points}"), "friction\n".to_owned()] {
            assert!(refused(&text).starts_with("line 1, column "), "{text}: {}", refused(&text));
        }
        assert!(refused(&format!("X,Y,Z\nabout,these,points\n{points}")).starts_with("line 2"));
    }
}
