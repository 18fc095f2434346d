//! Reasons for which packets are rejected, and their counters.

use std::sync::atomic::{AtomicU64, Ordering};

macro_rules! rejections {
    ($($name:ident, $text:literal, $about:literal;)*) => {
        /// Why a packet was rejected. A packet is checked in this order and counted once.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum Rejection { $(#[doc = $about] $name,)* }

        impl Rejection {
            /// All reasons, in the order of the checks.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// A key for programs: lower case, words joined by `_`.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $text,)* }
            }

            /// What is wrong, in a sentence.
            #[must_use]
            pub fn about(self) -> &'static str {
                match self { $(Self::$name => $about,)* }
            }
        }
    };
}

rejections! {
    TooShort, "too_short", "Shorter than a head and a tag.";
    TooLong, "too_long", "Longer than the largest datagram.";
    Magic, "wrong_magic", "Does not begin with the four characters of this protocol.";
    Version, "wrong_version", "Another version of the protocol.";
    Length, "wrong_length", "The length in the head is not that of the datagram, or not one of its kind.";
    Kind, "wrong_kind", "No kind of packet that this side receives.";
    Session, "unknown_session", "Of a session that has ended or never began.";
    Tag, "wrong_tag", "The tag (HMAC) is not that of the content: damage, or another key.";
    Old, "old", "Behind the replay window.";
    Replayed, "replayed", "Received before; of a Hello: its session has begun.";
    Time, "time_backwards", "A newer packet with an older time stamp, or an older one with a newer stamp.";
    Role, "wrong_role", "A command in a session that watches, or a Watch in one that commands.";
    SecondClient, "second_client", "Another client has the session.";
    TooManyWatchers, "too_many_watchers", "As many clients watch as may.";
    Rate, "rate", "More packets than a client may send, or a Hello more often than it is answered.";
    Code, "unknown_code", "A code without meaning.";
    Count, "wrong_count", "Not as many values or points as the machine has or a packet holds.";
    NonFinite, "non_finite", "A number that is not finite.";
    OutOfRange, "out_of_range", "A number outside of the machine's limits, or time stamps that do not ascend.";
    QueueFull, "queue_full", "The control cycle has not yet taken the commands before.";
}

impl Rejection {
    /// Number on the wire; 0 is none.
    #[must_use]
    pub fn number(self) -> u8 {
        self as u8 + 1
    }

    /// The reason of a number on the wire.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number).checked_sub(1)?).copied()
    }
}

/// Number of reasons.
const REASONS: usize = Rejection::ALL.len();

/// Counts of packets, read by any thread while another counts.
#[derive(Debug, Default)]
pub(crate) struct SharedCounters {
    accepted: AtomicU64,
    rejected: [AtomicU64; REASONS],
}

impl SharedCounters {
    pub(crate) fn accept(&self) {
        self.accepted.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn reject(&self, reason: Rejection) {
        self.rejected[reason as usize].fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn read(&self) -> Counters {
        Counters {
            accepted: self.accepted.load(Ordering::Relaxed),
            rejected: std::array::from_fn(|k| self.rejected[k].load(Ordering::Relaxed)),
        }
    }
}

/// Counts of packets by what happened to them.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Packets that passed all checks.
    pub accepted: u64,
    rejected: [u64; REASONS],
}

impl Counters {
    /// Packets rejected for a reason.
    #[must_use]
    pub fn rejected(&self, reason: Rejection) -> u64 {
        self.rejected[reason as usize]
    }

    /// Packets rejected for any reason.
    #[must_use]
    pub fn all_rejected(&self) -> u64 {
        self.rejected.iter().sum()
    }

    /// Reasons with their counts, in the order of the checks.
    pub fn by_reason(&self) -> impl Iterator<Item = (Rejection, u64)> + '_ {
        Rejection::ALL.iter().map(|reason| (*reason, self.rejected(*reason)))
    }
}
