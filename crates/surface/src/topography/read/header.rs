//! Header lines above the data: sizes, units, titles.

use super::entries::{length, nanometres, positive, refused, rounding, stated_length, unit, whole};
use super::keep_comment;
use super::keys::{Key, states_scale};
use super::lines::{Delimiter, excerpt, height, number};
use super::scale::Scale;
use crate::topography::{LengthUnit, ReadError};

/// Number of unused header lines that are quoted; further ones are only counted.
const MAX_NAMED: usize = 4;

/// Values found in the header of a map file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Header {
    /// Extents of the map along x, which is along a line of heights, and along y, across the lines, in metres.
    pub(super) sides_m: [Option<f64>; 2],
    /// Both extents of a square scan, in metres.
    side_m: Option<f64>,
    /// Sides of a pixel along x and y, in metres.
    pub(super) pixel_m: [Option<f64>; 2],
    /// Relative rounding errors of the map's extents along x and y as written in the header.
    pub(super) rounding: [f64; 2],
    value_unit: Option<Scale>,
    /// Length that a height value of 1 represents, used if no unit is stated.
    value_factor: Option<Scale>,
    pub(super) lateral: Option<Scale>,
    /// Whether the header has the line `File Format = ASCII` of SPIP; other programs use the same words with other
    /// units.
    spip: bool,
    /// Whether the file is a CSV export of a Keyence microscope.
    pub(super) keyence: bool,
    /// Whether column titles x, y and z were found.
    pub(super) titled: bool,
    /// Number of lines of the matrix, and number of values on each line.
    pub(super) pixels: [Option<u64>; 2],
    /// Comment lines without their comment mark.
    pub(super) comments: Vec<String>,
    /// Lengths without unit, until the unit of x and y is known: key, length, line number and header word.
    unitless: Vec<(Key, f64, usize, String)>,
    /// Comments with a comma that may be decimal or a thousands separator: text, line number, and error if it is not
    /// decimal.
    ambiguous: Vec<(String, usize, ReadError)>,
    /// Unused lines that state a unit or a scale: line number and text.
    unused: Vec<(usize, String)>,
    /// Words whose values are used, their values, and line numbers.
    stated: Vec<(String, String, usize)>,
}

impl Header {
    /// Reads `text` if it is a header line, that is a comment or the titles of columns x, y, z; returns whether it is.
    pub(crate) fn take(&mut self, text: &str, line: usize) -> Result<bool, ReadError> {
        if let Some(comment) = text.strip_prefix(['#', '%']) {
            self.comment(comment.trim(), line)?;
            return Ok(true);
        }
        Ok(self.titles(text, line)? || self.units_below_titles(text, line)?)
    }

    /// Reads a line above the data without comment mark that names a value, such as `Operator: Anna`. Programs write
    /// arbitrary words there, so a value that cannot be understood is not an error.
    pub(super) fn read_unmarked(&mut self, text: &str, line: usize) {
        if self.comment(text, line).is_err() {
            self.record_unused(text, line);
        }
    }

    /// Reads a comment.
    fn comment(&mut self, comment: &str, line: usize) -> Result<(), ReadError> {
        keep_comment(&mut self.comments, comment);
        self.entries(comment, line).or_else(|error| match &error {
            ReadError::Header { value, .. } if value.contains(',') => {
                self.ambiguous.push((comment.to_owned(), line, error));
                Ok(())
            }
            _ => Err(error),
        })
    }

    /// Reads the entries of a line: one, or several as in `h=48 w=64`.
    fn entries(&mut self, comment: &str, line: usize) -> Result<(), ReadError> {
        let words: Vec<&str> = comment.split_whitespace().collect();
        if words.len() > 1 && words.iter().all(|word| word.split_once('=').is_some_and(|(key, _)| !key.is_empty())) {
            return words.into_iter().try_for_each(|word| self.entry(word, line));
        }
        self.entry(comment, line)
    }

    fn entry(&mut self, text: &str, line: usize) -> Result<(), ReadError> {
        let Some((word, value)) = entry(text) else { return Ok(()) };
        // `Width [um]: 640` and `height conversion factor (-> m)=6.3e-8` give the unit next to the word.
        let (word, value) = match word.strip_suffix([')', ']']).and_then(|word| word.rsplit_once(['(', '['])) {
            Some((word, unit)) => (word.trim(), format!("{value} {}", unit.trim_start_matches("->").trim())),
            None => (word, value),
        };
        let spip = word.to_ascii_lowercase();
        if spip == "file format" {
            self.spip = value.eq_ignore_ascii_case("ascii");
        } else if self.spip && self.spip_entry(&spip, &value, line)? {
            return self.record_stated(word, value, line);
        }
        let Some(key) = Key::of(word) else {
            if states_scale(word, &value, Scale::parse(&value).is_some()) {
                self.record_unused(text, line);
            }
            return Ok(());
        };
        let is_count = matches!(key, Key::Cols | Key::Rows);
        if !self.set(key, word, &value, line)? {
            self.record_unused(text, line);
        } else if !is_count || value.parse::<usize>().is_ok_and(|count| count > 0) {
            self.record_stated(word, value, line)?;
        }
        Ok(())
    }

