//! Atomic writing of files. An existing file is replaced only if slipgrid wrote it.

use std::path::{Path, PathBuf};

use crate::{CliError, interruption};
use slipgrid_io::Failure;
use slipgrid_io::disk::quoted_word;
pub use slipgrid_io::disk::{Place, ResultFolder, WriteError, check_file, check_folder};
use slipgrid_io::formats::Diagnostic;
use slipgrid_report::Outputs;

/// Extensions of matrix text files.
const TEXT_EXTENSIONS: [&str; 5] = ["asc", "txt", "dat", "csv", "tsv"];

/// Checks the path of a map, which is written as matrix text; refuses extensions of other formats.
///
/// # Errors
/// [`CliError`] as for [`check_file`], or if the extension belongs to another format.
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

/// Replaces an earlier result in `folder` by `outputs`.
///
/// # Errors
/// Same as [`ResultFolder::replace`].
pub fn replace(outputs: &Outputs, folder: &ResultFolder) -> Result<(), WriteError> {
    interruption::enter("writing");
    folder.replace(outputs, &interruption::asked)?;
    interruption::wrote(folder.path());
    Ok(())
}

/// Adds `outputs` to the files in `folder`.
///
/// # Errors
/// Same as [`ResultFolder::add`].
pub fn add(outputs: &Outputs, folder: &ResultFolder) -> Result<(), WriteError> {
    interruption::enter("writing");
    folder.add(outputs, &interruption::asked)?;
    interruption::wrote(folder.path());
    Ok(())
}

/// Locks the folder given by a flag, if any, for a result whose files match `patterns`.
///
/// # Errors
/// Same as [`ResultFolder::open`].
pub fn open(path: Option<&PathBuf>, patterns: &[&str], inputs: &[PathBuf]) -> Result<Option<ResultFolder>, Failure> {
    path.map(|path| ResultFolder::open(Place::output(path), patterns, inputs)).transpose()
}

/// Writes one file atomically, and makes its folder if needed. An existing device or pipe is written directly.
///
/// # Errors
/// [`Failure`] if the system refuses, Ctrl-C was pressed, or slipgrid did not write the existing file; `path` then keeps
/// its content.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    slipgrid_io::disk::write_file(Place::output(path), bytes, &[], &interruption::asked)?;
    interruption::wrote(path);
    Ok(())
}

/// Quotes `path` for a shell if it contains special characters.
pub fn quoted(path: &Path) -> String {
    quoted_word(&path.display().to_string())
}
