//! Every transition of the application layer and what is checked before it, after ETG.1000.6.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::wire;

use sinew_segment::{AlState, DeviceSettings, builtin};
use wire::{Datagram, FPWR, LRW, STATION, Wire};

const INIT: u16 = 1;
const PRE_OP: u16 = 2;
const BOOT: u16 = 3;
const SAFE_OP: u16 = 4;
const OP: u16 = 8;
const ERROR: u16 = 0x10;
const INVALID_CHANGE: u16 = 0x11;

/// A drive brought to a state.
fn drive_in(state: u16) -> Wire {
    let mut wire = Wire::new(&[builtin::drive()]);
    match state {
        INIT => {}
        PRE_OP => wire.drive_to_pre_op(0),
        _ => wire.drive_to_safe_op(0, 0x100, 0x200),
    }
    if state != SAFE_OP && state != OP {
        // Settings for later, so that only the order of states matters.
        wire.sync_manager(0, 0, 0x1000, 256, 0x26);
        wire.sync_manager(0, 1, 0x1100, 256, 0x22);
        wire.sync_manager(0, 2, 0x1200, 6, 0x64);
        wire.sync_manager(0, 3, 0x1800, 16, 0x20);
        wire.fmmu(0, 0, 0x100, 6, 0x1200, 2);
    }
    if state == OP {
        outputs(&mut wire);
        assert_eq!(wire.request(0, OP), (OP, 0));
    }
    wire
}

fn outputs(wire: &mut Wire) -> u16 {
    wire.send_all(&[Datagram::logical(LRW, 0x100, &[0; 6])]).remove(0).counter
}

#[test]
fn every_request_in_every_state_is_answered_as_in_the_standard() {
    // From, requested; the status and the code that follow.
    let mut table = Vec::new();
    for from in [INIT, PRE_OP, SAFE_OP, OP] {
        for to in [INIT, PRE_OP, SAFE_OP, OP] {
            let step_up = to == 2 * from;
            let answer = if to <= from || step_up { (to, 0) } else { (from | ERROR, INVALID_CHANGE) };
            table.push((from, to, answer));
        }
        table.push((from, BOOT, (from | ERROR, 0x13)));
        for unknown in [0, 5, 6, 7, 9, 15] {
            table.push((from, unknown, (from | ERROR, 0x12)));
        }
    }
    for (from, to, expected) in table {
        let mut wire = drive_in(from);
        if to > from {
            outputs(&mut wire);
        }
        assert_eq!(wire.request(0, to), expected, "from {from} to {to}");
    }
}

#[test]
fn an_error_stands_until_it_is_acknowledged() {
    let mut wire = drive_in(PRE_OP);
    assert_eq!(wire.request(0, OP), (PRE_OP | ERROR, INVALID_CHANGE));
    assert_eq!(wire.request(0, SAFE_OP), (PRE_OP | ERROR, INVALID_CHANGE), "the way up is closed");
    assert_eq!(wire.request(0, PRE_OP | ERROR), (PRE_OP, 0));
    assert_eq!(wire.request(0, SAFE_OP), (SAFE_OP, 0));
    assert_eq!(wire.request(0, 5), (SAFE_OP | ERROR, 0x12));
    assert_eq!(wire.request(0, INIT), (INIT, 0), "the way down is open");
}

#[test]
fn the_mailbox_has_to_fit_before_pre_op() {
    // Channel, start, length, control.
    for (channel, start, length, control) in [
        (0, 0x1000, 0, 0x26),
        (0, 0x1002, 256, 0x26),
        (0, 0x1000, 128, 0x26),
        (0, 0x1000, 256, 0x24),
        (0, 0x1000, 256, 0x22),
        (1, 0x1100, 0, 0x22),
        (1, 0x1100, 256, 0x26),
    ] {
        let mut wire = drive_in(INIT);
        wire.sync_manager(0, channel, start, length, control);
        assert_eq!(
            wire.request(0, PRE_OP),
            (INIT | ERROR, 0x16),
            "{channel} {start:#x} {length} {control:#x}"
        );
    }
}

