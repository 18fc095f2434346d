//! Files that are cut off, damaged or of others: one error, or what is whole.

use crate::common::Setup;
use proptest::prelude::*;
use sinew_record::{Error, Recording};
use std::sync::LazyLock;

static WHOLE: LazyLock<Vec<u8>> = LazyLock::new(|| Setup::new("bench_joint", 1).recorded().0);

/// Cycles that a file gives, all of them decoded.
fn cycles(bytes: &[u8]) -> Result<usize, Error> {
    let recording = Recording::read(bytes)?;
    let mut count = 0;
    for block in recording.blocks() {
        count += block?.count;
    }
    Ok(count)
}

#[test]
fn a_file_that_was_cut_off_anywhere_gives_its_whole_chunks() {
    let whole = cycles(&WHOLE).unwrap();
    let mut last = 0;
    let mut seen = std::collections::BTreeSet::new();
    for length in (0..WHOLE.len()).step_by(97) {
        match cycles(&WHOLE[..length]) {
            Ok(count) => {
                assert!(count >= last && count.is_multiple_of(500), "{length}: {count}");
                last = count;
                seen.insert(count);
            }
            // Before the head is whole.
            Err(error) => assert_eq!(last, 0, "{length}: {error}"),
        }
    }
    assert_eq!(seen.into_iter().collect::<Vec<_>>(), [0, 500, 1000, 1500, 2000, whole]);
}

#[test]
fn files_of_others_are_refused_with_the_reason() {
    for (bytes, expected) in [
        (&b""[..], "an MCAP file"),
        (b"time_s,far_n\n0,1\n", "an MCAP file"),
        (&WHOLE[..8], "head.json"),
        (&[&WHOLE[..8], &[0x05, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff]].concat(), "head.json"),
    ] {
        let error = cycles(bytes).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
        assert_eq!(error.lines().count(), 1);
    }
    let mut foreign = mcap::Writer::new(std::io::Cursor::new(Vec::new())).unwrap();
    foreign.finish().unwrap();
    let error = cycles(&foreign.into_inner().into_inner()).unwrap_err();
    assert!(error.to_string().contains("expected a recording of `sinew run`"), "{error}");
}

#[test]
fn a_changed_bit_in_a_chunk_is_named_with_its_place() {
    let places: Vec<usize> = (WHOLE.len() / 4..WHOLE.len() / 2).step_by(211).collect();
    let mut refused = 0;
    for place in &places {
        let mut bytes = WHOLE.clone();
        bytes[*place] ^= 0x10;
        if let Err(error) = cycles(&bytes) {
            assert!(error.to_string().starts_with("byte "), "{error}");
            refused += 1;
        }
    }
    assert!(2 * refused > places.len(), "{refused} of {}", places.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn damage_at_random_places_gives_an_error_or_cycles_but_no_panic(
        damage in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut bytes = WHOLE.clone();
        for (place, value) in damage {
            let place = place.index(bytes.len());
            bytes[place] = value;
        }
        if let Some(cut) = cut {
            bytes.truncate(cut.index(bytes.len()));
        }
        match cycles(&bytes) {
            Ok(count) => prop_assert!(count <= 2500),
            Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1),
        }
    }
}
