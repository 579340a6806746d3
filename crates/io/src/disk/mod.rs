//! File access for front ends: [`Disk`] reads and writes files for libraries without file access, [`Place`] checks
//! where results may be written without loss, [`ResultFolder`] replaces a folder of results as a whole, and
//! [`KeptResults`] is a cache of results in a folder.
//!
//! Only this module and the front ends access files. A cached result is bit-identical to the computed one, and runs with
//! an empty cache, or without one, give the same bytes:
//!
//! ```
//! use slipgrid_io::disk::KeptResults;
//! use slipgrid_base::monitor::{Key, Memory};
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
mod words;
mod written;
mod written_list;

pub use files::{Disk, disk};
pub use kept_results::KeptResults;
pub use places::{Place, WriteError, check_file, check_folder, write_file};
pub use result_folder::{ResultFolder, write_folder};
pub use words::quoted_word;
pub use written_list::hexadecimal;

use std::fs;
use std::io;
use std::io::Write;
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::formats::Diagnostic;

/// Maximum number of threads of a pool: more than the cores of any machine, but few enough for all to be created.
pub const MAX_THREADS: usize = 1024;

/// Number of cores that this process may use, at most [`MAX_THREADS`].
pub fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from).min(MAX_THREADS)
}

/// Default number of threads: the value of the environment variable `RAYON_NUM_THREADS`, otherwise the number of cores.
///
/// # Errors
/// [`Diagnostic`] if the environment variable is invalid or above [`MAX_THREADS`].
pub fn default_threads() -> Result<usize, Diagnostic> {
    const VARIABLE: &str = "RAYON_NUM_THREADS";
    let Some(named) = std::env::var(VARIABLE).ok().filter(|text| !text.is_empty()) else { return Ok(cores()) };
    match named.parse() {
        Ok(0) => Ok(cores()),
        Ok(threads) if threads <= MAX_THREADS => Ok(threads),
        _ => Err(Diagnostic::flag(VARIABLE, named, "is no number of threads")
            .expected(format!("a whole number up to {MAX_THREADS}, or no such variable"))),
    }
}

/// Prefix and suffix of the name of an unfinished file or folder.
pub const UNFINISHED: (&str, &str) = (".slipgrid-", ".part");

/// Number of files and folders that this process is writing.
static WRITING: Mutex<usize> = Mutex::new(0);

/// Blocks further writing while the returned guard lives, so that the program can end; `None` while a file is
/// unfinished or a result partially renamed.
pub fn hold_writing() -> Option<MutexGuard<'static, usize>> {
    // A counter is complete even if a thread panicked.
    let writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    (*writing == 0).then_some(writing)
}

/// Counts one write as unfinished until dropped; must be dropped after unfinished files have been removed.
pub(crate) struct Writing;

impl Writing {
    pub(crate) fn new() -> Self {
        *WRITING.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        Self
    }
}

impl Drop for Writing {
    fn drop(&mut self) {
        *WRITING.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
    }
}

/// Writes a file atomically and creates its folder if needed: the file is written under another name in the same folder
/// and then renamed. An existing file is replaced without a check.
///
/// # Errors
/// Error of the operating system.
pub fn put(path: &Path, bytes: &[u8]) -> io::Result<()> {
    put_unless(path, bytes, &|| false)
}

/// Writes a file like [`put`], unless `is_cancelled` returns true before the file is renamed.
///
/// # Errors
/// Error of the operating system, or an error after cancellation; an existing file then keeps its content.
pub fn put_unless(path: &Path, bytes: &[u8], is_cancelled: &dyn Fn() -> bool) -> io::Result<()> {
    let folder = parent(path);
    fs::create_dir_all(folder)?;
    let _writing = Writing::new();
    let mut file = unfinished(0o666).tempfile_in(folder)?;
    file.write_all(bytes)?;
    // Storing may take seconds.
    file.as_file().sync_data()?;
    if is_cancelled() {
        return Err(io::Error::other("interrupted"));
    }
    file.persist(path).map(drop).map_err(|error| error.error)
}

/// Parent folder of `path`; `.` for a bare file name.
pub fn parent(path: &Path) -> &Path {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Builder of temporary files and folders with the prefix and suffix `UNFINISHED` and the permissions `mode`, reduced
/// by the user's umask; without `mode` only the owner could read the files.
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
