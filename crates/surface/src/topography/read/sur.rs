//! Digital Surf surface (`.sur`, version 1): a header of 512 bytes, a comment, a private zone, then 16 or 32-bit
//! integers line by line, plain (`DIGITAL SURF`) or in zlib streams (`DSCOMPRESSED`). A height is the integer times the
//! z spacing plus the z offset, in the unit of the z step.
//!
//! | at byte | entry | | at byte | entry |
//! |---|---|---|---|---|
//! | 0 | magic, 12 bytes | | 116 | number of all points, 4 |
//! | 12 | byte order, 2: 0 for little endian | | 120, 124, 128 | x, y, z spacing, floats |
//! | 14 | objects, 2 | | 180, 196, 212 | units of the x, y, z steps, 16 |
//! | 16 | version, 2 | | 290 | inverted, 2 |
//! | 18 | kind of object, 2 | | 324 | bytes of compressed data, 4 |
//! | 20, 50 | object and operator, 30 | | 334, 336 | bytes of comment and private zone, 2 |
//! | 86 | points may be missing, 2 | | 474 | z offset, float |
//! | 98 | bits of a point, 2 | | 512 | comment, private zone, points |
//! | 100, 104 | least and greatest integer, 4 | | | |
//! | 108, 112 | points of a line, lines, 4 | | | |
//!
//! A missing point is the least integer minus 2. Compressed data begin with the number of streams and, for each stream,
//! its unpacked and packed lengths, 4 bytes each.

use std::io::{BufRead, Cursor, Read};

use flate2::bufread::ZlibDecoder;

use super::bytes::{Number, array, at_end, exact, next_bytes, numbers, text, unreadable};
use super::lines::excerpt;
use super::overridden::StatedValues;
use super::window::Window;
use super::{MapFormat, ReadMap, ReadOptions, check_expansion, keep_comment};
use crate::topography::unit::unit_names;
use crate::topography::{LengthUnit, ReadError};

pub(super) const MAGIC_PLAIN: &[u8] = b"DIGITAL SURF";
pub(super) const MAGIC_COMPRESSED: &[u8] = b"DSCOMPRESSED";
const FORMAT: &str = MapFormat::Sur.name();
/// Largest number of zlib streams; usual writers use one.
const MAX_STREAMS: u32 = 4096;

struct Header([u8; 512]);

impl Header {
    fn short(&self, at: usize) -> u16 {
        u16::from_le_bytes(array(&self.0[at..]))
    }

    fn int(&self, at: usize) -> i32 {
        i32::from_le_bytes(array(&self.0[at..]))
    }

    fn float(&self, at: usize) -> f64 {
        f32::from_le_bytes(array(&self.0[at..])).into()
    }

    fn text(&self, at: usize, length: usize) -> String {
        text(&self.0[at..at + length])
    }

    fn count(&self, field: &'static str, at: usize) -> Result<u64, ReadError> {
        u64::try_from(self.int(at))
            .ok()
            .filter(|count| *count > 0)
            .ok_or_else(|| refused(field, self.int(at).to_string(), "a whole number from 1 up"))
    }

    /// The unit of a step; files of MS-DOS programs write the micro sign in code page 437.
    fn unit(&self, field: &'static str, at: usize) -> Result<LengthUnit, ReadError> {
        let name = self.text(at, 16);
        name.replace('\u{e6}', "u")
            .parse()
            .map_err(|_| refused(field, excerpt(&name), concat!("a unit of length: ", unit_names!())))
    }
}

fn refused(field: &'static str, value: String, expected: &'static str) -> ReadError {
    ReadError::Field { format: FORMAT, field, value, expected }
}

