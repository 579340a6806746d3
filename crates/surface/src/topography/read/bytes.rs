//! Reads numbers from binary files in pieces.

use std::io::{ErrorKind, Read};

use super::window::Window;
use crate::topography::ReadError;

/// Number of values decoded at a time.
const PIECE: usize = 4096;

/// Storage type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Number {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F32,
    F64,
}

impl Number {
    /// Size of one number in bytes.
    pub(crate) const fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
        }
    }

    /// Decodes the number in the first bytes of `bytes`, little endian.
    fn decode(self, bytes: &[u8]) -> f64 {
        match self {
            Self::U8 => f64::from(bytes[0]),
            Self::I8 => f64::from(bytes[0] as i8),
            Self::U16 => f64::from(u16::from_le_bytes(array(bytes))),
            Self::I16 => f64::from(i16::from_le_bytes(array(bytes))),
            Self::U32 => f64::from(u32::from_le_bytes(array(bytes))),
            Self::I32 => f64::from(i32::from_le_bytes(array(bytes))),
            Self::U64 => u64::from_le_bytes(array(bytes)) as f64,
            Self::I64 => i64::from_le_bytes(array(bytes)) as f64,
            Self::F32 => f64::from(f32::from_le_bytes(array(bytes))),
            Self::F64 => f64::from_le_bytes(array(bytes)),
        }
    }
}

/// The first N bytes of `bytes`, padded with zeros if there are fewer.
pub(crate) fn array<const N: usize>(bytes: &[u8]) -> [u8; N] {
    let mut array = [0; N];
    for (target, source) in array.iter_mut().zip(bytes) {
        *target = *source;
    }
    array
}

/// Error for a header of `format` that is longer than `most_bytes`, more than the header of any map takes.
pub(super) fn header_too_long(format: &'static str, most_bytes: usize) -> ReadError {
    ReadError::Refused(format!("{format}: the header is longer than {most_bytes} bytes"))
}

/// Error for a source or decompression library that failed; its message may quote a hostile file.
pub(super) fn unreadable(format: &'static str, error: &dyn std::fmt::Display) -> ReadError {
    const MAX_CHARS: usize = 160;
    let reason: String =
        error.to_string().chars().map(|c| if c.is_control() { ' ' } else { c }).take(MAX_CHARS).collect();
    ReadError::Refused(format!("{format}: cannot be read: {reason}"))
}

/// Fills `buffer` as far as the source reaches; returns the number of bytes read.
fn fill(source: &mut impl Read, buffer: &mut [u8], format: &'static str) -> Result<usize, ReadError> {
    let mut filled = 0;
    while filled < buffer.len() {
        match source.read(&mut buffer[filled..]) {
            Ok(0) => break,
            Ok(read) => filled += read,
            Err(error) if error.kind() == ErrorKind::Interrupted => {}
            Err(error) => return Err(unreadable(format, &error)),
        }
    }
    Ok(filled)
}

/// Reads the next N bytes; `what` names the part of the file in errors.
pub(crate) fn exact<const N: usize>(
    source: &mut impl Read,
    format: &'static str,
    what: &'static str,
) -> Result<[u8; N], ReadError> {
    let mut bytes = [0; N];
    let found = fill(source, &mut bytes, format)?;
    if found < N {
        return Err(ReadError::Ended { format, what, expected: N as u64, found: found as u64 });
    }
    Ok(bytes)
}

/// Reads the next `count` bytes, which must be few; `what` names the part of the file in errors.
pub(super) fn next_bytes(
    source: &mut impl Read,
    format: &'static str,
    what: &'static str,
    count: u64,
) -> Result<Vec<u8>, ReadError> {
    let mut bytes = Vec::new();
    let found = source.take(count).read_to_end(&mut bytes).map_err(|error| unreadable(format, &error))? as u64;
    if found < count {
        return Err(ReadError::Ended { format, what, expected: count, found });
    }
    Ok(bytes)
}

