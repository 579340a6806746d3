//! Cache of results between computations.

use std::collections::{BTreeMap, VecDeque};
use std::fmt::{self, Debug, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use sha2::{Digest, Sha256};

use crate::monitor::Monitor;

/// Cache of results by the content from which they follow. A cached result is bit-identical to the computed one.
pub trait Memory: Sync {
    /// Returns the value stored under `key`.
    fn recall(&self, key: &Key) -> Option<Vec<u8>>;

    /// Stores `value` under `key`. A value that cannot be stored is computed again later.
    fn keep(&self, key: &Key, value: &[u8]);
}

/// Version of keys and of the bytes kept under them. Raise it where a kept value changes its form or its meaning while its content stays: results
/// under other versions are then computed again.
const SCHEMA: &[u8] = b"slipgrid key 1";

/// Key of a result: its kind, and a hash of everything from which it follows.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(String);

impl Key {
    /// Creates the key of a result of `kind` that follows from `content`; numbers are distinguished to the last bit.
    ///
    /// The hash covers the schema's version and the `Debug` text of `content`. Derived `Debug` names every type and field, quotes texts and
    /// writes the shortest digits that read back as the same number, so that different contents have different texts: a renamed or a new field is
    /// a new key. `Debug` by hand could leave a field out; the tests of the house list the types that have one. Serialization would need serde in
    /// ten crates that compute and do not read or write, and JSON writes one `null` for every number that is not finite.
    #[must_use]
    pub fn of(kind: &str, content: &dyn Debug) -> Self {
        let mut hashed = Hashed(Sha256::new_with_prefix(SCHEMA));
        // Writing to a hash cannot fail.
        let _ = write!(hashed, "{content:?}");
        let digest = hashed.0.finalize();
        let hex = digest.iter().fold(String::new(), |mut hex, byte| {
            let _ = write!(hex, "{byte:02x}");
            hex
        });
        Self(format!("{kind}-{hex}"))
    }

    /// Letters, digits and a hyphen, suitable as a file name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0
    }
}

/// Writer that hashes text.
struct Hashed(Sha256);

impl Write for Hashed {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

/// A cache in memory that drops the oldest values if it would exceed its size limit.
#[derive(Debug)]
pub struct InMemory {
    kept: Mutex<Entries>,
    max_bytes: usize,
}

#[derive(Debug)]
struct Entries {
    values: BTreeMap<Key, Vec<u8>>,
    oldest_first: VecDeque<Key>,
    bytes: usize,
}

impl InMemory {
    /// Creates an empty cache for at most `max_bytes` of values.
    #[must_use]
    pub const fn new(max_bytes: usize) -> Self {
        let kept = Entries { values: BTreeMap::new(), oldest_first: VecDeque::new(), bytes: 0 };
        Self { kept: Mutex::new(kept), max_bytes }
    }

    fn kept(&self) -> MutexGuard<'_, Entries> {
        // Values are complete when they are inserted, so that a poisoned lock is harmless.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Default for InMemory {
    fn default() -> Self {
        Self::new(usize::MAX)
    }
}

impl Memory for InMemory {
    fn recall(&self, key: &Key) -> Option<Vec<u8>> {
        self.kept().values.get(key).cloned()
    }

