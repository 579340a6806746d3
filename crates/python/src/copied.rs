//! Copies: what a scene, a design or a calibration was read from travels with it, so that it is read again where its files are not.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use slipgrid::formats::file_kind::FileKind;
use slipgrid::formats::source::{Entry, Files, NoFiles, Source, read_bytes};
use slipgrid::formats::{Diagnostic, Document};
use slipgrid_disk::{Disk, disk};

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

/// The disk by paths that count from a folder, wherever the process goes meanwhile.
#[derive(Clone, Debug)]
pub struct Anchored {
    folder: PathBuf,
}

impl Anchored {
    /// The disk by paths that count from where the process is.
    fn here() -> Self {
        Self { folder: std::env::current_dir().unwrap_or_default() }
    }

    /// Where `path` leads.
    fn place(&self, path: &Path) -> PathBuf {
        self.folder.join(path)
    }

    /// As a source of files.
    pub fn source(&self) -> Source {
        Arc::new(self.clone())
    }

    /// A `path` that counts from where the process is now, as it is where that is still the same folder.
    pub fn seen_from_there(&self, path: PathBuf) -> PathBuf {
        let here = Self::here();
        if here.folder == self.folder { path } else { here.place(&path) }
    }
}

impl Files for Anchored {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        Disk.read(&self.place(path))
    }

    fn stream(&self, path: &Path) -> io::Result<Box<dyn io::Read>> {
        Disk.stream(&self.place(path))
    }

    fn entry(&self, path: &Path) -> io::Result<Entry> {
        Disk.entry(&self.place(path))
    }

    fn names(&self, folder: &Path) -> Vec<String> {
        Disk.names(&self.place(folder))
    }

    fn canonical(&self, path: &Path) -> PathBuf {
        Disk.canonical(&self.place(path))
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
    /// The disk, by paths that count from where the process was then.
    pub disk: Anchored,
    files: Arc<Remembered>,
}

impl Origin {
    /// A text at a path, beside which the disk has the files that it names; a copy has those alone that are given with it.
    pub fn new(text: String, path: PathBuf, is_file: bool, given: Option<Contents>) -> Self {
        let disk = Anchored::here();
        let beyond = if given.is_none() { disk.source() } else { Arc::new(NoFiles) };
        let known = given.into_iter().flatten().map(|(path, bytes)| (path.into(), Some(bytes.into()))).collect();
        Self { text, path, is_file, disk, files: Arc::new(Remembered { known: Mutex::new(known), beyond }) }
    }

    /// The file at `path`, which should be a `kind`.
    ///
    /// # Errors
    /// [`Diagnostic`] if it cannot be read, is no text, or seems to be another kind of file.
    pub fn read(path: PathBuf, kind: FileKind) -> Result<Self, Diagnostic> {
        let text = Document::read(&disk(), &path, kind)?.text().to_owned();
        Ok(Self::new(text, path, true, None))
    }

    /// The files that it names.
    pub fn source(&self) -> Source {
        Arc::clone(&self.files) as Source
    }

    /// The document to be read, which should be a `kind`.
    ///
    /// # Errors
    /// [`Diagnostic`] if it seems to be another kind.
    pub fn document(&self, kind: FileKind) -> Result<Document, Diagnostic> {
        let document = Document::within(&self.source(), self.path.clone(), self.text.clone());
        document.require(kind)?;
        Ok(document.as_kind(kind))
    }

    /// Where the files of `named` stand that a run reads: its own only if the text came from there.
    pub fn inputs(&self, named: &[PathBuf]) -> Vec<PathBuf> {
        let read = named.iter().filter(|input| self.is_file || **input != self.path);
        read.map(|input| self.disk.place(input)).collect()
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
