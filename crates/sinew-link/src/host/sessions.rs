//! Sessions and the checks of received packets, without sockets and clock.

use super::domain::Domain;
use super::rate::RateLimit;
use crate::peer::{Peer, bare_head};
use crate::rejection::SharedCounters;
use crate::replay::Freshness;
use crate::setpoints;
use crate::snapshot::{Snapshot, StateCounts};
use crate::wire::{
    Datagram, Head, Hello, Kind, Nonce, Received, Refused, Sealer, SessionKeys, Welcome, features, open,
    session_of,
};
use crate::{Command, Counters, Error, Key, RefusedBecause, Rejection, Request};
use std::net::SocketAddr;
use std::sync::Arc;

/// Fills a nonce with random bytes; false where there are none.
pub type RandomSource = Box<dyn FnMut(&mut Nonce) -> bool + Send>;

/// Settings of the sessions of a host.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SessionSettings {
    /// Whether the machine's time advances as the client asks. Commands are not limited in rate then.
    pub lock_step: bool,
    /// Of the control cycle, ns.
    pub period_ns: u64,
    /// Of the State packets, ns.
    pub state_period_ns: u64,
    /// From the time stamp of a set-point to its effect, ns.
    pub playout_delay_ns: u64,
    /// Without a valid command, in the machine's time: then the machine holds, ns.
    pub timeout_ns: u64,
    /// Without a valid packet, on the wall clock: then the session ends, ns.
    pub expiry_ns: u64,
    /// Most commands per second.
    pub commands_per_second: u32,
}

impl Default for SessionSettings {
    fn default() -> Self {
        Self {
            lock_step: false,
            period_ns: 1_000_000,
            state_period_ns: 2_000_000,
            playout_delay_ns: 4_000_000,
            timeout_ns: 100_000_000,
            expiry_ns: 500_000_000,
            commands_per_second: 4000,
        }
    }
}

/// Sessions offered at once: more Hello packets replace the oldest offer.
const OFFERS: usize = 8;
/// Most Hello packets answered per second.
const HELLOS_PER_SECOND: u32 = 50;
/// Commands above the mean rate at once, in parts of a second.
const BURST: u32 = 10;

/// All sessions of a host: at most one is active, some are offered.
pub struct Sessions {
    sealer: Sealer,
    domain: Domain,
    settings: SessionSettings,
    random: RandomSource,
    counters: Arc<SharedCounters>,
    active: Option<Active>,
    offers: [Option<Offer>; OFFERS],
    next_offer: usize,
    hellos: RateLimit,
    commands: RateLimit,
    generation: u64,
}

impl std::fmt::Debug for Sessions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let active = self.active.as_ref().map(|active| active.address);
        f.debug_struct("Sessions")
            .field("domain", &self.domain)
            .field("active", &active)
            .finish_non_exhaustive()
    }
}

#[derive(Debug, Clone)]
struct Offer {
    session: u64,
    nonces: [Nonce; 2],
    keys: SessionKeys,
}

#[derive(Debug)]
struct Active {
    offer: Offer,
    peer: Peer,
    address: SocketAddr,
    heard: u64,
    last_rejection: Option<Rejection>,
}

/// What happened to a received datagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Rejected and counted; where a reply was written it is to be sent.
    Rejected(Rejection),
    /// A session is offered: the reply is to be sent.
    Offered,
    /// A command was taken.
    Commanded,
    /// The session has ended.
    Ended,
}

impl Sessions {
    /// Without any session.
    ///
    /// # Errors
    /// As [`Domain::validate`].
    pub fn new(
        key: &Key,
        domain: Domain,
        settings: SessionSettings,
        random: RandomSource,
    ) -> Result<Self, Error> {
        domain.validate()?;
        let rate = if settings.lock_step { 0 } else { settings.commands_per_second };
        Ok(Self {
            sealer: Sealer::new(key),
            domain,
            settings,
            random,
            counters: Arc::default(),
            active: None,
            offers: [const { None }; OFFERS],
            next_offer: 0,
            hellos: RateLimit::new(HELLOS_PER_SECOND, HELLOS_PER_SECOND),
            commands: RateLimit::new(rate, rate / BURST),
            generation: 0,
        })
    }

