use super::domain::Domain;
use super::outcome::Outcome;
use super::rate::RateLimit;
use crate::peer::Peer;
use crate::replay::Freshness;
use crate::setpoints;
use crate::snapshot::{Snapshot, StateCounts};
use crate::wire::{Datagram, Head, Kind, Received, SessionKeys};
use crate::{Command, Rejection, Request, Role};
use std::net::SocketAddr;

/// A client whose session has begun.
#[derive(Debug)]
pub(super) struct Attached {
    session: u64,
    role: Role,
    keys: SessionKeys,
    peer: Peer,
    pub(super) address: SocketAddr,
    heard: u64,
    last_rejection: Option<Rejection>,
}

impl Attached {
    pub(super) fn new(
        session: u64,
        (role, keys): (Role, SessionKeys),
        (address, now): (SocketAddr, u64),
    ) -> Self {
        Self { session, role, keys, peer: Peer::default(), address, heard: now, last_rejection: None }
    }

    /// Number of its session.
    pub(super) fn session(&self) -> u64 {
        self.session
    }

    /// Whether a packet carries the tag of this client.
    pub(super) fn has_sealed(&self, received: &Received<'_>) -> bool {
        received.is_sealed_by(&self.keys.client)
    }

    /// Whether nothing valid has come for longer than `expiry` ns.
    pub(super) fn is_expired(&self, now: u64, expiry: u64) -> bool {
        now.saturating_sub(self.heard) > expiry
    }

    /// Takes a packet of this session whose tag is right; a command is handed to `take`.
    pub(super) fn receive(
        &mut self,
        received: &Received<'_>,
        (from, now): (SocketAddr, u64),
        domain: &Domain,
        rate: &mut RateLimit,
        take: impl FnOnce(&Command) -> bool,
    ) -> Result<Outcome, Rejection> {
        let freshness = self.peer.judge(&received.head)?;
        let result = match (received.kind, self.role) {
            (Kind::Command, Role::Watches) | (Kind::Watch, Role::Commands) => Err(Rejection::Role),
            (Kind::Command, _) => command(received, freshness, domain, rate, now, take),
            _ if !received.body().is_empty() => Err(Rejection::Length),
            (Kind::Goodbye, _) => Ok(Outcome::Ended),
            _ => Ok(Outcome::Watched),
        };
        // An authentic packet counts as arrived whatever its content.
        self.peer.record(&received.head, now);
        (self.heard, self.address) = (now, from);
        if let Err(reason) = result {
            self.last_rejection = Some(reason);
        }
        result
    }

    /// Seals one part of a state: `part` is where it begins, [0, 0] at first, and becomes where the next one
    /// begins, none after the last. `rejected` are the packets from anyone that were rejected.
    pub(super) fn state(
        &mut self,
        snapshot: &Snapshot,
        part: &mut Option<[usize; 2]>,
        (rejected, now): (u64, u64),
        datagram: &mut Datagram,
    ) -> Option<SocketAddr> {
        let from = part.take()?;
        let counts = StateCounts {
            accepted: self.peer.accepted(),
            lost: self.peer.lost(),
            rejected,
            last_rejection: self.last_rejection,
        };
        let head: Head = self.peer.next_head(Kind::State, self.session, now);
        datagram.seal(head, &self.keys.host, |writer| {
            *part = snapshot.write(from, &counts, writer)?;
            Some(())
        });
        Some(self.address)
    }
}

/// Reads, checks and hands over a command.
fn command(
    received: &Received<'_>,
    freshness: Freshness,
    domain: &Domain,
    rate: &mut RateLimit,
    now: u64,
    take: impl FnOnce(&Command) -> bool,
) -> Result<Outcome, Rejection> {
    if !rate.allow(now) {
        return Err(Rejection::Rate);
    }
    let mut command = setpoints::read(&mut received.body())?;
    domain.check(&command)?;
    // A request that was overtaken by a newer one has no effect; its points have their own time stamps.
    if freshness == Freshness::Late {
        command.request = Request::None;
    }
    if take(&command) { Ok(Outcome::Commanded) } else { Err(Rejection::QueueFull) }
}
