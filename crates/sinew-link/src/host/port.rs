//! The control cycle's end of the queues.

use crate::rejection::SharedCounters;
use crate::{Command, Counters, Snapshot};
use rtrb::{Consumer, Producer, RingBuffer};
use std::io::Write;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::Thread;
use std::time::Duration;

/// Commands that wait for the cycle at most.
const COMMANDS: usize = 64;
/// States that wait for the server at most.
const SNAPSHOTS: usize = 16;

/// What both ends of the queues share beside them.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// Number of the active session; 0 without one.
    session: AtomicU64,
    /// The cycle waits to be woken (lock-step).
    waiting: AtomicBool,
    stop: AtomicBool,
}

/// A command with the number of its session.
#[derive(Debug, Clone, Copy)]
struct Numbered {
    session: u64,
    command: Command,
}

/// What a link gives to the control cycle, in the order in which it happened. Watchers and clients that are
/// refused give nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "the control cycle takes it, which allocates nothing")]
pub enum Input {
    /// The session of a client that commands has begun.
    Begins,
    /// It has sent a valid command.
    Command(Command),
    /// Its session has ended: by a Goodbye, or because nothing came for too long.
    Ends,
}

/// The control cycle's end of a link. All but [`Port::wait`] are free of locks, system calls and allocation.
#[derive(Debug)]
pub struct Port {
    commands: Consumer<Numbered>,
    snapshots: Producer<Snapshot>,
    /// Number of the session whose beginning was given last; 0 after its end.
    seen: u64,
    /// A command of a session whose beginning has not been given.
    next: Option<Numbered>,
    dropped: u64,
    shared: Arc<Shared>,
    counters: Arc<SharedCounters>,
    wake: UnixStream,
}

/// The server's end.
#[derive(Debug)]
pub(super) struct ServerEnd {
    commands: Producer<Numbered>,
    pub(super) snapshots: Consumer<Snapshot>,
    shared: Arc<Shared>,
    /// The thread that waits in lock-step.
    pub(super) cycle: Thread,
}

/// Both ends; the port is used on the calling thread where it waits.
pub(super) fn queues(wake: UnixStream, counters: Arc<SharedCounters>) -> (Port, ServerEnd) {
    let (to_cycle, commands) = RingBuffer::new(COMMANDS);
    let (snapshots, from_cycle) = RingBuffer::new(SNAPSHOTS);
    let shared = Arc::<Shared>::default();
    let port = Port {
        commands,
        snapshots,
        seen: 0,
        next: None,
        dropped: 0,
        shared: Arc::clone(&shared),
        counters,
        wake,
    };
    let cycle = std::thread::current();
    (port, ServerEnd { commands: to_cycle, snapshots: from_cycle, shared, cycle })
}

impl Port {
    /// The next of what has happened. The commands that a session was in time to send come before its end, so
    /// that none is lost with it.
    pub fn next_input(&mut self) -> Option<Input> {
        // Before the queue is looked at: all commands of sessions before this one are in it by then.
        let newest = self.shared.session.load(Ordering::Acquire);
        let next = self.next.take().or_else(|| self.commands.pop().ok());
        let session = next.map_or(newest, |next| next.session);
        if let Some(Numbered { session, command }) = next
            && session == self.seen
        {
            return Some(Input::Command(command));
        }
        self.next = next;
        if session == self.seen {
            return None;
        }
        if self.seen > 0 {
            self.seen = 0;
            return Some(Input::Ends);
        }
        self.seen = session;
        Some(Input::Begins)
    }

    /// The next command, whose session does not matter.
    pub fn next_command(&mut self) -> Option<Command> {
        loop {
            if let Input::Command(command) = self.next_input()? {
                return Some(command);
            }
        }
    }

    /// Hands a state to the server; where it does not keep up the state is dropped and counted.
    pub fn publish(&mut self, snapshot: &Snapshot) {
        if self.snapshots.push(*snapshot).is_err() {
            self.dropped += 1;
        }
    }

    /// States that were dropped.
    #[must_use]
    pub fn dropped_states(&self) -> u64 {
        self.dropped
    }

    /// Counts of received packets.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters.read()
    }

    /// Lock-step alone: has the published states sent at once and waits for a command, the beginning or the
    /// end of a session, at most this long. This is a system call.
    pub fn wait(&mut self, most: Duration) {
        self.shared.waiting.store(true, Ordering::SeqCst);
        // Full: the server has not yet seen the byte before.
        let _ = self.wake.write(&[1]);
        let changed = self.shared.session.load(Ordering::SeqCst) != self.seen;
        if self.commands.is_empty() && self.next.is_none() && !changed {
            std::thread::park_timeout(most);
        }
        self.shared.waiting.store(false, Ordering::SeqCst);
    }
}

impl ServerEnd {
    /// False where the queue is full.
    pub(super) fn push(&mut self, command: &Command, session: u64) -> bool {
        // Before the command, so that the cycle does not drop the first one of a session.
        self.set_session(session);
        let taken = self.commands.push(Numbered { session, command: *command }).is_ok();
        self.wake_cycle();
        taken
    }

    pub(super) fn set_session(&self, session: u64) {
        if self.shared.session.swap(session, Ordering::AcqRel) != session {
            self.wake_cycle();
        }
    }

    fn wake_cycle(&self) {
        if self.shared.waiting.load(Ordering::SeqCst) {
            self.cycle.unpark();
        }
    }

    pub(super) fn is_stopped(&self) -> bool {
        self.shared.stop.load(Ordering::Relaxed)
    }

    /// For the handle that stops the server.
    pub(super) fn shared(&self) -> Arc<Shared> {
        Arc::clone(&self.shared)
    }
}

impl Shared {
    pub(super) fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}
