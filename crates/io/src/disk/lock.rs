//! Lock file next to a folder of results, so that one run at a time writes it.
//!
//! The operating system releases the lock when the process ends in any way, so that the next run takes over the lock
//! file of a killed run. On file systems without locks, nothing prevents two runs from writing at once.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::formats::Diagnostic;

use crate::Failure;
use crate::disk::places::WriteError;

/// Number of attempts to lock a file that the last holder removes between opening and locking.
const ATTEMPTS: usize = 20;
/// First word of a lock file; the id of the process follows.
const MARK: &str = "slipgrid";
/// Maximum number of bytes that are read from a lock file.
const HEAD: u64 = 100;

/// Lock files that this process holds.
static HELD: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn held() -> MutexGuard<'static, Vec<PathBuf>> {
    // Paths are complete when they are inserted, so that a poisoned lock is harmless.
    HELD.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all lock files of this process, before the program ends.
pub fn remove_all() {
    for path in held().drain(..) {
        let _ = fs::remove_file(path);
    }
}

/// A locked file, held until it is dropped. Dropping removes the lock file, and those folders created for the file that
/// are empty.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    file: Option<File>,
    /// Folders that were created for the lock file, innermost first.
    made: Vec<PathBuf>,
}

impl Lock {
    /// Locks the file at `path` for this process.
    ///
    /// # Errors
    /// [`Diagnostic`] if another run holds the lock, or a folder or a foreign file is at `path`; [`WriteError`] for an
    /// error of the operating system.
    pub fn new(path: &Path) -> Result<Self, Failure> {
        let failed = |source: io::Error| WriteError { path: path.to_owned(), source };
        if path.is_dir() {
            return Err(Diagnostic::file(path, "is a folder where a file is to go").expected("no such folder").into());
        }
        let missing = |above: &&Path| !above.as_os_str().is_empty() && !above.exists();
        let made: Vec<PathBuf> = path.ancestors().skip(1).take_while(missing).map(Path::to_owned).collect();
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent).map_err(failed)?;
        }
        let mut lock = Self { path: path.to_owned(), file: None, made };
        for _ in 0..ATTEMPTS {
            let mut file =
                File::options().read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
            let head = read_head(&mut file);
            if matches!(file.try_lock(), Err(TryLockError::WouldBlock)) {
                return Err(lock.refuse(&head.unwrap_or_default()).into());
            }
            // The last holder may have removed the file between opening and locking.
            if !is_there(&file, path) {
                continue;
            }
            let head = head.map_err(failed)?;
            let mut words = head.split_whitespace();
            let names_process = words.next() == Some(MARK) && words.next().is_some_and(|id| id.parse::<u32>().is_ok());
            if !head.is_empty() && !names_process {
                let refused = Diagnostic::file(path, "is no lock of slipgrid, and stands where one is to be");
                return Err(refused.expected("another folder of results, or no such file").into());
            }
            let emptied = file.set_len(0).and_then(|()| file.rewind());
            // At once: a run that is killed between two writes would leave half a mark, which the next run takes for foreign.
            let mark = format!("{MARK} {}\n", std::process::id());
            if let Err(error) = emptied.and_then(|()| file.write_all(mark.as_bytes())) {
                // On a full disk an empty file would remain.
                let _ = fs::remove_file(path);
                return Err(failed(error).into());
            }
            lock.file = Some(file);
            held().push(path.to_owned());
            return Ok(lock);
        }
        Err(lock.refuse("").into())
    }

    /// Refuses a lock that another run holds; `head` is the text that the other run wrote into the lock file.
    fn refuse(&self, head: &str) -> Diagnostic {
        let process = head.split_whitespace().nth(1).map_or_else(String::new, |number| format!(": process {number}"));
        Diagnostic::file(&self.path, format!("another run works for this folder{process}"))
            .expected("another folder after -o, or to wait until that run has ended")
    }

    /// Removes those folders created for the lock file that are empty, up to the first that is not.
    fn remove_made(&self) {
        let _ = self.made.iter().try_for_each(fs::remove_dir);
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        let Some(file) = self.file.take() else { return self.remove_made() };
        held().retain(|held| *held != self.path);
        // Removed while locked, so that no other run's file is removed. A file that cannot be removed is taken over by
        // the next run.
        if cfg!(unix) {
            let _ = fs::remove_file(&self.path);
            drop(file);
        } else {
            drop(file);
            let _ = fs::remove_file(&self.path);
        }
        self.remove_made();
    }
}

/// The beginning of a lock file as text.
fn read_head(file: &mut File) -> io::Result<String> {
    let mut head = Vec::new();
    file.take(HEAD).read_to_end(&mut head)?;
    Ok(String::from_utf8_lossy(&head).into_owned())
}

/// Whether `path` still refers to `file`.
#[cfg(unix)]
fn is_there(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let (Ok(own), Ok(there)) = (file.metadata(), fs::metadata(path)) else { return false };
    (own.dev(), own.ino()) == (there.dev(), there.ino())
}

#[cfg(not(unix))]
fn is_there(_: &File, path: &Path) -> bool {
    path.exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_at_a_time_and_nothing_is_left() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("new/out/a.lock");
        let first = Lock::new(&path).unwrap();
        let refused = Lock::new(&path).unwrap_err().to_string();
        let who = format!("another run works for this folder: process {};", std::process::id());
        assert!(refused.contains(&who) && refused.contains("another folder after -o"), "{refused}");
        drop(first);
        assert!(!place.path().join("new").exists());
        // A file that a run wrote next to the lock keeps the folders.
        let second = Lock::new(&path).unwrap();
        fs::write(place.path().join("new/out/result"), "").unwrap();
        drop(second);
        assert!(place.path().join("new/out/result").exists() && !path.exists());
    }

    #[test]
    fn what_a_dead_run_left_is_taken_over_and_files_of_others_are_not() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.lock");
        for left in ["slipgrid 999999\n", ""] {
            fs::write(&path, left).unwrap();
            drop(Lock::new(&path).unwrap());
            assert!(!path.exists());
        }
        for notes in ["my notes", "slipgrid is what I use"] {
            fs::write(&path, notes).unwrap();
            assert!(Lock::new(&path).unwrap_err().to_string().contains("is no lock of slipgrid"));
            assert_eq!(fs::read_to_string(&path).unwrap(), notes);
        }
    }

    #[test]
    fn many_at_once_hold_it_in_turn() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.lock");
        let counter = place.path().join("counter");
        fs::write(&counter, "0").unwrap();
        let held: u32 = std::thread::scope(|scope| {
            let work = || {
                (0..50)
                    .filter_map(|_| Lock::new(&path).ok())
                    .map(|_held| {
                        let count: u32 = fs::read_to_string(&counter).unwrap().parse().unwrap();
                        fs::write(&counter, (count + 1).to_string()).unwrap();
                    })
                    .count() as u32
            };
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(work)).collect();
            threads.into_iter().map(|thread| thread.join().unwrap()).sum()
        });
        assert!(held > 0);
        assert_eq!(fs::read_to_string(&counter).unwrap(), held.to_string());
    }
}
