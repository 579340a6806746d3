//! List of the files that slipgrid wrote into a folder: names with hashes in the format of `sha256sum`. The list
//! identifies tables and pictures, which hold no mark. Files that were changed since then belong to the user.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs::{self, File};
use std::io;
use std::path::Path;

use sha2::{Digest, Sha256};

/// Name of the file that holds the list.
pub(crate) const LIST: &str = ".slipgrid-written";

/// Hashes of the files that slipgrid wrote into a folder, by file name. A name has several hashes if a run was killed
/// while it replaced files.
#[derive(Clone, Debug, Default)]
pub(crate) struct Written(BTreeMap<String, Vec<String>>);

impl Written {
    /// Reads the list of `folder`; empty if there is none.
    pub(crate) fn read(folder: &Path) -> Self {
        let mut written = Self::default();
        for line in fs::read_to_string(folder.join(LIST)).unwrap_or_default().lines() {
            if let Some((hash, name)) = line.split_once("  ") {
                written.0.entry(name.to_owned()).or_default().push(hash.to_owned());
            }
        }
        written
    }

    /// Whether the list holds the file at `path`, relative to `folder`, with its current content.
    pub(crate) fn holds(&self, folder: &Path, path: &Path) -> bool {
        let Some(hashes) = path.to_str().and_then(|name| self.0.get(name)) else { return false };
        hash_file(&folder.join(path)).is_ok_and(|hash| hashes.contains(&hash))
    }

    /// Whether the list has an entry for the file at `path`, relative to the list's folder.
    pub(crate) fn names(&self, path: &Path) -> bool {
        path.to_str().is_some_and(|name| self.0.contains_key(name))
    }

    /// Adds a hash that the file may have, besides those known.
    pub(crate) fn add(&mut self, name: &str, hash: String) {
        self.0.entry(name.to_owned()).or_default().push(hash);
    }

    pub(crate) fn insert(&mut self, name: &str, hash: String) {
        self.0.insert(name.to_owned(), vec![hash]);
    }

    pub(crate) fn remove(&mut self, path: &Path) {
        path.to_str().map(|name| self.0.remove(name));
    }

    pub(crate) fn to_text(&self) -> String {
        let lines = self.0.iter().flat_map(|(name, hashes)| hashes.iter().map(move |hash| format!("{hash}  {name}\n")));
        lines.collect()
    }
}

fn hash_file(path: &Path) -> io::Result<String> {
    let mut hashing = Hashing { to: io::sink(), hash: Sha256::new(), is_cancelled: &|| false };
    io::copy(&mut File::open(path)?, &mut hashing)?;
    Ok(hexadecimal(&hashing.hash.finalize()))
}

/// A writer that hashes the written data and refuses further data once the run is cancelled.
pub(crate) struct Hashing<'a, W> {
    pub(crate) to: W,
    pub(crate) hash: Sha256,
    pub(crate) is_cancelled: &'a dyn Fn() -> bool,
}

impl<W: io::Write> io::Write for Hashing<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Writers retry after errors of the kind `Interrupted`.
        if (self.is_cancelled)() {
            return Err(io::Error::other("interrupted"));
        }
        let count = self.to.write(bytes)?;
        self.hash.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// Formats `bytes` as hexadecimal digits.
pub fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().fold(String::new(), |mut text, byte| {
        // Writing to a string cannot fail.
        let _ = write!(text, "{byte:02x}");
        text
    })
}