    /// Records a word whose value is used. Refuses one that an earlier line states with another value: which of both
    /// holds is not known.
    fn record_stated(&mut self, word: &str, value: String, line: usize) -> Result<(), ReadError> {
        match self.stated.iter().find(|(known, ..)| known.eq_ignore_ascii_case(word)) {
            Some((_, earlier, earlier_line)) if *earlier != value => Err(ReadError::Refused(format!(
                "line {line}: {} is \"{}\", and was \"{}\" on line {earlier_line}: expected one value",
                excerpt(word),
                excerpt(&value),
                excerpt(earlier)
            ))),
            _ => {
                self.stated.push((word.to_owned(), value, line));
                Ok(())
            }
        }
    }

    /// Stores the value of `key`, written as `word`; returns whether the entry was used.
    fn set(&mut self, key: Key, word: &str, value: &str, line: usize) -> Result<bool, ReadError> {
        let name = key.name();
        // Other programs use these words for other values too; only positive whole numbers are counts.
        let count = || value.parse().ok().filter(|count| *count > 0);
        match key {
            Key::Width | Key::Height => {
                if let Some(length) = number(value).filter(|_| word.contains('-')) {
                    self.unitless.push((key, length, line, word.to_owned()));
                    return Ok(true);
                }
                let axis = usize::from(key == Key::Height);
                self.sides_m[axis] = Some(length(line, name, value)?);
                self.rounding[axis] = rounding(value);
            }
            Key::Side => self.side_m = Some(length(line, name, value)?),
            Key::Cols => self.pixels[1] = count().or(self.pixels[1]),
            Key::Rows => self.pixels[0] = count().or(self.pixels[0]),
            Key::Pixel | Key::PixelX | Key::PixelY => match (stated_length(value), number(value)) {
                (Some(length), _) => self.set_pixel(key, length.to_metres(1.0)),
                (None, Some(length)) => self.unitless.push((key, length, line, word.to_owned())),
                (None, None) => return Ok(false),
            },
            Key::HeightUnit => self.value_unit = Some(unit(line, name, value)?),
            Key::DataUnit => {
                let unit = Scale::parse(value);
                self.value_unit = unit.or(self.value_unit);
                // Radians become heights by a conversion factor.
                return Ok(unit.is_some() || value.eq_ignore_ascii_case("rad"));
            }
            Key::HeightFactor => {
                let factor = Scale::parse(value);
                self.value_factor = factor.or(self.value_factor);
                return Ok(factor.is_some() || number(value) == Some(1.0));
            }
            Key::LateralUnit => self.lateral = Some(unit(line, name, value)?),
        }
        Ok(true)
    }

