//! Lock file next to a folder of results, so that one run at a time writes it.
//!
//! The operating system releases the lock when the process ends in any way, so that the lock file of a killed run is
//! taken over. On file systems without locks, the process id in the file is checked.

use std::fs::{self, File, TryLockError};
use std::io::{self, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use crate::formats::Diagnostic;

use crate::disk::places::{PlaceError, WriteError};

/// Number of attempts to create a lock file that its holder has just removed.
const ATTEMPTS: usize = 20;
/// Maximum size of a lock file, in bytes.
const MAX_BYTES: u64 = 1000;

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

/// A lock, held until it is dropped. Dropping removes the lock file, and the folders that were created for it if they
/// are empty.
#[derive(Debug)]
pub struct Lock {
    path: PathBuf,
    file: Option<File>,
    /// Folders that were created, innermost first.
    made: Vec<PathBuf>,
}

/// Holder of a lock.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Holder {
    process: u32,
    host: String,
    /// Start of the run, in seconds since 1 January 1970.
    since_s: u64,
}

impl Lock {
    /// Locks the file at `path` for this process.
    ///
    /// # Errors
    /// [`Diagnostic`] if another run holds the lock; [`WriteError`] for an error of the operating system.
    pub fn new(path: &Path) -> Result<Self, PlaceError> {
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
            let is_locked = match file.try_lock() {
                Ok(()) => true,
                Err(TryLockError::WouldBlock) => return Err(lock.refuse(Holder::read(&mut file).as_ref()).into()),
                Err(TryLockError::Error(_)) => false,
            };
            // The last holder may have removed the file between opening and locking.
            if !is_there(&file, path) {
                continue;
            }
            let own = Holder::own();
            match Holder::read(&mut file) {
                Some(other) if other.host != own.host || (!is_locked && other.lives()) => {
                    return Err(lock.refuse(Some(&other)).into());
                }
                None if file.metadata().is_ok_and(|metadata| metadata.len() > 0) => {
                    let refused = Diagnostic::file(path, "is no lock of slipgrid, and stands where one is to be");
                    return Err(refused.expected("another folder of results, or no such file").into());
                }
                _ => {}
            }
            if let Err(error) = own.write(&mut file) {
                // On a full disk an empty file would remain.
                let _ = fs::remove_file(path);
                return Err(failed(error).into());
            }
            lock.file = Some(file);
            held().push(path.to_owned());
            return Ok(lock);
        }
        Err(lock.refuse(None).into())
    }

    fn refuse(&self, holder: Option<&Holder>) -> Diagnostic {
        let who = holder.map_or_else(String::new, |holder| {
            format!(": process {} on {}, for {}", holder.process, holder.host, holder.age())
        });
        let instead = match holder {
            Some(holder) if holder.host != Holder::own().host => {
                "another folder after -o, or no such file once that run has ended: it cannot be seen from here"
            }
            _ => "another folder after -o, or to wait until that run has ended",
        };
        Diagnostic::file(&self.path, format!("another run works for this folder{who}")).expected(instead)
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

impl Lock {
    /// Removes the created folders, as far as they are empty.
    fn remove_made(&self) {
        for folder in &self.made {
            if fs::remove_dir(folder).is_err() {
                return;
            }
        }
    }
}

impl Holder {
    fn own() -> Self {
        let host: String =
            gethostname::gethostname().to_string_lossy().chars().filter(|letter| !letter.is_whitespace()).collect();
        Self { process: std::process::id(), host, since_s: now_s() }
    }

    /// Holder named in a lock file; `None` if it names none.
    fn read(file: &mut File) -> Option<Self> {
        let mut text = String::new();
        file.rewind().ok()?;
        file.take(MAX_BYTES).read_to_string(&mut text).ok()?;
        let ["slipgrid", process, host, since_s] = text.split_whitespace().collect::<Vec<_>>()[..] else { return None };
        Some(Self { process: process.parse().ok()?, host: host.to_owned(), since_s: since_s.parse().ok()? })
    }

    fn write(&self, file: &mut File) -> io::Result<()> {
        file.set_len(0)?;
        file.rewind()?;
        file.write_all(format!("slipgrid {} {} {}\n", self.process, self.host, self.since_s).as_bytes())
    }

    /// Whether the holder's process still runs on this host, as far as can be determined.
    fn lives(&self) -> bool {
        let processes = Path::new("/proc");
        !processes.join("self").exists() || processes.join(self.process.to_string()).exists()
    }

    fn age(&self) -> String {
        match now_s().saturating_sub(self.since_s) {
            seconds @ 0..120 => format!("{seconds} s"),
            seconds @ 120..7200 => format!("{} min", seconds / 60),
            seconds => format!("{} h", seconds / 3600),
        }
    }
}

fn now_s() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs())
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
        let who = format!("another run works for this folder: process {} on ", std::process::id());
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
    fn what_a_dead_run_left_is_taken_over_and_that_of_another_host_is_not() {
        let place = tempfile::tempdir().unwrap();
        let path = place.path().join("a.lock");
        let left = |host: &str| fs::write(&path, format!("slipgrid 999999 {host} 1000\n")).unwrap();
        left(&Holder::own().host);
        drop(Lock::new(&path).unwrap());
        left("elsewhere");
        let refused = Lock::new(&path).unwrap_err().to_string();
        assert!(refused.contains("process 999999 on elsewhere, for ") && refused.contains(" h"), "{refused}");
        assert!(path.exists());
        fs::write(&path, "").unwrap();
        drop(Lock::new(&path).unwrap());
        fs::write(&path, "my notes").unwrap();
        assert!(Lock::new(&path).unwrap_err().to_string().contains("is no lock of slipgrid"));
        assert_eq!(fs::read_to_string(&path).unwrap(), "my notes");
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
