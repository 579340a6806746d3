//! Checks where results may be written: inputs of a run and files not written by slipgrid are never replaced.

use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use crate::Failure;
use crate::disk::written::{HEAD, has_mark};
use crate::formats::Diagnostic;
use crate::formats::source::fits;

use crate::disk::written_list::{LIST, Written, hexadecimal};
use crate::disk::{Writing, parent, put, put_unless, unfinished};

/// Error of the operating system while an output was written.
#[derive(Debug, thiserror::Error)]
#[error("{path}: cannot be written: {source}", path = path.display())]
pub struct WriteError {
    /// File or folder that could not be written.
    pub path: PathBuf,
    /// Error of the operating system.
    pub source: std::io::Error,
}

impl WriteError {
    /// Returns a function that adds `path` to an error of the operating system.
    pub fn at(path: &Path) -> impl Fn(std::io::Error) -> Self + '_ {
        move |source| Self { path: path.to_owned(), source }
    }
}

/// A place for results, with the flag or argument by which the user names it.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// Flag or argument that names the place.
    pub flag: &'a str,
    /// Path of the place.
    pub path: &'a Path,
}

impl<'a> Place<'a> {
    /// The place given by `--output`.
    pub const fn output(path: &'a Path) -> Self {
        Self { flag: "--output", path }
    }

    fn refuse(&self, reason: impl Into<String>) -> Diagnostic {
        Diagnostic::flag(self.flag, self.path.display().to_string(), reason)
    }

    /// Refuses a symbolic link whose target does not exist.
    fn check_link(&self) -> Result<(), Diagnostic> {
        if !self.path.exists() && self.path.is_symlink() {
            return Err(self.refuse("is a link to what does not exist").expected("a link to something, or no link"));
        }
        Ok(())
    }

    /// Refuses to replace the file at `path` in `folder` if it is one of `inputs`, or was not written by slipgrid.
    fn check_replaced(&self, folder: &Path, path: &Path, inputs: &[PathBuf]) -> Result<(), Diagnostic> {
        let file = &folder.join(path);
        let reason = if inputs.iter().any(|input| is_same(input, file)) {
            "is an input of this run and would be replaced"
        } else if file.is_dir() {
            "is a folder where a file is to go"
        } else if !is_ours(folder, path) {
            "was not written by slipgrid, or was changed since, and would be replaced"
        } else {
            return Ok(());
        };
        let reason =
            if self.path.is_dir() { format!("holds {}, which {reason}", path.display()) } else { reason.to_owned() };
        Err(self.refuse(reason).expected("another place, so that nothing is lost"))
    }
}

/// Checks, before long work starts, that results can be written to a folder. `names` are the files that will be
/// written, where one `*` stands for any characters and `/` for subfolders; `inputs` are files that the run reads.
///
/// # Errors
/// [`Failure`] if the place is not a folder, is not writable, or holds a file to be replaced that is an input or was
/// not written by slipgrid.
pub fn check_folder(place: Place<'_>, names: &[&str], inputs: &[PathBuf]) -> Result<(), Failure> {
    let folder = place.path;
    place.check_link()?;
    if folder.exists() && !folder.is_dir() {
        return Err(place.refuse("is a file").expected("a folder").into());
    }
    check_parents(place)?;
    let mut there: Vec<PathBuf> = names.iter().flat_map(|pattern| matching(folder, pattern)).collect();
    there.sort();
    there.iter().try_for_each(|path| place.check_replaced(folder, path, inputs))?;
    Ok(())
}