    /// Reads an entry of a SPIP header: lengths in nanometres; heights in their unit or, without unit, multiplied by
    /// Bit2nm. Returns whether it was used.
    fn spip_entry(&mut self, key: &str, value: &str, line: usize) -> Result<bool, ReadError> {
        match key {
            "x-pixels" => self.pixels[1] = Some(whole(line, "x-pixels", value)?),
            "y-pixels" => self.pixels[0] = Some(whole(line, "y-pixels", value)?),
            "x-length" => self.sides_m[0] = Some(nanometres(line, "x-length", value)?),
            "y-length" => self.sides_m[1] = Some(nanometres(line, "y-length", value)?),
            "z-unit" => self.value_unit = Some(unit(line, "z-unit", value)?),
            "bit2nm" => self.value_factor = Some(Scale::new(positive(line, "Bit2nm", value)?, LengthUnit::Nanometre)),
            "voidpixels" if value.parse() != Ok(0_u64) => {
                return Err(refused(line, "voidpixels", value, "0, with NaN for points that are missing"));
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Reads a line of a Keyence export, recognised by its form because its words can be in any language and encoding:
    /// a key and a length with unit is the pixel size, a key and a unit is the unit of heights, and the first whole
    /// numbers below the pixel size are the counts of columns and lines.
    pub(super) fn keyence_line(&mut self, text: &str) {
        let delimiter = Delimiter::of(text);
        let fields: Vec<&str> = delimiter.fields(text).collect();
        keep_comment(&mut self.comments, fields.join(" ").trim());
        let [word, values @ ..] = &fields[..] else { return };
        let value = values.join(" ");
        // Commas between semicolons are decimal commas.
        let value = if delimiter == Delimiter::Semicolon { value.replace(',', ".") } else { value };
        match (Scale::parse(&value), value.trim().parse()) {
            // The letters XY occur in all languages.
            (Some(pixel), _) if word.contains("XY") => self.set_pixel(Key::Pixel, pixel.to_metres(1.0)),
            (Some(unit), _) if !value.starts_with(|c: char| c.is_ascii_digit()) => self.value_unit = Some(unit),
            (None, Ok(count)) if self.pixel_m[0].is_some() && count > 0 => {
                let counted = usize::from(self.pixels[1].is_none());
                self.pixels[counted] = self.pixels[counted].or(Some(count));
            }
            _ => {}
        }
    }

    /// Decides open questions at the first line of data: commas in the header are decimal if those in the data are, and
    /// lengths without unit are in the unit of x and y.
    pub(super) fn resolve_open_entries(&mut self, has_decimal_commas: bool) -> Result<(), ReadError> {
        for (text, line, error) in std::mem::take(&mut self.ambiguous) {
            if !has_decimal_commas {
                return Err(error);
            }
            self.entries(&text.replace(',', "."), line)?;
        }
        for (key, length, line, word) in std::mem::take(&mut self.unitless) {
            match (self.lateral.filter(|_| length > 0.0).map(|lateral| lateral.to_metres(length)), key) {
                (None, _) => self.record_unused(&format!("{word}: {length}"), line),
                (Some(length_m), Key::Width) => self.sides_m[0] = Some(length_m),
                (Some(length_m), Key::Height) => self.sides_m[1] = Some(length_m),
                (Some(length_m), _) => self.set_pixel(key, length_m),
            }
        }
        Ok(())
    }

    /// Uses the steps of the axes along and across lines, in the unit of x and y, as pixel sides, if no size is given
    /// otherwise and the unit is known.
    pub(super) fn set_pixel_from_axes(&mut self, steps: [f64; 2], lateral: Option<Scale>) {
        if let Some(lateral) = lateral.or(self.lateral)
            && !self.is_sized()
        {
            self.pixel_m = steps.map(|step| Some(lateral.to_metres(step.abs())));
        }
    }

    fn set_pixel(&mut self, key: Key, length_m: f64) {
        for axis in 0..2 {
            if [Key::PixelY, Key::PixelX][axis] != key {
                self.pixel_m[axis] = Some(length_m);
            }
        }
    }

    /// Length that a height value of 1 represents; a unit has precedence over a factor. `None` if the header states
    /// neither.
    pub(super) fn value(&self) -> Option<Scale> {
        self.value_unit.or(self.value_factor)
    }

    /// Whether a size of the map or of its pixels is stated, as for a matrix.
    pub(super) fn is_sized(&self) -> bool {
        let mut lengths = self.sides_m.iter().chain(&self.pixel_m).chain([&self.side_m]);
        lengths.any(Option::is_some) || self.pixels[1].is_some() || !self.unitless.is_empty()
    }

    /// Whether the pixel size depends on the number of lines in the file.
    pub(super) fn shares_sides(&self) -> bool {
        self.pixel_m.contains(&None) && self.sides_m[1].or(self.side_m).is_some()
    }

    /// Distances between lines and between the points of a line, in metres, for a map of `rows` lines of `cols` points;
    /// `None` where the header does not give them.
    pub(super) fn grid_m(&self, rows: usize, cols: usize) -> [Option<f64>; 2] {
        // A single side length applies to both sides only if the counts of points are equal.
        let side_m = self.side_m.filter(|_| rows == cols);
        let share =
            |pixel_m: Option<f64>, side_m: Option<f64>, count| pixel_m.or(side_m.map(|side_m| side_m / count as f64));
        [
            share(self.pixel_m[1], self.sides_m[1].or(side_m), rows),
            share(self.pixel_m[0], self.sides_m[0].or(side_m), cols),
        ]
    }

    /// Whether `text`, below data, states a side of the map again, so that another map begins.
    pub(super) fn restates_side(&self, text: &str) -> bool {
        let key = text.strip_prefix(['#', '%']).and_then(entry).and_then(|(word, _)| Key::of(word));
        let is_known = |side: Key, side_m: Option<f64>| key == Some(side) && side_m.is_some();
        is_known(Key::Width, self.sides_m[0]) || is_known(Key::Height, self.sides_m[1])
    }

    /// Records an unused line that states a unit or a scale.
    fn record_unused(&mut self, text: &str, line: usize) {
        self.unused.push((line, excerpt(text)));
    }

    /// Notes on unused header lines.
    pub(super) fn notes(&self) -> Vec<String> {
        let named = self.unused.iter().take(MAX_NAMED);
        let more = self.unused.len().saturating_sub(MAX_NAMED);
        let named = named.map(|(line, text)| format!("line {line} of the header is not used: \"{text}\""));
        let more =
            (more > 0).then(|| format!("{more} more lines of the header that state units or lengths are not used"));
        named.chain(more).collect()
    }
    /// Reads column titles such as `x_um,y_um,z_nm`, `X [um]  Y [um]  Z [nm]` or `"X (mm)","Y (mm)","Height (um)"`.
    fn titles(&mut self, text: &str, line: usize) -> Result<bool, ReadError> {
        let joined = text.replace(" [", "_").replace(" (", "_");
        let titles: Vec<&str> = Delimiter::of(&joined).fields(&joined).take(4).collect();
        let [x, y, z] = titles[..] else { return Ok(false) };
        // First word of each title, and the rest.
        let parted = [x, y, z].map(|title| {
            let (word, rest) = title.split_at(title.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(title.len()));
            (word.to_ascii_lowercase().replace("height", "z"), rest)
        });
        let mut words: Vec<&str> = parted.iter().map(|(word, _)| &word[..]).collect();
        let in_order = words == ["x", "y", "z"];
        words.sort_unstable();
        if words != ["x", "y", "z"] {
            return Ok(false);
        }
        if !in_order {
            return Err(refused(line, "order of the columns", text, "x, y and z from left to right"));
        }
        self.titled = true;
        self.take_units(parted.each_ref().map(|(_, rest)| *rest), line)?;
        Ok(true)
    }

    /// Reads units on a line of their own below the titles, such as `um,um,nm` or `[um] [um] [nm]`.
    fn units_below_titles(&mut self, text: &str, line: usize) -> Result<bool, ReadError> {
        let cells: Vec<&str> = Delimiter::of(text).fields(text).take(4).collect();
        let [x, y, z] = cells[..] else { return Ok(false) };
        let is_row = self.titled && [x, y, z].iter().all(|cell| Scale::parse(without_brackets(cell)).is_some());
        if is_row {
            self.take_units([x, y, z], line)?;
        }
        Ok(is_row)
    }

    /// Stores the units of x, y and z; units that are not named stay unchanged.
    fn take_units(&mut self, cells: [&str; 3], line: usize) -> Result<(), ReadError> {
        let [x, y, z] = cells.map(without_brackets);
        if x != y {
            return Err(refused(line, "unit of x and y", &format!("{x} and {y}"), "the same unit for both"));
        }
        if !x.is_empty() {
            self.lateral = Some(unit(line, "unit of x and y", x)?);
        }
        if !z.is_empty() {
            self.value_unit = Some(unit(line, "unit of z", z)?);
        }
        Ok(())
    }
}

/// Removes brackets around a unit.
fn without_brackets(cell: &str) -> &str {
    cell.trim_matches(['_', '[', ']', '(', ')', ' ', '/'])
}

/// Expected form of lines above data without titles, for messages.
pub(super) const ABOVE_DATA: &str =
    "a number; lines above the data begin with #, or name a value, as \"Operator: Anna\"";

/// Whether a line names a value, such as `Operator: Anna` or `Gain = 20`.
pub(super) fn names_a_value(text: &str) -> bool {
    entry(text).is_some()
}

/// Splits a line that names a value into word and value: at a colon or `=`, or at a table's delimiter after a known
/// word.
fn entry(text: &str) -> Option<(&str, String)> {
    if let Some((word, value)) = text.split_once([':', '=', '\u{ff1a}'])
        && !word.contains([';', ',', '\t'])
    {
        return Some((word.trim(), value.trim().to_owned()));
    }
    let fields: Vec<&str> = Delimiter::of(text).fields(text).take(4).collect();
    let ([word, value] | [word, value, _]) = fields[..] else { return None };
    let joined = [value, fields.get(2).copied().unwrap_or_default()].join(" ").trim().to_owned();
    let is_entry = text.contains([';', ',', '\t']) && (Scale::parse(&joined).is_some() || number(&joined).is_some());
    (is_entry && Key::of(word).is_some()).then_some((word, joined))
}

/// Whether a line begins with a word other than those for a missing height.
pub(super) fn begins_with_a_word(text: &str) -> bool {
    let first = Delimiter::of(text).fields(text).next().unwrap_or_default();
    first.starts_with(char::is_alphabetic) && height(first).is_none()
}

#[cfg(test)]
mod tests;
