//! NumPy array (`.npy`, versions 1 to 3): a magic string, the length of the header, the header as a Python dictionary
//! of `descr`, `fortran_order` and `shape`, then the numbers. The second index runs along x, the first along y. The
//! file has no pixel size and no unit.

use std::io::Read;

use super::bytes::{Number, at_end, exact, header_too_long, next_bytes, numbers, unreadable};
use super::header::Header;
use super::lines::excerpt;
use super::matrix::MatrixReader;
use super::overridden::StatedValues;
use super::window::{Crop, Window};
use super::{MapFormat, ReadMap, ReadOptions};
use crate::topography::ReadError;

pub(super) const MAGIC: &[u8] = b"\x93NUMPY";
const FORMAT: &str = MapFormat::Npy.name();
/// Longest header; NumPy pads it to a multiple of 64 or 128 bytes.
const MAX_HEADER_BYTES: usize = 1 << 16;

pub(super) fn read(mut source: impl Read, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let start: [u8; 8] = exact(&mut source, FORMAT, "header")?;
    let length = match start[6] {
        1 => u32::from(u16::from_le_bytes(exact(&mut source, FORMAT, "header")?)),
        2 | 3 => u32::from_le_bytes(exact(&mut source, FORMAT, "header")?),
        version => return Err(refused("version", version.to_string(), "1, 2 or 3")),
    };
    if length as usize > MAX_HEADER_BYTES {
        return Err(header_too_long(FORMAT, MAX_HEADER_BYTES));
    }
    let header = next_bytes(&mut source, FORMAT, "header", length.into())?;
    let header = String::from_utf8(header).map_err(|error| unreadable(FORMAT, &error))?;
    let number = number(&header)?;
    let fortran_order = match entry(&header, "fortran_order") {
        Some(value) if value.starts_with("True") => true,
        Some(value) if value.starts_with("False") => false,
        other => return Err(refused("fortran_order", excerpt(other.unwrap_or_default()), "True or False")),
    };
    let [rows, cols] = shape(&header)?;

    let (Some(height_unit), Some(pixel_m)) = (options.height_unit, options.grid_m()) else {
        let missing = MatrixReader::missing(&Header::default(), options);
        return Err(ReadError::NotGiven { missing });
    };
    // An array stored by columns is the transposed array stored by rows.
    let (file, crop, pixel) = if fortran_order {
        ([cols, rows], options.crop.map(Crop::transposed), [pixel_m[1], pixel_m[0]])
    } else {
        ([rows, cols], options.crop, pixel_m)
    };
    let mut window = Window::new(Some(file[0]), file[1], crop, options.decimation)?;
    if numbers(&mut source, FORMAT, number, rows.saturating_mul(cols), &mut window, Ok)? {
        at_end(&mut source, FORMAT)?;
    }
    let to_metres = |height| height_unit.to_metres(height);
    // An array stored by columns already has the order of the map; one stored by rows is a file of lines.
    let (map, whole) =
        if fortran_order { window.finish(pixel, to_metres)? } else { window.finish_lines(pixel, to_metres)? };
    let notes = StatedValues::default().notes(options, MapFormat::Npy);
    Ok(ReadMap { map, whole, format: MapFormat::Npy, comments: Vec::new(), notes })
}

fn refused(field: &'static str, value: String, expected: &'static str) -> ReadError {
    ReadError::Field { format: FORMAT, field, value, expected }
}

/// Returns the text after `'key':` in the header.
fn entry<'h>(header: &'h str, key: &str) -> Option<&'h str> {
    ['\'', '"'].into_iter().find_map(|quote| {
        let (_, after) = header.split_once(&format!("{quote}{key}{quote}"))?;
        Some(after.trim_start().strip_prefix(':')?.trim_start())
    })
}

/// Storage type of the numbers, and whether they are big endian.
fn number(header: &str) -> Result<(Number, bool), ReadError> {
    let value = entry(header, "descr").unwrap_or_default();
    let name = value.trim_start_matches(['\'', '"']).split(['\'', '"']).next().unwrap_or_default();
    let expected = "a real number of 1 to 8 bytes, for instance <f8, <f4, <i2";
    let (order, kind) = match name.as_bytes().first() {
        Some(b'<' | b'|' | b'=') => (false, &name[1..]),
        Some(b'>') => (true, &name[1..]),
        _ => return Err(refused("descr", excerpt(value), expected)),
    };
    let number = match kind {
        "u1" => Number::U8,
        "i1" => Number::I8,
        "u2" => Number::U16,
        "i2" => Number::I16,
        "u4" => Number::U32,
        "i4" => Number::I32,
        "u8" => Number::U64,
        "i8" => Number::I64,
        "f4" => Number::F32,
        "f8" => Number::F64,
        _ => return Err(refused("descr", excerpt(value), expected)),
    };
    Ok((number, order))
}

