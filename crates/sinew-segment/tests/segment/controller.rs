//! Registers with side effects: EEPROM, sync managers, clocks, line control.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::wire;

use sinew_segment::{DeviceSettings, builtin};
use wire::{ARMW, BWR, Datagram, FPRD, FPWR, FRMW, LRW, STATION, Wire};

fn eeprom_read(wire: &mut Wire, word: u32) -> Vec<u8> {
    let mut request = vec![0, 1];
    request.extend(word.to_le_bytes());
    wire.write(0, 0x0502, &request);
    assert_eq!(wire.word(0, 0x0502) & 0x8000, 0x8000, "busy");
    wire.wait_ms(1);
    assert_eq!(wire.word(0, 0x0502) & 0xf000, 0);
    wire.read(0, 0x0508, 8)
}

#[test]
fn the_eeprom_is_read_and_written_through_its_registers() {
    let settings = |_| DeviceSettings { serial: Some(0x1234_5678), alias: 0x55, ..DeviceSettings::default() };
    let mut wire = Wire::with_settings(&[builtin::drive()], settings);
    assert_eq!(eeprom_read(&mut wire, 8)[..4], 0x51e37_u32.to_le_bytes());
    assert_eq!(eeprom_read(&mut wire, 14)[..4], 0x1234_5678_u32.to_le_bytes());
    assert_eq!(wire.word(0, 0x0012), 0x55, "alias");
    // A new alias, with enable bit in the same write; then its checksum; then reload.
    let write = |wire: &mut Wire, word: u32, value: u16| {
        wire.write(0, 0x0508, &value.to_le_bytes());
        let mut request = vec![1, 2];
        request.extend(word.to_le_bytes());
        wire.write(0, 0x0502, &request);
        wire.wait_ms(1);
        assert_eq!(wire.word(0, 0x0502) & 0xe000, 0);
    };
    write(&mut wire, 4, 0x66);
    assert_eq!(eeprom_read(&mut wire, 4)[..2], [0x66, 0]);
    wire.write(0, 0x0502, &[0, 4]);
    wire.wait_ms(1);
    assert_eq!(wire.word(0, 0x0502) & 0x0800, 0x0800, "the checksum is wrong now");
    assert_eq!(wire.word(0, 0x0012), 0x55, "and nothing is taken");
    let head: Vec<u8> = (0..4).flat_map(|at| eeprom_read(&mut wire, 2 * at)[..4].to_vec()).collect();
    write(&mut wire, 7, u16::from(crc(&head[..14])));
    wire.write(0, 0x0502, &[0, 4]);
    wire.wait_ms(1);
    assert_eq!(wire.word(0, 0x0502) & 0x0800, 0);
    assert_eq!(wire.word(0, 0x0012), 0x66);
}

/// CRC-8 as in ETG.1000.6, computed another way than in the crate: division of the polynomial bit by bit.
fn crc(octets: &[u8]) -> u8 {
    let mut register = 0xff_u16;
    for octet in octets {
        register ^= u16::from(*octet);
        for _ in 0..8 {
            register <<= 1;
            if register & 0x100 != 0 {
                register ^= 0x107;
            }
        }
    }
    register as u8
}

#[test]
fn commands_that_the_eeprom_cannot_do_are_refused() {
    let mut wire = Wire::new(&[builtin::drive()]);
    for (control, address, error) in [
        (0x0100_u16, 0x00ff_ffff_u32, 0x2000),
        (0x0200, 4, 0x4000),
        (0x0201, 0x00ff_ffff, 0x2000),
        (0x0700, 0, 0x2000),
    ] {
        let mut request = control.to_le_bytes().to_vec();
        request.extend(address.to_le_bytes());
        wire.write(0, 0x0502, &request);
        wire.wait_ms(1);
        assert_eq!(wire.word(0, 0x0502) & 0xe000, error, "{control:#x} {address:#x}");
        wire.write(0, 0x0502, &[0, 0]);
        assert_eq!(wire.word(0, 0x0502) & 0xe000, 0, "cleared");
    }
    // It belongs to the firmware.
    wire.write(0, 0x0500, &[1]);
    assert_eq!(wire.send(FPWR, STATION, 0x0502, &[0, 1, 0, 0, 0, 0]).counter, 0);
}

