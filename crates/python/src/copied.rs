//! Copies: what a scene, a design or a calibration was read from travels with it, so that it is read again where its files are not.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use slipgrid::formats::source::{Entry, Files, NoFiles, Source, read_bytes};
use slipgrid::formats::{Diagnostic, Document};
use slipgrid_disk::disk;

/// Contents of files by their paths. These are no paths of Python, which would spell some otherwise than they are asked for.
pub type Contents = BTreeMap<OsString, Vec<u8>>;

/// Files that are remembered as they are read.
#[derive(Debug)]
struct Remembered {
    /// Contents by paths; `None` of a file that was only looked for.
    known: Mutex<BTreeMap<PathBuf, Option<Arc<[u8]>>>>,
    /// Where others come from: the disk, or nowhere in a copy.
    beyond: Source,
}

impl Remembered {
    fn known(&self) -> MutexGuard<'_, BTreeMap<PathBuf, Option<Arc<[u8]>>>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn get(&self, path: &Path) -> io::Result<Arc<[u8]>> {
        if let Some(Some(bytes)) = self.known().get(path) {
            return Ok(Arc::clone(bytes));
        }
        let bytes: Arc<[u8]> = self.beyond.read(path)?.into();
        self.known().insert(path.to_owned(), Some(Arc::clone(&bytes)));
        Ok(bytes)
    }
}

impl Files for Remembered {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        Ok(self.get(path)?.to_vec())
    }

    fn stream(&self, path: &Path) -> io::Result<Box<dyn io::Read>> {
        Ok(Box::new(io::Cursor::new(self.get(path)?)))
    }

    fn entry(&self, path: &Path) -> io::Result<Entry> {
        let mut known = self.known();
        if known.contains_key(path) {
            return Ok(Entry::File);
        }
        let found = self.beyond.entry(path)?;
        if found == Entry::File {
            known.insert(path.to_owned(), None);
        }
        Ok(found)
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        let known = self.known();
        let inside = known.keys().filter(|path| path.parent() == Some(folder)).filter_map(|path| path.file_name());
        let names = inside.map(|name| name.to_string_lossy().into_owned()).chain(self.beyond.names(folder));
        names.collect::<BTreeSet<_>>().into_iter().collect()
    }

    fn canonical(&self, path: &Path) -> PathBuf {
        self.beyond.canonical(path)
    }
}

/// What something was read from.
#[derive(Debug)]
pub struct Origin {
    /// What it says.
    pub text: String,
    /// Where that stands, or would stand.
    pub path: PathBuf,
    /// It does stand there.
    pub is_file: bool,
    files: Arc<Remembered>,
}

impl Origin {
    /// A text at a path, beside which the disk has the files that it names; a copy has those alone that are given with it.
    pub fn new(text: String, path: PathBuf, is_file: bool, given: Option<Contents>) -> Self {
        let beyond = if given.is_none() { disk() } else { Arc::new(NoFiles) };
        let known = given.into_iter().flatten().map(|(path, bytes)| (path.into(), Some(bytes.into()))).collect();
        Self { text, path, is_file, files: Arc::new(Remembered { known: Mutex::new(known), beyond }) }
    }

    /// The files that it names.
    pub fn source(&self) -> Source {
        Arc::clone(&self.files) as Source
    }

    /// The document to be read.
    pub fn document(&self) -> Document {
        Document::within(&self.source(), self.path.clone(), self.text.clone())
    }

    /// Every file that was read or looked for.
    ///
    /// # Errors
    /// [`Diagnostic`] for one that was looked for and cannot be read now.
    pub fn contents(&self) -> Result<Contents, Diagnostic> {
        let (source, paths) = (self.source(), self.files.known().keys().cloned().collect::<Vec<_>>());
        let content = |path: PathBuf| {
            let bytes = read_bytes(&source, &path, "a file that a copy takes along")?;
            Ok((path.into_os_string(), bytes))
        };
        paths.into_iter().map(content).collect()
    }
}
