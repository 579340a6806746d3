//! What comment lines before the data say: sizes, units, titles.

use super::keep_comment;
use super::lines::{Delimiter, excerpt, number};
use crate::unit::UNIT_NAMES;
use crate::{LengthUnit, ReadError};

/// What the header said.
#[derive(Clone, Debug, Default)]
pub(crate) struct Header {
    /// Extent across the columns, in metres.
    pub(crate) width_m: Option<f64>,
    /// Extent across the rows, in metres.
    pub(crate) height_m: Option<f64>,
    pub(crate) value_unit: Option<LengthUnit>,
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
        self.titles(text, line)
    }

    fn comment(&mut self, comment: &str, line: usize) -> Result<(), ReadError> {
        keep_comment(&mut self.comments, comment);
        let Some((key, value)) = comment.split_once(':') else { return Ok(()) };
        let value = value.trim();
        match key.trim().to_ascii_lowercase().as_str() {
            "width" => self.width_m = Some(length(line, "Width", value)?),
            "height" => self.height_m = Some(length(line, "Height", value)?),
            "value units" | "z units" => self.value_unit = Some(unit(line, "Value units", value)?),
            "xy units" | "lateral units" => self.lateral_unit = Some(unit(line, "XY units", value)?),
            _ => {}
        }
        Ok(())
    }

    /// Titles such as `x_um,y_um,z_nm` or `X [um]  Y [um]  Z [nm]`.
    fn titles(&mut self, text: &str, line: usize) -> Result<bool, ReadError> {
        let joined = text.replace(" [", "_").replace(" (", "_");
        let titles: Vec<&str> = Delimiter::of(&joined).fields(&joined).take(4).collect();
        let [x, y, z] = titles[..] else { return Ok(false) };
        let is_title = |title: &str, name: char| {
            let mut chars = title.chars();
            chars.next().is_some_and(|c| c.eq_ignore_ascii_case(&name))
                && chars.next().is_none_or(|c| !c.is_alphanumeric())
        };
        if !(is_title(x, 'x') && is_title(y, 'y') && is_title(z, 'z')) {
            return Ok(false);
        }
        let named = |title: &str| title[1..].trim_matches(['_', '[', ']', '(', ')', ' ', '/']).to_owned();
        let (x, y, z) = (named(x), named(y), named(z));
        if x != y {
            let value = excerpt(&format!("{x} and {y}"));
            return Err(ReadError::Header { line, key: "unit of x and y", value, expected: "the same unit for both" });
        }
        if !x.is_empty() {
            self.lateral_unit = Some(unit(line, "unit of x and y", &x)?);
        }
        if !z.is_empty() {
            self.value_unit = Some(unit(line, "unit of z", &z)?);
        }
        Ok(true)
    }
}

/// A length with its unit, as `1.5 mm`, in metres.
fn length(line: usize, key: &'static str, value: &str) -> Result<f64, ReadError> {
    let refused = || ReadError::Header {
        line,
        key,
        value: excerpt(value),
        expected: "a positive length with its unit (m, cm, mm, um, nm, pm), for instance 1.5 mm",
    };
    let split = value.find(|c: char| c.is_alphabetic() && !matches!(c, 'e' | 'E')).ok_or_else(refused)?;
    let (amount, name) = value.split_at(split);
    let amount = number(amount.trim()).filter(|amount| *amount > 0.0).ok_or_else(refused)?;
    let unit: LengthUnit = name.parse().map_err(|_| refused())?;
    Ok(unit.to_metres(amount))
}

fn unit(line: usize, key: &'static str, value: &str) -> Result<LengthUnit, ReadError> {
    value.parse().map_err(|_| ReadError::Header { line, key, value: excerpt(value), expected: UNIT_NAMES })
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn column_titles_carry_units() {
        for titles in ["x_um,y_um,z_nm", "X [um]\tY [um]\tZ [nm]", "x (\u{b5}m); y (\u{b5}m); z (nm)"] {
            let read = header(&[titles]).unwrap();
            assert_eq!(read.lateral_unit, Some(LengthUnit::Micrometre), "{titles}");
            assert_eq!(read.value_unit, Some(LengthUnit::Nanometre), "{titles}");
        }
        let read = header(&["x y z"]).unwrap();
        assert_eq!((read.lateral_unit, read.value_unit), (None, None));
        assert!(!Header::default().take("1 2 3", 1).unwrap());
        assert!(!Header::default().take("xerox yes zero", 1).unwrap());
    }

    #[test]
    fn header_entries_that_mean_nothing_are_refused_with_line_and_value() {
        for (text, needle) in [
            ("# Width: wide", "wide"),
            ("# Width: -1 mm", "-1 mm"),
            ("# Height: 3", "\"3\""),
            ("# Value units: inch", "one of m"),
            ("x_um,y_mm,z_um", "um and mm"),
        ] {
            let message = header(&["# ok", text]).unwrap_err().to_string();
            assert!(message.starts_with("line 2: ") && message.contains(needle), "{message}");
        }
    }
}
