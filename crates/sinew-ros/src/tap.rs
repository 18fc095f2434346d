use rtrb::{Consumer, Producer, RingBuffer};
use sinew_session::signals::{Frame, FrameLayout};
use sinew_session::{CycleRecord, Plant};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// Time from a published cycle to the next, s, at least.
const EVERY: f64 = 0.002;
/// Cycles that wait for the node's thread at most: a second of them.
const RING: usize = 512;

/// The control cycle's end of a node.
#[derive(Debug)]
pub struct Tap {
    ring: Producer<f64>,
    layout: Arc<FrameLayout>,
    count: u64,
    every: u64,
    missed: Arc<AtomicU64>,
}

/// The other end.
#[derive(Debug)]
pub(crate) struct TapReader {
    ring: Consumer<f64>,
    frame: Frame,
    missed: Arc<AtomicU64>,
}

/// Both ends, for a machine with so many muscles and joints and a period, s.
pub(crate) fn tap(sizes: [usize; 2], period: f64) -> (Tap, TapReader) {
    // What a real machine knows: no truth.
    let layout = Arc::new(FrameLayout::new(sizes, false));
    let (producer, consumer) = RingBuffer::new(RING * layout.words());
    let every = (EVERY / period).round().max(1.0) as u64;
    let missed = Arc::<AtomicU64>::default();
    let frame = Frame::new(Arc::clone(&layout));
    let tap = Tap { ring: producer, layout, count: 0, every, missed: Arc::clone(&missed) };
    (tap, TapReader { ring: consumer, frame, missed })
}

impl Tap {
    /// One that nobody reads, for a machine with so many muscles and joints and a period, s: what a cycle is
    /// tested with.
    #[must_use]
    pub fn detached(sizes: [usize; 2], period: f64) -> Self {
        tap(sizes, period).0
    }

    /// Cycles that the node was too slow for.
    #[must_use]
    pub fn missed(&self) -> u64 {
        self.missed.load(Ordering::Relaxed)
    }

    /// Offers a cycle to the node, which takes one of some; where it is slow, it misses it. Allocates
    /// nothing, takes no lock and makes no system call.
    pub fn show<P: Plant>(&mut self, record: &CycleRecord<'_, P>) {
        let due = self.count.is_multiple_of(self.every);
        self.count += 1;
        if !due {
            return;
        }
        // The ring holds whole cycles only, so that none is split at its end.
        let Ok(mut chunk) = self.ring.write_chunk(self.layout.words()) else {
            self.missed.fetch_add(1, Ordering::Relaxed);
            return;
        };
        self.layout.fill(chunk.as_mut_slices().0, &record.seen());
        chunk.commit_all();
    }
}

impl TapReader {
    /// The next cycle.
    pub(crate) fn read(&mut self) -> Option<&Frame> {
        self.ring.pop_entire_slice(self.frame.words_mut()).ok()?;
        Some(&self.frame)
    }

    /// Cycles for which there was no room.
    pub(crate) fn missed(&self) -> u64 {
        self.missed.load(Ordering::Relaxed)
    }
}