    /// Counts since the start.
    #[must_use]
    pub fn counters(&self) -> Counters {
        self.counters.read()
    }

    pub(super) fn shared_counters(&self) -> Arc<SharedCounters> {
        Arc::clone(&self.counters)
    }

    /// The client of the active session.
    #[must_use]
    pub fn client(&self) -> Option<SocketAddr> {
        self.active.as_ref().map(|active| active.address)
    }

    /// Number of the active session since the start, from 1; 0 without one.
    #[must_use]
    pub fn generation(&self) -> u64 {
        if self.active.is_some() { self.generation } else { 0 }
    }

    /// Ends the active session where nothing valid has come for too long. Times are those of one monotonic clock, ns.
    pub fn expire(&mut self, now: u64) {
        let expiry = self.settings.expiry_ns;
        if self.active.as_ref().is_some_and(|active| now.saturating_sub(active.heard) > expiry) {
            self.active = None;
        }
    }

    /// Checks a datagram; a valid command is handed to `take`, which says whether there was room for it. A reply, if any, is
    /// written, else the reply is empty.
    pub fn receive(
        &mut self,
        datagram: &[u8],
        from: SocketAddr,
        now: u64,
        reply: &mut Datagram,
        take: impl FnOnce(&Command, u64) -> bool,
    ) -> Outcome {
        reply.clear();
        self.expire(now);
        let result = open(datagram).and_then(|received| match received.kind {
            Kind::Hello => self.offer(&received, now, reply),
            Kind::Command | Kind::Goodbye => self.command(&received, from, now, take),
            Kind::Welcome | Kind::Refused | Kind::State => Err(Rejection::Kind),
        });
        match result {
            Ok(outcome) => {
                self.counters.accept();
                outcome
            }
            Err(reason) => {
                self.counters.reject(reason);
                Outcome::Rejected(reason)
            }
        }
    }

    /// Answers a Hello.
    fn offer(
        &mut self,
        received: &Received<'_>,
        now: u64,
        reply: &mut Datagram,
    ) -> Result<Outcome, Rejection> {
        let mut body = received.body();
        let hello = Hello::read(&mut body).filter(|_| body.is_empty()).ok_or(Rejection::Length)?;
        if received.head.session != 0 {
            return Err(Rejection::Session);
        }
        if !received.is_sealed_by(&self.sealer) {
            return Err(Rejection::Tag);
        }
        if received.head.sequence != 0 || hello.padding != [0; 88] {
            return Err(Rejection::Code);
        }
        if !self.hellos.allow(now) {
            return Err(Rejection::Rate);
        }
        let client_nonce = hello.client_nonce;
        if let Some(active) = &self.active {
            if active.offer.nonces[0] == client_nonce {
                return Err(Rejection::Replayed);
            }
            let because = RefusedBecause::SecondClient.number();
            let refused = Refused { client_nonce, because, padding: [0; 7] };
            reply.seal(bare_head(Kind::Refused, now), &self.sealer, |writer| refused.write(writer));
            return Err(Rejection::SecondClient);
        }
        let known = self.offers.iter().flatten().find(|offer| offer.nonces[0] == client_nonce);
        let host_nonce = match known {
            Some(offer) => offer.nonces[1],
            None => self.new_offer(client_nonce)?,
        };
        let welcome = self.welcome([client_nonce, host_nonce]);
        reply.seal(bare_head(Kind::Welcome, now), &self.sealer, |writer| welcome.write(writer));
        Ok(Outcome::Offered)
    }

    fn new_offer(&mut self, client_nonce: Nonce) -> Result<Nonce, Rejection> {
        let mut host_nonce = [0; 16];
        if !(self.random)(&mut host_nonce) || session_of(&host_nonce) == 0 {
            return Err(Rejection::Session);
        }
        let keys = SessionKeys::new(&self.sealer, &client_nonce, &host_nonce);
        let nonces = [client_nonce, host_nonce];
        self.offers[self.next_offer] = Some(Offer { session: session_of(&host_nonce), nonces, keys });
        self.next_offer = (self.next_offer + 1) % OFFERS;
        Ok(host_nonce)
    }

