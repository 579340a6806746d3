//! Reads altitude maps from the formats that instruments write. The format is recognised by content, not by name.
//!
//! | format | recognised by | sizes and units |
//! |---|---|---|
//! | [`Matrix`](MapFormat::Matrix) text, also CSV | anything else | lines as `# Width: 1 mm`, `# Value units: m` (Gwyddion, in any language), `# x-length = 1e6` (SPIP), `Pixel size: 1 um`, or by option |
//! | Keyence CSV, as a matrix | `ImageDataCsv` above the data | in the header |
//! | Wyko ASCII, as a matrix | `Wyko ASCII Data File Format` | in the header |
//! | Zygo ASCII, as a matrix; Zygo XYZ, as points | `Zygo ASCII Data File`, `Zygo XYZ Data File` | in the header |
//! | [`Xyz`](MapFormat::Xyz) text, also CSV | three values on the first line of data | `# XY units: um`, `# Value units: um`, or titles `x_um,y_um,z_um`, or by option |
//! | [`Gsf`](MapFormat::Gsf), Gwyddion simple field | first line | in the header, where they are given |
//! | [`Npy`](MapFormat::Npy), NumPy array | `\x93NUMPY` | by option |
//! | [`Sdf`](MapFormat::Sdf), surface data file, text or binary | `aISO-`, `bISO-`, `aBCR-`, ... | metres |
//! | [`Sur`](MapFormat::Sur), Digital Surf, plain or compressed | `DIGITAL SURF`, `DSCOMPRESSED` | in the header |
//! | [`X3p`](MapFormat::X3p), XML 3-D surface | a zip archive | metres |
//!
//! Units of text are m, cm, mm, um, nm, pm, and in headers inches, mils, Angstrom and multiples such as 10 nm. Values
//! are separated by spaces, tabs, commas or semicolons. `NaN`, `BAD`, `---`, `***`, `No Data` and an empty field mark a
//! missing point. Delimiters that end all lines close their last field, tabs that begin all lines are an indentation,
//! and a line of as many tabs as rows have is a row of missing points. Other lines that begin with `#` or `%` are
//! comments, in UTF-8 or Latin-1, and so are lines above the data that name a value, such as `Operator: Anna`; both may
//! state sizes and units.
//!
//! The points of a line of a matrix follow each other along x, and the lines along y, as in instrument software. Points
//! x y z keep their axes. Only the heights kept by [`ReadOptions::crop`] and [`ReadOptions::decimation`] are held in
//! memory, except for points x y z, the archive of an X3P and the packed stream of a compressed `.sur`. Sizes stated by
//! a file are checked and memory is never reserved for them: memory grows with the heights that arrive.

mod bytes;
mod comma;
mod entries;
mod foreign;
mod gsf;
mod header;
mod keys;
mod lines;
mod matrix;
mod npy;
mod overridden;
mod scale;
mod scan;
mod sdf;
mod sur;
mod tables;
mod text;
mod utf16;
#[cfg(test)]
mod vendor_tests;
mod window;
mod wyko;
mod x3p;
mod x3p_index;
mod xyz;
mod zygo;

use std::io::{BufRead, BufReader, Cursor, Read};

pub(crate) use matrix::is_square;
use text::read_text;
use utf16::Utf16;
pub use window::{Crop, Decimation, DecimationMethod};

use crate::topography::{HeightMap, LengthUnit, ReadError};

/// Maximum number of comments stored.
const MAX_COMMENTS: usize = 100;
/// Maximum number of characters stored of each comment.
const MAX_COMMENT_CHARS: usize = 300;
/// Number of bytes from which the format is recognised.
const SIGNATURE_BYTES: usize = 64;
/// Packed data with more heights per packed byte than this are refused as a decompression bomb, if they have more than
/// [`HARMLESS_HEIGHTS`]. Measured heights have at least one bit of noise each, so a map takes at most 64 times its
/// file, or 8 MiB.
const MAX_HEIGHTS_PER_BYTE: u64 = 8;
/// Number of heights up to which packed data are not refused as a decompression bomb.
const HARMLESS_HEIGHTS: u64 = 1 << 20;