pub(super) fn read(mut source: impl BufRead, options: &ReadOptions) -> Result<ReadMap, ReadError> {
    let header = Header(exact(&mut source, FORMAT, "header")?);
    if header.short(12) != 0 {
        return Err(refused("byte order", header.short(12).to_string(), "0, little endian"));
    }
    if header.short(16) != 1 {
        return Err(refused("version", header.short(16).to_string(), "1"));
    }
    let lines = header.count("number of lines", 112)?;
    let points = header.count("points of a line", 108)?;
    // Surfaces, alone or before the layers of an image; some programs label a surface as a profile of many lines.
    match header.short(18) {
        2 | 11 | 16 => {}
        1 if lines > 1 => {}
        kind => return Err(refused("kind of object", kind.to_string(), "2, a surface, or 16, one with an image")),
    }
    let total = header.count("number of all points", 116)?;
    if total != lines * points {
        return Err(refused("number of all points", total.to_string(), "points of a line times number of lines"));
    }
    let number = match header.short(98) {
        16 => Number::I16,
        32 => Number::I32,
        bits => return Err(refused("bits of a point", bits.to_string(), "16 or 32")),
    };
    let spacing = |field, at| {
        let value = header.float(at);
        if value.is_finite() && value > 0.0 { Ok(value) } else { Err(refused(field, value.to_string(), "above 0")) }
    };
    let (step_x, step_y, step_z) = (spacing("x spacing", 120)?, spacing("y spacing", 124)?, header.float(128));
    let offset_z = header.float(474);
    if !(step_z.is_finite() && step_z != 0.0 && offset_z.is_finite()) {
        return Err(refused("z spacing and offset", format!("{step_z} and {offset_z}"), "numbers, spacing not 0"));
    }
    let pixel_m = match options.grid_m() {
        Some(pixel_m) => pixel_m,
        None => {
            let unit = |field, at| options.lateral_unit.map_or_else(|| header.unit(field, at), Ok);
            [unit("unit of y", 196)?.to_metres(step_y), unit("unit of x", 180)?.to_metres(step_x)]
        }
    };
    let unit = options.height_unit.map_or_else(|| header.unit("unit of z", 212), Ok)?;

    let own = |at| header.unit("unit of an axis", at).ok();
    let stated = StatedValues {
        pixel_m: [own(180).map(|unit| unit.to_metres(step_x)), own(196).map(|unit| unit.to_metres(step_y))],
        height_unit: own(212).map(Into::into),
        lateral_unit: own(180).map(Into::into),
    };
    let (mut comments, mut notes) = (Vec::new(), stated.notes(options, MapFormat::Sur));
    for (name, at) in [("object", 20), ("operator", 50)] {
        let value = header.text(at, 30);
        if !value.is_empty() {
            keep_comment(&mut comments, &format!("{name}: {value}"));
        }
    }
    for line in text(&next_bytes(&mut source, FORMAT, "comment", header.short(334).into())?).lines() {
        keep_comment(&mut comments, line.trim());
    }
    next_bytes(&mut source, FORMAT, "private zone", header.short(336).into())?;
    if header.short(290) != 0 {
        notes.push(
            "the header says that heights have been inverted or mirrored; they are taken as they stand".to_owned(),
        );
    }

    let missing = (header.short(86) != 0).then(|| f64::from(header.int(100)) - 2.0);
    let mut window = Window::new(Some(lines), points, options.crop, options.decimation)?;
    let height = |value| Ok(if Some(value) == missing { f64::NAN } else { value });
    if header.0.starts_with(MAGIC_COMPRESSED) {
        let mut streams = Streams::new(source, total, number.bytes() as u64)?;
        if numbers(&mut streams, FORMAT, (number, false), total, &mut window, height)? {
            at_end(&mut streams, FORMAT)?;
        }
    } else {
        numbers(&mut source, FORMAT, (number, false), total, &mut window, height)?;
    }
    let (map, whole) = window.finish_lines(pixel_m, |height| unit.to_metres(height * step_z + offset_z))?;
    Ok(ReadMap { map, whole, format: MapFormat::Sur, comments, notes })
}

/// Concatenated streams of compressed data.
struct Streams<R> {
    current: Option<ZlibDecoder<std::io::Take<R>>>,
    /// Packed lengths of the remaining streams, last first.
    packed: Vec<u32>,
}

impl Streams<Cursor<Vec<u8>>> {
    /// Streams with `heights` heights of `bytes_each` bytes. All packed bytes are read before anything is unpacked, so
    /// that their stated lengths are verified.
    fn new(mut source: impl Read, heights: u64, bytes_each: u64) -> Result<Self, ReadError> {
        let needed = heights * bytes_each;
        let count = u32::from_le_bytes(exact(&mut source, FORMAT, "streams")?);
        if !(1..=MAX_STREAMS).contains(&count) {
            return Err(refused("number of streams", count.to_string(), "1 to 4096"));
        }
        let (mut packed, mut unpacked) = (Vec::new(), 0);
        for _ in 0..count {
            let lengths: [u8; 8] = exact(&mut source, FORMAT, "streams")?;
            unpacked += u64::from(u32::from_le_bytes(array(&lengths)));
            packed.push(u32::from_le_bytes(array(&lengths[4..])));
        }
        if unpacked != needed {
            return Err(refused("length of the streams", unpacked.to_string(), "bytes of a point times all points"));
        }
        let claimed: u64 = packed.iter().map(|&length| u64::from(length)).sum();
        check_expansion(FORMAT, heights, bytes_each, claimed)?;
        let mut bytes = Vec::new();
        source.take(claimed).read_to_end(&mut bytes).map_err(|error| unreadable(FORMAT, &error))?;
        check_expansion(FORMAT, heights, bytes_each, bytes.len() as u64)?;
        packed.reverse();
        let first = packed.pop().unwrap_or(0);
        Ok(Self { current: Some(ZlibDecoder::new(Cursor::new(bytes).take(first.into()))), packed })
    }
}

