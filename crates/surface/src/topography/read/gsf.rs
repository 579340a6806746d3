//! Gwyddion simple field (`.gsf`, version 1.0): a text header of lines `name = value`, zeros up to a multiple of four
//! bytes, then 32-bit floats, row by row. Lengths are in base units (the format has no prefixes); a side that is not
//! given is 1. Missing points are NaN.

use std::io::Read;

use super::bytes::{Number, at_end, exact, header_too_long, numbers};
use super::entries::Entry;
use super::overridden::Lengths;
use super::window::Window;
use super::{MapFormat, ReadMap, ReadOptions, keep_comment};
use crate::topography::unit::unit_names;
use crate::topography::{LengthUnit, MapOption, NotGiven, ReadError};

/// First line of the file.
pub(super) const MAGIC: &[u8] = b"Gwyddion Simple Field 1.0\n";
const FORMAT: &str = MapFormat::Gsf.name();
/// Longest header: titles and notes take a few lines.
const MAX_HEADER_BYTES: usize = 1 << 16;

#[derive(Default)]
struct Header {
    pixels: [Option<u64>; 2],
    side: [Option<f64>; 2],
    lateral_unit: Option<LengthUnit>,
    height_unit: Option<LengthUnit>,
}

pub(super) fn read(mut source: impl Read, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let text = header_text(&mut source)?;
    let (mut header, mut comments) = (Header::default(), Vec::new());
    for line in text.lines().skip(1) {
        let Some((key, value)) = line.split_once('=') else { continue };
        let (key, value) = (key.trim(), value.trim());
        keep_comment(&mut comments, &format!("{key}: {value}"));
        let entry = |name| Entry::new(FORMAT, name, value);
        let side = |name| entry(name).number(|side| side > 0.0, "a length above 0").map(Some);
        let unit = |name| match value {
            "" => Ok(None),
            unit => unit.parse().map(Some).map_err(|_| entry(name).refused("a unit of length, for instance m")),
        };
        match key {
            "XRes" => header.pixels[1] = Some(entry("XRes").count()?),
            "YRes" => header.pixels[0] = Some(entry("YRes").count()?),
            "XReal" => header.side[1] = side("XReal")?,
            "YReal" => header.side[0] = side("YReal")?,
            "XYUnits" => header.lateral_unit = unit("XYUnits")?,
            "ZUnits" => header.height_unit = unit("ZUnits")?,
            _ => {}
        }
    }
    let missing = |name| Entry::new(FORMAT, name, "").refused("the number of pixels, a whole number from 1 up");
    let rows = header.pixels[0].ok_or_else(|| missing("YRes"))?;
    let cols = header.pixels[1].ok_or_else(|| missing("XRes"))?;
    let Header { side, lateral_unit, height_unit, .. } = header;
    let no_height = options.height_unit.or(height_unit).is_none().then_some(NotGiven {
        what: "unit of the heights",
        expected: concat!("ZUnits in the header, or a unit by option: ", unit_names!()),
        option: MapOption::HeightUnit,
    });
    let no_side = (options.pixel_m.is_none() && options.lateral_unit.or(lateral_unit).is_none()).then_some(NotGiven {
        what: "unit of the sides",
        expected: "XYUnits in the header, or a unit or a pixel size by option",
        option: MapOption::LateralUnit,
    });
    let missing: Vec<NotGiven> = no_height.into_iter().chain(no_side).collect();
    if !missing.is_empty() {
        return Err(ReadError::NotGiven { missing });
    }
    let mut window = Window::new(Some(rows), cols, options.crop, options.decimation)?;
    // The window has checked both counts, so the product fits.
    let points = rows.saturating_mul(cols);
    if numbers(&mut source, FORMAT, (Number::F32, false), points, &mut window, Ok)? {
        at_end(&mut source, FORMAT)?;
    }
    let steps = [(1, cols), (0, rows)].map(|(axis, pixels)| side[axis].unwrap_or(1.0) / pixels as f64);
    Lengths { steps, lateral_unit, height_unit }.map(window, |height| height, options, MapFormat::Gsf, comments)
}

/// Reads the header up to and including its padding of zeros.
fn header_text(source: &mut impl Read) -> Result<String, ReadError> {
    let mut bytes = Vec::new();
    loop {
        // One to four zeros pad the header to a multiple of four bytes.
        let group: [u8; 4] = exact(source, FORMAT, "header")?;
        let text = group.iter().position(|&byte| byte == 0).unwrap_or(4);
        if group[text..].iter().any(|&byte| byte != 0) {
            let expected = "zeros from the header's end to a multiple of four bytes";
            return Err(Entry { format: FORMAT, name: "padding", text: &format!("{group:?}") }.refused(expected));
        }
        bytes.extend_from_slice(&group[..text]);
        if text < 4 {
            return Ok(String::from_utf8_lossy(&bytes).into_owned());
        }
        if bytes.len() > MAX_HEADER_BYTES {
            return Err(header_too_long(FORMAT, MAX_HEADER_BYTES));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{GIVEN, plainly};
    use super::*;
    use crate::topography::read_map;

    /// A file of 2 x 3 heights with `extra` header lines.
    fn file(extra: &str) -> Vec<u8> {
        let mut bytes = format!("Gwyddion Simple Field 1.0\nXRes = 3\nYRes=2\n{extra}").into_bytes();
        bytes.resize(bytes.len() + 4 - bytes.len() % 4, 0);
        for height in [1.0_f32, 2.0, 3.0, f32::NAN, -5.0, 6.0] {
            bytes.extend_from_slice(&height.to_le_bytes());
        }
        bytes
    }

    #[test]
    fn sides_units_and_every_length_of_padding() {
        for title in ["", "T", "Ti", "Tit"] {
            let extra = format!("XReal = 3e-6\nYReal = 4e-6\nXYUnits = m\nZUnits = nm\nTitle = {title}\n");
            let read = plainly::read(file(&extra));
            assert_eq!(read.format, MapFormat::Gsf);
            let map = &read.map;
            assert_eq!((map.rows(), map.cols(), map.missing()), (3, 2, 1));
            assert!((map.dx_m() - 1e-6).abs() < 1e-20 && (map.dy_m() - 2e-6).abs() < 1e-20);
            assert_eq!((map.heights_m()[2], map.heights_m()[3]), (2e-9, -5e-9));
            assert!(read.comments.contains(&format!("Title: {title}")));
        }
    }

    #[test]
    fn what_the_header_does_not_say_must_be_given() {
        let refused = |extra: &str| plainly::refused(file(extra));
        assert!(refused("").contains("unit of the heights"));
        assert!(refused("ZUnits = V\n").contains("\"V\""));
        assert!(refused("ZUnits = m\n").contains("unit of the sides"));
        assert!(refused("ZUnits = m\nXReal = -1\n").contains("XReal"));
        let given = ReadOptions { lateral_unit: None, ..GIVEN };
        assert_eq!(read_map(&file("")[..], &given).unwrap().map.heights_m()[5], 6e-6);
        let longer = [file(""), vec![0]].concat();
        assert!(read_map(&longer[..], &given).unwrap_err().to_string().contains("go on behind"));
    }
}