#[test]
fn process_data_are_consistent_whatever_the_order_of_accesses() {
    let mut wire = Wire::new(&[builtin::drive()]);
    wire.drive_to_safe_op(0, 0x100, 0x200);
    // A frame that does not begin at the first octet has no buffer.
    assert_eq!(wire.send(FPRD, STATION, 0x1801, &[0; 15]).counter, 0);
    assert_eq!(wire.send(FPWR, STATION, 0x1201, &[0; 5]).counter, 0);
    // Read in two parts: in between the device writes new inputs, and the second part is still of the old
    // ones.
    let set = |wire: &mut Wire, position: i32| {
        wire.segment.device_mut(0).unwrap().drive_mut().unwrap().set_actual(position, position, 0);
        wire.wait_ms(1);
    };
    set(&mut wire, 0x0101_0101);
    let first = wire.read(0, 0x1800, 4);
    set(&mut wire, 0x0202_0202);
    let second = wire.read(0, 0x1804, 12);
    assert_eq!((first[2], second[0], second[2]), (1, 1, 1));
    assert_eq!(wire.read(0, 0x1800, 16)[2..6], [2; 4]);
    // Written in two parts: taken when complete.
    wire.request(0, 8);
    wire.write(0, 0x1200, &[6, 0]);
    wire.wait_ms(1);
    assert_eq!(wire.word(0, 0x0130), 4, "no outputs yet");
    wire.write(0, 0x1202, &[0, 0, 10, 0]);
    wire.wait_ms(1);
    assert_eq!(wire.word(0, 0x0130), 8);
    // The status shows which of three buffers was written, never the same twice running.
    let buffer = |wire: &mut Wire| wire.read(0, 0x0815, 1)[0] >> 4 & 3;
    let mut last = buffer(&mut wire);
    for _ in 0..6 {
        wire.write(0, 0x1200, &[6, 0, 0, 0, 10, 0]);
        let now = buffer(&mut wire);
        assert!(now < 3 && now != last, "{now} after {last}");
        last = now;
    }
}

#[test]
fn settings_of_a_sync_manager_are_locked_while_it_is_switched_on() {
    let mut wire = Wire::new(&[builtin::drive()]);
    wire.sync_manager(0, 0, 0x1000, 256, 0x26);
    wire.send(FPWR, STATION, 0x0800, &[0x34, 0x12]);
    assert_eq!(wire.word(0, 0x0800), 0x1000);
    wire.write(0, 0x0806, &[0]);
    wire.write(0, 0x0800, &[0x34, 0x12]);
    assert_eq!(wire.word(0, 0x0800), 0x1234);
}

#[test]
fn the_mailbox_status_can_be_mapped_to_a_bit_of_the_process_data() {
    let mut wire = Wire::new(&[builtin::drive()]);
    wire.drive_to_pre_op(0);
    // Bit 3 of 0x080d to bit 0 of the logical octet.
    let mut unit = 0x300_u32.to_le_bytes().to_vec();
    unit.extend([1, 0, 0, 0, 0x0d, 0x08, 3, 1, 1, 0, 0, 0]);
    wire.write(0, 0x0620, &unit);
    let status = |wire: &mut Wire| wire.send_all(&[Datagram::logical(LRW, 0x300, &[0])]).remove(0);
    assert_eq!((status(&mut wire).data, status(&mut wire).counter), (vec![0], 1));
    wire.post(0, 3, &[0, 0x20, 0x40, 0x18, 0x10, 1, 0, 0, 0, 0]);
    wire.wait_ms(1);
    assert_eq!(status(&mut wire).data, [1]);
}

fn system_time(wire: &mut Wire, position: u16) -> u64 {
    u64::from_le_bytes(wire.read(position, 0x0910, 8).try_into().unwrap())
}

#[test]
fn receive_times_give_the_delays_of_the_line() {
    let settings = |position: usize| DeviceSettings {
        forward_delay_ns: 100 * (position as u32 + 1),
        clock_at_start_ns: 1_000_000_007 * position as u64,
        ..DeviceSettings::default()
    };
    let mut wire = Wire::with_settings(&[builtin::drive(), builtin::drive(), builtin::drive()], settings);
    assert_eq!(wire.send(BWR, 0, 0x0900, &[0; 4]).counter, 3);
    let loops: Vec<u32> = (0..3)
        .map(|position| {
            let times = wire.read(position, 0x0900, 8);
            let word = |at: usize| u32::from_le_bytes(times[at..at + 4].try_into().unwrap());
            word(4).wrapping_sub(word(0))
        })
        .collect();
    // From port 0 of a device to its port 1 the frame passes everything behind, forth and back.
    assert_eq!(loops, [2 * (200 + 300), 2 * 300, 0]);
}

