//! Cache of results between computations.

use std::collections::{BTreeMap, VecDeque};
use std::fmt::{self, Debug, Write};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use serde::de::DeserializeOwned;
use sha2::{Digest, Sha256};

use crate::monitor::Monitor;

/// Cache of results, each stored under a key of all inputs that determine it. A cached result is bit-identical to the
/// computed one.
pub trait Memory: Sync {
    /// Returns the value stored under `key`; `None` if there is none.
    fn recall(&self, key: &Key) -> Option<Vec<u8>>;

    /// Stores `value` under `key`. A value that cannot be stored is computed again later.
    fn keep(&self, key: &Key, value: &[u8]);
}

/// Version of keys and of the values stored under them. Increase it when the form or meaning of a stored value changes
/// while the content that its key hashes does not: results of other versions are then computed again.
const SCHEMA: &[u8] = b"slipgrid key 2";

/// Key of a result: its kind, and a hash of all inputs that determine it.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(String);

impl Key {
    /// Creates the key of a result of `kind` that follows from `content`; numbers are distinguished to the last bit.
    ///
    /// The hash covers the schema's version and the `Debug` text of `content`. Derived `Debug` names every type and
    /// field, quotes texts and writes the shortest digits that read back as the same number, so that different contents
    /// have different texts: a renamed or a new field is a new key. `Debug` by hand could leave a field out; a test of
    /// the workspace lists the types that have one. Serialization would need serde in ten crates that compute and do
    /// not read or write, and JSON writes one `null` for every number that is not finite.
    pub fn of(kind: &str, content: &dyn Debug) -> Self {
        let mut hashed = Hashed(Sha256::new_with_prefix(SCHEMA));
        // Writing to a hash cannot fail.
        let _ = write!(hashed, "{content:?}");
        let hex: Vec<String> = hashed.0.finalize().iter().map(|byte| format!("{byte:02x}")).collect();
        Self(format!("{kind}-{}", hex.concat()))
    }

    /// Text of the key: letters, digits and a hyphen, suitable as a file name.
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

/// Returns the result of `compute`, which must depend on `content` only. `kind` and `content` are the key of the result
/// in the monitor's cache. A result found in the cache advances the monitor by `share`; otherwise the result is
/// computed and stored. Errors are not stored, nor is any result once the monitor has cancelled, since it may be
/// incomplete; such a monitor must remain cancelled.
///
/// # Errors
/// Errors of `compute`.
pub fn cached<T: Serialize + DeserializeOwned, E>(
    monitor: &dyn Monitor,
    (kind, content): (&str, &dyn Debug),
    share: f64,
    compute: impl FnOnce() -> Result<T, E>,
) -> Result<T, E> {
    let Some(memory) = monitor.memory() else { return compute() };
    let key = Key::of(kind, content);
    if let Some(known) = memory.recall(&key).and_then(|bytes| postcard::from_bytes(&bytes).ok()) {
        monitor.advance(share);
        return Ok(known);
    }
    let result = compute()?;
    if !monitor.cancelled()
        && let Ok(bytes) = postcard::to_stdvec(&result)
    {
        memory.keep(&key, &bytes);
    }
    Ok(result)
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
    fn results_come_back_to_the_last_bit_and_neither_errors_nor_what_was_cut_short_is_kept() {
        let cancelling = AtomicBool::new(true);
        let monitor = CachingMonitor::new(&cancelling);
        let first = vec![Some(1.0 / 3.0), None, Some(-0.0), Some(f64::NAN), Some(f64::INFINITY)];
        let found = cached(&monitor, ("list", &1), 0.0, || Ok::<_, ()>(first.clone()));
        assert_eq!(bits(&found.unwrap()), bits(&first));
        cancelling.store(false, Ordering::Relaxed);
        let refused = cached(&monitor, ("list", &1), 0.0, || Err::<Vec<Option<f64>>, _>("refused"));
        assert_eq!(refused, Err("refused"));
        for other in [first.clone(), vec![None]] {
            let found = cached(&monitor, ("list", &1), 0.0, || Ok::<_, ()>(other)).unwrap();
            assert_eq!(bits(&found), bits(&first));
        }
        // What cannot be decoded is computed.
        let memory = monitor.memory().unwrap();
        memory.keep(&Key::of("list", &2), &[5, 1, 0]);
        assert_eq!(cached(&monitor, ("list", &2), 0.0, || Ok::<_, ()>(vec![Some(1.0)])), Ok(vec![Some(1.0)]));
    }

    fn bits(numbers: &[Option<f64>]) -> Vec<Option<u64>> {
        numbers.iter().map(|number| number.map(f64::to_bits)).collect()
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