impl<R: BufRead> Read for Streams<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        while let Some(mut stream) = self.current.take() {
            let read = stream.read(buffer)?;
            if read > 0 || buffer.is_empty() {
                self.current = Some(stream);
                return Ok(read);
            }
            // Bytes left after the end of a stream belong to no stream.
            let mut rest = stream.into_inner();
            std::io::copy(&mut rest, &mut std::io::sink())?;
            if let Some(length) = self.packed.pop() {
                self.current = Some(ZlibDecoder::new(rest.into_inner().take(length.into())));
            }
        }
        Ok(0)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;
    use crate::topography::read::plainly;

    fn header(magic: &[u8], bits: u16) -> Vec<u8> {
        let mut bytes = vec![0; 512];
        let mut put = |at: usize, value: &[u8]| bytes[at..at + value.len()].copy_from_slice(value);
        put(0, magic);
        for (at, value) in [(16, 1), (18, 2), (86, 1), (98, bits), (334, 7), (336, 2)] {
            put(at, &value.to_le_bytes());
        }
        for (at, value) in [(100, -5_i32), (108, 3), (112, 2), (116, 6)] {
            put(at, &value.to_le_bytes());
        }
        for (at, value) in [(120, 1.5_f32), (124, 2.5), (128, 0.5), (474, 100.0)] {
            put(at, &value.to_le_bytes());
        }
        for (at, text) in [(50, &b"an operator"[..]), (180, b"\xb5m"), (196, b"um              "), (212, b"nm")] {
            put(at, text);
        }
        bytes.extend_from_slice(b"comment\0\0");
        bytes
    }

    fn zlib(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    fn check(bytes: &[u8]) {
        let heights_m = [100.5, f64::NAN, 101.0, 97.5, 101.5, 103.0].map(|height_nm| 1e-9 * height_nm);
        let read = plainly::check(bytes, MapFormat::Sur, [1.5e-6, 2.5e-6], heights_m, 1e-18);
        assert_eq!(read.comments, ["operator: an operator", "comment"]);
    }

    /// The same points as 16-bit and 32-bit integers.
    fn points() -> (Vec<u8>, Vec<u8>) {
        let points = [1_i16, 2, 3, -7, -5, 6];
        (
            points.into_iter().flat_map(i16::to_le_bytes).collect(),
            points.into_iter().flat_map(|point| i32::from(point).to_le_bytes()).collect(),
        )
    }

    #[test]
    fn plain_and_compressed_of_both_sizes_give_the_same_map() {
        let (short, long) = points();
        check(&[header(MAGIC_PLAIN, 16), short.clone()].concat());
        check(&[header(MAGIC_PLAIN, 32), long.clone()].concat());
        // Two streams divided in the middle of a number, the first followed by extra bytes.
        let (first, second) = (zlib(&long[..9]), zlib(&long[9..]));
        let mut packed = header(MAGIC_COMPRESSED, 32);
        for length in [2, 9, first.len() as u32 + 3, 15, second.len() as u32] {
            packed.extend_from_slice(&length.to_le_bytes());
        }
        check(&[&packed[..], &first, b"???", &second].concat());
    }

    #[test]
    fn headers_that_lie_are_refused_by_name() {
        let (short, _) = points();
        let refused = |at: usize, value: &[u8]| {
            let mut bytes = [header(MAGIC_PLAIN, 16), short.clone()].concat();
            bytes[at..at + value.len()].copy_from_slice(value);
            plainly::refused(bytes)
        };
        assert!(refused(12, &[1, 1]).contains("byte order is \"257\""));
        assert!(refused(18, &[12, 0]).contains("kind of object"));
        assert!(refused(98, &[8, 0]).contains("bits of a point"));
        assert!(refused(108, &(-3_i32).to_le_bytes()).contains("points of a line"));
        assert!(refused(116, &7_i32.to_le_bytes()).contains("all points"));
        assert!(refused(120, &f32::NAN.to_le_bytes()).contains("x spacing"));
        assert!(refused(212, b"V\0").contains("unit of z is \"V\""));
        assert!(refused(334, &u16::MAX.to_le_bytes()).contains("comment"));
        let huge = [&i32::MAX.to_le_bytes()[..], &i32::MAX.to_le_bytes()].concat();
        assert!(refused(108, &huge).contains("all points"));
    }

    #[test]
    fn streams_that_lie_are_refused() {
        let (_, long) = points();
        let packed = zlib(&long);
        let with = |lengths: [u32; 3]| {
            let lengths: Vec<u8> = lengths.into_iter().flat_map(u32::to_le_bytes).collect();
            let bytes = [&header(MAGIC_COMPRESSED, 32)[..], &lengths, &packed].concat();
            plainly::refused(bytes)
        };
        assert!(with([u32::MAX, 24, packed.len() as u32]).contains("number of streams"));
        assert!(with([1, u32::MAX, packed.len() as u32]).contains("length of the streams"));
        assert!(with([1, 24, 5]).contains("surface (.sur)"));
    }
}
