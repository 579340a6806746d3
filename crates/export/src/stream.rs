//! Files handed on piece by piece: memory does not grow with the number of cavities.

use std::io::{self, Write};

/// Bytes gathered before they are handed on: calls cost little, and so does the memory.
const BLOCK: usize = 1 << 16;

/// Hands `out` on to `to` where it has grown enough.
pub(crate) fn hand_on(out: &mut String, to: &mut dyn Write) -> io::Result<()> {
    if out.len() >= BLOCK {
        to.write_all(out.as_bytes())?;
        out.clear();
    }
    Ok(())
}

/// Hands the rest of `out` on to `to`.
pub(crate) fn finish(out: &mut String, to: &mut dyn Write) -> io::Result<()> {
    to.write_all(out.as_bytes())?;
    out.clear();
    Ok(())
}

/// What a writer writes, as text.
#[cfg(test)]
pub(crate) fn text(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> String {
    let mut bytes = Vec::new();
    write(&mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}
