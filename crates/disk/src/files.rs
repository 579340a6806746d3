//! Files on disk.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use slipgrid_campaign::Store;
use slipgrid_formats::source::{Entry, Files, Source};

use crate::put;

/// Files as the system has them.
#[derive(Clone, Copy, Debug, Default)]
pub struct Disk;

/// The disk, for readers of files.
#[must_use]
pub fn disk() -> Source {
    Arc::new(Disk)
}

impl Files for Disk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        fs::read(path)
    }

    fn stream(&self, path: &Path) -> io::Result<Box<dyn io::Read>> {
        Ok(Box::new(File::open(path)?))
    }

    fn entry(&self, path: &Path) -> io::Result<Entry> {
        let found = fs::metadata(path)?;
        Ok(if found.is_dir() {
            Entry::Folder
        } else if found.is_file() {
            Entry::File
        } else {
            Entry::Other
        })
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).into_iter().flatten().flatten();
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect()
    }

    fn canonical(&self, path: &Path) -> PathBuf {
        path.canonicalize().unwrap_or_else(|_| path.to_owned())
    }
}

impl Store for Disk {
    fn put(&self, path: &Path, bytes: &[u8]) -> io::Result<()> {
        put(path, bytes)
    }
}
