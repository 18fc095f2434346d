//! Packets of the link, version 2.
//!
//! ```text
//! Head | body of the kind | tag = HMAC-SHA256(key, head and body)
//! ```
//!
//! Little endian, no padding but what the tables name. Hello, Welcome and Refused carry a tag by the
//! pre-shared key, all others one by the key of their session and direction:
//!
//! ```text
//! HMAC-SHA256(key, "sinew-link 1 client" | client_nonce | host_nonce)      Command, Watch, Goodbye
//! HMAC-SHA256(key, "sinew-link 1 host"   | client_nonce | host_nonce)      State
//! ```
//!
//! # Source
//! HMAC: RFC 2104; keys bound to both sides' random numbers: NIST SP 800-108; the reflected sequence number:
//! `schreiber2010`.

mod datagram;
mod document;
mod packets;
mod seal;
mod table;

pub use datagram::{Datagram, Received, open};
pub use document::{Section, sections, tables};
pub use packets::{
    CommandHead, Head, Hello, JointState, Kind, MuscleState, PointHead, Refused, StateHead, Welcome,
    features, flags,
};
pub(crate) use seal::session_of;
pub use seal::{Nonce, Sealer, SessionKeys};
pub use table::{Code, Field};
pub(crate) use table::{Reader, Writer};

/// First bytes of every datagram.
pub const MAGIC: [u8; 4] = *b"SNWL";
/// Version of the protocol.
pub const VERSION: u8 = 2;
/// Bytes of a tag.
pub const TAG_SIZE: usize = 32;
/// Longest datagram, bytes: what IPv6 guarantees to deliver unfragmented (1280 less the heads of IPv6 and
/// UDP).
pub const MAX_DATAGRAM: usize = 1232;
/// Shortest datagram, bytes.
pub const MIN_DATAGRAM: usize = Head::SIZE + TAG_SIZE;
/// Most joints of a machine: a set-point of all joints fits in one datagram twice.
pub const MAX_JOINTS: usize = 64;
/// Most muscles of a machine: a set-point of all muscles fits in one datagram.
pub const MAX_MUSCLES: usize = 128;
/// Most numbers of one set-point.
pub const MAX_VALUES: usize = MAX_MUSCLES;
/// Bytes for the points of a command.
pub const POINT_BYTES: usize = MAX_DATAGRAM - MIN_DATAGRAM - CommandHead::SIZE;
/// Most points of one command, of a machine with one joint.
pub const MAX_POINTS: usize = POINT_BYTES / (PointHead::SIZE + 8);

const _: () = assert!(POINT_BYTES >= PointHead::SIZE + 8 * MAX_VALUES, "a point of all muscles fits");
const _: () = assert!(Hello::SIZE == Welcome::SIZE, "no answer is longer than its question");
const _: () = assert!(MAX_JOINTS <= MAX_VALUES, "joints are values, too");

/// Most points of one command with this many numbers each.
#[must_use]
pub const fn points_per_command(values: usize) -> usize {
    POINT_BYTES / (PointHead::SIZE + 8 * values)
}
