//! Streaming of files, so that memory does not grow with the number of cavities.

use std::io::{self, Write};

/// Buffer size, in bytes, from which data is written: large enough for few calls.
const BLOCK: usize = 1 << 16;

/// Writes `out` to `to` and empties it, if it has reached the buffer size.
pub(crate) fn flush_full(out: &mut String, to: &mut dyn Write) -> io::Result<()> {
    if out.len() >= BLOCK {
        to.write_all(out.as_bytes())?;
        out.clear();
    }
    Ok(())
}

/// Writes the rest of `out` to `to`.
pub(crate) fn flush_rest(out: &mut String, to: &mut dyn Write) -> io::Result<()> {
    to.write_all(out.as_bytes())?;
    out.clear();
    Ok(())
}

/// Output of a writer as text.
#[cfg(test)]
pub(crate) fn text(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> String {
    let mut bytes = Vec::new();
    write(&mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}
