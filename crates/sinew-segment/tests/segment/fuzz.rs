//! Whatever comes over the wire, nothing panics, nothing hangs, and every answer keeps the standard's
//! lengths.

use crate::fuzzing;

use fuzzing::Played;
use proptest::prelude::*;
use std::time::{Duration, Instant};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn no_sequence_of_frames_breaks_a_line(octets in proptest::collection::vec(any::<u8>(), 0..4000)) {
        fuzzing::play(&octets);
    }
}

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }
}

#[test]
fn long_a_million_frames_break_no_line() {
    if std::env::var_os("SINEW_LONG").is_none() {
        return;
    }
    let (mut random, mut all, mut slowest) = (Random(1), Played::default(), Duration::ZERO);
    while all.frames < 1_000_000 {
        let octets: Vec<u8> = (0..2500).flat_map(|_| random.next().to_le_bytes()).collect();
        let start = Instant::now();
        let played = fuzzing::play(&octets);
        slowest = slowest.max(start.elapsed());
        all.frames += played.frames;
        all.in_op += played.in_op;
        all.messages += played.messages;
    }
    println!("{all:?}, slowest sequence {slowest:?}");
    assert!(all.in_op > 10_000 && all.messages > 1_000, "the random frames stay outside: {all:?}");
    assert!(slowest < Duration::from_secs(10), "a sequence took {slowest:?}");
}
