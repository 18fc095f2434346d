use super::newest::Newest;
use super::rate::RateLimit;
use crate::wire::{Nonce, session_of};
use crate::{Rejection, Role};
use std::net::SocketAddr;

/// Hello packets that are told apart, and sessions that are offered at once: more replace the oldest.
const KNOWN: usize = 1024;
/// Most answers to one Hello per second: to the address that sent it first, and to all others together.
const ANSWERS_PER_SECOND: u32 = 50;

/// Fills a nonce with random bytes; false where there are none.
pub type RandomSource = Box<dyn FnMut(&mut Nonce) -> bool + Send>;

/// What clients have asked for: sessions that are offered and have not begun, and how often each Hello was
/// answered.
///
/// A Hello can be recorded and sent again by anyone. It then takes the place and the answers of that Hello
/// alone: a new one, whose random number nobody has seen, is answered however many are repeated.
#[derive(Debug)]
pub(super) struct Offers {
    offers: Newest<u64, Offer>,
    sessions: Newest<(Nonce, Role), u64>,
    asked: Newest<Nonce, Asked>,
    /// Random numbers of the clients whose sessions have begun: their Hellos are of no use again.
    begun: Newest<Nonce, ()>,
}

/// A session that a client may begin.
#[derive(Debug, Clone, Copy)]
pub(super) struct Offer {
    /// Of client and host.
    pub(super) nonces: [Nonce; 2],
    pub(super) role: Role,
}

/// A Hello.
#[derive(Debug)]
struct Asked {
    first: SocketAddr,
    /// To the first address, and to others.
    answers: [RateLimit; 2],
}

impl Default for Offers {
    fn default() -> Self {
        Self {
            offers: Newest::at_most(KNOWN),
            sessions: Newest::at_most(KNOWN),
            asked: Newest::at_most(KNOWN),
            begun: Newest::at_most(KNOWN),
        }
    }
}

impl Offers {
    /// Whether a Hello may be answered now.
    pub(super) fn may_answer(&mut self, client_nonce: Nonce, from: SocketAddr, now: u64) -> bool {
        if self.asked.get(&client_nonce).is_none() {
            let answers = [RateLimit::new(ANSWERS_PER_SECOND, ANSWERS_PER_SECOND); 2];
            self.asked.put(client_nonce, Asked { first: from, answers });
        }
        let asked = self.asked.get_mut(&client_nonce);
        asked.is_some_and(|asked| asked.answers[usize::from(asked.first != from)].allow(now))
    }

    /// Whether a session has begun with this random number of its client.
    pub(super) fn has_begun(&self, client_nonce: &Nonce) -> bool {
        self.begun.get(client_nonce).is_some()
    }

    /// Random number of the host in the session that is offered to a client's Hello: the same for the same
    /// Hello.
    pub(super) fn offer(
        &mut self,
        client_nonce: Nonce,
        role: Role,
        random: &mut RandomSource,
    ) -> Result<Nonce, Rejection> {
        let known = self.sessions.get(&(client_nonce, role)).and_then(|session| self.offers.get(session));
        if let Some(offer) = known {
            return Ok(offer.nonces[1]);
        }
        let mut host_nonce = [0; 16];
        let session = |nonce: &Nonce| Some(session_of(nonce)).filter(|session| *session != 0);
        let Some(session) = random(&mut host_nonce).then(|| session(&host_nonce)).flatten() else {
            return Err(Rejection::Session);
        };
        self.offers.put(session, Offer { nonces: [client_nonce, host_nonce], role });
        self.sessions.put((client_nonce, role), session);
        Ok(host_nonce)
    }

    /// The offer of a session.
    pub(super) fn of(&self, session: u64) -> Option<Offer> {
        self.offers.get(&session).copied()
    }

    /// A session begins: it is no longer offered.
    pub(super) fn begin(&mut self, session: u64) {
        if let Some(offer) = self.offers.take(&session) {
            self.begun.put(offer.nonces[0], ());
        }
    }
}
