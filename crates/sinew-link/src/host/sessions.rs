//! Sessions and the checks of received packets, without sockets and clock.

use super::attached::Attached;
use super::domain::Domain;
use super::offers::{Offer, Offers, RandomSource};
use super::outcome::Outcome;
use super::rate::RateLimit;
use crate::peer::bare_head;
use crate::rejection::SharedCounters;
use crate::snapshot::Snapshot;
use crate::wire::{
    Datagram, Hello, Kind, Nonce, Received, Refused, Sealer, SessionKeys, Welcome, features, open,
};
use crate::{Command, Counters, Error, Key, RefusedBecause, Rejection, Role};
use std::net::SocketAddr;
use std::sync::Arc;

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
    /// From the end of a session, in the machine's time, for which a machine under tension is held before its
    /// tension is released, ns.
    pub unattended_ns: u64,
    /// Most commands per second.
    pub commands_per_second: u32,
}

/// Time between State packets, and from a set-point's time stamp to its effect, ns: whole cycles, at least
/// these.
const STATE_PERIOD: u64 = 2_000_000;
const PLAYOUT_DELAY: u64 = 4_000_000;

impl SessionSettings {
    /// Those of a control cycle with a period, ns, > 0.
    #[must_use]
    pub fn of_period(period_ns: u64) -> Self {
        let period_ns = period_ns.max(1);
        Self {
            lock_step: false,
            period_ns,
            state_period_ns: STATE_PERIOD.div_ceil(period_ns) * period_ns,
            playout_delay_ns: PLAYOUT_DELAY.max(2 * period_ns),
            timeout_ns: 100_000_000,
            expiry_ns: 500_000_000,
            unattended_ns: 5_000_000_000,
            commands_per_second: 4000,
        }
    }
}

impl Default for SessionSettings {
    /// Of a millisecond.
    fn default() -> Self {
        Self::of_period(1_000_000)
    }
}

/// Clients that watch at once, at most.
pub const WATCHERS: usize = 8;
/// Commands above the mean rate at once, in parts of a second.
const BURST: u32 = 10;

/// All sessions of a host: at most one commands, some watch, some are offered.
pub struct Sessions {
    sealer: Sealer,
    domain: Domain,
    settings: SessionSettings,
    random: RandomSource,
    counters: Arc<SharedCounters>,
    active: Option<Attached>,
    watchers: Vec<Attached>,
    offers: Offers,
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
            watchers: Vec::with_capacity(WATCHERS),
            offers: Offers::default(),
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

    /// The client that commands.
    #[must_use]
    pub fn client(&self) -> Option<SocketAddr> {
        self.active.as_ref().map(|active| active.address)
    }

    /// Number of clients that watch.
    #[must_use]
    pub fn watchers(&self) -> usize {
        self.watchers.len()
    }

    /// Number of the active session since the start, from 1; 0 without one.
    #[must_use]
    pub fn generation(&self) -> u64 {
        if self.active.is_some() { self.generation } else { 0 }
    }

    /// Ends sessions in which nothing valid has come for too long. Times are those of one monotonic clock,
    /// ns.
    pub fn expire(&mut self, now: u64) {
        let expiry = self.settings.expiry_ns;
        self.active.take_if(|active| active.is_expired(now, expiry));
        self.watchers.retain(|watcher| !watcher.is_expired(now, expiry));
    }