/// File format of a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MapFormat {
    /// A matrix of heights, as text.
    Matrix,
    /// Points x y z, as text.
    Xyz,
    /// Gwyddion simple field.
    Gsf,
    /// NumPy array.
    Npy,
    /// Surface data file, ISO 25178-71.
    Sdf,
    /// Digital Surf.
    Sur,
    /// XML 3-D surface, ISO 25178-72.
    X3p,
}

slipgrid_base::names!(MapFormat {
    Matrix = "matrix",
    Xyz = "xyz",
    Gsf = "Gwyddion simple field (.gsf)",
    Npy = "NumPy array (.npy)",
    Sdf = "surface data file (.sdf)",
    Sur = "Digital Surf surface (.sur)",
    X3p = "XML 3-D surface (.x3p)",
});

/// Options for reading a map file; values given here take precedence over the header of the file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// The format; `None` recognises it by content: titles x, y, z mean points, a header with width or height means a
    /// matrix, otherwise three values on the first line of data mean points.
    pub format: Option<MapFormat>,
    /// Pixel sides of the file along x (between the points of a line) and along y (between lines), in metres.
    pub pixel_m: Option<[f64; 2]>,
    /// Unit of the heights.
    pub height_unit: Option<LengthUnit>,
    /// Unit of the points' x and y, or of the header's sides.
    pub lateral_unit: Option<LengthUnit>,
    /// Whether text has decimal commas, `1,5`; need not be set if no other reading is possible.
    pub decimal_comma: bool,
    /// Part of the grid to keep; `None` keeps the whole grid.
    pub crop: Option<Crop>,
    /// Reduction of blocks of pixels to one pixel after cropping; `None` keeps every pixel.
    pub decimation: Option<Decimation>,
}

impl ReadOptions {
    /// Distances between lines and between the points of a line, in metres; `None` if not given by the caller.
    pub(crate) fn grid_m(&self) -> Option<[f64; 2]> {
        self.pixel_m.map(|[x_m, y_m]| [y_m, x_m])
    }
}

/// A map as read, with information on the file.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadMap {
    /// The map, missing points NaN.
    pub map: HeightMap,
    /// Whether every pixel of the file is in the map: nothing was cropped, and decimation left no row or column over.
    pub whole: bool,
    /// Format recognised or given.
    pub format: MapFormat,
    /// The first comment lines, without their comment mark, and other texts of the header.
    pub comments: Vec<String>,
    /// Notes for the user on how the file was interpreted.
    pub notes: Vec<String>,
}

impl ReadMap {
    /// Whether the file states that the surface is synthetic.
    pub fn is_synthetic(&self) -> bool {
        self.comments.iter().any(|comment| comment.to_ascii_lowercase().contains("synthetic"))
    }
}

/// Reads a height map in the format given by `options`, or else in the format recognised by content.
///
/// # Errors
/// [`ReadError`] names the line or entry and the value that cannot be understood, or the missing quantity.
pub fn read_map(mut source: impl BufRead, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let mut start = Vec::with_capacity(SIGNATURE_BYTES);
    (&mut source).take(SIGNATURE_BYTES as u64).read_to_end(&mut start).map_err(|error| ReadError::source(1, &error))?;
    let format = match options.format {
        Some(format) => Some(format),
        None => format_of(&start)?,
    };
    let order = utf16::order_of(&start);
    let source = Cursor::new(start).chain(source);
    match format {
        None | Some(MapFormat::Matrix | MapFormat::Xyz) => match order {
            Some(order) => read_text(BufReader::new(Utf16::new(source, order)), options),
            None => read_text(source, options),
        },
        Some(MapFormat::Gsf) => gsf::read(source, options),
        Some(MapFormat::Npy) => npy::read(source, options),
        Some(MapFormat::Sdf) => sdf::read(source, options),
        Some(MapFormat::Sur) => sur::read(source, options),
        Some(MapFormat::X3p) => x3p::read(source, options),
    }
}

