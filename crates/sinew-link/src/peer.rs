//! Sequence numbers, time stamps, losses and round trips of one side of a session.

use crate::Rejection;
use crate::replay::{Freshness, ReplayWindow};
use crate::wire::{Head, Kind, MAGIC, VERSION};

/// One side's view of a session: what it has sent, and what it has received from the other side.
#[derive(Debug, Clone, Copy, Default)]
pub struct Peer {
    sent: u64,
    window: ReplayWindow,
    accepted: u64,
    /// `time_ns` of the newest packet, and when it arrived by our clock.
    newest_time: u64,
    newest_arrival: u64,
    /// Our newest packet that the other side has received, as far as it has said.
    reflected: u64,
    round_trip: RoundTrip,
}

/// Times from the sending of a packet to the arrival of one that reflects it, less the time for which the
/// other side held it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RoundTrip {
    /// Number of measurements.
    pub count: u64,
    /// The newest, ns.
    pub last_ns: u64,
    /// The shortest, ns.
    pub min_ns: u64,
    /// The longest, ns.
    pub max_ns: u64,
    sum_ns: u64,
}

impl Default for RoundTrip {
    fn default() -> Self {
        Self { count: 0, last_ns: 0, min_ns: u64::MAX, max_ns: 0, sum_ns: 0 }
    }
}

impl RoundTrip {
    /// Mean, ns; none before the first.
    #[must_use]
    pub fn mean_ns(&self) -> Option<u64> {
        self.sum_ns.checked_div(self.count)
    }

    fn record(&mut self, time: u64) {
        self.count += 1;
        self.last_ns = time;
        self.min_ns = self.min_ns.min(time);
        self.max_ns = self.max_ns.max(time);
        self.sum_ns = self.sum_ns.saturating_add(time);
    }
}

impl Peer {
    /// Packets sent.
    #[must_use]
    pub fn sent(&self) -> u64 {
        self.sent
    }

    /// Packets received that passed all checks.
    #[must_use]
    pub fn accepted(&self) -> u64 {
        self.accepted
    }

    /// Packets of the other side that have not arrived.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.window.newest() - self.accepted
    }

    /// Number of our newest packet that the other side says it has received; 0 before the first.
    #[must_use]
    pub fn reflected(&self) -> u64 {
        self.reflected
    }

    /// Round trips so far.
    #[must_use]
    pub fn round_trip(&self) -> &RoundTrip {
        &self.round_trip
    }

    /// Head of the next packet to the other side.
    pub(crate) fn next_head(&mut self, kind: Kind, session: u64, now: u64) -> Head {
        self.sent += 1;
        let received = self.window.newest() > 0;
        Head {
            magic: MAGIC,
            version: VERSION,
            kind: kind as u8,
            length: 0,
            session,
            sequence: self.sent,
            reflected_sequence: self.window.newest(),
            time_ns: now,
            reflected_time_ns: self.newest_time,
            held_ns: if received { now.saturating_sub(self.newest_arrival) } else { 0 },
        }
    }

    /// Judges an authentic packet by its sequence number and time stamp.
    pub(crate) fn judge(&self, head: &Head) -> Result<Freshness, Rejection> {
        let freshness = self.window.judge(head.sequence);
        let in_order = match freshness {
            Freshness::Old => return Err(Rejection::Old),
            Freshness::Replayed => return Err(Rejection::Replayed),
            Freshness::Newest => head.time_ns >= self.newest_time,
            Freshness::Late => head.time_ns <= self.newest_time,
        };
        if in_order { Ok(freshness) } else { Err(Rejection::Time) }
    }

    /// Records a packet that was judged.
    pub(crate) fn record(&mut self, head: &Head, now: u64) {
        let newest = head.sequence > self.window.newest();
        self.window.record(head.sequence);
        self.accepted += 1;
        if !newest {
            return;
        }
        (self.newest_time, self.newest_arrival) = (head.time_ns, now);
        let sent_by_us = head.reflected_sequence > 0 && head.reflected_sequence <= self.sent;
        if sent_by_us {
            self.reflected = self.reflected.max(head.reflected_sequence);
        }
        let travelled = now.checked_sub(head.reflected_time_ns).and_then(|t| t.checked_sub(head.held_ns));
        if let (true, Some(time)) = (sent_by_us, travelled) {
            self.round_trip.record(time);
        }
    }
}

/// Head of a packet outside of sessions.
pub(crate) fn bare_head(kind: Kind, now: u64) -> Head {
    Peer::default().next_head(kind, 0, now).without_sequence()
}

impl Head {
    fn without_sequence(self) -> Self {
        Self { sequence: 0, ..self }
    }
}
