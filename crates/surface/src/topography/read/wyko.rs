//! Wyko ASCII (`.asc`), written by Vision: tab-separated entries, then blocks of heights, each line of which runs along
//! y. Heights are in nanometres, or in wavelengths divided by the entry `Mult`; `Bad` marks a missing point.

use std::io::BufRead;

use super::entries::Entry;
use super::lines::{Lines, expected_height, height, not_a_number};
use super::overridden::StatedValues;
use super::scale::Scale;
use super::window::{Crop, Window};
use super::{MapFormat, ReadMap, ReadOptions, keep_comment};
use crate::topography::{LengthUnit, ReadError};

/// Beginning of a file in this format.
pub(super) const MAGIC: &str = "Wyko ASCII Data File Format";
const FORMAT: &str = "Wyko ASCII";
/// Names of the blocks that hold heights.
const HEIGHT_BLOCKS: [&str; 4] = ["RAW_DATA", "RAW DATA", "SAMPLE_DATA", "OPD"];

/// Values of the entries above the heights.
#[derive(Default)]
struct Header {
    /// Number of points along x and along y.
    size: [Option<u64>; 2],
    pixel_mm: Option<f64>,
    /// Ratio of a pixel's side along y to that along x.
    aspect: Option<f64>,
    wavelength_nm: Option<f64>,
    mult: Option<f64>,
    comments: Vec<String>,
}

impl Header {
    /// Reads the file up to the heights.
    fn read(lines: &mut Lines<impl BufRead>) -> Result<Self, ReadError> {
        let mut header = Self::default();
        while let Some(text) = lines.next()? {
            let fields: Vec<&str> = text.split('\t').map(str::trim).collect();
            let (word, value) = (fields[0], fields.last().copied().unwrap_or_default());
            if HEIGHT_BLOCKS.contains(&word) {
                return Ok(header);
            }
            if !word.starts_with(char::is_alphabetic) || height(word).is_some() {
                continue;
            }
            keep_comment(&mut header.comments, &fields.join(" "));
            let positive =
                |name| Entry::new(FORMAT, name, value).number(|number| number > 0.0, "a number above 0").map(Some);
            let count = |name| Entry::new(FORMAT, name, value).count().map(Some);
            match word {
                "X Size" => header.size[0] = count("X Size")?,
                "Y Size" => header.size[1] = count("Y Size")?,
                "Pixel_size" => header.pixel_mm = positive("Pixel_size")?,
                "Aspect" => header.aspect = positive("Aspect")?,
                "Wavelength" => header.wavelength_nm = positive("Wavelength")?,
                "Mult" => header.mult = positive("Mult")?,
                _ => {}
            }
        }
        Err(Entry::new(FORMAT, "RAW_DATA", "").refused("a block of heights"))
    }

    /// Length that a height value of 1 represents; the second number after the format's name on the first line tells
    /// whether heights are in nanometres.
    fn scale(&self) -> Result<Scale, ReadError> {
        let flags = self.comments.first().and_then(|first| first.strip_prefix(MAGIC)).unwrap_or_default();
        if flags.split_whitespace().nth(1) == Some("1") {
            return Ok(LengthUnit::Nanometre.into());
        }
        let wavelength_nm =
            self.wavelength_nm.ok_or_else(|| Entry::new(FORMAT, "Wavelength", "").refused("a number of nanometres"))?;
        Ok(Scale::new(wavelength_nm / self.mult.unwrap_or(1.0), LengthUnit::Nanometre))
    }
}