    fn welcome(&self, [client_nonce, host_nonce]: [Nonce; 2]) -> Welcome {
        let mut machine = [0; 32];
        let mut length = self.domain.name.len().min(machine.len());
        while !self.domain.name.is_char_boundary(length) {
            length -= 1;
        }
        machine[..length].copy_from_slice(&self.domain.name.as_bytes()[..length]);
        let [joints, muscles] = self.domain.dimensions();
        let lock_step = if self.settings.lock_step { features::LOCK_STEP } else { 0 };
        Welcome {
            client_nonce,
            host_nonce,
            machine,
            joints: joints as u16,
            muscles: muscles as u16,
            features: self.domain.features() | lock_step,
            period_ns: self.settings.period_ns,
            state_period_ns: self.settings.state_period_ns,
            playout_delay_ns: self.settings.playout_delay_ns,
            timeout_ns: self.settings.timeout_ns,
        }
    }

    /// Takes a command or the end of a session; the first valid one of an offered session makes it the active one.
    fn command(
        &mut self,
        received: &Received<'_>,
        from: SocketAddr,
        now: u64,
        take: impl FnOnce(&Command, u64) -> bool,
    ) -> Result<Outcome, Rejection> {
        let session = received.head.session;
        if self.active.as_ref().is_none_or(|active| active.offer.session != session) {
            self.activate(received, from, now)?;
        } else if !self.active.as_ref().is_some_and(|active| received.is_sealed_by(&active.offer.keys.client))
        {
            return Err(Rejection::Tag);
        }
        let Self { active: Some(active), domain, commands, generation, .. } = self else {
            return Err(Rejection::Session);
        };
        let freshness = active.peer.judge(&received.head)?;
        let result = match received.kind {
            Kind::Goodbye if received.body().is_empty() => Ok(Outcome::Ended),
            Kind::Goodbye => Err(Rejection::Length),
            _ => {
                active.take(received, freshness, domain, commands, now, |command| take(command, *generation))
            }
        };
        // An authentic packet counts as arrived whatever its content.
        active.peer.record(&received.head, now);
        (active.heard, active.address) = (now, from);
        match result {
            Ok(Outcome::Ended) => self.active = None,
            Ok(_) => {}
            Err(reason) => active.last_rejection = Some(reason),
        }
        result
    }

    fn activate(&mut self, received: &Received<'_>, from: SocketAddr, now: u64) -> Result<(), Rejection> {
        let session = received.head.session;
        let offer = self.offers.iter_mut().find(|o| o.as_ref().is_some_and(|o| o.session == session));
        let offered = offer.as_ref().and_then(|offer| offer.as_ref()).ok_or(Rejection::Session)?;
        if !received.is_sealed_by(&offered.keys.client) {
            return Err(Rejection::Tag);
        }
        if self.active.is_some() {
            return Err(Rejection::SecondClient);
        }
        let Some(offer) = offer.and_then(Option::take) else { return Err(Rejection::Session) };
        self.generation += 1;
        self.active =
            Some(Active { offer, peer: Peer::default(), address: from, heard: now, last_rejection: None });
        Ok(())
    }

    /// Seals one part of a state for the active client: `part` is where it begins, [0, 0] at first, and becomes where the next
    /// one begins, none after the last. None without a client.
    pub fn state(
        &mut self,
        snapshot: &Snapshot,
        part: &mut Option<[usize; 2]>,
        now: u64,
        datagram: &mut Datagram,
    ) -> Option<SocketAddr> {
        let from = part.take()?;
        let active = self.active.as_mut()?;
        let counts = StateCounts {
            accepted: active.peer.accepted(),
            lost: active.peer.lost(),
            rejected: self.counters.read().all_rejected(),
            last_rejection: active.last_rejection,
        };
        let head: Head = active.peer.next_head(Kind::State, active.offer.session, now);
        datagram.seal(head, &active.offer.keys.host, |writer| {
            *part = snapshot.write(from, &counts, writer)?;
            Some(())
        });
        Some(active.address)
    }
}

impl Active {
    /// Reads, checks and hands over a command.
    fn take(
        &self,
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
}
