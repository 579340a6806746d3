//! Files written whole or not at all: first under another name beside their place, then renamed. A file that stands
//! there is replaced only if slipgrid wrote it.

use std::fs;
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use crate::CliError;
use crate::interruption;
use slipgrid_disk::{UNFINISHED, unfinished};
use slipgrid_formats::Diagnostic;
use slipgrid_report::written::{HEAD, begins_as_ours};
use slipgrid_report::{Content, Outputs};

/// Age at which an unfinished file belongs to a run that was killed: writing takes milliseconds.
const ABANDONED: Duration = Duration::from_secs(600);

/// An output that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: cannot be written: {source}", path = path.display())]
pub struct WriteError {
    /// The file or folder.
    pub path: PathBuf,
    /// What the system said.
    pub source: std::io::Error,
}

impl WriteError {
    fn at(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        move |source| Self { path: path.to_owned(), source }
    }
}

/// Writes all of `outputs` into `folder`. A new folder appears with everything in it; in one that
/// exists, files of the same names are replaced one by one once all are ready. Other files stay.
///
/// # Errors
/// [`WriteError`] if the system refuses, or a file of one of the names is not slipgrid's; then the folder holds
/// what it held before, unless a rename failed.
pub fn write(outputs: &Outputs, folder: &Path) -> Result<(), WriteError> {
    interruption::enter("writing");
    let failed = WriteError::at(folder);
    let parent = parent(folder);
    fs::create_dir_all(parent).map_err(&failed)?;
    if folder.is_dir() {
        remove_abandoned(folder);
        let mut files = Vec::new();
        // Looked at before the work; since then others may have come.
        for (name, _) in outputs.iter() {
            refuse_foreign(&folder.join(name))?;
        }
        for (name, content) in outputs.iter() {
            files.push((ready(folder, content).map_err(&failed)?, folder.join(name)));
        }
        let _whole = interruption::shield();
        for (file, path) in files {
            file.persist(&path).map_err(|error| WriteError { path: path.clone(), source: error.error })?;
        }
        interruption::wrote(folder);
        return Ok(());
    }
    remove_abandoned(parent);
    let staging = unfinished(0o777).tempdir_in(parent).map_err(&failed)?;
    for (name, content) in outputs.iter() {
        let file = fs::File::create_new(staging.path().join(name)).map_err(&failed)?;
        write_through(file, content).map_err(&failed)?;
    }
    let _whole = interruption::shield();
    fs::rename(staging.path(), folder).map_err(&failed)?;
    // Renamed away: nothing is left to remove.
    let _ = staging.keep();
    interruption::wrote(folder);
    Ok(())
}

/// Writes one file whole, making its folder if needed.
///
/// # Errors
/// [`WriteError`] if the system refuses, or the file there is not slipgrid's; then `path` holds what it held before.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), WriteError> {
    let failed = WriteError::at(path);
    if fs::metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
        // A device or a pipe is written to; a file in its place would take it away.
        let mut device = fs::File::options().write(true).open(path).map_err(&failed)?;
        return device.write_all(bytes).map_err(&failed);
    }
    // What a link leads to is replaced, not the link.
    let path = &fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    refuse_foreign(path)?;
    let folder = parent(path);
    fs::create_dir_all(folder).map_err(&failed)?;
    remove_abandoned(folder);
    let file = ready(folder, &Content::Bytes(bytes.to_vec())).map_err(&failed)?;
    file.persist(path).map_err(|error| failed(error.error))?;
    interruption::wrote(path);
    Ok(())
}

/// A place for results, as the command line names it.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// The flag.
    pub flag: &'a str,
    /// What stands after it.
    pub path: &'a Path,
}

impl<'a> Place<'a> {
    /// The place after `--output`.
    #[must_use]
    pub const fn output(path: &'a Path) -> Self {
        Self { flag: "--output", path }
    }

    fn refuse(&self, reason: impl Into<String>) -> Diagnostic {
        Diagnostic::flag(self.flag, self.path.display().to_string(), reason)
    }

    /// Refuses a link that leads nowhere.
    fn check_link(&self) -> Result<(), Diagnostic> {
        if !self.path.exists() && self.path.is_symlink() {
            return Err(self.refuse("is a link to what does not exist").expected("a link to something, or no link"));
        }
        Ok(())
    }