pub(super) fn read(source: impl BufRead, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let mut lines = Lines::new(source);
    let header = Header::read(&mut lines)?;
    let [Some(along_x), Some(along_y)] = header.size else {
        return Err(
            Entry::new(FORMAT, "X Size and Y Size", "").refused("the numbers of points, whole numbers from 1 up")
        );
    };
    let own_m = header.pixel_mm.map(|pixel_mm| LengthUnit::Millimetre.to_metres(pixel_mm));
    let own_m = own_m.map(|pixel_m| [pixel_m, pixel_m * header.aspect.unwrap_or(1.0)]);
    let pixel_m = options.pixel_m.or(own_m).ok_or_else(|| {
        Entry::new(FORMAT, "Pixel_size", "").refused("a number of millimetres, or a pixel size by option")
    })?;
    let own = header.scale()?;
    let scale = options.height_unit.map_or(own, Scale::from);
    // Lines of the file run along y, lines of a crop along x.
    let mut window = Window::new(Some(along_x), along_y, options.crop.map(Crop::transposed), options.decimation)?;
    let (mut found, mut row) = (0, Vec::new());
    while found < along_x && !window.is_full() {
        let line = lines.line() + 1;
        let Some(text) = lines.next()? else {
            return Err(ReadError::Ended { format: FORMAT, what: "lines of heights", expected: along_x, found });
        };
        row.clear();
        for (place, field) in text.split_whitespace().enumerate() {
            let height = height(field).ok_or_else(|| not_a_number(line, place, field, expected_height(field)))?;
            row.push(height.unwrap_or(f64::NAN));
        }
        if row.len() as u64 != along_y {
            let expected = usize::try_from(along_y).unwrap_or(usize::MAX);
            return Err(ReadError::RowLength { line, found: row.len(), expected });
        }
        window.push(&row)?;
        found += 1;
    }
    let (map, whole) = window.finish(pixel_m, |height| scale.to_metres(height))?;
    let stated = StatedValues {
        pixel_m: own_m.map_or([None; 2], |sides_m| sides_m.map(Some)),
        height_unit: Some(own),
        lateral_unit: None,
    };
    let notes = stated.notes(options, MapFormat::Matrix);
    Ok(ReadMap { map, whole, format: MapFormat::Matrix, comments: header.comments, notes })
}

#[cfg(test)]
mod tests {
    use super::super::plainly;
    use crate::topography::{Crop, MapFormat, ReadOptions, read_map};

    fn text(is_nm: u8) -> String {
        format!(
            "Wyko ASCII Data File Format 0\t{is_nm}\t1\nX Size\t3\nY Size\t2\nBlock Name\tType\tLength\tValue\nTitle\t5\t20\tplate 3\n\
             Pixel_size\t7\t4\t0.002\nWavelength\t7\t4\t632.8\nMult\t6\t2\t2\nAspect\t7\t4\t1.5\nIntensity\t3\t24\t\n9\t9\n9\t9\n9\tBad\n\
             RAW_DATA\t3\t24\t\n1\t2\n3\tBad\n5\t6\n"
        )
    }

    #[test]
    fn lines_run_along_y_and_heights_are_nanometres_or_wavelengths() {
        for (is_nm, nm) in [(1, 1.0), (0, 316.4)] {
            let heights_m = [1.0, 2.0, 3.0, f64::NAN, 5.0, 6.0].map(|value| 1e-9 * nm * value);
            plainly::check(text(is_nm).as_bytes(), MapFormat::Matrix, [2e-6, 3e-6], heights_m, 1e-18);
        }
        // Rows of a crop run along y, as for other files.
        let crop = Some(Crop { first_row: 0, first_col: 1, rows: 2, cols: 2 });
        let part = read_map(text(1).as_bytes(), &ReadOptions { crop, ..ReadOptions::default() }).unwrap().map;
        assert_eq!((part.rows(), part.cols(), part.heights_m()[2]), (2, 2, 5e-9));
    }

    #[test]
    fn files_that_lie_or_are_cut_short_are_refused() {
        let refused = |from: &str, to: &str| plainly::refused(text(0).replace(from, to));
        assert!(refused("\n5\t6\n", "\n").contains("the lines of heights end after 2 of 3"));
        assert!(refused("\n5\t6", "\n5").contains("1 values: expected 2"));
        assert!(refused("\n5\t6", "\n5\tx").contains("column 2: \"x\""));
        assert!(refused("RAW_DATA", "Phase").contains("RAW_DATA"));
        assert!(refused("X Size\t3", "X Size\t-3").contains("X Size is \"-3\""));
        assert!(refused("Wavelength", "Wave").contains("Wavelength is"));
        assert!(refused("0.002", "0").contains("Pixel_size is \"0\""));
    }
}