/// Recognises the format of a file that begins with `start`; `None` stands for text.
fn format_of(start: &[u8]) -> Result<Option<MapFormat>, ReadError> {
    let begins = |magic: &[u8]| start.starts_with(magic);
    let format = if begins(gsf::MAGIC) {
        MapFormat::Gsf
    } else if begins(npy::MAGIC) {
        MapFormat::Npy
    } else if sdf::is_sdf(start) {
        MapFormat::Sdf
    } else if begins(sur::MAGIC_PLAIN) || begins(sur::MAGIC_COMPRESSED) {
        MapFormat::Sur
    } else if begins(x3p::MAGIC) {
        MapFormat::X3p
    } else if utf16::order_of(start).is_some() {
        return Ok(None);
    } else if let Some(foreign) = foreign::of(start) {
        return Err(foreign);
    } else if start.iter().any(|&byte| byte < 9) {
        // No text contains such bytes.
        return Err(ReadError::Refused(format!(
            "the file begins with \"{}\": expected text, .gsf, .npy, .sdf, .sur or .x3p (export one of these)",
            start[..start.len().min(16)].escape_ascii()
        )));
    } else {
        return Ok(None);
    };
    Ok(Some(format))
}

/// Stores a comment, unless [`MAX_COMMENTS`] are stored, cut to [`MAX_COMMENT_CHARS`].
fn keep_comment(comments: &mut Vec<String>, comment: &str) {
    if comments.len() < MAX_COMMENTS && !comment.is_empty() {
        comments.push(comment.chars().take(MAX_COMMENT_CHARS).collect());
    }
}

/// Refuses `packed` bytes that expand to far more heights than measured data do; a height takes `bytes_each` bytes.
fn check_expansion(format: &'static str, heights: u64, bytes_each: u64, packed: u64) -> Result<(), ReadError> {
    if heights > HARMLESS_HEIGHTS && heights / MAX_HEIGHTS_PER_BYTE > packed {
        return Err(bomb(format, heights.saturating_mul(bytes_each), packed, MAX_HEIGHTS_PER_BYTE * bytes_each));
    }
    Ok(())
}

/// Error for data that expand from `packed` to `unpacked` bytes, by more than the factor `most`.
fn bomb(format: &'static str, unpacked: u64, packed: u64, most: u64) -> ReadError {
    ReadError::Refused(format!(
        "{format}: what is packed in {packed} bytes unpacks to {unpacked} bytes: expected at most {most} times as many"
    ))
}

/// Nothing is known, and the whole map is wanted; the default, for constants of tests.
#[cfg(test)]
const NONE: ReadOptions = ReadOptions {
    format: None,
    pixel_m: None,
    height_unit: None,
    lateral_unit: None,
    decimal_comma: false,
    crop: None,
    decimation: None,
};

/// Options of most tests: heights in micrometres on pixels of one micrometre.
#[cfg(test)]
const GIVEN: ReadOptions = ReadOptions {
    pixel_m: Some([1e-6; 2]),
    height_unit: Some(LengthUnit::Micrometre),
    lateral_unit: Some(LengthUnit::Micrometre),
    ..NONE
};

/// Readings of files without any option, for tests.
#[cfg(test)]
mod plainly {
    use super::{MapFormat, ReadMap, ReadOptions, read_map};

    pub(super) fn read(bytes: impl AsRef<[u8]>) -> ReadMap {
        read_map(bytes.as_ref(), &ReadOptions::default()).unwrap()
    }

    /// The message with which `bytes` are refused.
    pub(super) fn refused(bytes: impl AsRef<[u8]>) -> String {
        read_map(bytes.as_ref(), &ReadOptions::default()).unwrap_err().to_string()
    }

