//! Input files: opened and read, or refused with what was expected in their place.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::diagnostic::Diagnostic;

/// Opens the file at `path`; `expected` says what it should be.
///
/// # Errors
/// [`Diagnostic`] if it is a folder or cannot be opened.
pub fn open(path: &Path, expected: &str) -> Result<File, Diagnostic> {
    if path.is_dir() {
        return Err(Diagnostic::file(path, "is a folder").expected(expected));
    }
    File::open(path).map_err(|error| unreadable(path, &error))
}

/// The content of the file at `path`.
///
/// # Errors
/// As [`open`], or if reading fails.
pub fn read_bytes(path: &Path, expected: &str) -> Result<Vec<u8>, Diagnostic> {
    let mut bytes = Vec::new();
    open(path, expected)?.read_to_end(&mut bytes).map_err(|error| unreadable(path, &error))?;
    Ok(bytes)
}

/// The text of the file at `path`.
///
/// # Errors
/// As [`read_bytes`], or if it is not UTF-8.
pub fn read_text(path: &Path, expected: &str) -> Result<String, Diagnostic> {
    let mut text = String::new();
    open(path, expected)?.read_to_string(&mut text).map_err(|error| unreadable(path, &error))?;
    Ok(text)
}

fn unreadable(path: &Path, error: &std::io::Error) -> Diagnostic {
    Diagnostic::file(path, format!("cannot be read: {error}"))
}
