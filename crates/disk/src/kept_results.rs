//! A folder of results by their content.

use std::fs::{self, File, OpenOptions};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::SystemTime;

use sha2::{Digest, Sha256};
use slipgrid_monitor::{Key, Memory};

use crate::put;

/// Of which form files are: the hash of another form differs.
const FORMAT: &[u8] = b"slipgrid kept 2";
/// Bytes of the hash that a file begins with.
const HASH_BYTES: usize = 32;
/// Share of the bound to which a folder that has grown beyond it is brought back.
const AFTER_CLEARING: f64 = 0.75;
/// Bytes that a user's folder holds at most, about: some thousand runs.
const MAX_BYTES: u64 = 256 << 20;
/// How names of kept results end.
const EXTENSION: &str = "kept";

/// A folder that holds one file a result, named by its key and the build of the program that computed it. Any number of
/// processes may use it at once: a file appears whole and begins with a hash of its name and its content, and one that is broken, gone or
/// another's is as if it had never been. Beyond the bound those go first that were not asked for the longest.
#[derive(Debug)]
pub struct KeptResults {
    folder: PathBuf,
    build: String,
    most_bytes: u64,
    is_cleared: AtomicBool,
}

impl KeptResults {
    /// The results of `build` in `folder`, which is made when the first is kept and holds `most_bytes` at most, about.
    #[must_use]
    pub fn new(folder: PathBuf, build: &str, most_bytes: u64) -> Self {
        let build: String = Sha256::digest(build.as_bytes()).iter().take(4).map(|byte| format!("{byte:02x}")).collect();
        Self { folder, build, most_bytes, is_cleared: AtomicBool::new(false) }
    }

    /// The results of the running program in the user's folder for such files: the one that the environment names in
    /// `SLIPGRID_CACHE`, else `slipgrid` in the system's. `None` where `SLIPGRID_CACHE` is empty, or nothing names a folder.
    /// The build is told by the size and the time of the program's file.
    #[must_use]
    pub fn of_this_program() -> Option<Self> {
        let named = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = match std::env::var_os("SLIPGRID_CACHE") {
            Some(folder) => Some(PathBuf::from(folder)).filter(|folder| !folder.as_os_str().is_empty()),
            None => named("XDG_CACHE_HOME")
                .or_else(|| named("LOCALAPPDATA"))
                .or_else(|| Some(named("HOME")?.join(".cache")))
                .map(|folder| folder.join("slipgrid")),
        };
        let program = fs::metadata(std::env::current_exe().ok()?).ok()?;
        let build = format!("{} {:?}", program.len(), program.modified().ok()?);
        Some(Self::new(folder?, &build, MAX_BYTES))
    }

    fn path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}-{}.{EXTENSION}", key.name(), self.build))
    }

    /// What a file at `path` that holds `value` begins with: it is bound to its key and build.
    fn hash(path: &Path, value: &[u8]) -> [u8; HASH_BYTES] {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        let mut hash = Sha256::new();
        hash.update(FORMAT);
        hash.update(Sha256::digest(name));
        hash.update(value);
        hash.finalize().into()
    }

    /// Removes what was not asked for the longest, where there is too much.
    fn clear(&self) {
        let mut kept: Vec<(SystemTime, u64, PathBuf)> = fs::read_dir(&self.folder)
            .into_iter()
            .flatten()
            .flatten()
            .filter(|entry| Path::new(&entry.file_name()).extension().is_some_and(|own| own == EXTENSION))
            .filter_map(|entry| {
                let found = entry.metadata().ok()?;
                Some((found.modified().ok()?, found.len(), entry.path()))
            })
            .collect();
        let mut bytes: u64 = kept.iter().map(|(_, length, _)| length).sum();
        if bytes <= self.most_bytes {
            return;
        }
        kept.sort();
        for (_, length, path) in kept {
            if bytes as f64 <= AFTER_CLEARING * self.most_bytes as f64 {
                return;
            }
            // Another process may have been faster.
            let _ = fs::remove_file(path);
            bytes -= length;
        }
    }
}

/// Options to open a file that may be a pipe, which would wait for its other end.
fn unblocking() -> OpenOptions {
    let mut options = File::options();
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::custom_flags(&mut options, libc::O_NONBLOCK);
    options
}