    /// Refuses to replace the file at `file` if it is one of `inputs`, or not slipgrid's.
    fn check_replaced(&self, file: &Path, inputs: &[PathBuf]) -> Result<(), Diagnostic> {
        let reason = if inputs.iter().any(|input| is_same(input, file)) {
            "is an input of this run and would be replaced"
        } else if file.is_dir() {
            "is a folder where a file is to go"
        } else if !is_ours(file) {
            "was not written by slipgrid and would be replaced"
        } else {
            return Ok(());
        };
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        let reason = if file == self.path { reason.to_owned() } else { format!("holds {name}, which {reason}") };
        Err(self.refuse(reason).expected("another place, so that nothing is lost"))
    }
}

/// Checks, before long work starts, that results can go to a folder. `names` are those of the files that will be
/// written there, with `*` for any letters; `inputs` are files that this run reads.
///
/// # Errors
/// [`CliError`] if something else than a folder has that name, nothing can be written there, or a file would be
/// replaced that is an input or that slipgrid did not write.
pub fn check_folder(place: Place<'_>, names: &[&str], inputs: &[PathBuf]) -> Result<(), CliError> {
    let folder = place.path;
    place.check_link()?;
    if folder.exists() && !folder.is_dir() {
        return Err(place.refuse("is a file").expected("a folder").into());
    }
    check_parents(place)?;
    let Ok(entries) = fs::read_dir(folder) else { return Ok(()) };
    let mut there: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    there.sort();
    let is_named = |path: &&PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        names.iter().any(|pattern| fits(&name, pattern))
    };
    for file in there.iter().filter(is_named) {
        place.check_replaced(file, inputs)?;
    }
    Ok(())
}

/// Checks, before long work starts, that a result can go to a file; `inputs` are files that this run reads.
///
/// # Errors
/// [`CliError`] if a folder has that name, nothing can be written there, or the file there is an input or was not
/// written by slipgrid.
pub fn check_file(place: Place<'_>, inputs: &[PathBuf]) -> Result<(), CliError> {
    place.check_link()?;
    if place.path.is_dir() {
        return Err(place.refuse("is a folder").expected("a file").into());
    }
    check_parents(place)?;
    if place.path.exists() {
        place.check_replaced(place.path, inputs)?;
    }
    Ok(())
}

/// Whether both paths lead to one file.
fn is_same(left: &Path, right: &Path) -> bool {
    matches!((fs::canonicalize(left), fs::canonicalize(right)), (Ok(left), Ok(right)) if left == right)
}

/// Whether `name` is `pattern`, which may hold one `*` for any letters.
fn fits(name: &str, pattern: &str) -> bool {
    match pattern.split_once('*') {
        None => name == pattern,
        Some((start, end)) => name.len() >= start.len() + end.len() && name.starts_with(start) && name.ends_with(end),
    }
}

/// Whether the file at `path` is one that slipgrid wrote, by how it begins, or is empty. Devices and pipes hold nothing
/// that could be lost.
fn is_ours(path: &Path) -> bool {
    if path.metadata().is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
        return true;
    }
    let mut head = Vec::new();
    if fs::File::open(path).and_then(|file| file.take(HEAD as u64).read_to_end(&mut head)).is_err() {
        return false;
    }
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    head.is_empty() || begins_as_ours(&name, &head)
}

/// # Errors
/// [`WriteError`] if the file at `path` is there and not slipgrid's.
fn refuse_foreign(path: &Path) -> Result<(), WriteError> {
    if !path.exists() || is_ours(path) {
        return Ok(());
    }
    Err(WriteError { path: path.to_owned(), source: io::Error::other("slipgrid did not write the file that is there") })
}

fn check_parents(place: Place<'_>) -> Result<(), CliError> {
    let path = place.path;
    let blocking = path.ancestors().skip(1).find(|above| above.exists());
    match blocking {
        Some(above) if !above.as_os_str().is_empty() && !above.is_dir() => {
            let reason = format!("cannot be made: {} is a file", above.display());
            Err(place.refuse(reason).expected("a path below folders").into())
        }
        _ => Ok(check_writable(path)?),
    }
}

/// Checks that a file can be made where `path` would appear: hours of work should not end at a closed door.
fn check_writable(path: &Path) -> Result<(), WriteError> {
    if fs::metadata(path).is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir()) {
        // A device or a pipe.
        return Ok(());
    }
    let folders = path.ancestors().skip(usize::from(!path.is_dir()));
    let named = folders.map(|above| if above.as_os_str().is_empty() { Path::new(".") } else { above });
    let Some(folder) = named.into_iter().find(|above| above.is_dir()) else { return Ok(()) };
    // It goes away at once.
    unfinished(0o666).tempfile_in(folder).map(drop).map_err(WriteError::at(path))
}

