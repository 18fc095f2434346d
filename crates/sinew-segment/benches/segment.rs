//! Cost of a cycle: drives in one LRW frame, and the firmware's fraction.

#![allow(clippy::unwrap_used, reason = "a benchmark may panic")]

#[path = "../tests/segment/wire.rs"]
mod wire;

use divan::{Bencher, black_box};
use sinew_segment::builtin;
use wire::{Datagram, LRW, Wire};

fn main() {
    divan::main();
}

/// Drives in OP, outputs and inputs side by side in the logical memory.
fn line(drives: usize) -> (Wire, Vec<u8>) {
    let mut wire = Wire::new(&vec![builtin::drive(); drives]);
    for position in 0..drives as u16 {
        let base = 22 * u32::from(position);
        wire.drive_to_safe_op(position, base, base + 6);
        wire.write(position, 0x0420, &[0, 0]);
        wire.write(position, 0x1200, &[6, 0, 0, 0, 10, 0]);
        assert_eq!(wire.request(position, 8), (8, 0));
    }
    let frame = wire::frame(&[Datagram::logical(LRW, 0, &vec![0; 22 * drives])]);
    (wire, frame)
}

/// The frame alone: memory management, sync managers, outputs to objects, one step of every drive.
#[divan::bench(args = [1, 15, 60])]
fn process(bencher: Bencher, drives: usize) {
    let (mut wire, sent) = line(drives);
    let mut frame = sent.clone();
    bencher.bench_local(|| {
        frame.copy_from_slice(&sent);
        wire.segment.process(black_box(&mut frame))
    });
}

/// Frame and a millisecond of virtual time.
#[divan::bench(args = [1, 15, 60])]
fn cycle(bencher: Bencher, drives: usize) {
    let (mut wire, sent) = line(drives);
    let mut frame = sent.clone();
    bencher.bench_local(|| {
        frame.copy_from_slice(&sent);
        wire.segment.advance(1_000_000);
        wire.segment.process(black_box(&mut frame))
    });
}