/// The content of the file at `path`; `None` of what is no regular file, or has more than `most_bytes`.
fn read_regular(path: &Path, most_bytes: u64) -> Option<Vec<u8>> {
    let file = unblocking().read(true).open(path).ok()?;
    let found = file.metadata().ok().filter(|found| found.is_file() && found.len() <= most_bytes)?;
    let mut bytes = Vec::new();
    // It may grow while it is read.
    file.take(found.len()).read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

impl Memory for KeptResults {
    fn recall(&self, key: &Key) -> Option<Vec<u8>> {
        let path = self.path(key);
        let mut bytes = read_regular(&path, self.most_bytes)?;
        let value = bytes.split_off(HASH_BYTES.min(bytes.len()));
        if Self::hash(&path, &value)[..] != bytes[..] {
            return None;
        }
        // Asked for now: what is not written stays a little older.
        let _ = unblocking().append(true).open(&path).and_then(|file| file.set_modified(SystemTime::now()));
        Some(value)
    }

    fn keep(&self, key: &Key, value: &[u8]) {
        let path = self.path(key);
        // A full or read-only disk keeps nothing: the next run computes it again.
        let _ = put(&path, &[&Self::hash(&path, value)[..], value].concat());
        // Once a process: results come by the dozen.
        if !self.is_cleared.swap(true, Ordering::Relaxed) {
            self.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_broken_is_not_recalled_and_what_cannot_be_kept_is_no_error() {
        let place = tempfile::tempdir().unwrap();
        let kept = KeptResults::new(place.path().to_owned(), "a", 1000);
        let key = Key::of("run", &1.5);
        kept.keep(&key, b"value");
        let path = kept.path(&key);
        let own = fs::read(&path).unwrap();
        let unbound = [&Sha256::digest(b"other")[..], b"other"].concat();
        for broken in [&b""[..], b"short", &[0; 40], &own[..own.len() - 1], &unbound, &[7; 1001]] {
            fs::write(&path, broken).unwrap();
            assert_eq!(kept.recall(&key), None);
        }
        // The file of another key is whole, and another's.
        let other = Key::of("run", &2.5);
        kept.keep(&other, b"value");
        fs::copy(kept.path(&other), &path).unwrap();
        assert_eq!((kept.recall(&key), kept.recall(&other)), (None, Some(b"value".to_vec())));
        fs::write(&path, own).unwrap();
        assert_eq!(kept.recall(&key).as_deref(), Some(&b"value"[..]));
        #[cfg(unix)]
        {
            // A pipe that nobody writes to.
            fs::remove_file(&path).unwrap();
            assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
            assert_eq!(kept.recall(&key), None);
        }
        kept.keep(&key, b"");
        assert_eq!(kept.recall(&key).as_deref(), Some(&b""[..]));
        let file = place.path().join("file");
        fs::write(&file, "").unwrap();
        let nowhere = KeptResults::new(file, "a", 1000);
        nowhere.keep(&key, b"value");
        assert_eq!(nowhere.recall(&key), None);
    }

    #[test]
    fn beyond_the_bound_the_oldest_go_and_files_of_others_stay() {
        let place = tempfile::tempdir().unwrap();
        let keys: Vec<Key> = (0..10).map(|number| Key::of("run", &number)).collect();
        fs::write(place.path().join("notes.txt"), [0; 5000]).unwrap();
        for (key, age) in keys.iter().zip([10_u32, 9, 8, 7, 6, 5, 4, 3, 2, 1]) {
            let kept = KeptResults::new(place.path().to_owned(), "a", 1 << 20);
            kept.keep(key, &[0; 68]);
            let at = SystemTime::now() - std::time::Duration::from_secs(u64::from(age) * 100);
            File::options().append(true).open(kept.path(key)).unwrap().set_modified(at).unwrap();
        }
        let kept = KeptResults::new(place.path().to_owned(), "a", 800);
        // The first is asked for again, and so is the youngest.
        assert!(kept.recall(&keys[0]).is_some());
        kept.keep(&Key::of("run", &"new"), &[0; 68]);
        let left: Vec<usize> = (0..10).filter(|&number| kept.recall(&keys[number]).is_some()).collect();
        assert_eq!(left, [0, 6, 7, 8, 9]);
        assert!(place.path().join("notes.txt").exists());
    }

    #[test]
    fn many_at_once_find_whole_values_or_none() {
        let place = tempfile::tempdir().unwrap();
        let key = Key::of("run", &0);
        std::thread::scope(|scope| {
            for writer in 0..4_u8 {
                let (folder, key) = (place.path().to_owned(), &key);
                scope.spawn(move || {
                    let kept = KeptResults::new(folder, "a", 1 << 20);
                    for _ in 0..25 {
                        kept.keep(key, &[writer; 4096]);
                        let value = kept.recall(key).unwrap();
                        assert!(value.len() == 4096 && value.iter().all(|byte| *byte == value[0]));
                    }
                });
            }
        });
    }
}
