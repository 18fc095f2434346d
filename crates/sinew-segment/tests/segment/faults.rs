//! Injected faults begin and end at their time and do what they say.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::wire;

use sinew_segment::{AlState, Device, DeviceSettings, Fault, FaultKind, Passed, builtin};
use wire::{BRD, Datagram, Wire};

const MILLISECOND: u64 = 1_000_000;

fn line() -> Wire {
    Wire::new(&[builtin::coupler(), builtin::drive(), builtin::load_cell(), builtin::coupler()])
}

/// From 1 ms to 3 ms.
fn inject(wire: &mut Wire, device: usize, kind: FaultKind) {
    let fault = Fault { device, kind, start_ns: MILLISECOND, duration_ns: Some(2 * MILLISECOND) };
    wire.segment.inject(fault).unwrap();
}

fn count(wire: &mut Wire) -> u16 {
    wire.send(BRD, 0, 0, &[0]).counter
}

#[test]
fn frames_are_disturbed_from_the_start_to_the_end_of_a_fault() {
    for (device, kind, counter) in [
        (1, FaultKind::Mute, 3),
        (0, FaultKind::OffTheWire, 0),
        (2, FaultKind::OffTheWire, 2),
        (3, FaultKind::PowerLoss, 3),
        (1, FaultKind::WorkingCounter(-1), 3),
        (1, FaultKind::WorkingCounter(2), 6),
    ] {
        let mut wire = line();
        let name = format!("{kind:?} of {device}");
        inject(&mut wire, device, kind);
        assert_eq!(count(&mut wire), 4, "{name} before");
        wire.wait_ms(1);
        if counter == 0 {
            assert_eq!(
                wire.segment.process(&mut wire::frame(&[Datagram::new(BRD, 0, 0, &[0])])),
                Passed::Lost
            );
        } else {
            assert_eq!(count(&mut wire), counter, "{name}");
        }
        wire.segment.advance(2 * MILLISECOND - 1);
        wire.segment.advance(1);
        assert_eq!(count(&mut wire), 4, "{name} after");
    }
}

#[test]
fn late_lost_and_damaged_frames_are_told() {
    let frame = || wire::frame(&[Datagram::new(BRD, 0, 0, &[0])]);
    let mut wire = line();
    let Passed::Returned { delay_ns: usual } = wire.segment.process(&mut frame()) else { panic!("lost") };
    inject(&mut wire, 2, FaultKind::Late(700));
    wire.wait_ms(1);
    assert_eq!(wire.segment.process(&mut frame()), Passed::Returned { delay_ns: usual + 700 });

    let mut wire = line();
    inject(&mut wire, 2, FaultKind::Lost);
    wire.wait_ms(1);
    assert_eq!(wire.segment.process(&mut frame()), Passed::Lost);

    let mut wire = line();
    inject(&mut wire, 1, FaultKind::Corrupted);
    wire.wait_ms(1);
    let mut damaged = wire::frame(&[Datagram::new(wire::BWR, 0, 0x0f80, &[9])]);
    assert_eq!(wire.segment.process(&mut damaged), Passed::Corrupted);
    wire.wait_ms(2);
    let written: Vec<u8> = (0..4).map(|position| wire.read(position, 0x0f80, 1)[0]).collect();
    assert_eq!(written, [9, 0, 0, 0], "devices behind the damage do not act");
    let errors: Vec<u8> = (0..4).map(|position| wire.read(position, 0x0300, 1)[0]).collect();
    assert_eq!(errors, [0, 0, 1, 1], "wrong checksums at port 0");
}

#[test]
fn an_open_cable_is_seen_in_the_link_status_of_both_neighbours() {
    let mut wire = line();
    let links = |wire: &mut Wire, position| wire.word(position, 0x0110) & 0x0030;
    assert_eq!((links(&mut wire, 1), links(&mut wire, 3)), (0x30, 0x10));
    inject(&mut wire, 2, FaultKind::OffTheWire);
    wire.wait_ms(1);
    assert_eq!(links(&mut wire, 1), 0x10);
    assert_eq!(wire.read(1, 0x0310, 2), [0, 1], "links lost");
    wire.wait_ms(2);
    assert_eq!(links(&mut wire, 1), 0x30);
}

#[test]
fn a_device_that_had_no_power_starts_anew_and_one_that_was_cut_off_does_not() {
    for (kind, state) in [(FaultKind::PowerLoss, AlState::Init), (FaultKind::OffTheWire, AlState::PreOp)] {
        let mut wire = line();
        wire.drive_to_pre_op(1);
        let start = wire.segment.now();
        let fault = Fault { device: 1, kind, start_ns: start, duration_ns: Some(MILLISECOND) };
        wire.segment.inject(fault).unwrap();
        wire.wait_ms(3);
        assert_eq!(wire.segment.device(1).unwrap().state(), state);
        assert_eq!(count(&mut wire), 4);
    }
}

#[test]
fn a_swapped_device_stands_in_the_place_of_the_first_until_the_end() {
    let mut wire = line();
    let other = Device::new(&builtin::encoder(2), DeviceSettings::default()).unwrap();
    inject(&mut wire, 1, FaultKind::Swapped(Box::new(other)));
    let name = |wire: &Wire| wire.segment.device(1).unwrap().name().to_owned();
    assert_eq!(name(&wire), "SIM-DRV1");
    wire.wait_ms(1);
    assert_eq!(name(&wire), "SIM-ENC2");
    assert_eq!(wire.word(0, 0x0110) & 0x30, 0x30);
    wire.wait_ms(2);
    assert_eq!(name(&wire), "SIM-DRV1");
}

#[test]
fn what_happens_once_happens_once() {
    let mut wire = line();
    wire.drive_to_pre_op(1);
    let start_ns = wire.segment.now() + MILLISECOND;
    for kind in [FaultKind::Emergency(0x1000, 1, [0; 5]), FaultKind::DriveFault(0x2310)] {
        wire.segment.inject(Fault { device: 1, kind, start_ns, duration_ns: None }).unwrap();
    }
    assert_eq!(wire.fetch(1), Some(vec![0, 0x10, 0, 0x10, 1, 0, 0, 0, 0, 0]));
    assert_eq!(wire.fetch(1), Some(vec![0, 0x10, 0x10, 0x23, 1, 0, 0, 0, 0, 0]));
    assert_eq!(wire.fetch(1), None);
    let unknown = Fault { device: 4, kind: FaultKind::Mute, start_ns: 0, duration_ns: None };
    assert!(wire.segment.inject(unknown).is_err());
}

#[test]
fn a_long_step_passes_every_beginning_and_end_on_its_way() {
    let mut wire = line();
    wire.drive_to_pre_op(1);
    let start_ns = wire.segment.now() + MILLISECOND;
    wire.segment
        .inject(Fault { device: 1, kind: FaultKind::PowerLoss, start_ns, duration_ns: Some(MILLISECOND) })
        .unwrap();
    wire.segment.advance(1000 * MILLISECOND);
    assert_eq!(wire.segment.device(1).unwrap().state(), AlState::Init);
}
