//! Every command with every addressing, answered as ETG.1000.4 says.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::wire;

use sinew_segment::{DeviceSettings, Passed, Segment, builtin};
use wire::{
    APRD, APRW, APWR, ARMW, BRD, BRW, BWR, Datagram, FPRD, FPRW, FPWR, FRMW, LRD, LRW, LWR, NOP, STATION,
    Wire,
};

/// Three devices with user memory at 0x0f80 set to 1, 2 and 4, the alias of the last in use.
fn line() -> Wire {
    let settings =
        |position| DeviceSettings { alias: if position == 2 { 77 } else { 0 }, ..DeviceSettings::default() };
    let mut wire =
        Wire::with_settings(&[builtin::coupler(), builtin::coupler(), builtin::coupler()], settings);
    for (position, value) in [(0, 1), (1, 2), (2, 4)] {
        wire.write(position, 0x0f80, &[value]);
    }
    wire.write(2, 0x0103, &[1]);
    wire
}

fn memory(wire: &mut Wire) -> [u8; 3] {
    [0, 1, 2].map(|position| wire.read(position, 0x0f80, 1)[0])
}

/// Command, address as sent, data as sent; then the data, the counter, the address and the memory after it.
type Row = (u8, u16, u8, u8, u16, u16, [u8; 3]);

#[test]
fn every_command_reads_writes_and_counts_as_the_standard_says() {
    let before = [1, 2, 4];
    let minus = |positions: u16| 0_u16.wrapping_sub(positions);
    let table: &[Row] = &[
        (NOP, 0, 9, 9, 0, 0, before),
        (APRD, 0, 9, 1, 1, 3, before),
        (APRD, minus(1), 9, 2, 1, 2, before),
        (APRD, minus(2), 9, 4, 1, 1, before),
        (APRD, minus(3), 9, 9, 0, 0, before),
        (APRD, 1, 9, 9, 0, 4, before),
        (APWR, minus(1), 9, 9, 1, 2, [1, 9, 4]),
        (APWR, minus(3), 9, 9, 0, 0, before),
        (APRW, minus(1), 9, 2, 3, 2, [1, 9, 4]),
        (APRW, 5, 9, 9, 0, 8, before),
        (FPRD, STATION + 1, 9, 2, 1, STATION + 1, before),
        (FPRD, 77, 9, 4, 1, 77, before),
        (FPRD, 78, 9, 9, 0, 78, before),
        (FPWR, STATION, 9, 9, 1, STATION, [9, 2, 4]),
        (FPWR, 77, 9, 9, 1, 77, [1, 2, 9]),
        (FPRW, STATION + 2, 9, 4, 3, STATION + 2, [1, 2, 9]),
        (FPRW, 1, 9, 9, 0, 1, before),
        (BRD, 0, 0, 7, 3, 3, before),
        (BRD, 10, 8, 15, 3, 13, before),
        (BWR, 0, 9, 9, 3, 3, [9, 9, 9]),
        (BRW, 0, 8, 15, 9, 3, [8, 9, 11]),
        (ARMW, minus(1), 9, 2, 3, 2, [9, 2, 2]),
        (ARMW, minus(3), 9, 9, 3, 0, [9, 9, 9]),
        (FRMW, STATION, 9, 1, 3, STATION, [1, 1, 1]),
        (FRMW, 77, 9, 4, 3, 77, [9, 9, 4]),
        (LRD, 0, 9, 9, 0, 0, before),
        (LWR, 0, 9, 9, 0, 0, before),
        (LRW, 0, 9, 9, 0, 0, before),
        (15, 0, 9, 9, 0, 0, before),
        (255, 0, 9, 9, 0, 0, before),
    ];
    for (command, device, sent, data, counter, address, after) in table {
        let mut wire = line();
        let answer = wire.send(*command, *device, 0x0f80, &[*sent]);
        let name = format!("command {command} to {device:#06x}");
        assert_eq!(answer.data, [*data], "{name}: data");
        assert_eq!(answer.counter, *counter, "{name}: working counter");
        assert_eq!(answer.address as u16, *address, "{name}: address");
        assert_eq!(answer.address >> 16, 0x0f80, "{name}: offset");
        assert_eq!(memory(&mut wire), *after, "{name}: memory");
    }
}

