use rtrb::{Consumer, Producer, RingBuffer};
use sinew_link::{Command, Rejection};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// What the control cycle took from a link, so that a linked run can be replayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinkInput {
    /// Machine time of the cycle that took it, ns.
    pub at_ns: u64,
    /// A command; none where a session began or ended.
    pub command: Option<Command>,
}

impl LinkInput {
    /// The body of its Command packet; empty where a session began or ended.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        self.command.map_or_else(Vec::new, |command| command.to_bytes())
    }

    /// From what [`to_bytes`](Self::to_bytes) gives.
    ///
    /// # Errors
    /// Why the bytes are no command.
    pub fn from_bytes(at_ns: u64, bytes: &[u8]) -> Result<Self, Rejection> {
        let command = (!bytes.is_empty()).then(|| Command::from_bytes(bytes)).transpose()?;
        Ok(Self { at_ns, command })
    }
}

/// Inputs that wait for the reader at most.
const INPUTS: usize = 1024;
/// Between two looks at a tape without room.
const PAUSE: Duration = Duration::from_millis(1);

/// The control cycle's end of a ring of inputs.
#[derive(Debug)]
pub struct Tape {
    ring: Producer<LinkInput>,
    dropped: Arc<AtomicU64>,
    waits: bool,
}

/// The other end.
#[derive(Debug)]
pub struct TapeReader {
    ring: Consumer<LinkInput>,
    dropped: Arc<AtomicU64>,
}

impl Tape {
    /// Both ends. One that waits for room serves virtual time alone; else an input without room is dropped and counted, and
    /// nothing is allocated, locked or asked of the system.
    #[must_use]
    pub fn new(waits: bool) -> (Self, TapeReader) {
        let (ring, reader) = RingBuffer::new(INPUTS);
        let dropped = Arc::<AtomicU64>::default();
        (Self { ring, dropped: Arc::clone(&dropped), waits }, TapeReader { ring: reader, dropped })
    }

    pub(super) fn put(&mut self, input: LinkInput) {
        while self.waits && self.ring.is_full() && !self.ring.is_abandoned() {
            std::thread::sleep(PAUSE);
        }
        if self.ring.push(input).is_err() {
            self.dropped.fetch_add(1, Ordering::Release);
        }
    }
}

impl TapeReader {
    /// The next input, if there is one.
    pub fn read(&mut self) -> Option<LinkInput> {
        self.ring.pop().ok()
    }

    /// Inputs for which there was no room: a replay differs from there on.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Acquire)
    }
}
