//! Sources of files: a disk, memory or a page. This module requests bytes by path and opens no file itself.

use std::fmt::Debug;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::formats::diagnostic::Diagnostic;

/// Kind of entry at a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Entry {
    /// A file.
    File,
    /// A folder.
    Folder,
    /// Another kind of entry: a device or a pipe.
    Other,
}

/// Access to files by their paths.
pub trait Files: Debug + Send + Sync {
    /// The bytes of the file at `path`.
    ///
    /// # Errors
    /// The error of the system.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// The file at `path` as a stream, for files too large to be read at once.
    ///
    /// # Errors
    /// The error of the system.
    fn stream(&self, path: &Path) -> io::Result<Box<dyn io::Read>> {
        Ok(Box::new(io::Cursor::new(self.read(path)?)))
    }

    /// Kind of entry at `path`. By default, for sources without folders, every readable path is a file.
    ///
    /// # Errors
    /// The error of the system, if there is no entry or its kind is unknown.
    fn entry(&self, path: &Path) -> io::Result<Entry> {
        self.read(path).map(|_| Entry::File)
    }

    /// Names of the entries of `folder`, in any order; empty if `folder` is no folder, or if the source has no folders.
    fn names(&self, _folder: &Path) -> Vec<String> {
        Vec::new()
    }

    /// Canonical path of the file at `path`, equal for all paths of one file.
    fn canonical(&self, path: &Path) -> PathBuf {
        path.to_owned()
    }
}

/// File source shared by documents.
pub type Source = Arc<dyn Files>;

/// Source without files, for self-contained documents.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &Path) -> io::Result<Vec<u8>> {
        Err(io::ErrorKind::NotFound.into())
    }
}

/// Whether `name` matches `pattern`, in which every `*` stands for any characters.
pub fn fits(name: &str, pattern: &str) -> bool {
    let parts: Vec<&str> = pattern.split('*').collect();
    let [first, middle @ .., last] = &parts[..] else { return name == pattern };
    let Some(mut rest) = name.strip_prefix(first).and_then(|rest| rest.strip_suffix(last)) else { return false };
    for part in middle {
        match rest.find(part) {
            Some(at) => rest = &rest[at + part.len()..],
            None => return false,
        }
    }
    true
}

/// Content of the file at `path` of `source`; `expected` describes the expected file.
///
/// # Errors
/// [`Diagnostic`] if `path` is a folder or cannot be read.
pub fn read_bytes(source: &Source, path: &Path, expected: &str) -> Result<Vec<u8>, Diagnostic> {
    refuse_folder(source, path, expected)?;
    source.read(path).map_err(|error| unreadable(path, &error))
}

/// The file at `path` of `source` as a stream; `expected` describes the expected file.
///
/// # Errors
/// [`Diagnostic`] if `path` is a folder or cannot be opened.
pub fn stream(source: &Source, path: &Path, expected: &str) -> Result<Box<dyn io::Read>, Diagnostic> {
    refuse_folder(source, path, expected)?;
    source.stream(path).map_err(|error| unreadable(path, &error))
}

fn refuse_folder(source: &Source, path: &Path, expected: &str) -> Result<(), Diagnostic> {
    match source.entry(path) {
        Ok(Entry::Folder) => Err(Diagnostic::file(path, "is a folder").expected(expected)),
        _ => Ok(()),
    }
}

/// Text of the file at `path` of `source`, in UTF-8, or in UTF-16 with a byte order mark; `expected` describes the
/// file.
///
/// # Errors
/// Errors of [`read_bytes`], or a refusal of other encodings.
pub fn read_text(source: &Source, path: &Path, expected: &str) -> Result<String, Diagnostic> {
    decoded(path, read_bytes(source, path, expected)?, expected)?.map_err(|bytes| {
        let valid = bytes.utf8_chunks().next().map_or(0, |chunk| chunk.valid().len());
        let line = bytes[..valid].split(|byte| *byte == b'\n').count();
        let refused = Diagnostic::file(path, "is no text in UTF-8").expected("a file saved as UTF-8 by its editor");
        Diagnostic { line: u32::try_from(line).ok(), ..refused }
    })
}

/// Text of a table at `path` of `source`. A file that is neither UTF-8 nor UTF-16 with a byte order mark is read as
/// Latin-1, the encoding of many instruments and spreadsheets, whose letters have the same numbers in Unicode.
///
/// # Errors
/// Errors of [`read_bytes`], or a refusal of binary content.
pub fn read_letters(source: &Source, path: &Path, expected: &str) -> Result<String, Diagnostic> {
    let text = decoded(path, read_bytes(source, path, expected)?, expected)?;
    Ok(text.unwrap_or_else(|bytes| bytes.into_iter().map(char::from).collect()))
}