    fn keep(&self, key: &Key, value: &[u8]) {
        let mut kept = self.kept();
        if value.len() > self.max_bytes || kept.values.contains_key(key) {
            return;
        }
        while kept.bytes > self.max_bytes - value.len() {
            let Some(oldest) = kept.oldest_first.pop_front() else { break };
            kept.bytes -= kept.values.remove(&oldest).map_or(0, |value| value.len());
        }
        kept.bytes += value.len();
        kept.oldest_first.push_back(key.clone());
        kept.values.insert(key.clone(), value.to_vec());
    }
}

/// Returns the result of `compute`, of the given `kind`, which follows from `content` only. The result is read from the
/// monitor's cache with `from_bytes` if possible; otherwise it is computed, and stored with `to_bytes`, which returns
/// `None` for results that must not be stored.
pub fn cached<T>(
    monitor: &dyn Monitor,
    (kind, content): (&str, &dyn Debug),
    (from_bytes, to_bytes): (impl FnOnce(&[u8]) -> Option<T>, impl FnOnce(&T) -> Option<Vec<u8>>),
    compute: impl FnOnce() -> T,
) -> T {
    let Some(memory) = monitor.memory() else { return compute() };
    let key = Key::of(kind, content);
    if let Some(known) = memory.recall(&key).and_then(|bytes| from_bytes(&bytes)) {
        return known;
    }
    let result = compute();
    if let Some(bytes) = to_bytes(&result) {
        memory.keep(&key, &bytes);
    }
    result
}

/// [`cached`] for a list of `count` numbers, some of which may be absent or NaN, which is read back as absent. Errors are
/// not stored, nor what may have been cut short because the monitor has cancelled. A list from the cache advances the
/// monitor by `share`.
///
/// # Errors
/// Those of `compute`.
pub fn cached_numbers<E>(
    monitor: &dyn Monitor,
    (kind, content): (&str, &dyn Debug),
    (count, share): (usize, f64),
    compute: impl FnOnce() -> Result<Vec<Option<f64>>, E>,
) -> Result<Vec<Option<f64>>, E> {
    let number = |number: f64| Some(number).filter(|number| !number.is_nan());
    let known = |bytes: &[u8]| {
        let numbers = from_bytes(bytes);
        (numbers.len() == count).then(|| {
            monitor.advance(share);
            Ok(numbers.into_iter().map(number).collect())
        })
    };
    let kept = |found: &Result<Vec<Option<f64>>, E>| {
        let numbers: Vec<f64> = found.as_ref().ok()?.iter().map(|number| number.unwrap_or(f64::NAN)).collect();
        (!monitor.cancelled()).then(|| to_bytes(&numbers))
    };
    cached(monitor, (kind, content), (known, kept), compute)
}

/// Serializes `numbers` without loss.
pub fn to_bytes<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// Deserializes the output of [`to_bytes`].
#[must_use]
pub fn from_bytes(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use crate::monitor::CachingMonitor;

    #[test]
    fn keys_tell_the_last_bit_and_memories_return_what_they_were_given() {
        let third = 1.0_f64 / 3.0;
        let next = f64::from_bits(third.to_bits() + 1);
        assert_eq!(Key::of("run", &(third, "a")), Key::of("run", &(third, "a")));
        assert_ne!(Key::of("run", &(third, "a")), Key::of("run", &(next, "a")));
        assert_ne!(Key::of("run", &third), Key::of("material", &third));
        assert_eq!(Key::of("run", &1).name().len(), 4 + 64);
        // Neither a mark within a text nor a number that is not finite looks like another content.
        assert_ne!(Key::of("run", &("a\", \"b",)), Key::of("run", &("a", "b")));
        assert_ne!(Key::of("run", &f64::NAN), Key::of("run", &f64::INFINITY));
        assert_ne!(Key::of("run", &0.0), Key::of("run", &-0.0));
        let memory = InMemory::default();
        let key = Key::of("run", &third);
        assert_eq!(memory.recall(&key), None);
        memory.keep(&key, &[1, 2]);
        assert_eq!(memory.recall(&key), Some(vec![1, 2]));
    }

    #[test]
    fn lists_are_kept_with_their_gaps_and_neither_errors_nor_what_was_cut_short() {
        #[derive(Default)]
        struct Cancelling(AtomicBool);
        impl Monitor for Cancelling {
            fn cancelled(&self) -> bool {
                self.0.load(Ordering::Relaxed)
            }
        }
        let cancelling = Cancelling(AtomicBool::new(true));
        let monitor = CachingMonitor::new(&cancelling);
        let first = vec![Some(1.0 / 3.0), None, Some(-0.0)];
        let found = cached_numbers(&monitor, ("list", &1), (3, 0.0), || Ok::<_, ()>(first.clone()));
        assert_eq!(found, Ok(first.clone()));
        cancelling.0.store(false, Ordering::Relaxed);
        assert_eq!(cached_numbers(&monitor, ("list", &1), (3, 0.0), || Err("refused")), Err("refused"));
        for other in [first.clone(), vec![None]] {
            let found = cached_numbers(&monitor, ("list", &1), (3, 0.0), || Ok::<_, ()>(other)).unwrap();
            assert_eq!((found.clone(), found[2].map(f64::is_sign_negative)), (first.clone(), Some(true)));
        }
        let shorter = cached_numbers(&monitor, ("list", &1), (1, 0.0), || Ok::<_, ()>(vec![None]));
        assert_eq!(shorter, Ok(vec![None]), "a list of another length is computed");
    }

    #[test]
    fn a_memory_that_is_full_forgets_what_it_has_kept_longest() {
        let memory = InMemory::new(10);
        let key = |number: u32| Key::of("run", &number);
        for (number, length) in [(1, 4), (2, 4), (2, 4), (3, 4), (4, 11)] {
            memory.keep(&key(number), &vec![7; length]);
        }
        // Eight bytes plus four are too many, and eleven alone as well.
        assert_eq!([1, 2, 3, 4].map(|number| memory.recall(&key(number)).is_some()), [false, true, true, false]);
        memory.keep(&key(5), &[7; 10]);
        assert_eq!([2, 3, 5].map(|number| memory.recall(&key(number)).is_some()), [false, false, true]);
    }
}
