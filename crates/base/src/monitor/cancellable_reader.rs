//! A reader that fails once a monitor cancels.

use std::io::{self, Read};

use crate::monitor::Monitor;

/// Reads from a source until a monitor cancels; reading then fails, so that parsing of a long file ends.
pub struct CancellableReader<'a, R> {
    source: R,
    monitor: &'a dyn Monitor,
}

impl<'a, R: Read> CancellableReader<'a, R> {
    /// Creates a reader of `source` that fails once `monitor` cancels.
    pub const fn new(source: R, monitor: &'a dyn Monitor) -> Self {
        Self { source, monitor }
    }
}

impl<R: Read> Read for CancellableReader<'_, R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        // Readers retry after errors of the kind `Interrupted`.
        self.monitor.heed().map_err(|_| io::Error::other("cancelled"))?;
        self.source.read(into)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;

    #[test]
    fn a_source_fails_once_its_monitor_cancels() {
        let button = AtomicBool::new(false);
        let mut source = CancellableReader::new(&b"0123456789"[..], &button);
        let mut four = [0; 4];
        source.read_exact(&mut four).unwrap();
        assert_eq!(&four, b"0123");
        button.store(true, Ordering::Relaxed);
        assert_eq!(source.read_exact(&mut four).unwrap_err().to_string(), "cancelled");
    }
}
