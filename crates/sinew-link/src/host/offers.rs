use crate::wire::{Nonce, Sealer, SessionKeys, session_of};
use crate::{Rejection, Role};

/// Sessions offered at once: more Hello packets replace the oldest offer.
const OFFERS: usize = 8;

/// Fills a nonce with random bytes; false where there are none.
pub type RandomSource = Box<dyn FnMut(&mut Nonce) -> bool + Send>;

/// Sessions that clients have asked for and that have not begun.
#[derive(Debug, Default)]
pub(super) struct Offers {
    offers: [Option<Offer>; OFFERS],
    next: usize,
}

#[derive(Debug, Clone)]
pub(super) struct Offer {
    pub(super) session: u64,
    /// Of client and host.
    pub(super) nonces: [Nonce; 2],
    pub(super) keys: SessionKeys,
    pub(super) role: Role,
}

impl Offers {
    /// Random number of the host in the session that is offered to a client's Hello: the same for the same Hello.
    pub(super) fn offer(
        &mut self,
        client_nonce: Nonce,
        role: Role,
        sealer: &Sealer,
        random: &mut RandomSource,
    ) -> Result<Nonce, Rejection> {
        let same = |offer: &&Offer| offer.nonces[0] == client_nonce && offer.role == role;
        if let Some(offer) = self.offers.iter().flatten().find(same) {
            return Ok(offer.nonces[1]);
        }
        let mut host_nonce = [0; 16];
        if !random(&mut host_nonce) || session_of(&host_nonce) == 0 {
            return Err(Rejection::Session);
        }
        let keys = SessionKeys::new(sealer, &client_nonce, &host_nonce);
        let nonces = [client_nonce, host_nonce];
        let free = self.offers.iter().position(Option::is_none);
        let place = free.unwrap_or(self.next % OFFERS);
        self.next = (place + 1) % OFFERS;
        self.offers[place] = Some(Offer { session: session_of(&host_nonce), nonces, keys, role });
        Ok(host_nonce)
    }

    /// The offer of a session.
    pub(super) fn of(&mut self, session: u64) -> Option<&mut Option<Offer>> {
        self.offers.iter_mut().find(|offer| offer.as_ref().is_some_and(|offer| offer.session == session))
    }
}