/// Reads `count` numbers, which may be big endian, until `window` is full; `height` converts a number to a height of
/// the window, NaN where missing. Returns whether all were read.
pub(crate) fn numbers(
    source: &mut impl Read,
    format: &'static str,
    (number, big_endian): (Number, bool),
    count: u64,
    window: &mut Window,
    mut height: impl FnMut(f64) -> Result<f64, ReadError>,
) -> Result<bool, ReadError> {
    let size = number.bytes();
    let mut bytes = vec![0; PIECE * size];
    let mut values = Vec::with_capacity(PIECE);
    let mut left = count;
    while left > 0 {
        // At most PIECE, so the cast is exact.
        let wanted = left.min(PIECE as u64) as usize;
        let piece = &mut bytes[..wanted * size];
        let found = fill(source, piece, format)?;
        if big_endian {
            piece.chunks_exact_mut(size).for_each(<[u8]>::reverse);
        }
        values.clear();
        for bytes in piece[..found].chunks_exact(size) {
            values.push(height(number.decode(bytes))?);
        }
        window.push(&values)?;
        if found < wanted * size {
            let found = count - left + (found / size) as u64;
            return Err(ReadError::Ended { format, what: "heights", expected: count, found });
        }
        left -= wanted as u64;
        if window.is_full() {
            return Ok(left == 0);
        }
    }
    Ok(true)
}

/// Refuses a source that continues after its heights. Decompressors verify their checksum at this point.
pub(crate) fn at_end(source: &mut impl Read, format: &'static str) -> Result<(), ReadError> {
    match fill(source, &mut [0], format)? {
        0 => Ok(()),
        _ => Err(ReadError::Refused(format!(
            "{format}: data go on behind the heights that the header announces: expected the file to end there"
        ))),
    }
}

/// Decodes a text field of fixed length, without the zeros and spaces that pad it; Latin-1 if it is not valid UTF-8.
pub(crate) fn text(bytes: &[u8]) -> String {
    let end = bytes.iter().position(|&byte| byte == 0).unwrap_or(bytes.len());
    let bytes = &bytes[..end];
    std::str::from_utf8(bytes)
        .map_or_else(|_| bytes.iter().map(|&byte| char::from(byte)).collect(), str::to_owned)
        .trim()
        .to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(bytes: &[u8], number: Number, big_endian: bool, count: u64) -> Result<Vec<f64>, ReadError> {
        let (mut found, mut window) = (Vec::new(), Window::new(None, 1, None, None)?);
        let whole = numbers(&mut &bytes[..], "test", (number, big_endian), count, &mut window, |value| {
            found.push(value);
            Ok(value)
        })?;
        assert!(whole);
        Ok(found)
    }

    #[test]
    fn numbers_of_every_kind_and_byte_order() {
        assert_eq!(all(&[1, 255], Number::I8, false, 2).unwrap(), [1.0, -1.0]);
        assert_eq!(all(&[0xfe, 0xff, 1, 0], Number::I16, false, 2).unwrap(), [-2.0, 1.0]);
        assert_eq!(all(&[0xff, 0xfe, 0, 1], Number::I16, true, 2).unwrap(), [-2.0, 1.0]);
        assert_eq!(all(&(-7_i64).to_le_bytes(), Number::I64, false, 1).unwrap(), [-7.0]);
        assert_eq!(all(&1.5_f32.to_be_bytes(), Number::F32, true, 1).unwrap(), [1.5]);
        let many: Vec<u8> = (0..10_000_u32).flat_map(u32::to_le_bytes).collect();
        let read = all(&many, Number::U32, false, 10_000).unwrap();
        assert!(read.iter().enumerate().all(|(n, &value)| value == n as f64));
    }

    #[test]
    fn a_file_that_ends_early_says_how_much_is_missing() {
        let message = all(&[0; 9], Number::F64, false, 1 << 60).unwrap_err().to_string();
        assert!(message.contains("after 1 of") && message.contains(&(1_u64 << 60).to_string()), "{message}");
        assert!(exact::<4>(&mut &[1_u8, 2][..], "test", "header").is_err());
        assert!(next_bytes(&mut &[0_u8; 3][..], "test", "comment", 4).is_err());
    }

    #[test]
    fn texts_lose_their_padding() {
        assert_eq!(text(b"\xb5m\0junk"), "\u{b5}m");
        assert_eq!(text("\u{b5}m    ".as_bytes()), "\u{b5}m");
    }
}
