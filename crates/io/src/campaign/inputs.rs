//! Files that tasks read: recorded when a campaign is planned, and provided to its workers.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::formats::source::{Entry, Files, Source};

use crate::campaign::records::hash;

/// Contents of files, by SHA-256 hash in hexadecimal digits.
pub type Contents = BTreeMap<String, Arc<Vec<u8>>>;

/// SHA-256 in hexadecimal digits, and content of a file.
type Hashed = (String, Arc<Vec<u8>>);

/// A file source that reads each file once.
#[derive(Debug)]
pub struct ReadOnce {
    inner: Source,
    known: Mutex<BTreeMap<PathBuf, Hashed>>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl ReadOnce {
    pub fn new(inner: Source) -> Arc<Self> {
        Arc::new(Self { inner, known: Mutex::default() })
    }

    /// Contents of all files that were read, by hash.
    pub fn contents(&self) -> Contents {
        locked(&self.known).values().map(|(hash, bytes)| (hash.clone(), Arc::clone(bytes))).collect()
    }

    fn get(&self, path: &Path) -> io::Result<Hashed> {
        if let Some(known) = locked(&self.known).get(path) {
            return Ok(known.clone());
        }
        let bytes = Arc::new(self.inner.read(path)?);
        let read = (hash(&bytes), bytes);
        locked(&self.known).insert(path.to_owned(), read.clone());
        Ok(read)
    }
}

/// A file source that records the files read by one task.
#[derive(Debug)]
pub struct RecordedFiles {
    files: Arc<ReadOnce>,
    /// Folder to which recorded paths are relative.
    folder: PathBuf,
    seen: Mutex<BTreeMap<String, String>>,
}

impl RecordedFiles {
    pub fn new(files: &Arc<ReadOnce>, folder: &Path) -> Arc<Self> {
        Arc::new(Self { files: Arc::clone(files), folder: folder.to_owned(), seen: Mutex::default() })
    }

    /// Hashes of the files that were read, by path relative to `folder`.
    pub fn seen(&self) -> BTreeMap<String, String> {
        locked(&self.seen).clone()
    }
}

impl Files for RecordedFiles {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let (hash, bytes) = self.files.get(path)?;
        let name = path.strip_prefix(&self.folder).unwrap_or(path).display().to_string();
        locked(&self.seen).insert(name, hash);
        Ok(bytes.to_vec())
    }

    fn entry(&self, path: &Path) -> io::Result<Entry> {
        self.files.inner.entry(path)
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        self.files.inner.names(folder)
    }
}

/// Inputs of a campaign, as a file source for workers.
#[derive(Debug)]
pub struct HashedFiles {
    /// SHA-256 hashes of the files, in hexadecimal digits, by path.
    hashes: BTreeMap<PathBuf, String>,
    /// File source of the contents.
    store: Source,
    /// Folder of the contents in `store`, in which the name of a file is the hash of its content.
    folder: PathBuf,
}

impl HashedFiles {
    pub fn new(inputs: &BTreeMap<String, String>, store: Source, folder: PathBuf) -> Self {
        Self { hashes: inputs.iter().map(|(path, hash)| (path.into(), hash.clone())).collect(), store, folder }
    }
}

impl Files for HashedFiles {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let wanted = self.hashes.get(path).ok_or(io::ErrorKind::NotFound)?;
        let bytes = self.store.read(&self.folder.join(wanted))?;
        if hash(&bytes) != *wanted {
            let reason = "it is not what it was when the campaign was planned";
            return Err(io::Error::new(io::ErrorKind::InvalidData, reason));
        }
        Ok(bytes)
    }

    fn entry(&self, path: &Path) -> io::Result<Entry> {
        self.hashes.get(path).map(|_| Entry::File).ok_or(io::ErrorKind::NotFound.into())
    }
}

/// File source in memory; the path of a file is the hash of its content.
#[derive(Debug)]
pub struct InMemory(pub Contents);

impl Files for InMemory {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let found = path.to_str().and_then(|hash| self.0.get(hash)).ok_or(io::ErrorKind::NotFound)?;
        Ok(found.to_vec())
    }
}
