//! Packets of every kind and damage at the host of a link, each rejected for the reason for which it was made; the bytes
//! themselves as a datagram at both ends, which nothing but a tag makes a command or state.
#![no_main]

#[path = "../../crates/sinew-link/tests/adversary/mod.rs"]
#[allow(dead_code, unreachable_pub, reason = "the tests of the crate use more of it")]
mod adversary;

use libfuzzer_sys::fuzz_target;
use sinew_link::wire::open;

fuzz_target!(|octets: &[u8]| {
    let played = adversary::play(&mut adversary::Bytes(octets));
    assert_eq!(played.counters.accepted, played.expected_accepted);
    for (reason, count) in played.expected {
        assert_eq!(played.counters.rejected(reason), count, "{reason:?}");
    }
    if let Ok(received) = open(octets) {
        assert_eq!(usize::from(received.head.length), octets.len());
    }
});
