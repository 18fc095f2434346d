//! A cycle of a line in OP allocates nothing.

use crate::wire::{self, Datagram, LRW, Wire};
use allocation_counter::measure;
use sinew_segment::{AlState, builtin};

#[test]
fn a_cycle_in_op_allocates_nothing() {
    let mut wire = Wire::new(&vec![builtin::drive(); 15]);
    for position in 0..15 {
        let base = 32 * u32::from(position);
        wire.drive_to_safe_op(position, base, base + 8);
        wire.write(position, 0x1200, &[6, 0, 0, 0, 10, 0]);
        assert_eq!(wire.request(position, 8), (8, 0));
    }
    let sent = wire::frame(&[Datagram::logical(LRW, 0, &[0; 15 * 32])]);
    let mut frame = sent.clone();
    let counted = measure(|| {
        for cycle in 0..1000 {
            frame.copy_from_slice(&sent);
            for position in 0..15 {
                if let Some(drive) = wire.segment.device_mut(position).and_then(|device| device.drive_mut()) {
                    drive.set_actual(cycle, 1, 1);
                }
            }
            wire.segment.advance(1_000_000);
            wire.segment.process(&mut frame);
        }
    });
    assert_eq!(counted.count_total, 0);
    // The cycles were real: process data came and went.
    let answer = wire::datagrams(&frame).remove(0);
    assert_eq!(answer.counter, 45);
    assert_eq!(answer.data[10..14], 999_i32.to_le_bytes());
    assert!(wire.segment.devices().iter().all(|device| device.state() == AlState::Op));
}
