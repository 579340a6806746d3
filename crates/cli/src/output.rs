//! Files written whole or not at all. A file that stands there is replaced only if slipgrid wrote it.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::{CliError, interruption};
pub use slipgrid_disk::{Place, ResultFolder, WriteError, check_file, check_folder};
use slipgrid_disk::{PlaceError, put, refuse_foreign};
use slipgrid_formats::Diagnostic;
use slipgrid_report::Outputs;

/// Extensions of files that hold matrix text.
const TEXT_EXTENSIONS: [&str; 5] = ["asc", "txt", "dat", "csv", "tsv"];

/// Looks at the place of a map, which is written as matrix text: a name that ends as those of another format is refused.
///
/// # Errors
/// [`CliError`] as of [`check_file`], or if the name is one of another format.
pub fn check_map_file(place: Place<'_>, inputs: &[PathBuf]) -> Result<(), CliError> {
    if let Some(extension) = place.path.extension().and_then(|extension| extension.to_str())
        && !TEXT_EXTENSIONS.contains(&&extension.to_lowercase()[..])
    {
        let reason = format!("is no name of a map: it is written as matrix text, not as .{extension}");
        let refused = Diagnostic::flag(place.flag, place.path.display().to_string(), reason);
        return Err(refused.expected("a name that ends in .asc or .txt").into());
    }
    Ok(check_file(place, inputs)?)
}

/// Has `outputs` replace what `folder` holds of an earlier result.
///
/// # Errors
/// As [`ResultFolder::replace`].
pub fn replace(outputs: &Outputs, folder: &ResultFolder) -> Result<(), WriteError> {
    interruption::enter("writing");
    folder.replace(outputs, &interruption::asked)?;
    interruption::wrote(folder.path());
    Ok(())
}

/// Writes `outputs` beside what `folder` holds.
///
/// # Errors
/// As [`ResultFolder::add`].
pub fn add(outputs: &Outputs, folder: &ResultFolder) -> Result<(), WriteError> {
    interruption::enter("writing");
    folder.add(outputs, &interruption::asked)?;
    interruption::wrote(folder.path());
    Ok(())
}

/// Locks the folder after a flag, where one is given, for a result of files that fit `patterns`.
///
/// # Errors
/// As [`ResultFolder::open`].
pub fn open(path: Option<&PathBuf>, patterns: &[&str], inputs: &[PathBuf]) -> Result<Option<ResultFolder>, PlaceError> {
    path.map(|path| ResultFolder::open(Place::output(path), patterns, inputs)).transpose()
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
    put(path, bytes).map_err(&failed)?;
    interruption::wrote(path);
    Ok(())
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
}