/// Existing paths, relative to `folder`, that match `pattern`, in which `*` stands for any characters.
pub(crate) fn matching(folder: &Path, pattern: &str) -> Vec<PathBuf> {
    let (first, rest) = pattern.split_once('/').map_or((pattern, None), |(first, rest)| (first, Some(rest)));
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let named =
        entries.map(|entry| PathBuf::from(entry.file_name())).filter(|name| fits(&name.to_string_lossy(), first));
    let Some(rest) = rest else { return named.collect() };
    let below = |name: PathBuf| {
        let inside = folder.join(&name);
        // A file with the name of the required folder.
        let found = if inside.is_dir() { matching(&inside, rest) } else { vec![PathBuf::new()] };
        found.into_iter().map(move |path| if path.as_os_str().is_empty() { name.clone() } else { name.join(path) })
    };
    named.flat_map(below).collect()
}

/// Checks, before long work starts, that a result can be written to a file; `inputs` are files that the run reads.
///
/// # Errors
/// [`Failure`] if the place is a folder, is not writable, or holds a file that is an input or was not written by
/// slipgrid.
pub fn check_file(place: Place<'_>, inputs: &[PathBuf]) -> Result<(), Failure> {
    place.check_link()?;
    if place.path.is_dir() {
        return Err(place.refuse("is a folder").expected("a file").into());
    }
    check_parents(place)?;
    if place.path.exists() {
        let name = place.path.file_name().map_or(place.path, Path::new);
        place.check_replaced(parent(place.path), name, inputs)?;
    }
    Ok(())
}

/// Writes `bytes` to the file at `place` and creates its folder if needed; `inputs` are files from which the content was
/// computed; they are never replaced. Ends with an error once `is_cancelled` returns true.
///
/// # Errors
/// [`Failure`], as in [`check_file`], or for an error of the operating system.
pub fn write_file(
    place: Place<'_>,
    bytes: &[u8],
    inputs: &[PathBuf],
    is_cancelled: &dyn Fn() -> bool,
) -> Result<(), Failure> {
    check_file(place, inputs)?;
    // The target of a link is replaced, not the link; a device is opened, because a renamed file would replace it.
    let path = fs::canonicalize(place.path).unwrap_or_else(|_| place.path.to_owned());
    let (folder, name) = (parent(&path), path.file_name().map_or("".into(), |name| name.to_string_lossy()));
    let (mut listed, hash) = (Written::read(folder), hexadecimal(&Sha256::digest(bytes)));
    let is_listed = listed.names(Path::new(&*name));
    let list = |listed: &Written| {
        let written = if is_listed { put(&folder.join(LIST), listed.to_text().as_bytes()) } else { Ok(()) };
        written.map_err(WriteError::at(place.path))
    };
    // A killed run leaves the old or the new file: meanwhile the list has both.
    listed.add(&name, hash.clone());
    list(&listed)?;
    let written = if is_device(&path) { fs::write(&path, bytes) } else { put_unless(&path, bytes, is_cancelled) };
    written.map_err(WriteError::at(place.path))?;
    listed.insert(&name, hash);
    list(&listed)?;
    Ok(())
}

/// Whether `path` is a device or a pipe, which holds no data to lose and must not be replaced by a file.
fn is_device(path: &Path) -> bool {
    path.metadata().is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir())
}

/// Whether both paths refer to the same file.
fn is_same(left: &Path, right: &Path) -> bool {
    matches!((fs::canonicalize(left), fs::canonicalize(right)), (Ok(left), Ok(right)) if left == right)
}

/// Whether the file at `path` in `folder` was written by slipgrid, or is empty. The list of written files in `folder`
/// decides if it names the file, because a file that was changed since still has its mark; otherwise the mark decides.
/// Devices and pipes count as written by slipgrid: they hold no data to lose.
fn is_ours(folder: &Path, path: &Path) -> bool {
    let file = &folder.join(path);
    if is_device(file) {
        return true;
    }
    let mut head = Vec::new();
    if fs::File::open(file).and_then(|file| file.take(HEAD as u64).read_to_end(&mut head)).is_err() {
        return false;
    }
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    let written = Written::read(folder);
    head.is_empty() || if written.names(path) { written.holds(folder, path) } else { has_mark(&name, &head) }
}

