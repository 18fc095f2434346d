//! A file that always ends with whole records.

use std::io::{self, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Where a recording is written to.
pub trait Storage: Write + Send {
    /// Shortens what was written to a length, bytes, and continues there.
    ///
    /// # Errors
    /// Those of the operating system.
    fn truncate(&mut self, length: u64) -> io::Result<()>;
}

impl Storage for std::fs::File {
    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)?;
        self.seek(SeekFrom::Start(length)).map(drop)
    }
}

/// Collects bytes until they are committed together. After the first failure nothing is written any more.
pub(crate) struct Sink {
    storage: Box<dyn Storage>,
    pending: Vec<u8>,
    /// Length of the storage, and its length before the last commit, bytes.
    committed: u64,
    before: u64,
    failed: bool,
}

/// End of a file without a summary: data end, footer, magic.
const TAIL: [u8; 50] = {
    let mut tail = [0; 50];
    // Data end: 4 bytes, no checksum.
    tail[0] = mcap::records::op::DATA_END;
    tail[1] = 4;
    // Footer: 20 bytes, no summary, no checksum.
    tail[13] = mcap::records::op::FOOTER;
    tail[14] = 20;
    let mut k = 0;
    while k < mcap::MAGIC.len() {
        tail[42 + k] = mcap::MAGIC[k];
        k += 1;
    }
    tail
};

impl Sink {
    pub(crate) fn new(storage: Box<dyn Storage>) -> Self {
        Self { storage, pending: Vec::new(), committed: 0, before: 0, failed: false }
    }

    /// Writes what was collected. Where that fails, what was written before is closed as a whole file.
    pub(crate) fn commit(&mut self) -> io::Result<()> {
        if self.failed || self.pending.is_empty() {
            return Ok(());
        }
        let written = self.storage.write_all(&self.pending).and_then(|()| self.storage.flush());
        match written {
            Ok(()) => {
                self.before = self.committed;
                self.committed += self.pending.len() as u64;
                self.pending.clear();
                Ok(())
            }
            Err(error) => {
                self.failed = true;
                self.pending = Vec::new();
                self.close();
                Err(error)
            }
        }
    }

    /// Ends the storage after the last commit, or where there is no room for the end, after the one before.
    fn close(&mut self) {
        for length in [self.committed, self.before] {
            let closed = self.storage.truncate(length).and_then(|()| self.storage.write_all(&TAIL));
            if length == 0 || closed.and_then(|()| self.storage.flush()).is_ok() {
                return;
            }
        }
        // Readers cope with a missing end, but not with half of one.
        let _ = self.storage.truncate(self.committed.min(self.before));
    }

    /// Bytes in the storage.
    pub(crate) fn length(&self) -> u64 {
        self.committed
    }
}

/// A sink that the MCAP writer and the recorder share.
#[derive(Clone)]
pub(crate) struct SharedSink(Arc<Mutex<Sink>>);

impl SharedSink {
    pub(crate) fn new(storage: Box<dyn Storage>) -> Self {
        Self(Arc::new(Mutex::new(Sink::new(storage))))
    }

    pub(crate) fn lock(&self) -> MutexGuard<'_, Sink> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Write for SharedSink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut sink = self.lock();
        if !sink.failed {
            sink.pending.extend_from_slice(bytes);
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A storage of limited size.
    #[derive(Clone)]
    struct Limited(Arc<Mutex<Vec<u8>>>, usize);

    impl Write for Limited {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            let room = self.1 - all.len();
            if room == 0 {
                return Err(io::ErrorKind::StorageFull.into());
            }
            let taken = room.min(bytes.len());
            all.extend_from_slice(&bytes[..taken]);
            Ok(taken)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Storage for Limited {
        fn truncate(&mut self, length: u64) -> io::Result<()> {
            self.0.lock().unwrap_or_else(PoisonError::into_inner).truncate(length as usize);
            Ok(())
        }
    }

    #[test]
    fn a_full_storage_ends_with_whole_commits_and_an_end() {
        for limit in 100..260 {
            let bytes = Arc::new(Mutex::new(Vec::new()));
            let sink = SharedSink::new(Box::new(Limited(bytes.clone(), limit)));
            let mut failures = 0;
            for k in 0..10_u8 {
                sink.clone().write_all(&[k; 60]).unwrap_or_default();
                failures += usize::from(sink.lock().commit().is_err());
            }
            let bytes = bytes.lock().unwrap_or_else(PoisonError::into_inner);
            assert_eq!(failures, 1, "told once");
            assert_eq!(&bytes[bytes.len() - 50..], &TAIL);
            assert_eq!((bytes.len() - 50) % 60, 0, "{limit}");
            assert!(bytes.len() - 50 >= (limit / 60 - 1) * 60, "at most one commit makes room for the end");
        }
    }
}
