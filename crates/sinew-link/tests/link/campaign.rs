//! Everything that may arrive, by the hundred thousand; ten million with `SINEW_LONG`.

use crate::adversary::{Bytes, Random, play};
use proptest::prelude::*;
use sinew_link::Rejection;

#[test]
fn every_packet_is_counted_for_the_reason_for_which_it_was_made() {
    let packets = if std::env::var_os("SINEW_LONG").is_some() { 10_000_000 } else { 100_000 };
    let played = play(&mut Random { state: 16, left: packets });
    assert_eq!(played.counters.accepted, played.expected_accepted);
    for (reason, count) in &played.expected {
        assert_eq!(played.counters.rejected(*reason), *count, "{reason:?}");
        let apart = [Rejection::Rate, Rejection::Old];
        assert!(*count > 0 || apart.contains(reason), "{reason:?} was never tried");
        eprintln!("{:>16} {count}", reason.name());
    }
    eprintln!("{:>16} {} of {} sent", "taken", played.taken, played.sent);
    assert!(played.taken > packets / 4);
}

proptest! {
    #[test]
    fn no_choice_of_packets_breaks_the_host(choices in prop::collection::vec(any::<u8>(), 0..4000)) {
        let played = play(&mut Bytes(&choices));
        prop_assert_eq!(played.counters.accepted, played.expected_accepted);
        for (reason, count) in &played.expected {
            prop_assert_eq!(played.counters.rejected(*reason), *count);
        }
    }
}