/// The folder that holds `path`.
fn parent(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A file ready to be renamed; it disappears if it is not.
fn ready(folder: &Path, content: &Content) -> io::Result<tempfile::NamedTempFile> {
    let file = unfinished(0o666).tempfile_in(folder)?;
    write_through(file.as_file().try_clone()?, content)?;
    Ok(file)
}

/// Writes everything and waits until it is stored: only then may a file take its name.
fn write_through(file: fs::File, content: &Content) -> io::Result<()> {
    let mut buffered = BufWriter::new(Interruptible(file));
    content.write(&mut buffered)?;
    let Interruptible(file) = buffered.into_inner().map_err(io::IntoInnerError::into_error)?;
    file.sync_data()
}

/// A file that takes nothing more once Ctrl-C was pressed.
struct Interruptible(fs::File);

impl Write for Interruptible {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // Writers try again after errors of the kind `Interrupted`.
        if interruption::asked() { Err(io::Error::other("interrupted")) } else { self.0.write(bytes) }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Removes what killed runs left in `folder`: entries of our unfinished names, old enough that no
/// living run owns them. Failing to do so harms nobody.
fn remove_abandoned(folder: &Path) {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_folder_is_made_whole_and_replaced_file_by_file() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("deep/out");
        let mut outputs = Outputs::default();
        outputs.add("a.stl", "slipgrid one");
        outputs.add("b.stl", "slipgrid two");
        write(&outputs, &folder).unwrap();
        assert_eq!(names(&folder), ["a.stl", "b.stl"]);
        fs::write(folder.join("notes.txt"), "foreign").unwrap();

        let mut outputs = Outputs::default();
        outputs.add("a.stl", "slipgrid three");
        write(&outputs, &folder).unwrap();
        assert_eq!(names(&folder), ["a.stl", "b.stl", "notes.txt"]);
        assert_eq!(fs::read_to_string(folder.join("a.stl")).unwrap(), "slipgrid three");
        // Of a foreign file not even its neighbours are replaced.
        let mut outputs = Outputs::default();
        outputs.add("a.stl", "slipgrid four");
        outputs.add("notes.txt", "slipgrid five");
        let refused = write(&outputs, &folder).unwrap_err().to_string();
        assert!(refused.contains("notes.txt: cannot be written: slipgrid did not write"), "{refused}");
        assert_eq!(fs::read_to_string(folder.join("a.stl")).unwrap(), "slipgrid three");
        assert_eq!(names(&place.path().join("deep")), ["out"]);
    }

    #[test]
    fn nothing_changes_where_a_file_cannot_be_made() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("out");
        let mut outputs = Outputs::default();
        outputs.add("a.txt", "one");
        outputs.add("missing/b.txt", "two");
        assert!(write(&outputs, &folder).is_err());
        assert!(names(place.path()).is_empty());
    }

    #[test]
    fn only_old_unfinished_files_are_removed() {
        let place = tempfile::tempdir().unwrap();
        let old = place.path().join(".slipgrid-old.part");
        for name in [".slipgrid-old.part", ".slipgrid-new.part", "other.part"] {
            fs::write(place.path().join(name), "").unwrap();
        }
        let long_ago = SystemTime::now() - 2 * ABANDONED;
        fs::File::options().write(true).open(&old).unwrap().set_modified(long_ago).unwrap();
        write_file(&place.path().join("a.txt"), b"one").unwrap();
        assert_eq!(names(place.path()), [".slipgrid-new.part", "a.txt", "other.part"]);
    }

    #[test]
    fn an_output_that_cannot_be_is_seen_before_the_work() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        fs::write(&file, "").unwrap();
        let to_folder = |path: &Path| check_folder(Place::output(path), &["a.toml", "map-*.svg"], &[]);
        let to_file = |path: &Path| check_file(Place::output(path), &[]);
        assert!(to_folder(&file).is_err() && to_folder(&file.join("below")).is_err());
        assert!(to_file(place.path()).is_err() && to_file(&place.path().join("new/file")).is_ok());
        assert!(to_folder(Path::new("relative/out")).is_ok() && to_folder(place.path()).is_ok());
        fs::write(place.path().join("map-1.svg"), "<?xml").unwrap();
        let refused = to_folder(place.path()).unwrap_err().to_string();
        assert!(refused.contains("holds map-1.svg, which was not written by slipgrid"), "{refused}");
        assert!(to_file(&place.path().join("map-1.svg")).is_err());
        let place = tempfile::tempdir().unwrap();
        fs::create_dir(place.path().join("a.toml")).unwrap();
        let refused = to_folder(place.path()).unwrap_err().to_string();
        assert!(refused.contains("holds a.toml, which is a folder where a file is to go"), "{refused}");
    }
}
