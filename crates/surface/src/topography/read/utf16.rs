//! Decodes text in UTF-16, which some programs write, to UTF-8.

use std::io::{BufRead, Read, Result};

/// Number of bytes decoded at a time, even.
const CHUNK: u64 = 16 * 1024;

/// Byte order: converts two bytes to a code unit.
type Order = fn([u8; 2]) -> u16;

/// Reads a source in UTF-16 as UTF-8; invalid code units become the replacement character.
pub(super) struct Utf16<R> {
    source: R,
    order: Order,
    /// First half of a surrogate pair whose second half is not read yet.
    half: Option<u16>,
    decoded: Vec<u8>,
    taken: usize,
}

/// The byte order given by a UTF-16 byte order mark at the beginning of `start`; `None` without such a mark.
pub(super) fn order_of(start: &[u8]) -> Option<Order> {
    match start {
        [0xFF, 0xFE, ..] => Some(u16::from_le_bytes),
        [0xFE, 0xFF, ..] => Some(u16::from_be_bytes),
        _ => None,
    }
}

impl<R: BufRead> Utf16<R> {
    /// Creates a reader of `source` in the byte order `order`.
    pub(super) const fn new(source: R, order: Order) -> Self {
        Self { source, order, half: None, decoded: Vec::new(), taken: 0 }
    }

    fn decode(&mut self) -> Result<()> {
        let mut bytes = Vec::new();
        (&mut self.source).take(CHUNK).read_to_end(&mut bytes)?;
        let mut units: Vec<u16> = self.half.take().into_iter().collect();
        units.extend(bytes.as_chunks::<2>().0.iter().map(|pair| (self.order)(*pair)));
        // A character may continue in the next bytes, unless these are the last.
        let is_half = |unit: &mut u16| (0xD800..0xDC00).contains(unit);
        self.half = if bytes.is_empty() { None } else { units.pop_if(is_half) };
        let letters = char::decode_utf16(units).map(|letter| letter.unwrap_or(char::REPLACEMENT_CHARACTER));
        self.decoded = letters.collect::<String>().into_bytes();
        self.taken = 0;
        Ok(())
    }
}

impl<R: BufRead> Read for Utf16<R> {
    fn read(&mut self, to: &mut [u8]) -> Result<usize> {
        // Bytes that are only half of a character decode to nothing yet.
        while self.taken == self.decoded.len() && !self.source.fill_buf()?.is_empty() {
            self.decode()?;
        }
        if self.taken == self.decoded.len() && self.half.is_some() {
            self.decode()?;
        }
        let count = (&self.decoded[self.taken..]).read(to)?;
        self.taken += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use std::io::{BufReader, Read};

    use super::{CHUNK, Utf16, order_of};
    use crate::topography::read::GIVEN;
    use crate::topography::read_map;

    fn wide(text: &str, bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        format!("\u{FEFF}{text}").encode_utf16().flat_map(bytes).collect()
    }

    #[test]
    fn a_map_in_utf_16_is_that_in_utf_8() {
        let text = "# Gerät: 3\r\n1 2 3 4\r\n5 6 7.5 8\r\n".to_owned() + &"1 2 3 4\r\n".repeat(2000);
        let expected = read_map(text.as_bytes(), &GIVEN).unwrap();
        for bytes in [wide(&text, u16::to_le_bytes), wide(&text, u16::to_be_bytes)] {
            let found = read_map(bytes.as_slice(), &GIVEN).unwrap();
            assert_eq!((&found.map, &found.comments), (&expected.map, &expected.comments));
        }
        let refused = read_map(wide("1 2 3 4\n1 2 x7 4\n", u16::to_le_bytes).as_slice(), &GIVEN).unwrap_err();
        assert!(refused.to_string().starts_with("line 2, column 3: \"x7\""), "{refused}");
    }

    #[test]
    fn letters_of_two_units_are_read_wherever_a_chunk_ends_and_damage_is_replaced() {
        for before in [CHUNK as usize / 2 - 3, CHUNK as usize / 2 - 2, CHUNK as usize / 2 - 1] {
            let text = "a".repeat(before) + "\u{1F600}b";
            let (mut read, bytes) = (String::new(), wide(&text, u16::to_le_bytes));
            let source = BufReader::with_capacity(3, bytes.as_slice());
            Utf16::new(source, order_of(&bytes).unwrap()).read_to_string(&mut read).unwrap();
            assert_eq!(read.trim_start_matches('\u{FEFF}'), text);
        }
        let (mut read, cut) = (String::new(), [0xFF, 0xFE, 0x61, 0x00, 0x00, 0xD8]);
        Utf16::new(cut.as_slice(), order_of(&cut).unwrap()).read_to_string(&mut read).unwrap();
        assert_eq!(read, "\u{FEFF}a\u{FFFD}");
        assert!(order_of(b"1 2").is_none());
    }
}
