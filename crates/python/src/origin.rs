//! Copies of scenes, designs and calibrations: they carry the files that they were read from, so that they can be restored anywhere.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use slipgrid::disk::{Disk, disk};
use slipgrid::formats::file_kind::FileKind;
use slipgrid::formats::source::{Entry, Files, NoFiles, Source, read_bytes};
use slipgrid::formats::{Diagnostic, Document};

/// Contents of files by path. The paths are not `pathlib` paths, which would normalize some paths that are looked up verbatim.
pub type Contents = BTreeMap<OsString, Vec<u8>>;

/// File source that keeps every file that was read.
#[derive(Debug)]
struct Remembered {
    /// Contents by path; `None` for a file whose existence was checked only.
    known: Mutex<BTreeMap<PathBuf, Option<Arc<[u8]>>>>,
    /// Source of other files: the disk, or an empty source for a copy.
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

/// The disk, with relative paths from the current folder of this moment.
fn here() -> Disk {
    Disk::from_folder(std::env::current_dir().unwrap_or_default())
}

/// Makes a `path` relative to the current folder absolute; keeps it if `disk` starts from the current folder.
pub fn to_absolute(disk: &Disk, path: PathBuf) -> PathBuf {
    let here = here();
    if here == *disk { path } else { here.place(&path) }
}

/// Input for a scene, design or calibration: its text, `None` to read it from its file; contents of objects in the text
/// by path; and for a copy whether the text came from a file, and contents of all files that it reads by path.
pub type Given = (Option<String>, Option<Contents>, Option<(bool, Contents)>);

/// Arguments from which a copy is made: text, path, no objects, and the value of `copied`.
pub type Parts = (String, OsString, Option<Contents>, (bool, Contents));

/// Text and files that a scene, design or calibration was read from.
#[derive(Debug)]
pub struct Origin {
    /// Text of the scene, design or calibration.
    pub text: String,
    /// Path of the text, which need not exist.
    pub path: PathBuf,
    /// The file at `path` exists.
    pub is_file: bool,
    /// The scene, design or calibration is a copy, whose warnings were given when the original was made.
    pub is_copy: bool,
    /// The disk, with relative paths from the current folder at construction.
    pub disk: Disk,
    files: Arc<Remembered>,
}

impl Origin {
    /// Makes the origin of `text`, by default that of the file at `path`, which should be a `kind`, and parses it. Files named in
    /// the text are `objects`, or are read from the disk; for a copy, `copied` has all available files, and whether the file at
    /// `path` exists.
    ///
    /// # Errors
    /// [`Diagnostic`] if the file at `path` cannot be read, is not text, or seems to be another kind of file; errors of `parse`.
    pub fn read<T>(
        kind: FileKind,
        given: Given,
        path: PathBuf,
        parse: impl FnOnce(Document) -> Result<T, Diagnostic>,
    ) -> Result<(Self, T), Diagnostic> {
        let (text, objects, copied) = given;
        let (is_copy, is_read) = (copied.is_some(), text.is_none());
        let text = text.map_or_else(|| Ok(Document::read(&disk(), &path, kind)?.text().to_owned()), Ok)?;
        let disk = here();
        let beyond = if is_copy { Arc::new(NoFiles) as Source } else { Arc::new(disk.clone()) };
        let (is_file, files) = copied.unwrap_or_else(|| (is_read, Contents::new()));
        let all = files.into_iter().chain(objects.into_iter().flatten());
        let known = all.map(|(path, bytes)| (path.into(), Some(bytes.into()))).collect();
        let files = Arc::new(Remembered { known: Mutex::new(known), beyond });
        let origin = Self { text, path, is_file, is_copy, disk, files };
        let document = Document::within(&origin.source(), origin.path.clone(), origin.text.clone());
        document.require(kind)?;
        let read = parse(document.as_kind(kind))?;
        Ok((origin, read))
    }

    /// Source of the files named in the text.
    pub fn source(&self) -> Source {
        Arc::clone(&self.files) as Source
    }

    /// Absolute paths of `named`, the files that a run reads; omits the object's own path if the text did not come from that file.
    pub fn inputs(&self, named: &[PathBuf]) -> Vec<PathBuf> {
        let read = named.iter().filter(|input| self.is_file || **input != self.path);
        read.map(|input| self.disk.place(input)).collect()
    }

    /// Text, path, and contents of every file that was read or whose existence was checked.
    ///
    /// # Errors
    /// [`Diagnostic`] if a file whose existence was only checked cannot be read now.
    pub fn parts(&self) -> Result<Parts, Diagnostic> {
        let (source, paths) = (self.source(), self.files.known().keys().cloned().collect::<Vec<_>>());
        let content = |path: PathBuf| {
            let bytes = read_bytes(&source, &path, "a file that a copy takes along")?;
            Ok((path.into_os_string(), bytes))
        };
        let files = paths.into_iter().map(content).collect::<Result<_, Diagnostic>>()?;
        Ok((self.text.clone(), self.path.clone().into(), None, (self.is_file, files)))
    }
}