#[test]
fn logical_commands_count_once_for_reading_and_twice_for_writing_in_an_exchange() {
    let data = [9_u8; 8];
    // FMMUs of devices 0 and 1: (kind of device 0, kind of device 1, command) -> counter, data.
    let table: &[(u8, u8, u8, u16, [u8; 2])] = &[
        (1, 1, LRD, 2, [1, 2]),
        (1, 1, LWR, 0, [9, 9]),
        (1, 1, LRW, 2, [1, 2]),
        (2, 2, LRD, 0, [9, 9]),
        (2, 2, LWR, 2, [9, 9]),
        (2, 2, LRW, 4, [9, 9]),
        (1, 2, LRW, 3, [1, 9]),
        (3, 3, LRW, 6, [1, 2]),
        (3, 3, LRD, 2, [1, 2]),
        (0, 0, LRW, 0, [9, 9]),
    ];
    for (first, second, command, counter, expected) in table {
        let mut wire = Wire::new(&[builtin::encoder(1), builtin::encoder(1)]);
        for (position, kind) in [(0, *first), (1, *second)] {
            wire.write(position, 0x1e00, &[position as u8 + 1]);
            wire.fmmu(position, 0, 0x8000_0000 + u32::from(position), 1, 0x1e00, kind);
        }
        let answer = wire.send_all(&[Datagram::logical(*command, 0x8000_0000, &data)]).remove(0);
        assert_eq!(
            (answer.counter, &answer.data[..2]),
            (*counter, &expected[..]),
            "{first} {second} {command}"
        );
        assert_eq!(answer.data[2..], data[2..], "what nobody maps stays");
        let written = |kind: u8| command != &LRD && kind & 2 != 0;
        let expected = [if written(*first) { 9 } else { 1 }, if written(*second) { 9 } else { 2 }];
        assert_eq!([wire.read(0, 0x1e00, 1)[0], wire.read(1, 0x1e00, 1)[0]], expected);
    }
}

#[test]
fn bits_are_mapped_singly_and_their_neighbours_stay() {
    let mut wire = Wire::new(&[builtin::encoder(1)]);
    wire.write(0, 0x1e00, &[0b1010_0101]);
    // Three bits from bit 5 of the logical octet on, at bit 2 of the device's.
    let mut unit = 0x100_u32.to_le_bytes().to_vec();
    unit.extend([1, 0, 5, 7, 0x00, 0x1e, 2, 3, 1, 0, 0, 0]);
    wire.write(0, 0x0600, &unit);
    let answer = wire.send_all(&[Datagram::logical(LRD, 0x100, &[0b0001_1111])]).remove(0);
    assert_eq!((answer.data[0], answer.counter), (0b0011_1111, 1));
    let answer = wire.send_all(&[Datagram::logical(LWR, 0x100, &[0b1100_0000])]).remove(0);
    assert_eq!(answer.counter, 1);
    assert_eq!(wire.read(0, 0x1e00, 1), [0b1011_1001]);
}

#[test]
fn several_datagrams_of_a_frame_see_what_earlier_ones_have_written() {
    let mut wire = line();
    let answers = wire.send_all(&[
        Datagram::new(BWR, 0, 0x0f80, &[5]),
        Datagram::new(FPRD, STATION + 1, 0x0f80, &[0]),
        Datagram::new(APRD, 0, 0x0130, &[0, 0]),
    ]);
    assert_eq!(answers.iter().map(|answer| answer.counter).collect::<Vec<_>>(), [3, 1, 1]);
    assert_eq!(answers[1].data, [5]);
    assert_eq!(answers[2].data, [1, 0], "INIT");
}

