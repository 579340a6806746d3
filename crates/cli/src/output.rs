//! Files written whole or not at all: first under another name beside their place, then renamed. A file that stands
//! there is replaced only if slipgrid wrote it.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::time::{Duration, SystemTime};

use crate::interruption;
pub use slipgrid_disk::{Place, WriteError, check_file, check_folder};
use slipgrid_disk::{UNFINISHED, refuse_foreign, unfinished};
use slipgrid_report::{Content, Outputs};

/// Age at which an unfinished file belongs to a run that was killed: writing takes milliseconds.
const ABANDONED: Duration = Duration::from_secs(600);

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

/// `path` as a shell takes it for one word: quoted if it holds anything that a shell would read otherwise.
pub fn quoted(path: &Path) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "/._-+,:@%".contains(letter);
    let path = path.display().to_string();
    if cfg!(windows) {
        // Names there hold no double quotes.
        return if path.contains(' ') { format!("\"{path}\"") } else { path };
    }
    if path.chars().all(plain) { path } else { format!("'{}'", path.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(not(windows))]
    fn paths_are_one_word_of_a_shell() {
        for (path, word) in [
            ("my-material/calibration.toml", "my-material/calibration.toml"),
            ("polym\u{e8}re.toml", "polym\u{e8}re.toml"),
            ("my material.toml", "'my material.toml'"),
            ("Anna's (2).toml", r"'Anna'\''s (2).toml'"),
            ("a$b.toml", "'a$b.toml'"),
        ] {
            assert_eq!(quoted(Path::new(path)), word);
        }
    }

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
}