    /// Asserts that `bytes` are in `format` and hold a map of 3 x 2 points with pixel sides `pixel_m`, one point
    /// missing, and these heights, all in metres.
    pub(super) fn check(
        bytes: &[u8],
        format: MapFormat,
        pixel_m: [f64; 2],
        heights_m: [f64; 6],
        within_m: f64,
    ) -> ReadMap {
        let read = read(bytes);
        let map = &read.map;
        assert_eq!((read.format, map.rows(), map.cols(), map.missing()), (format, 3, 2, 1));
        assert_eq!([map.dx_m(), map.dy_m()], pixel_m);
        for (found, expected) in map.heights_m().iter().zip(heights_m) {
            assert!(found.is_nan() && expected.is_nan() || (found - expected).abs() < within_m, "{found} {expected}");
        }
        read
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UM: Option<LengthUnit> = Some(LengthUnit::Micrometre);

    fn read(text: &str) -> Result<ReadMap, ReadError> {
        read_map(text.as_bytes(), &ReadOptions::default())
    }

    /// The error message for `text`, read as micrometres on pixels of one micrometre.
    fn refused(text: &str) -> String {
        read_map(text.as_bytes(), &GIVEN).unwrap_err().to_string()
    }

    #[test]
    fn a_matrix_with_units_in_its_header() {
        let text =
            "# Channel: Z\n# Rows: 2\n# Width: 3 \u{b5}m\n# Height: 4 um\n# Value units: nm\n1\t2\tNaN\n4\tBAD\t---\n";
        let read = read(text).unwrap();
        assert_eq!(read.format, MapFormat::Matrix);
        let map = &read.map;
        assert_eq!((map.rows(), map.cols(), map.dx_m(), map.dy_m()), (3, 2, 1e-6, 2e-6));
        assert_eq!(map.heights_m()[..2], [1e-9, 4e-9]);
        assert_eq!((map.heights_m()[2], map.missing()), (2e-9, 3));
        assert!(!read.is_synthetic());
    }

    #[test]
    fn a_matrix_with_the_header_of_spip() {
        let text = "# File Format = ASCII\r\n# Created by SPIP 6.7 2015-03-02 10:11\r\n# x-pixels = 3\r\n\
                    # y-pixels = 2\r\n# x-length = 6000\r\n# y-length = 2000\r\n# Bit2nm = 0.5\r\n\
                    # voidpixels = 0\r\n# Start of Data:\r\n1\t2\t3\r\n4\t5\tNaN\r\n";
        let found = read(text).unwrap();
        let map = &found.map;
        assert_eq!((found.format, map.rows(), map.cols(), map.missing()), (MapFormat::Matrix, 3, 2, 1));
        assert!((map.dx_m() - 2e-6).abs() < 1e-20 && (map.dy_m() - 1e-6).abs() < 1e-20);
        assert!((map.heights_m()[3] - 2.5e-9).abs() < 1e-24);
        // A unit has precedence over a factor.
        let with_unit = text.replace("# Start", "# z-unit = um\r\n# Start");
        assert!((read(&with_unit).unwrap().map.heights_m()[3] - 5e-6).abs() < 1e-21);
        let refused = |from: &str, to: &str| read(&text.replace(from, to)).unwrap_err().to_string();
        assert_eq!(refused("x-pixels = 3", "x-pixels = 4"), "line 10: 3 values: expected 4");
        assert!(refused("y-pixels = 2", "y-pixels = 3").contains("rows end after 2 of 3"));
        assert!(refused("y-pixels = 2", "y-pixels = 99999999999").contains("after 2 of"));
    }

    #[test]
    fn a_plain_matrix_needs_pixel_and_unit_from_the_caller() {
        let text = "1, 2, 3, 4\n5, 6, 7, 8\n";
        assert!(read(text).unwrap_err().to_string().contains("unit of the heights"));
        let unit_only = ReadOptions { height_unit: UM, ..ReadOptions::default() };
        assert!(read_map(text.as_bytes(), &unit_only).unwrap_err().to_string().contains("pixel size"));
        let given = ReadOptions { pixel_m: Some([2e-6, 3e-6]), ..unit_only };
        let map = read_map(text.as_bytes(), &given).unwrap().map;
        assert_eq!((map.rows(), map.cols(), map.dx_m(), map.dy_m()), (4, 2, 2e-6, 3e-6));
        assert_eq!(map.heights_m()[7], 8e-6);
    }

    #[test]
    fn points_in_any_order_with_gaps_and_rounded_coordinates() {
        // 3 x 4 points, steps 1.953125 and 0.5, coordinates rounded to two digits, one point absent, one BAD.
        let (mut text, mut points) = (String::from("# a comment\nx_um;y_um;z_nm\n"), Vec::new());
        for i in 0..3 {
            for j in 0..4 {
                let z = if (i, j) == (2, 1) { "BAD".to_owned() } else { format!("{}", 10 * i + j) };
                points.push(format!("{:.2};{:.2};{z}\n", 10.0 + 1.953125 * f64::from(i), 0.5 * f64::from(j)));
            }
        }
        points.remove(5);
        points.reverse();
        points.iter().for_each(|point| text.push_str(point));
        let read = read(&text).unwrap();
        let map = &read.map;
        assert_eq!((read.format, map.rows(), map.cols(), map.missing()), (MapFormat::Xyz, 3, 4, 2));
        assert!((map.dx_m() / 1.953125e-6 - 1.0).abs() < 2e-3 && (map.dy_m() - 0.5e-6).abs() < 1e-18);
        assert_eq!((map.heights_m()[0], map.heights_m()[11]), (0.0, 23e-9));
    }

    #[test]
    fn rounded_steps_do_not_add_up_over_a_long_row() {
        let mut text = String::from("# XY units: um\n# Value units: um\n");
        for i in 0..512 {
            text.push_str(&format!("{:.2} 0 1\n{:.2} 1 2\n", 1.953125 * f64::from(i), 1.953125 * f64::from(i)));
        }
        let map = read(&text).unwrap().map;
        assert_eq!((map.rows(), map.cols(), map.missing()), (512, 2, 0));
        assert!((map.dx_m() / 1.953125e-6 - 1.0).abs() < 1e-5);
    }

    #[test]
    fn a_matrix_of_three_columns_can_be_forced_or_sized() {
        let options = ReadOptions { format: Some(MapFormat::Matrix), ..GIVEN };
        let map = read_map("1 2 3\n4 5 6\n".as_bytes(), &options).unwrap().map;
        assert_eq!((map.rows(), map.cols()), (3, 2));
    }

    #[test]
    fn errors_name_line_value_and_what_would_do() {
        let bad = refused("1 2 3 4\n1 2 x7 4\n");
        assert!(bad.starts_with("line 2, column 3: \"x7\"") && bad.contains("decimal point"), "{bad}");
        assert!(refused("1,500;2,500;3;4\n").starts_with("line 1, column 1: \"1,500\""));
        assert_eq!(refused("1 2 3 4\n\n1 2 3\n"), "line 3: 3 values: expected 4");
        assert!(refused("0 0 1\n0 1 1\n1 0 1\n1 1\n").starts_with("line 4: 2 values: expected 3"));
        assert!(refused("0 0 1\n0 1 1\n1 0 1\n0 1 5\n").contains("line 4: x = 0, y = 1 was given on line 2"));
        assert!(refused("0 0 1\n0 1 1\n0 2 1\n").contains("all points have x = 0"));
        assert!(refused("0 0 1\n1 0 1\n2.45 0 1\n0 1 1\n4 1 1\n").contains("line 3: x = 2.45"));
        assert!(refused("0 nan 1\n").contains("column 2: \"nan\""));
        assert!(refused("").contains("no data after 0 lines"));
        assert!(refused("# only\n").contains("no data after 1 lines"));
        assert!(refused("1 2 3 4\n").contains("1 rows and 4 columns"));
        assert!(refused("nan nan nan nan\nnan nan nan nan\n").contains("all 8 points are missing"));
        let great = refused("1 2 3 1e98\n1 2 1.0e99 4\n");
        assert_eq!(great, "line 2, column 3: \"1.0e99\": expected a height within 1e3 m, or NaN");
        let great = refused("0 0 1\n0 1 1\n1 0 1\n1 1 -1e30\n");
        assert_eq!(great, "line 4, column 3: \"-1e30\": expected a height within 1e3 m, or NaN");
    }

    #[test]
    fn hostile_coordinates_make_no_huge_grid() {
        assert!(refused("0 0 1\n0.001 0.001 1\n1000 1000 1\n").contains("3 points on a grid of"));
        assert!(refused("-1e308 0 1\n1e308 1 1\n0 0.5 1\n").contains("expected"));
        assert!(refused("0 0 1\n5e-324 5e-324 1\n1 1 1\n").contains("expected"));
    }
}
