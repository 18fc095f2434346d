//! A recording of format 1, cut short, as version 0.1 has written it.

use sinew_record::{Recording, Signal};

static OLD: &[u8] = include_bytes!("format_1.mcap");

#[test]
fn a_recording_of_format_1_stays_readable() {
    let recording = Recording::read(OLD).unwrap();
    assert!(recording.head.format == 1 && !recording.complete);
    let sum = |signal: Signal, part: usize| -> f64 {
        let first = recording.head.place(signal).unwrap();
        let blocks = recording.blocks().map(Result::unwrap);
        let columns = blocks.map(|block| if signal.row().slow { block.slow } else { block.fast });
        columns.flat_map(|columns| columns[first + part].clone()).fold(0.0, |sum, x| sum + x)
    };
    // Sums of the table that version 0.1 exported.
    for (signal, part, expected) in [
        (Signal::PositionIn, 0, 1131.6511299092383),
        (Signal::PositionIn, 1, 1131.6511299092383),
        (Signal::TensionIn, 0, 111518.1999999999),
        (Signal::TensionIn, 1, 60290.699999999975),
        (Signal::Joint, 0, 849.0583660946642),
        (Signal::Command, 0, 0.0),
        (Signal::Command, 1, 0.0),
        (Signal::JointTrue, 0, 42.54072200000005),
        (Signal::TensionOut, 0, 3711.149999999998),
        (Signal::TensionOut, 1, 2536.8999999999983),
    ] {
        let found = sum(signal, part);
        assert!((found - expected).abs() <= 1e-12 * expected.abs(), "{signal:?}: {found}");
    }
}

#[test]
fn a_damaged_recording_of_format_1_is_refused_or_read_without_a_panic() {
    for place in (0..OLD.len()).step_by(61) {
        let mut bytes = OLD.to_vec();
        bytes[place] ^= 0x24;
        if let Ok(recording) = Recording::read(&bytes) {
            recording.blocks().for_each(drop);
        }
    }
}
