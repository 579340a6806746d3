//! What front doors share of the system: [`Disk`] reads and writes files for libraries that know none, [`Place`] is where results
//! go without anything being lost, [`ResultFolder`] a folder of them that is replaced as a whole, and [`KeptResults`] is a folder of results by their content, so that nothing is computed twice.
//!
//! Only this crate and the front doors themselves touch files. A kept result is the one that would be computed, to the last
//! bit; a run with an empty folder, or without one, gives the same bytes:
//!
//! ```
//! use slipgrid_disk::KeptResults;
//! use slipgrid_monitor::{Key, Memory};
//!
//! let place = tempfile::tempdir().unwrap();
//! let kept = KeptResults::new(place.path().join("cache"), "this build", 1 << 20);
//! let key = Key::of("run", &(0.65e6, "flat"));
//! assert_eq!(kept.recall(&key), None);
//! kept.keep(&key, b"mu = 0.2488");
//! assert_eq!(kept.recall(&key).as_deref(), Some(&b"mu = 0.2488"[..]));
//! // Another build of the program may compute other numbers.
//! assert_eq!(KeptResults::new(place.path().join("cache"), "another build", 1 << 20).recall(&key), None);
//! ```

mod files;
mod kept_results;
pub mod lock;
mod places;
mod result_folder;
mod written_list;

pub use files::{Disk, disk};
pub use kept_results::KeptResults;
pub use places::{Place, PlaceError, WriteError, check_file, check_folder, refuse_foreign, write_file, write_folder};
pub use result_folder::{ResultFolder, hold_renaming};

use std::fs;
use std::io;
use std::io::Write;
use std::path::Path;

use slipgrid_formats::Diagnostic;

/// Most threads of a pool: more than one machine has cores, and few enough to be made in an instant.
pub const MAX_THREADS: usize = 1024;

/// Threads of a pool for which nobody asked by a number: those that the environment names in `RAYON_NUM_THREADS`, else as many as cores.
///
/// # Errors
/// [`Diagnostic`] where the environment names more than [`MAX_THREADS`].
pub fn default_threads() -> Result<usize, Diagnostic> {
    const VARIABLE: &str = "RAYON_NUM_THREADS";
    let cores = std::thread::available_parallelism().map_or(1, usize::from).min(MAX_THREADS);
    let Some(named) = std::env::var(VARIABLE).ok().filter(|text| !text.is_empty()) else { return Ok(cores) };
    match named.parse() {
        Ok(0) => Ok(cores),
        Ok(threads) if threads <= MAX_THREADS => Ok(threads),
        _ => Err(Diagnostic::flag(VARIABLE, named, "is no number of threads")
            .expected(format!("a whole number up to {MAX_THREADS}, or no such variable"))),
    }
}

/// Name of a file that is not finished, at its beginning and end.
pub const UNFINISHED: (&str, &str) = (".slipgrid-", ".part");

/// Has a file appear whole, making its folder if needed, without a look at what stands there: it is written under another name
/// beside its place, then renamed.
///
/// # Errors
/// What the system said.
pub fn put(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let folder = parent(path);
    fs::create_dir_all(folder)?;
    let mut file = unfinished(0o666).tempfile_in(folder)?;
    file.write_all(bytes)?;
    file.as_file().sync_data()?;
    file.persist(path).map(drop).map_err(|error| error.error)
}

/// The folder that holds `path`.
#[must_use]
pub fn parent(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// A maker of files and folders of unfinished names, with permissions `mode` before the user's mask: temporary ones are
/// otherwise private.
#[must_use]
pub fn unfinished(mode: u32) -> tempfile::Builder<'static, 'static> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(UNFINISHED.0).suffix(UNFINISHED.1);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(mode));
    }
    #[cfg(not(unix))]
    let _ = mode;
    builder
}