/// Lengths of the array along its first and second index.
fn shape(header: &str) -> Result<[u64; 2], ReadError> {
    let value = entry(header, "shape").unwrap_or_default();
    let refuse = || refused("shape", excerpt(value), "two whole numbers, for instance (512, 512)");
    let inside = value.strip_prefix('(').and_then(|rest| rest.split_once(')')).ok_or_else(refuse)?.0;
    let counts: Vec<u64> = inside
        .trim_end_matches([',', ' '])
        .split(',')
        .take(3)
        .map(|count| count.trim().parse().ok().filter(|count| *count > 0))
        .collect::<Option<_>>()
        .ok_or_else(refuse)?;
    <[u64; 2]>::try_from(counts).map_err(|_| refuse())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topography::{LengthUnit, read_map};

    const GIVEN: ReadOptions = ReadOptions {
        pixel_m: Some([1e-6, 2e-6]),
        height_unit: Some(LengthUnit::Micrometre),
        ..crate::topography::read::NONE
    };

    fn file(version: u8, header: &str, data: &[u8]) -> Vec<u8> {
        let mut bytes = [MAGIC, &[version, 0]].concat();
        if version == 1 {
            bytes.extend_from_slice(&(header.len() as u16).to_le_bytes());
        } else {
            bytes.extend_from_slice(&(header.len() as u32).to_le_bytes());
        }
        [&bytes[..], header.as_bytes(), data].concat()
    }

    #[test]
    fn both_orders_and_byte_orders_give_the_same_map() {
        let rows: Vec<u8> = [1.0_f64, 2.0, 3.0, 4.0, 5.0, 6.0].into_iter().flat_map(f64::to_le_bytes).collect();
        let columns: Vec<u8> = [1_i16, 4, 2, 5, 3, 6].into_iter().flat_map(i16::to_be_bytes).collect();
        let plain = file(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 3), }\n", &rows);
        let fortran = file(2, "{\"shape\": (2,3), 'fortran_order':True, 'descr': '>i2'}", &columns);
        let plain = read_map(&plain[..], &GIVEN).unwrap().map;
        assert_eq!((plain.rows(), plain.cols(), plain.dx_m(), plain.dy_m()), (3, 2, 1e-6, 2e-6));
        assert_eq!(plain.heights_m()[1], 4e-6);
        assert_eq!(read_map(&fortran[..], &GIVEN).unwrap().map, plain);
        let crop = Some(Crop { first_row: 0, first_col: 1, rows: 2, cols: 2 });
        let cropped = read_map(&fortran[..], &ReadOptions { crop, ..GIVEN }).unwrap().map;
        assert_eq!(cropped.heights_m(), [2e-6, 5e-6, 3e-6, 6e-6]);
    }

    #[test]
    fn arrays_that_are_no_map_are_refused() {
        let refused = |header: &str| read_map(&file(1, header, &[0; 64])[..], &GIVEN).unwrap_err().to_string();
        let with = |descr: &str, shape: &str| {
            refused(&format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}}}"))
        };
        assert!(with("'<c16'", "(2, 2)").contains("<c16"));
        assert!(with("[('x', '<f8')]", "(2, 2)").contains("descr"));
        assert!(with("'<f8'", "(8,)").contains("(8,)"));
        assert!(with("'<f8'", "(2, 2, 2)").contains("shape"));
        assert!(with("'<f8'", "(2, -2)").contains("shape"));
        assert!(with("'<f8'", "(99999999999999999, 99999999999)").contains("expected at most"));
        assert!(refused("{}").contains("descr"));
        let bare = read_map(
            &file(1, "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2)}", &[0; 32])[..],
            &ReadOptions::default(),
        );
        assert!(bare.unwrap_err().to_string().contains("unit of the heights"));
    }
}