    /// Checks a datagram; a valid command is handed to `take`, which says whether there was room for it. A
    /// reply, if any, is written, else the reply is empty.
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
            Kind::Hello => self.offer(&received, (from, now), reply),
            Kind::Command | Kind::Goodbye | Kind::Watch => self.take(&received, from, now, take),
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
        (from, now): (SocketAddr, u64),
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
        let role = Role::from_number(hello.role).ok_or(Rejection::Code)?;
        if received.head.sequence != 0 || hello.padding != [0; 87] {
            return Err(Rejection::Code);
        }
        let client_nonce = hello.client_nonce;
        if self.offers.has_begun(&client_nonce) {
            return Err(Rejection::Replayed);
        }
        if !self.offers.may_answer(client_nonce, from, now) {
            return Err(Rejection::Rate);
        }
        if let Err((because, rejection)) = self.has_room(role) {
            let refused = Refused { client_nonce, because: because.number(), padding: [0; 7] };
            reply.seal(bare_head(Kind::Refused, now), &self.sealer, |writer| refused.write(writer));
            return Err(rejection);
        }
        let host_nonce = self.offers.offer(client_nonce, role, &mut self.random)?;
        let welcome = self.welcome([client_nonce, host_nonce]);
        reply.seal(bare_head(Kind::Welcome, now), &self.sealer, |writer| welcome.write(writer));
        Ok(Outcome::Offered)
    }

    /// Whether a session may begin, or how its client is told that it may not.
    fn has_room(&self, role: Role) -> Result<(), (RefusedBecause, Rejection)> {
        match role {
            Role::Commands if self.active.is_some() => {
                Err((RefusedBecause::SecondClient, Rejection::SecondClient))
            }
            Role::Watches if self.watchers.len() >= WATCHERS => {
                Err((RefusedBecause::TooManyWatchers, Rejection::TooManyWatchers))
            }
            _ => Ok(()),
        }
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

    /// Takes a packet of a session; the first valid one of an offered session begins it.
    fn take(
        &mut self,
        received: &Received<'_>,
        from: SocketAddr,
        now: u64,
        take: impl FnOnce(&Command, u64) -> bool,
    ) -> Result<Outcome, Rejection> {
        let session = received.head.session;
        if !self.active.iter().chain(&self.watchers).any(|attached| attached.session() == session) {
            self.begin(received, from, now)?;
        }
        let Self { active, watchers, domain, commands, generation, .. } = self;
        let mut attached = active.iter_mut().chain(watchers);
        let attached = attached.find(|attached| attached.session() == session);
        let attached = attached.ok_or(Rejection::Session)?;
        if !attached.has_sealed(received) {
            return Err(Rejection::Tag);
        }
        let take = |command: &Command| take(command, *generation);
        let outcome = attached.receive(received, (from, now), domain, commands, take)?;
        if outcome == Outcome::Ended {
            self.active.take_if(|active| active.session() == session);
            self.watchers.retain(|watcher| watcher.session() != session);
        }
        Ok(outcome)
    }

    fn begin(&mut self, received: &Received<'_>, from: SocketAddr, now: u64) -> Result<(), Rejection> {
        let session = received.head.session;
        let Offer { nonces: [client_nonce, host_nonce], role } =
            self.offers.of(session).ok_or(Rejection::Session)?;
        let keys = SessionKeys::new(&self.sealer, &client_nonce, &host_nonce);
        if !received.is_sealed_by(&keys.client) {
            return Err(Rejection::Tag);
        }
        let other = if role == Role::Commands { Kind::Watch } else { Kind::Command };
        if received.kind == other {
            return Err(Rejection::Role);
        }
        self.has_room(role).map_err(|(_, rejection)| rejection)?;
        self.offers.begin(session);
        let attached = Attached::new(session, (role, keys), (from, now));
        if role == Role::Watches {
            self.watchers.push(attached);
        } else {
            self.generation += 1;
            self.active = Some(attached);
        }
        Ok(())
    }

    /// Seals one part of a state for the client that commands: `part` is where it begins, [0, 0] at first,
    /// and becomes where the next one begins, none after the last. None without a client.
    pub fn state(
        &mut self,
        snapshot: &Snapshot,
        part: &mut Option<[usize; 2]>,
        now: u64,
        datagram: &mut Datagram,
    ) -> Option<SocketAddr> {
        let rejected = self.counters.read().all_rejected();
        self.active.as_mut()?.state(snapshot, part, (rejected, now), datagram)
    }

    /// The same for one of the clients that watch, by its index below [`watchers`](Self::watchers).
    pub fn state_for_watcher(
        &mut self,
        watcher: usize,
        snapshot: &Snapshot,
        part: &mut Option<[usize; 2]>,
        now: u64,
        datagram: &mut Datagram,
    ) -> Option<SocketAddr> {
        let rejected = self.counters.read().all_rejected();
        self.watchers.get_mut(watcher)?.state(snapshot, part, (rejected, now), datagram)
    }
}
