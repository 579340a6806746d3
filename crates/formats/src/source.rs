//! Where files come from: a disk, memory, a page. This crate asks for bytes by their path and opens nothing itself.

use std::fmt::Debug;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::diagnostic::Diagnostic;

/// What stands at a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// A file.
    File,
    /// A folder.
    Folder,
    /// Something else: a device, a pipe.
    Other,
}

/// Files by their paths.
pub trait Files: Debug + Send + Sync {
    /// The bytes of the file at `path`.
    ///
    /// # Errors
    /// What the system said.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// The file at `path` as a stream, for what is too large to be read at once.
    ///
    /// # Errors
    /// What the system said.
    fn stream(&self, path: &Path) -> io::Result<Box<dyn io::Read>> {
        Ok(Box::new(io::Cursor::new(self.read(path)?)))
    }

    /// What stands at `path`.
    ///
    /// # Errors
    /// What the system said, where nothing does or it cannot be told.
    fn entry(&self, path: &Path) -> io::Result<Entry>;

    /// Names of what stands in `folder`, in any order; empty where that is none.
    fn names(&self, folder: &Path) -> Vec<String>;

    /// The path by which a file is known under any name.
    fn canonical(&self, path: &Path) -> PathBuf {
        path.to_owned()
    }
}

/// Files that documents share.
pub type Source = Arc<dyn Files>;

/// No files at all: documents that stand alone.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &Path) -> io::Result<Vec<u8>> {
        Err(io::ErrorKind::NotFound.into())
    }

    fn entry(&self, _: &Path) -> io::Result<Entry> {
        Err(io::ErrorKind::NotFound.into())
    }

    fn names(&self, _: &Path) -> Vec<String> {
        Vec::new()
    }
}

/// The content of the file at `path` of `source`; `expected` says what it should be.
///
/// # Errors
/// [`Diagnostic`] if it is a folder or cannot be read.
pub fn read_bytes(source: &Source, path: &Path, expected: &str) -> Result<Vec<u8>, Diagnostic> {
    if source.entry(path).is_ok_and(|entry| entry == Entry::Folder) {
        return Err(Diagnostic::file(path, "is a folder").expected(expected));
    }
    source.read(path).map_err(|error| unreadable(path, &error))
}

/// The file at `path` of `source` as a stream.
///
/// # Errors
/// [`Diagnostic`] if it is a folder or cannot be opened.
pub fn stream(source: &Source, path: &Path, expected: &str) -> Result<Box<dyn io::Read>, Diagnostic> {
    if source.entry(path).is_ok_and(|entry| entry == Entry::Folder) {
        return Err(Diagnostic::file(path, "is a folder").expected(expected));
    }
    source.stream(path).map_err(|error| unreadable(path, &error))
}

/// The text of the file at `path` of `source`.
///
/// # Errors
/// As [`read_bytes`], or if it is not UTF-8.
pub fn read_text(source: &Source, path: &Path, expected: &str) -> Result<String, Diagnostic> {
    String::from_utf8(read_bytes(source, path, expected)?).map_err(|_| {
        unreadable(path, &io::Error::new(io::ErrorKind::InvalidData, "stream did not contain valid UTF-8"))
    })
}

/// The text of a table at `path` of `source`; where it is not UTF-8, as instruments and spreadsheets write it in Latin-1, whose letters have
/// the same numbers in Unicode.
///
/// # Errors
/// As [`read_bytes`].
pub fn read_letters(source: &Source, path: &Path, expected: &str) -> Result<String, Diagnostic> {
    let bytes = read_bytes(source, path, expected)?;
    Ok(String::from_utf8(bytes).unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect()))
}

fn unreadable(path: &Path, error: &io::Error) -> Diagnostic {
    Diagnostic::file(path, format!("cannot be read: {error}"))
}
