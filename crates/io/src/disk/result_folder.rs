//! A folder of results that one run at a time writes, and whose files are replaced together.
//!
//! New files are first written under another name. A new folder then appears by one rename. In an existing folder,
//! files are renamed one by one while `result.json` is absent, so that a folder with `result.json` never holds files of
//! two results. Files bear the time at which the folder was opened, before the inputs were read: an input that is
//! newer changed after the run began.

use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::{Content, Failure, Outputs};
use sha2::{Digest, Sha256};
use tempfile::TempDir;

use crate::disk::lock::Lock;
use crate::disk::places::{Place, WriteError, can_create_in, check_folder, matching, refuse_foreign_in};
use crate::disk::written_list::{Hashing, LIST, Written, hexadecimal};
use crate::disk::{UNFINISHED, Writing, parent, put, unfinished};

/// Age above which an unfinished file counts as left over by a killed run; writing takes seconds at most.
const ABANDONED: Duration = Duration::from_secs(600);
/// Main file of a result; a folder without it holds no complete result.
const RECORD: &str = "result.json";
/// File with wall times, which differ between equal runs.
const TIMINGS: &str = "timings.json";

/// A folder of results, locked for this run until dropped.
#[derive(Debug)]
pub struct ResultFolder {
    path: PathBuf,
    patterns: Vec<String>,
    opened: SystemTime,
    _lock: Lock,
}

impl ResultFolder {
    /// Checks with [`check_folder`] that results can be written to `place`, and locks the folder for this run.
    /// `patterns` are the names of all files that a result may have, `inputs` the files that the run reads.
    ///
    /// # Errors
    /// [`Failure`], as in [`check_folder`], and if another run holds the lock.
    pub fn open(place: Place<'_>, patterns: &[&str], inputs: &[PathBuf]) -> Result<Self, Failure> {
        let opened = SystemTime::now();
        check_folder(place, patterns, inputs)?;
        let lock = Lock::new(&lock_path(place.path))?;
        // Another run may have ended since.
        check_folder(place, patterns, inputs)?;
        let patterns = patterns.iter().map(|pattern| (*pattern).to_owned()).collect();
        Ok(Self { path: place.path.to_owned(), patterns, opened, _lock: lock })
    }

    /// The folder as given by the user.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Name of the design or scene whose result is in the folder now; `None` if the folder holds no result.
    pub fn earlier_name(&self) -> Option<String> {
        let record: serde_json::Value = serde_json::from_slice(&fs::read(self.path.join(RECORD)).ok()?).ok()?;
        record.get("name")?.as_str().map(str::to_owned)
    }

    /// Writes all of `outputs`, and removes other files of an earlier result that match the patterns given to `open`,
    /// unless the user has changed them. Ends with an error once `is_cancelled` returns true.
    ///
    /// # Errors
    /// [`WriteError`] for an error of the operating system, or if a file to be replaced was not written by slipgrid;
    /// the folder is then unchanged, unless a rename failed.
    pub fn replace(&self, outputs: &Outputs, is_cancelled: &dyn Fn() -> bool) -> Result<(), WriteError> {
        self.write(outputs, &self.patterns, is_cancelled)
    }

    /// Writes all of `outputs` and removes no other file of the folder.
    ///
    /// # Errors
    /// See [`replace`](Self::replace).
    pub fn add(&self, outputs: &Outputs, is_cancelled: &dyn Fn() -> bool) -> Result<(), WriteError> {
        self.write(outputs, &[], is_cancelled)
    }

    fn write(&self, outputs: &Outputs, stale: &[String], is_cancelled: &dyn Fn() -> bool) -> Result<(), WriteError> {
        let failed = WriteError::at(&self.path);
        // Replace the target of a link, not the link.
        let folder = &fs::canonicalize(&self.path).unwrap_or_else(|_| self.path.clone());
        let mut names = BTreeSet::new();
        if let Some((name, _)) = outputs.iter().find(|(name, _)| !names.insert(*name)) {
            return Err(failed(io::Error::other(format!("two results would have the name {name}"))));
        }
        fs::create_dir_all(parent(folder)).map_err(&failed)?;
        remove_abandoned(parent(folder));
        if !folder.is_dir() {
            let staged =
                Staged::new(outputs, parent(folder), Written::default(), self.opened, is_cancelled).map_err(&failed)?;
            if is_cancelled() {
                return Err(failed(io::Error::other("interrupted")));
            }
            fs::rename(staged.folder.path(), folder).map_err(&failed)?;
            // The folder was renamed, so that nothing is left to remove.
            let _ = staged.folder.keep();
            return Ok(());
        }
        remove_abandoned(folder);
        // The folder was checked before the computation; other files may have been added since.
        names.iter().try_for_each(|name| refuse_foreign_in(folder, Path::new(name)))?;
        let mut written = Written::read(folder);
        let stale: Vec<PathBuf> = stale
            .iter()
            .flat_map(|pattern| matching(folder, pattern))
            .filter(|path| !path.to_str().is_some_and(|name| names.contains(name)) && written.holds(folder, path))
            .collect();
        stale.iter().for_each(|path| written.remove(path));
        let staged = Staged::new(outputs, folder, written, self.opened, is_cancelled).map_err(&failed)?;
        rename_each(&staged, folder, &names, &stale).map_err(failed)
    }
}

