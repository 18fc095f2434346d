use sinew_link::host::{Input, Port};
use sinew_link::{Counters, Snapshot};
use std::collections::VecDeque;
use std::time::Duration;

/// Where sessions and commands come from.
#[derive(Debug)]
pub(super) enum Source {
    /// A server.
    Server(Box<Port>),
    /// What a recording holds, the oldest first: of a link alone.
    Recording(VecDeque<(u64, Input)>),
}

impl Source {
    /// The next input of a server.
    pub(super) fn next(&mut self) -> Option<Input> {
        if let Self::Server(port) = self { port.next_input() } else { None }
    }

    /// The next input of a recording that was taken in the cycle of a time, ns, or before it.
    pub(super) fn next_recorded(&mut self, now: u64) -> Option<Input> {
        let Self::Recording(inputs) = self else { return None };
        let (at_ns, _) = inputs.front()?;
        if *at_ns <= now { inputs.pop_front().map(|(_, input)| input) } else { None }
    }

    pub(super) fn publish(&mut self, snapshot: &Snapshot) {
        if let Self::Server(port) = self {
            port.publish(snapshot);
        }
    }

    pub(super) fn wait(&mut self, most: Duration) {
        if let Self::Server(port) = self {
            port.wait(most);
        }
    }

    pub(super) fn counters(&self) -> Counters {
        if let Self::Server(port) = self { port.counters() } else { Counters::default() }
    }

    pub(super) fn dropped_states(&self) -> u64 {
        if let Self::Server(port) = self { port.dropped_states() } else { 0 }
    }
}
