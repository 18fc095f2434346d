//! Tags and the keys of sessions.

use super::TAG_SIZE;
use crate::Key;
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use zeroize::Zeroizing;

/// A random number of one side.
pub type Nonce = [u8; 16];

/// Makes and checks tags with one key; the key is overwritten in memory when dropped.
#[derive(Clone)]
pub struct Sealer(Hmac<Sha256>);

impl std::fmt::Debug for Sealer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Sealer(redacted)")
    }
}

/// What the keys of both directions are derived from, before the random numbers.
pub(super) const CLIENT_LABEL: &[u8] = b"sinew-link 1 client";
pub(super) const HOST_LABEL: &[u8] = b"sinew-link 1 host";
/// Block of SHA-256, bytes.
const BLOCK: usize = 64;

impl Sealer {
    /// Tags by a pre-shared key.
    #[must_use]
    pub fn new(key: &Key) -> Self {
        Self::keyed(key.bytes())
    }

    /// Shorter keys are filled up with zeros, as HMAC prescribes.
    fn keyed(key: &[u8]) -> Self {
        let mut block = Zeroizing::new([0; BLOCK]);
        block.iter_mut().zip(key).for_each(|(block, key)| *block = *key);
        Self(Hmac::new((&*block).into()))
    }

    /// The tag of some bytes.
    #[must_use]
    pub fn tag(&self, bytes: &[u8]) -> [u8; TAG_SIZE] {
        let mut mac = self.0.clone();
        mac.update(bytes);
        mac.finalize().into_bytes().into()
    }

    /// Whether this is the tag of these bytes, in a time that does not depend on where they differ.
    #[must_use]
    pub fn is_tag(&self, bytes: &[u8], tag: &[u8]) -> bool {
        let mut mac = self.0.clone();
        mac.update(bytes);
        mac.verify_slice(tag).is_ok()
    }
}

/// Keys of one session, one per direction.
#[derive(Debug, Clone)]
pub struct SessionKeys {
    /// Client to host.
    pub client: Sealer,
    /// Host to client.
    pub host: Sealer,
}

impl SessionKeys {
    /// From the pre-shared key and the random numbers of both sides.
    #[must_use]
    pub fn new(base: &Sealer, client_nonce: &Nonce, host_nonce: &Nonce) -> Self {
        let derive = |label: &[u8]| {
            let mut mac = base.0.clone();
            mac.update(label);
            mac.update(client_nonce);
            mac.update(host_nonce);
            let key: Zeroizing<[u8; TAG_SIZE]> = Zeroizing::new(mac.finalize().into_bytes().into());
            Sealer::keyed(&*key)
        };
        Self { client: derive(CLIENT_LABEL), host: derive(HOST_LABEL) }
    }
}

/// The number by which packets name their session.
pub(crate) fn session_of(host_nonce: &Nonce) -> u64 {
    let mut first = [0; 8];
    first.copy_from_slice(&host_nonce[..8]);
    u64::from_le_bytes(first)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_are_those_of_rfc_4231() {
        let sealer = Sealer::keyed(&[0x0b; 20]);
        let tag = sealer.tag(b"Hi There");
        let hex: String = tag.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(hex, "b0344c61d8db38535ca8afceaf0bf12b881dc200c9833da726e9376c2e32cff7");
        assert!(sealer.is_tag(b"Hi There", &tag) && !sealer.is_tag(b"Hi there", &tag));
        assert!(!sealer.is_tag(b"Hi There", &tag[..31]));
    }

    #[test]
    fn the_two_directions_have_different_keys() {
        let keys = SessionKeys::new(&Sealer::new(&Key::none()), &[1; 16], &[2; 16]);
        assert_ne!(keys.client.tag(b"x"), keys.host.tag(b"x"));
    }
}