#[test]
fn drifting_clocks_follow_the_first_one() {
    let drifts = [0, 50_000, -80_000];
    let settings = |position: usize| DeviceSettings {
        drift_ppb: drifts[position],
        clock_at_start_ns: 7_000_000 * position as u64,
        forward_delay_ns: 0,
        ..DeviceSettings::default()
    };
    let mut wire = Wire::with_settings(&[builtin::drive(), builtin::drive(), builtin::drive()], settings);
    wire.send(BWR, 0, 0x0900, &[0; 4]);
    let local =
        |wire: &mut Wire, position| u64::from_le_bytes(wire.read(position, 0x0918, 8).try_into().unwrap());
    let reference = local(&mut wire, 0);
    for position in 1..3 {
        let offset = reference.wrapping_sub(local(&mut wire, position));
        wire.write(position, 0x0920, &offset.to_le_bytes());
    }
    let spread = |wire: &mut Wire| {
        let times = [0, 1, 2].map(|position| system_time(wire, position));
        times.iter().max().unwrap() - times.iter().min().unwrap()
    };
    wire.wait_ms(100);
    let free = spread(&mut wire);
    assert!((12_000..14_000).contains(&free), "130 ppm in 100 ms are 13 us, {free} ns");
    for command in [FRMW, ARMW].into_iter().cycle().take(3000) {
        let device = if command == FRMW { STATION } else { 0 };
        assert_eq!(wire.send(command, device, 0x0910, &[0; 8]).counter, 3);
        wire.segment.advance(1_000_000);
    }
    wire.send(FRMW, STATION, 0x0910, &[0; 8]);
    assert!(spread(&mut wire) < 100, "{} ns", spread(&mut wire));
    for position in 1..3 {
        let difference = u32::from_le_bytes(wire.read(position, 0x092c, 4).try_into().unwrap()) & 0x7fff_ffff;
        assert!(difference < 100, "{difference} ns in the register");
    }
}

#[test]
fn with_sync0_outputs_wait_for_its_pulse() {
    let mut wire = Wire::new(&[builtin::drive()]);
    wire.drive_to_pre_op(0);
    let start = system_time(&mut wire, 0) + 20_000_000;
    wire.write(0, 0x09a0, &1_000_000_u32.to_le_bytes());
    wire.write(0, 0x0990, &start.to_le_bytes());
    wire.write(0, 0x0981, &[3]);
    wire.drive_to_safe_op_from_pre_op();
    wire.write(0, 0x1200, &[0; 6]);
    assert_eq!(wire.request(0, 8), (8, 0));
    // Up to just behind a pulse.
    let next = u64::from_le_bytes(wire.read(0, 0x0990, 8).try_into().unwrap());
    let now = wire.segment.device(0).unwrap().clock().unwrap().1;
    wire.segment.advance(next - now + 1000);
    wire.write(0, 0x1200, &[6, 0, 0, 0, 10, 0]);
    let controlword = |wire: &Wire| wire.segment.device(0).unwrap().object(0x6040, 0).unwrap().to_vec();
    assert_eq!(controlword(&wire), [0, 0]);
    wire.segment.advance(990_000);
    assert_eq!(controlword(&wire), [0, 0], "just before the pulse");
    wire.segment.advance(20_000);
    assert_eq!(controlword(&wire), [6, 0], "behind it");
}

impl Wire {
    fn drive_to_safe_op_from_pre_op(&mut self) {
        self.sync_manager(0, 2, 0x1200, 6, 0x64);
        self.sync_manager(0, 3, 0x1800, 16, 0x20);
        assert_eq!(self.request(0, 4), (4, 0));
    }
}

#[test]
fn a_port_that_the_master_closes_ends_the_line() {
    let mut wire = Wire::new(&[builtin::coupler(), builtin::coupler(), builtin::coupler()]);
    // Loop control: port 1 closed.
    wire.write(1, 0x0101, &[0x0c]);
    assert_eq!(wire.send(wire::BRD, 0, 0, &[0]).counter, 2);
    wire.write(1, 0x0101, &[0]);
    assert_eq!(wire.send(wire::BRD, 0, 0, &[0]).counter, 3);
}

#[test]
fn what_a_controller_has_is_in_its_first_registers() {
    let mut wire = Wire::new(&[builtin::drive(), builtin::coupler()]);
    let drive = wire.read(0, 0, 10);
    assert_eq!(drive[4..8], [8, 8, 8, 0x0f], "FMMUs, sync managers, kilobytes, ports");
    assert_eq!((drive[8] & 0x0c, drive[9] & 1), (0x0c, 1), "clock with 64 bits and SYNC");
    let coupler = wire.read(1, 0, 10);
    assert_eq!((coupler[8] & 0x0c, coupler[9] & 1), (0x0c, 0), "clock without SYNC");
    // Links: both ports, then port 0 alone.
    assert_eq!(wire.word(0, 0x0110) & 0x0f30, 0x0a30);
    assert_eq!(wire.word(1, 0x0110) & 0x0f30, 0x0610);
}