/// Files of a result in a temporary folder, ready to be renamed.
struct Staged {
    folder: TempDir,
    // Dropped after the folder.
    _writing: Writing,
}

impl Staged {
    /// Writes `outputs` with the time `opened` to a temporary folder in `place`, together with the list `written`, to
    /// which `outputs` are added.
    fn new(
        outputs: &Outputs,
        place: &Path,
        mut written: Written,
        opened: SystemTime,
        is_cancelled: &dyn Fn() -> bool,
    ) -> io::Result<Self> {
        let writing = Writing::new();
        let folder = unfinished(0o777).tempdir_in(place)?;
        for (name, content) in outputs.iter() {
            let path = folder.path().join(name);
            fs::create_dir_all(parent(&path))?;
            let (file, hash) = write_through(File::create_new(path)?, content, is_cancelled)?;
            // Some file systems refuse to set a time.
            let _ = file.set_modified(opened);
            // Timings differ between runs and have their own mark.
            if name != TIMINGS {
                written.insert(name, hash);
            }
        }
        put(&folder.path().join(LIST), written.to_text().as_bytes())?;
        Ok(Self { folder, _writing: writing })
    }
}

/// Renames the `staged` files into `folder` one by one and removes `stale` files. `result.json` is removed first and
/// renamed after all other results; the list of written files comes last.
fn rename_each(staged: &Staged, folder: &Path, names: &BTreeSet<&str>, stale: &[PathBuf]) -> io::Result<()> {
    let is_record = names.contains(RECORD);
    // First write a list with both old and new files, because a killed run leaves files of both.
    let both = Written::read(folder).to_text() + &fs::read_to_string(staged.folder.path().join(LIST))?;
    put(&folder.join(LIST), both.as_bytes())?;
    if is_record && folder.join(RECORD).is_file() {
        fs::remove_file(folder.join(RECORD))?;
    }
    let rename = |name: &str| {
        fs::create_dir_all(parent(&folder.join(name)))?;
        fs::rename(staged.folder.path().join(name), folder.join(name))
    };
    names.iter().filter(|name| **name != RECORD).try_for_each(|name| rename(name))?;
    for path in stale {
        fs::remove_file(folder.join(path))?;
    }
    if is_record {
        rename(RECORD)?;
    }
    rename(LIST)
}

/// Writes `content` to `file`, waits until it is stored on the disk, and returns the file and its SHA-256. The file may
/// be renamed only afterwards.
fn write_through(file: File, content: &Content, is_cancelled: &dyn Fn() -> bool) -> io::Result<(File, String)> {
    let mut buffered = BufWriter::new(Hashing { to: file, hash: Sha256::new(), is_cancelled });
    content(&mut buffered)?;
    let Hashing { to: file, hash, .. } = buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.sync_data()?;
    Ok((file, hexadecimal(&hash.finalize())))
}

/// Removes files and folders with unfinished names in `folder` that are so old that no running process owns them.
/// Errors are ignored.
pub(crate) fn remove_abandoned(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let ours = name.starts_with(UNFINISHED.0) && name.ends_with(UNFINISHED.1);
        let old = entry
            .metadata()
            .and_then(|metadata| metadata.modified())
            .is_ok_and(|modified| SystemTime::now().duration_since(modified).is_ok_and(|age| age > ABANDONED));
        if ours && old {
            let path = entry.path();
            let _ = if path.is_dir() { fs::remove_dir_all(&path) } else { fs::remove_file(&path) };
        }
    }
}

/// Path of the lock file for `folder`: NAME.lock next to the folder, or `.slipgrid.lock` inside if its parent is not
/// writable.
fn lock_path(folder: &Path) -> PathBuf {
    let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
    let mut name = folder.file_name().map_or_else(OsString::new, OsString::from);
    name.push(".lock");
    match folder.file_name() {
        Some(_) if !folder.is_dir() || can_create_in(parent(&folder)).is_ok() => folder.with_file_name(name),
        _ => folder.join(".slipgrid.lock"),
    }
}

/// Writes `files`, pairs of name and content, into the folder at `place` after checking all of them; creates the folder
/// if needed. `inputs` are files from which the results were made.
///
/// # Errors
/// [`Failure`], as in [`check_folder`], or for an error of the operating system.
pub fn write_folder(place: Place<'_>, files: &[(String, Vec<u8>)], inputs: &[PathBuf]) -> Result<(), Failure> {
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    let mut outputs = Outputs::default();
    files.iter().for_each(|(name, bytes)| outputs.add(name.as_str(), bytes.as_slice()));
    Ok(ResultFolder::open(place, &names, inputs)?.replace(&outputs, &|| false)?)
}

#[cfg(test)]
mod tests;