#[test]
fn registers_that_are_read_only_or_absent_are_not_counted() {
    let mut wire = line();
    for (offset, readable, writable) in [
        (0x0000, true, false),
        (0x0012, true, false),
        (0x0130, true, false),
        (0x0120, true, true),
        (0x000f, false, false),
        (0x0980, false, false),
        (0x0f00, false, false),
        (0x2000, false, false),
        (0xffff, false, false),
    ] {
        assert_eq!(wire.send(FPRD, STATION, offset, &[0]).counter, u16::from(readable), "read {offset:#06x}");
        assert_eq!(
            wire.send(FPWR, STATION, offset, &[0]).counter,
            u16::from(writable),
            "write {offset:#06x}"
        );
    }
    // Part of the range is enough.
    assert_eq!(wire.send(FPRD, STATION, 0x000e, &[0; 4]).counter, 1);
    assert_eq!(wire.send(FPRD, STATION, 0xfffe, &[0; 8]).counter, 0);
}

#[test]
fn lengths_that_do_not_fit_are_processed_up_to_the_error_and_counted() {
    let mut wire = line();
    let mut frame = wire::frame(&[Datagram::new(BWR, 0, 0x0f80, &[5]), Datagram::new(BWR, 0, 0x0f80, &[6])]);
    // The second datagram claims more than the frame holds.
    frame[16 + 13 + 6] = 200;
    let length = frame.len();
    assert_eq!(wire.segment.process(&mut frame), Passed::Malformed);
    assert_eq!(frame.len(), length);
    assert_eq!(memory(&mut wire), [5, 5, 5]);
    assert_eq!(wire.read(0, 0x030c, 1), [1], "processing unit errors");
    // The header claims more than the frame holds: nothing is processed.
    let mut frame = wire::frame(&[Datagram::new(BWR, 0, 0x0f80, &[7])]);
    frame[14..16].copy_from_slice(&0x17ff_u16.to_le_bytes());
    assert_eq!(wire.segment.process(&mut frame), Passed::Malformed);
    assert_eq!(memory(&mut wire), [5, 5, 5]);
}

#[test]
fn other_frames_are_left_alone_and_a_vlan_tag_is_passed_over() {
    let mut wire = line();
    for (at, value) in [(12, 0x08), (15, 0x40)] {
        let mut frame = wire::frame(&[Datagram::new(BRD, 0, 0, &[0])]);
        frame[at] = value;
        let before = frame.clone();
        assert_eq!(wire.segment.process(&mut frame), Passed::Ignored);
        assert_eq!(frame, before);
    }
    for length in 0..16 {
        assert_eq!(wire.segment.process(&mut vec![0x88; length]), Passed::Ignored);
    }
    let mut tagged = wire::frame(&[Datagram::new(BRD, 0, 0, &[0])]);
    tagged.splice(12..12, [0x81, 0x00, 0x00, 0x05]);
    assert!(matches!(wire.segment.process(&mut tagged), Passed::Returned { .. }));
    assert_eq!(tagged[31], 3, "working counter behind the tag");
    assert_eq!(Segment::new(Vec::new()).process(&mut wire::frame(&[])), Passed::Lost);
}

#[test]
fn flags_that_are_not_the_devices_own_come_back_unchanged() {
    let mut wire = line();
    let mut frame = wire::frame(&[Datagram::new(BRD, 0, 0, &[0])]);
    // The bit of a frame that has circulated, and the reserved ones.
    frame[16 + 7] |= 0x78;
    wire.segment.process(&mut frame);
    assert_eq!(frame[16 + 7], 0x78);
    assert_eq!(frame[27], 3);
}

#[test]
fn events_that_the_master_asked_for_are_in_every_datagram() {
    let mut wire = Wire::new(&[builtin::coupler()]);
    wire.write(0, 0x0200, &0x0008_u16.to_le_bytes());
    wire.read(0, 0x0130, 2);
    assert_eq!(wire.send(NOP, 0, 0, &[0]).events, 0);
    wire.write(0, 0x0120, &[2, 0]);
    wire.wait_ms(1);
    assert_eq!(wire.send(NOP, 0, 0, &[0]).events, 0x0008, "AL status has changed");
    assert_eq!(wire.word(0, 0x0130), 2);
    assert_eq!(wire.send(NOP, 0, 0, &[0]).events, 0, "and was read");
}
