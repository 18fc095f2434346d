use super::tape::LinkInput;
use sinew_link::host::{Port, Session};
use sinew_link::{Command, Counters, Snapshot};
use std::collections::VecDeque;
use std::time::Duration;

/// Where sessions and commands come from.
#[derive(Debug)]
pub(super) enum Source {
    /// A server, and the session that was seen last.
    Server(Port, Option<Session>),
    /// What a recording holds, the oldest first.
    Recording(VecDeque<LinkInput>),
}

impl Source {
    /// Whether a session of a server has begun or ended since the last call.
    pub(super) fn session_changed(&mut self) -> bool {
        let Self::Server(port, session) = self else { return false };
        let newest = port.session();
        std::mem::replace(session, newest) != newest
    }

    pub(super) fn has_session(&self) -> bool {
        matches!(self, Self::Server(_, Some(_)))
    }

    /// The next command of a server.
    pub(super) fn next_command(&mut self) -> Option<Command> {
        if let Self::Server(port, _) = self { port.next_command() } else { None }
    }

    /// The next input of a recording that was taken in the cycle of a time, ns, or before it.
    pub(super) fn next_recorded(&mut self, now: u64) -> Option<LinkInput> {
        let Self::Recording(inputs) = self else { return None };
        if inputs.front()?.at_ns <= now { inputs.pop_front() } else { None }
    }

    pub(super) fn publish(&mut self, snapshot: &Snapshot) {
        if let Self::Server(port, _) = self {
            port.publish(snapshot);
        }
    }

    pub(super) fn wait(&mut self, most: Duration) {
        if let Self::Server(port, _) = self {
            port.wait(most);
        }
    }

    pub(super) fn counters(&self) -> Counters {
        if let Self::Server(port, _) = self { port.counters() } else { Counters::default() }
    }

    pub(super) fn dropped_states(&self) -> u64 {
        if let Self::Server(port, _) = self { port.dropped_states() } else { 0 }
    }
}