/// Number of bytes at the beginning of a file that are searched for zeros, which only binary content has.
const HEAD: usize = 512;

/// Byte order mark that some editors write in front of UTF-8.
const UTF_8_MARK: &[u8] = b"\xEF\xBB\xBF";

/// Decodes UTF-8 with or without byte order mark, or UTF-16 with byte order mark; other content is returned as the
/// inner error. In a text without line feeds, carriage returns become line feeds.
fn decoded(path: &Path, bytes: Vec<u8>, expected: &str) -> Result<Result<String, Vec<u8>>, Diagnostic> {
    let units = |rest: &[u8], unit: fn([u8; 2]) -> u16| {
        let pairs = rest.as_chunks::<2>().0.iter().map(|pair| unit(*pair));
        char::decode_utf16(pairs).collect::<Result<String, _>>().ok()
    };
    let wide = match bytes.as_slice() {
        [0xFF, 0xFE, rest @ ..] => units(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => units(rest, u16::from_be_bytes),
        _ if bytes[..bytes.len().min(HEAD)].contains(&0) => {
            return Err(Diagnostic::file(path, "is no text: it holds bytes that are zero").expected(expected));
        }
        _ => None,
    };
    if let Some(text) = wide {
        return Ok(Ok(if text.contains('\n') { text } else { text.replace('\r', "\n") }));
    }
    let mut bytes = if bytes.starts_with(UTF_8_MARK) { bytes[UTF_8_MARK.len()..].to_vec() } else { bytes };
    if !bytes.contains(&b'\n') {
        bytes.iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
    }
    Ok(String::from_utf8(bytes).map_err(std::string::FromUtf8Error::into_bytes))
}

fn unreadable(path: &Path, error: &io::Error) -> Diagnostic {
    let is_absent = error.kind() == io::ErrorKind::NotFound;
    Diagnostic { is_absent, ..Diagnostic::file(path, format!("cannot be read: {error}")) }
}

/// Files in memory.
#[cfg(test)]
pub(crate) fn in_memory(files: &[(&str, &[u8])]) -> Source {
    let contents = files.iter().map(|(path, bytes)| ((*path).to_owned(), Arc::new(bytes.to_vec())));
    Arc::new(crate::campaign::inputs::InMemory(contents.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_not_there_is_told_from_one_that_cannot_be_read() {
        let is_absent = |source: Source| read_text(&source, Path::new("a.toml"), "a file").unwrap_err().is_absent;
        assert!(is_absent(Arc::new(NoFiles)) && !is_absent(in_memory(&[("a.toml", b"Gr\xF6\xDFe")])));
    }

    #[test]
    fn text_is_utf_8_or_utf_16_and_what_is_neither_is_told_with_its_line() {
        let read = |bytes: &[u8]| decoded(Path::new("a.csv"), bytes.to_vec(), "a table");
        let little: Vec<u8> = "\u{FEFF}Größe".encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = "\u{FEFF}Größe".encode_utf16().flat_map(u16::to_be_bytes).collect();
        for bytes in [little.as_slice(), big.as_slice(), "Größe".as_bytes(), "\u{FEFF}Größe".as_bytes()] {
            assert_eq!(read(bytes).unwrap().unwrap(), "Größe");
        }
        assert_eq!(read(b"Gr\xF6\xDFe").unwrap(), Err(b"Gr\xF6\xDFe".to_vec()));
        let refused = read(b"\x7FELF\x02\x01\x01\x00\x00").unwrap_err().to_string();
        assert!(refused.contains("a.csv: is no text: it holds bytes that are zero; expected a table"), "{refused}");
        let source = in_memory(&[("a.toml", b"name = \"a\"\nsource = \"Gr\xF6\xDFe\"\n")]);
        let refused = read_text(&source, Path::new("a.toml"), "a design file").unwrap_err().to_string();
        assert_eq!(refused, "a.toml:2: is no text in UTF-8; expected a file saved as UTF-8 by its editor");
        assert!(read_letters(&source, Path::new("a.toml"), "a table").unwrap().contains("Größe"));
    }

    #[test]
    fn stars_stand_for_any_letters() {
        for (name, pattern, fit) in [
            ("flat-50N-1.csv", "flat-50N-*.csv", true),
            ("flat-50N-1.csv", "*", true),
            ("flat-50N-1.csv", "*50N*1*", true),
            ("flat-150N-1.csv", "flat-50N-*.csv", false),
            ("flat-50N-1.txt", "flat-50N-*.csv", false),
            ("aba", "ab*ba", false),
        ] {
            assert_eq!(fits(name, pattern), fit, "{name} {pattern}");
        }
    }
}
