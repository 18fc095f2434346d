//! A client's session, without socket and clock.

use crate::peer::{Peer, bare_head};
use crate::setpoints;
use crate::wire::{Datagram, Hello, Kind, Nonce, Refused, Sealer, SessionKeys, Welcome, open, session_of};
use crate::{Command, Key, RefusedBecause, Rejection, Request, Role, Setpoints, Snapshot, StateCounts};

/// A client before its session: it has asked for one.
#[derive(Debug, Clone)]
pub struct Greeting {
    sealer: Sealer,
    nonce: Nonce,
    role: Role,
}

impl Greeting {
    /// With a random number that is new for every session.
    #[must_use]
    pub fn new(key: &Key, nonce: Nonce) -> Self {
        Self { sealer: Sealer::new(key), nonce, role: Role::Commands }
    }

    /// The same for a session that watches: [`ClientSession::watch`] begins it and keeps it.
    #[must_use]
    pub fn watching(self) -> Self {
        Self { role: Role::Watches, ..self }
    }

    /// Writes the Hello, to be sent until an answer comes.
    pub fn hello<'a>(&self, now: u64, datagram: &'a mut Datagram) -> &'a [u8] {
        let hello = Hello { client_nonce: self.nonce, role: self.role.number(), padding: [0; 87] };
        datagram.seal(bare_head(Kind::Hello, now), &self.sealer, |writer| hello.write(writer))
    }

    /// Reads the answer: a session, or why there is none.
    ///
    /// # Errors
    /// Why the datagram is no answer to this Hello.
    pub fn answer(&self, datagram: &[u8]) -> Result<Result<ClientSession, RefusedBecause>, Rejection> {
        let received = open(datagram)?;
        if !matches!(received.kind, Kind::Welcome | Kind::Refused) {
            return Err(Rejection::Kind);
        }
        if !received.is_sealed_by(&self.sealer) {
            return Err(Rejection::Tag);
        }
        let mut body = received.body();
        if received.kind == Kind::Refused {
            let refused = Refused::read(&mut body).filter(|_| body.is_empty()).ok_or(Rejection::Length)?;
            if refused.client_nonce != self.nonce {
                return Err(Rejection::Session);
            }
            return RefusedBecause::from_number(refused.because).map(Err).ok_or(Rejection::Code);
        }
        let welcome = Welcome::read(&mut body).filter(|_| body.is_empty()).ok_or(Rejection::Length)?;
        if welcome.client_nonce != self.nonce {
            return Err(Rejection::Session);
        }
        Ok(Ok(ClientSession {
            keys: SessionKeys::new(&self.sealer, &self.nonce, &welcome.host_nonce),
            session: session_of(&welcome.host_nonce),
            welcome,
            peer: Peer::default(),
            state: Box::new(Snapshot::new(welcome.joints.into(), welcome.muscles.into())),
            counts: StateCounts::default(),
            stop: None,
        }))
    }
}

/// A client's session.
#[derive(Debug, Clone)]
pub struct ClientSession {
    keys: SessionKeys,
    session: u64,
    welcome: Welcome,
    peer: Peer,
    state: Box<Snapshot>,
    counts: StateCounts,
    /// The stop that was asked for last, without set-points, and the number of the packet that asked first;
    /// none once the machine has taken it, and where something else was asked for since.
    stop: Option<(Command, u64)>,
}

/// A state that arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Arrived {
    /// Its last part.
    Complete,
    /// One of several parts.
    Part,
    /// Overtaken by a newer one: not taken over.
    Late,
}

impl ClientSession {
    /// What the host said of the machine.
    #[must_use]
    pub fn welcome(&self) -> &Welcome {
        &self.welcome
    }

    /// Name of the machine.
    #[must_use]
    pub fn machine(&self) -> String {
        let name = &self.welcome.machine;
        let end = name.iter().position(|byte| *byte == 0).unwrap_or(name.len());
        String::from_utf8_lossy(&name[..end]).into_owned()
    }

    /// Sequence numbers, losses of states and round trips.
    #[must_use]
    pub fn peer(&self) -> &Peer {
        &self.peer
    }

    /// The newest state; zeros before the first.
    #[must_use]
    pub fn state(&self) -> &Snapshot {
        &self.state
    }

    /// What the host has received, by the newest state.
    #[must_use]
    pub fn counts(&self) -> &StateCounts {
        &self.counts
    }

    /// A stop that was asked for and that no state has yet shown as taken; to be sent again until one does.
    #[must_use]
    pub fn unacknowledged_stop(&self) -> Option<&Command> {
        self.stop.as_ref().map(|(stop, _)| stop)
    }

    /// Writes a command.
    pub fn command<'a>(&mut self, command: &Command, now: u64, datagram: &'a mut Datagram) -> &'a [u8] {
        let head = self.peer.next_head(Kind::Command, self.session, now);
        self.stop = match self.stop {
            _ if command.request.is_stop() => {
                let stop = Command { setpoints: Setpoints::none(), ..*command };
                Some(self.stop.filter(|(last, _)| *last == stop).unwrap_or((stop, head.sequence)))
            }
            waiting if command.request == Request::None => waiting,
            _ => None,
        };
        datagram.seal(head, &self.keys.client, |writer| setpoints::write(command, writer))
    }

    /// Writes a sign of life of a session that watches.
    pub fn watch<'a>(&mut self, now: u64, datagram: &'a mut Datagram) -> &'a [u8] {
        let head = self.peer.next_head(Kind::Watch, self.session, now);
        datagram.seal(head, &self.keys.client, |_| Some(()))
    }

    /// Writes the end of the session.
    pub fn goodbye<'a>(&mut self, now: u64, datagram: &'a mut Datagram) -> &'a [u8] {
        let head = self.peer.next_head(Kind::Goodbye, self.session, now);
        datagram.seal(head, &self.keys.client, |_| Some(()))
    }

    /// Takes a datagram of the host.
    ///
    /// # Errors
    /// Why it is rejected.
    pub fn receive(&mut self, datagram: &[u8], now: u64) -> Result<Arrived, Rejection> {
        let received = open(datagram)?;
        if received.kind != Kind::State {
            return Err(Rejection::Kind);
        }
        if received.head.session != self.session {
            return Err(Rejection::Session);
        }
        if !received.is_sealed_by(&self.keys.host) {
            return Err(Rejection::Tag);
        }
        self.peer.judge(&received.head)?;
        let mut newer = self.state.clone();
        let result = newer.read(&mut received.body());
        self.peer.record(&received.head, now);
        let (counts, last) = result?;
        if newer.cycle < self.state.cycle {
            return Ok(Arrived::Late);
        }
        (self.state, self.counts) = (newer, counts);
        // A state that has seen the request; the packet that carried it first may have been lost.
        self.stop = self.stop.filter(|(stop, sequence)| {
            self.state.request != stop.request || self.peer.reflected() < *sequence
        });
        Ok(if last { Arrived::Complete } else { Arrived::Part })
    }
}
