//! A master by somebody else, the crate dynamixel2, on a chain of simulated servos behind a pseudo-terminal.

use crate::common::{Setup, bare_machine};
use dynamixel2::{Bus, ReadError, TransferError};
use sinew_runtime::PseudoTerminal;
use sinew_runtime::servos::{ServoDevice, SimulatedMachine, serve};
use std::sync::atomic::{AtomicBool, Ordering};

const IDS: [u8; 5] = [1, 2, 3, 4, 5];
/// Addresses of the X series.
const MODE: u16 = 11;
const TORQUE: u16 = 64;
const GOAL_VELOCITY: u16 = 104;
const POSITION: u16 = 132;

/// A loaded computer exceeds the time that the crate waits.
fn again<T>(mut attempt: impl FnMut() -> Result<T, TransferError>) -> Result<T, TransferError> {
    for _ in 0..9 {
        match attempt() {
            Err(TransferError::ReadError(ReadError::Io(_))) => {}
            other => return other,
        }
    }
    attempt()
}

#[test]
fn a_master_of_another_crate_drives_simulated_servos() {
    let setup = Setup::new(bare_machine("finger"), 3, &[]);
    let servos = ServoDevice::simulated(&setup.machine);
    let ports = ServoDevice::ports(&servos);
    let mut machine = SimulatedMachine::new(setup.plant.clone(), &setup.machine, &servos, &ports, false);
    let mut terminals = [PseudoTerminal::open().unwrap()];
    let (path, stop) = (terminals[0].path().to_owned(), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let served = scope.spawn(|| serve(&mut terminals, &mut machine, 1_000_000, &stop, &mut |_| {}));
        let driven = std::panic::catch_unwind(|| drive(&path));
        stop.store(true, Ordering::Relaxed);
        assert!(served.join().unwrap().unwrap() > 0);
        driven.unwrap();
    });
}

fn drive(path: &str) {
    let mut bus = Bus::open(path, 1_000_000).unwrap();
    let found: Vec<u8> = bus.scan().unwrap().into_iter().map(|answer| answer.unwrap().motor_id).collect();
    assert_eq!(found, IDS);
    assert_eq!(again(|| bus.ping(3)).unwrap().data.model, 1020);
    again(|| bus.write_u8(1, TORQUE, 1)).unwrap();
    let Err(TransferError::ReadError(ReadError::MotorError(refused))) = again(|| bus.write_u8(1, MODE, 1))
    else {
        panic!("the EEPROM is locked under torque");
    };
    assert_eq!(refused.error_number(), 7, "access is refused");
    for id in IDS {
        again(|| bus.write_u8(id, TORQUE, 0)).unwrap();
        again(|| bus.write_u8(id, MODE, 1)).unwrap();
        assert_eq!(again(|| bus.read_u8(id, MODE)).unwrap().data, 1);
        again(|| bus.write_u8(id, TORQUE, 1)).unwrap();
    }
    let positions = |bus: &mut Bus<_, _>| {
        let answers = again(|| bus.sync_read_u32(&IDS, POSITION)).unwrap();
        answers.into_iter().map(|answer| answer.data.cast_signed()).collect::<Vec<i32>>()
    };
    let before = positions(&mut bus);
    let goals = IDS
        .map(|motor_id| dynamixel2::instructions::SyncWriteData { motor_id, data: 10_i32.cast_unsigned() });
    bus.sync_write_u32(GOAL_VELOCITY, &goals).unwrap();
    std::thread::sleep(std::time::Duration::from_millis(300));
    let after = positions(&mut bus);
    assert!(before.iter().zip(&after).all(|(before, after)| after > before), "{before:?} {after:?}");
}