#[test]
fn process_data_have_to_fit_before_safe_op() {
    for (channel, start, length, control, code) in [
        (2, 0x1200, 0, 0x64, 0x1d),
        (2, 0x1200, 7, 0x64, 0x1d),
        (2, 0x1201, 6, 0x64, 0x1d),
        (2, 0x1200, 6, 0x20, 0x1d),
        (2, 0x1200, 6, 0x66, 0x1d),
        (3, 0x1800, 0, 0x20, 0x1e),
        (3, 0x1800, 17, 0x20, 0x1e),
        (3, 0x1800, 16, 0x24, 0x1e),
    ] {
        let mut wire = drive_in(PRE_OP);
        wire.sync_manager(0, channel, start, length, control);
        assert_eq!(
            wire.request(0, SAFE_OP),
            (PRE_OP | ERROR, code),
            "{channel} {start:#x} {length} {control:#x}"
        );
    }
}

#[test]
fn op_waits_for_outputs_and_is_refused_without_them() {
    let mut wire = drive_in(SAFE_OP);
    assert_eq!(wire.request(0, OP), (SAFE_OP, 0), "waits");
    assert_eq!(outputs(&mut wire), 2, "outputs are written, nothing is read at these addresses");
    wire.wait_ms(1);
    assert_eq!(wire.word(0, 0x0130), OP);

    let mut wire = drive_in(SAFE_OP);
    wire.request(0, OP);
    wire.wait_ms(1100);
    assert_eq!((wire.word(0, 0x0130), wire.word(0, 0x0134)), (SAFE_OP | ERROR, 0x19));
}

#[test]
fn missing_outputs_lead_back_to_safe_op_after_the_watchdog_time() {
    let mut wire = drive_in(OP);
    // 10 ms instead of 100.
    wire.write(0, 0x0420, &100_u16.to_le_bytes());
    for _ in 0..20 {
        outputs(&mut wire);
        wire.wait_ms(9);
    }
    assert_eq!(wire.word(0, 0x0130), OP);
    assert_eq!(wire.word(0, 0x0440), 1);
    wire.wait_ms(2);
    assert_eq!((wire.word(0, 0x0130), wire.word(0, 0x0134)), (SAFE_OP | ERROR, 0x1b));
    assert_eq!(wire.word(0, 0x0440), 0);
    assert_eq!(wire.read(0, 0x0442, 1), [1]);
    // Acknowledged, and back with outputs.
    assert_eq!(wire.request(0, SAFE_OP | ERROR), (SAFE_OP, 0));
    outputs(&mut wire);
    assert_eq!(wire.request(0, OP), (OP, 0));
}

#[test]
fn a_watchdog_time_of_zero_switches_it_off() {
    let mut wire = drive_in(OP);
    wire.write(0, 0x0420, &[0, 0]);
    wire.wait_ms(500);
    assert_eq!(wire.word(0, 0x0130), OP);
}

#[test]
fn settings_of_sync0_are_checked() {
    // Activation, cycle in ns; code at SAFE-OP.
    for (activation, cycle, code) in [(1_u8, 1_000_000_u32, 0x30), (3, 0, 0x36), (3, 100_000, 0x36)] {
        let mut wire = drive_in(PRE_OP);
        wire.write(0, 0x09a0, &cycle.to_le_bytes());
        wire.write(0, 0x0981, &[activation]);
        assert_eq!(wire.request(0, SAFE_OP), (PRE_OP | ERROR, code), "{activation} {cycle}");
    }
    for (start_ms, expected) in [(-1_i64, (SAFE_OP | ERROR, 0x2d)), (20, (OP, 0))] {
        let mut wire = drive_in(PRE_OP);
        wire.wait_ms(2);
        let now = u64::from_le_bytes(wire.read(0, 0x0910, 8).try_into().unwrap());
        wire.write(0, 0x09a0, &1_000_000_u32.to_le_bytes());
        wire.write(0, 0x0990, &now.wrapping_add_signed(start_ms * 1_000_000).to_le_bytes());
        wire.write(0, 0x0981, &[3]);
        assert_eq!(wire.request(0, SAFE_OP), (SAFE_OP, 0));
        outputs(&mut wire);
        assert_eq!(wire.request(0, OP), expected, "start in {start_ms} ms");
    }
}

