//! Files on disk.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::campaign::Store;
use crate::formats::source::{Entry, Files, Source};

use crate::disk::put;

/// Maximum size, in bytes, of a file that is read into memory. A tribometer with 100 rows per second takes weeks to
/// fill such a file. Maps are read as streams.
const MAX_BYTES: u64 = 1 << 30;

/// Maximum size, in bytes, read from a pipe or device, which may have no end.
const MAX_STREAM_BYTES: u64 = 1 << 26;

/// File source and store for the files of the operating system. Relative paths start from the current folder, unless
/// another folder is given.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Disk {
    folder: PathBuf,
}

impl Disk {
    /// Creates a source in which relative paths start from `folder`, independent of the process's current folder.
    pub const fn from_folder(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// Resolves `path` from the folder of the source.
    pub fn place(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
    }
}

/// Returns the files of the operating system as a file source for readers.
pub fn disk() -> Source {
    Arc::new(Disk::default())
}

impl Files for Disk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let file = File::open(self.place(path))?;
        let most = if file.metadata()?.is_file() { MAX_BYTES } else { MAX_STREAM_BYTES };
        let mut bytes = Vec::new();
        file.take(most + 1).read_to_end(&mut bytes)?;
        if bytes.len() as u64 > most {
            return Err(io::Error::other(format!("it has more than {} MiB", most >> 20)));
        }
        Ok(bytes)
    }

    fn stream(&self, path: &Path) -> io::Result<Box<dyn io::Read>> {
        Ok(Box::new(File::open(self.place(path))?))
    }

    fn entry(&self, path: &Path) -> io::Result<Entry> {
        let found = fs::metadata(self.place(path))?;
        Ok(if found.is_dir() {
            Entry::Folder
        } else if found.is_file() {
            Entry::File
        } else {
            Entry::Other
        })
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(self.place(folder)).into_iter().flatten().flatten();
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    }

    fn canonical(&self, path: &Path) -> PathBuf {
        let path = self.place(path);
        path.canonicalize().unwrap_or(path)
    }
}

impl Store for Disk {
    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        put(&self.place(path), bytes)
    }
}
