//! Cache of results in a folder.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::SystemTime;

use sha2::{Digest, Sha256};
use slipgrid_base::monitor::{Key, Memory};

use crate::Failure;
use crate::disk::{Place, check_folder, hexadecimal, put};

/// Version of the file format, which is part of the hash at the beginning of every file.
const FORMAT: &[u8] = b"slipgrid kept 2";
/// Length of the hash at the beginning of a file, in bytes.
const HASH_BYTES: usize = 32;
/// Fraction of the size limit to which a cache folder above the limit is reduced.
const CLEARED_FRACTION: f64 = 0.75;
/// Approximate size limit of a user's cache folder, in bytes; holds the results of some thousand dynamic runs.
const MAX_BYTES: u64 = 256 << 20;
/// File name extension of cached results.
const EXTENSION: &str = "kept";

/// Cache in a folder with one file per result, named by the key of the result and the build of the program. Any number
/// of processes may use it concurrently: files appear atomically and begin with a hash of name and content; damaged,
/// missing or foreign files count as absent. Above the size limit the least recently used files are removed.
#[derive(Debug)]
pub struct KeptResults {
    folder: PathBuf,
    build: String,
    max_bytes: u64,
    is_cleared: AtomicBool,
    /// `SLIPGRID_CACHE` names the folder.
    is_named: bool,
}

impl KeptResults {
    /// Creates a cache of results of `build` in `folder`, with an approximate limit of `max_bytes`. The folder is
    /// created with the first result.
    pub fn new(folder: PathBuf, build: &str, max_bytes: u64) -> Self {
        let build = hexadecimal(&Sha256::digest(build.as_bytes())[..4]);
        Self { folder, build, max_bytes, is_cleared: AtomicBool::new(false), is_named: false }
    }

    /// Creates the cache of the running program in the user's cache folder; `None` as for [`Self::for_program`].
    pub fn for_this_program() -> Option<Self> {
        Self::for_program(&std::env::current_exe().ok()?, None)
    }

    /// Creates the cache of the executable file `program`, in `folder` if given, otherwise in the folder that the
    /// environment variable `SLIPGRID_CACHE` names, otherwise in `slipgrid` in the system's cache folder. `None` if
    /// `folder` or `SLIPGRID_CACHE` is empty, if no folder is known, or if `program` cannot be inspected. The build is
    /// identified by size and modification time of the executable.
    pub fn for_program(program: &Path, folder: Option<PathBuf>) -> Option<Self> {
        let is_named = folder.is_none() && std::env::var_os("SLIPGRID_CACHE").is_some();
        let named = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
        let folder = match folder.map_or_else(|| std::env::var_os("SLIPGRID_CACHE"), |folder| Some(folder.into())) {
            Some(folder) => Some(PathBuf::from(folder)).filter(|folder| !folder.as_os_str().is_empty()),
            None => named("XDG_CACHE_HOME")
                .or_else(|| named("LOCALAPPDATA"))
                .or_else(|| Some(named("HOME")?.join(".cache")))
                .map(|folder| folder.join("slipgrid")),
        };
        let program = fs::metadata(program).ok()?;
        let build = format!("{} {:?}", program.len(), program.modified().ok()?);
        Some(Self { is_named, ..Self::new(folder?, &build, MAX_BYTES) })
    }

    /// Reason why nothing can be stored in the folder that `SLIPGRID_CACHE` names; `None` for any other folder.
    pub fn refused(&self) -> Option<Failure> {
        let place = Place { flag: "SLIPGRID_CACHE", path: &self.folder };
        self.is_named.then(|| check_folder(place, &[], &[]).err()).flatten()
    }

    fn path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{}-{}.{EXTENSION}", key.name(), self.build))
    }

    /// Hash at the beginning of the file at `path` that stores `value`. The hash covers the file name, which includes
    /// key and build.
    fn hash(path: &Path, value: &[u8]) -> [u8; HASH_BYTES] {
        let name = path.file_name().unwrap_or_default().as_encoded_bytes();
        let mut hash = Sha256::new();
        hash.update(FORMAT);
        hash.update(Sha256::digest(name));
        hash.update(value);
        hash.finalize().into()
    }

    /// Removes the least recently used files if the size limit is exceeded.
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
        if bytes <= self.max_bytes {
            return;
        }
        kept.sort();
        for (_, length, path) in kept {
            if bytes as f64 <= CLEARED_FRACTION * self.max_bytes as f64 {
                return;
            }
            // Another process may have removed the file.
            let _ = fs::remove_file(path);
            bytes -= length;
        }
    }
}

impl Memory for KeptResults {
    fn recall(&self, key: &Key) -> Option<Vec<u8>> {
        let path = self.path(key);
        // Pipes and files of others are no results.
        fs::metadata(&path).ok().filter(|found| found.is_file() && found.len() <= self.max_bytes)?;
        let mut bytes = fs::read(&path).ok()?;
        let value = bytes.split_off(HASH_BYTES.min(bytes.len()));
        if Self::hash(&path, &value)[..] != bytes[..] {
            return None;
        }
        // Marks the file as used; after a failure the file only looks less recently used.
        let _ = File::options().append(true).open(&path).and_then(|file| file.set_modified(SystemTime::now()));
        Some(value)
    }

    fn keep(&self, key: &Key, value: &[u8]) {
        let path = self.path(key);
        // A full or read-only disk stores nothing, and the next run computes the result again.
        let _ = put(&path, &[&Self::hash(&path, value)[..], value].concat());
        // Once per process, because results come by the dozen.
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
        // The file of another key is complete, but does not match.
        let other = Key::of("run", &2.5);
        kept.keep(&other, b"value");
        fs::copy(kept.path(&other), &path).unwrap();
        assert_eq!((kept.recall(&key), kept.recall(&other)), (None, Some(b"value".to_vec())));
        fs::write(&path, own).unwrap();
        assert_eq!(kept.recall(&key).as_deref(), Some(&b"value"[..]));
        #[cfg(unix)]
        {
            // A pipe without a writer.
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
        // The first one is used again, and so is the youngest.
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