#[test]
fn a_synchronisation_type_has_to_be_supported_and_switched_on() {
    for (written, code) in [(0_u16, 0), (1, 0), (2, 0x30), (3, 0x30), (4, 0x27), (0x22, 0x27)] {
        let mut wire = drive_in(PRE_OP);
        assert_eq!(wire.download(0, 0x1c32, 1, &written.to_le_bytes()), Ok(()));
        let expected = if code == 0 { (SAFE_OP, 0) } else { (PRE_OP | ERROR, code) };
        assert_eq!(wire.request(0, SAFE_OP), expected, "type {written}");
    }
}

#[test]
fn a_watchdog_shorter_than_the_cycle_is_refused() {
    let mut wire = drive_in(PRE_OP);
    wire.write(0, 0x09a0, &2_000_000_u32.to_le_bytes());
    wire.write(0, 0x0981, &[3]);
    wire.write(0, 0x0420, &10_u16.to_le_bytes());
    assert_eq!(wire.request(0, SAFE_OP), (PRE_OP | ERROR, 0x1f), "1 ms and 2 ms");
}

#[test]
fn a_device_falls_when_its_sync_managers_or_sync0_are_taken_away() {
    // Channel; state and code that follow from OP.
    for (channel, status, code) in [(0, INIT, 0x16), (1, INIT, 0x16), (2, PRE_OP, 0x1d), (3, PRE_OP, 0x1e)] {
        let mut wire = drive_in(OP);
        wire.write(0, 0x0806 + 8 * channel, &[0]);
        wire.wait_ms(1);
        assert_eq!((wire.word(0, 0x0130), wire.word(0, 0x0134)), (status | ERROR, code), "channel {channel}");
    }
    let mut wire = drive_in(PRE_OP);
    let now = u64::from_le_bytes(wire.read(0, 0x0910, 8).try_into().unwrap());
    wire.write(0, 0x09a0, &1_000_000_u32.to_le_bytes());
    wire.write(0, 0x0990, &(now + 5_000_000).to_le_bytes());
    wire.write(0, 0x0981, &[3]);
    assert_eq!(wire.request(0, SAFE_OP), (SAFE_OP, 0));
    outputs(&mut wire);
    assert_eq!(wire.request(0, OP), (OP, 0));
    wire.write(0, 0x0981, &[0]);
    wire.wait_ms(1);
    assert_eq!((wire.word(0, 0x0130), wire.word(0, 0x0134)), (SAFE_OP | ERROR, 0x2c));
}

#[test]
fn identification_is_shown_on_request_and_only_then() {
    let settings = |_| DeviceSettings { identification: Some(0x1234), ..DeviceSettings::default() };
    let mut wire = Wire::with_settings(&[builtin::coupler()], settings);
    assert_eq!(wire.request(0, INIT | 0x20), (INIT | 0x20, 0x1234));
    assert_eq!(wire.request(0, INIT), (INIT, 0));
    let mut without = Wire::new(&[builtin::coupler()]);
    assert_eq!(without.request(0, INIT | 0x20), (INIT, 0));
}

#[test]
fn a_state_is_reached_only_after_the_time_of_its_transition() {
    let settings = |_| DeviceSettings { transition_ns: 5_000_000, ..DeviceSettings::default() };
    let mut wire = Wire::with_settings(&[builtin::coupler()], settings);
    assert_eq!(wire.send(FPWR, STATION, 0x0120, &[2, 0]).counter, 1);
    wire.wait_ms(4);
    assert_eq!(wire.segment.device(0).unwrap().state(), AlState::Init);
    wire.wait_ms(2);
    assert_eq!(wire.segment.device(0).unwrap().state(), AlState::PreOp);
}
