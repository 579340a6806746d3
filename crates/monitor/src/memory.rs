//! What a caller remembers from one computation to the next.

use std::collections::BTreeMap;
use std::fmt::{self, Debug, Write};
use std::sync::{Mutex, PoisonError};

use sha2::{Digest, Sha256};

use crate::Monitor;

/// Results by the content that they follow from: what is recalled is what would be computed, to the last bit.
pub trait Memory: Sync {
    /// What was kept under `key`.
    fn recall(&self, key: &Key) -> Option<Vec<u8>>;

    /// Keeps `value` under `key`. What cannot be kept is computed again another time.
    fn keep(&self, key: &Key, value: &[u8]);
}

/// The name of a result: what kind it is, and a hash of all that it follows from.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key(String);

impl Key {
    /// The key of a result of `kind`, a word, that follows from `content`: numbers are told apart to their last bit.
    #[must_use]
    pub fn of(kind: &str, content: &dyn Debug) -> Self {
        let mut hashed = Hashed(Sha256::new());
        // A hash takes everything that is written to it.
        let _ = write!(hashed, "{content:?}");
        let digest = hashed.0.finalize();
        let hex = digest.iter().fold(String::new(), |mut hex, byte| {
            let _ = write!(hex, "{byte:02x}");
            hex
        });
        Self(format!("{kind}-{hex}"))
    }

    /// Letters, digits and a hyphen: fit for the name of a file.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.0
    }
}

/// What is written is hashed.
struct Hashed(Sha256);

impl Write for Hashed {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

/// A memory that ends with the process.
#[derive(Debug, Default)]
pub struct InMemory(Mutex<BTreeMap<Key, Vec<u8>>>);

impl Memory for InMemory {
    fn recall(&self, key: &Key) -> Option<Vec<u8>> {
        // A value is whole when it enters: those of a panicking thread are as good as any.
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(key).cloned()
    }

    fn keep(&self, key: &Key, value: &[u8]) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(key.clone(), value.to_vec());
    }
}

/// What `compute` gives, a result of `kind` that follows from `content` alone: recalled by `from_bytes` where the monitor's caller
/// remembers it, and otherwise remembered as `to_bytes` has it, which is nothing of what is not to be kept.
pub fn recalled<T>(
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

/// `numbers` as they are kept, to the last bit.
pub fn to_bytes<'a>(numbers: impl IntoIterator<Item = &'a f64>) -> Vec<u8> {
    numbers.into_iter().flat_map(|number| number.to_le_bytes()).collect()
}

/// The numbers that [`to_bytes`] made `bytes` of.
#[must_use]
pub fn from_bytes(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_tell_the_last_bit_and_memories_return_what_they_were_given() {
        let third = 1.0_f64 / 3.0;
        let next = f64::from_bits(third.to_bits() + 1);
        assert_eq!(Key::of("run", &(third, "a")), Key::of("run", &(third, "a")));
        assert_ne!(Key::of("run", &(third, "a")), Key::of("run", &(next, "a")));
        assert_ne!(Key::of("run", &third), Key::of("material", &third));
        assert_eq!(Key::of("run", &1).name().len(), 4 + 64);
        let memory = InMemory::default();
        let key = Key::of("run", &third);
        assert_eq!(memory.recall(&key), None);
        memory.keep(&key, &[1, 2]);
        assert_eq!(memory.recall(&key), Some(vec![1, 2]));
    }
}
