use rtrb::{Consumer, Producer, RingBuffer};
use sinew_link::host::Input;
use sinew_link::{Command, Rejection};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// What the control cycle took from elsewhere, so that its run can be replayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleInput {
    /// Machine time of the cycle that took it, ns.
    pub at_ns: u64,
    /// What it was.
    pub what: Taken,
}

/// What was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "the control cycle puts it on a tape and allocates nothing")]
pub enum Taken {
    /// From a link.
    Link(Input),
    /// A safe stop, from the page or the terminal.
    Stop,
}

/// The only byte of an input that is no command: the body of a Command packet is longer.
const BEGINS: u8 = 1;
const ENDS: u8 = 2;
const STOP: u8 = 3;

impl CycleInput {
    /// The body of its Command packet, or one byte.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        match &self.what {
            Taken::Link(Input::Command(command)) => command.to_bytes(),
            Taken::Link(Input::Begins) => vec![BEGINS],
            Taken::Link(Input::Ends) => vec![ENDS],
            Taken::Stop => vec![STOP],
        }
    }

    /// From what [`to_bytes`](Self::to_bytes) gives. No byte at all, in recordings of programs until
    /// 2026-11-26, is a session that began or ended: the machine held.
    ///
    /// # Errors
    /// Why the bytes are no command.
    pub fn from_bytes(at_ns: u64, bytes: &[u8]) -> Result<Self, Rejection> {
        let what = match bytes {
            [BEGINS] => Taken::Link(Input::Begins),
            [] | [ENDS] => Taken::Link(Input::Ends),
            [STOP] => Taken::Stop,
            _ => Taken::Link(Input::Command(Command::from_bytes(bytes)?)),
        };
        Ok(Self { at_ns, what })
    }
}

/// Inputs that wait for the reader at most.
const INPUTS: usize = 1024;
/// Between two looks at a tape without room.
const PAUSE: Duration = Duration::from_millis(1);

/// The control cycle's end of a ring of inputs.
#[derive(Debug)]
pub struct Tape {
    ring: Producer<CycleInput>,
    dropped: Arc<AtomicU64>,
    waits: bool,
}

/// The other end.
#[derive(Debug)]
pub struct TapeReader {
    ring: Consumer<CycleInput>,
    dropped: Arc<AtomicU64>,
}

impl Tape {
    /// Both ends. One that waits for room serves virtual time alone; else an input without room is dropped
    /// and counted, and nothing is allocated, locked or asked of the system.
    #[must_use]
    pub fn new(waits: bool) -> (Self, TapeReader) {
        let (ring, reader) = RingBuffer::new(INPUTS);
        let dropped = Arc::<AtomicU64>::default();
        (Self { ring, dropped: Arc::clone(&dropped), waits }, TapeReader { ring: reader, dropped })
    }

    pub(crate) fn put(&mut self, input: CycleInput) {
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
    pub fn read(&mut self) -> Option<CycleInput> {
        self.ring.pop().ok()
    }

    /// Inputs for which there was no room: a replay differs from there on.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Acquire)
    }
}