/// Refuses to replace a file in `folder` that slipgrid did not write.
///
/// # Errors
/// [`WriteError`] if the file at `path` in the folder exists and was not written by slipgrid.
pub(crate) fn refuse_foreign_in(folder: &Path, path: &Path) -> Result<(), WriteError> {
    let file = folder.join(path);
    if !file.exists() || is_ours(folder, path) {
        return Ok(());
    }
    Err(WriteError {
        path: file,
        source: io::Error::other("slipgrid did not write the file that is there, or it was changed since"),
    })
}

fn check_parents(place: Place<'_>) -> Result<(), Failure> {
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

/// Checks that a file can be created at `path`, so that hours of work are not lost at the end.
fn check_writable(path: &Path) -> Result<(), WriteError> {
    if is_device(path) {
        return Ok(());
    }
    let folders = path.ancestors().skip(usize::from(!path.is_dir()));
    let named = folders.map(|above| if above.as_os_str().is_empty() { Path::new(".") } else { above });
    let Some(folder) = named.into_iter().find(|above| above.is_dir()) else { return Ok(()) };
    can_create_in(folder).map_err(WriteError::at(path))
}

/// Creates a file in `folder` and removes it at once, to check that `folder` is writable.
pub(crate) fn can_create_in(folder: &Path) -> io::Result<()> {
    let _writing = Writing::new();
    unfinished(0o666).tempfile_in(folder).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::write_folder;

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
        fs::write(place.path().join("next-1"), "a file").unwrap();
        let refused = check_folder(Place::output(place.path()), &["next-*/a.svg"], &[]).unwrap_err().to_string();
        assert!(refused.contains("holds next-1, which was not written by slipgrid"), "{refused}");
    }

    #[test]
    fn neither_inputs_nor_files_of_others_are_replaced() {
        let place = tempfile::tempdir().unwrap();
        let at = |name: &str| place.path().join(name);
        let files = |names: &[&str]| -> Vec<(String, Vec<u8>)> {
            names.iter().map(|name| ((*name).to_owned(), b"slipgrid new".to_vec())).collect()
        };
        let folder = Place { flag: "folder", path: place.path() };
        fs::write(at("b.stl"), "mine").unwrap();
        let refused = write_folder(folder, &files(&["a.stl", "b.stl"]), &[]).unwrap_err().to_string();
        assert!(refused.starts_with("folder: ") && refused.contains("holds b.stl, which was not written"), "{refused}");
        // If one file is foreign, no other file is written either.
        assert!(!at("a.stl").exists() && fs::read(at("b.stl")).unwrap() == b"mine");
        write_folder(folder, &files(&["a.stl"]), &[]).unwrap();
        write_folder(folder, &files(&["a.stl"]), &[]).unwrap();
        let refused = write_folder(folder, &files(&["a.stl"]), &[at("a.stl")]).unwrap_err().to_string();
        assert!(refused.contains("holds a.stl, which is an input of this run"), "{refused}");
        let file = |name: &str| write_file(Place { flag: "path", path: &at(name) }, b"slipgrid newer", &[], &|| false);
        // A file with a mark, filled in by a person.
        write_folder(folder, &[("trials.toml".to_owned(), b"# Trials of one disc, by slipgrid: new".to_vec())], &[])
            .unwrap();
        file("trials.toml").unwrap();
        file("trials.toml").unwrap();
        fs::write(at("trials.toml"), "# Trials of one disc, by slipgrid: ratio 0.9").unwrap();
        let refused = refuse_foreign_in(place.path(), Path::new("trials.toml")).unwrap_err().to_string();
        assert!(refused.contains("changed since") && file("trials.toml").is_err(), "{refused}");
        file("deep/c.stl").unwrap();
        file("a.stl").unwrap();
        assert_eq!(fs::read(at("a.stl")).unwrap(), b"slipgrid newer");
        assert!(file("b.stl").unwrap_err().to_string().starts_with("path: "));
    }
}
