//! The drive's state machine, modes, limits and faults, after IEC 61800-7-201.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::wire;

use sinew_segment::{AxisCommand, Drive, DriveState, Fault, FaultKind, Mode, builtin};
use wire::Wire;

/// A drive in OP whose objects are set from inside, as outputs would.
struct Axis(Wire);

impl Axis {
    fn new() -> Self {
        let mut wire = Wire::new(&[builtin::drive()]);
        wire.drive_to_safe_op(0, 0x100, 0x200);
        wire.write(0, 0x0420, &[0, 0]);
        wire.write(0, 0x1200, &[0; 6]);
        assert_eq!(wire.request(0, 8), (8, 0));
        Self(wire)
    }

    fn enabled(mode: i8) -> Self {
        let mut axis = Self::new();
        axis.set(0x6060, &mode.to_le_bytes());
        for control in [6, 7, 15] {
            axis.control(control);
        }
        assert_eq!(axis.drive().state(), DriveState::OperationEnabled);
        axis
    }

    fn set(&mut self, index: u16, value: &[u8]) {
        assert!(self.0.segment.device_mut(0).unwrap().set_object(index, 0, value));
    }

    fn set_sub(&mut self, index: u16, subindex: u8, value: &[u8]) {
        assert!(self.0.segment.device_mut(0).unwrap().set_object(index, subindex, value));
    }

    fn step(&mut self) {
        self.0.segment.advance(1_000_000);
    }

    fn control(&mut self, controlword: u16) {
        self.set(0x6040, &controlword.to_le_bytes());
        self.step();
    }

    fn drive(&self) -> &Drive {
        self.0.segment.device(0).unwrap().drive().unwrap()
    }

    fn drive_mut(&mut self) -> &mut Drive {
        self.0.segment.device_mut(0).unwrap().drive_mut().unwrap()
    }

    fn statusword(&self) -> u16 {
        let octets = self.0.segment.device(0).unwrap().object(0x6041, 0).unwrap();
        u16::from_le_bytes([octets[0], octets[1]])
    }
}

#[test]
fn every_transition_follows_its_command() {
    use DriveState as S;
    // Commands on the way to a state.
    let way = |state| -> &[u16] {
        match state {
            S::SwitchOnDisabled => &[],
            S::ReadyToSwitchOn => &[6],
            S::SwitchedOn => &[6, 7],
            S::OperationEnabled => &[6, 7, 15],
            _ => &[6, 7, 15, 2],
        }
    };
    // State; after shutdown, switch on, enable operation, disable voltage, quick stop.
    let table = [
        (
            S::SwitchOnDisabled,
            [
                S::ReadyToSwitchOn,
                S::SwitchOnDisabled,
                S::SwitchOnDisabled,
                S::SwitchOnDisabled,
                S::SwitchOnDisabled,
            ],
        ),
        (
            S::ReadyToSwitchOn,
            [S::ReadyToSwitchOn, S::SwitchedOn, S::SwitchedOn, S::SwitchOnDisabled, S::SwitchOnDisabled],
        ),
        (
            S::SwitchedOn,
            [
                S::ReadyToSwitchOn,
                S::SwitchedOn,
                S::OperationEnabled,
                S::SwitchOnDisabled,
                S::SwitchOnDisabled,
            ],
        ),
        (
            S::OperationEnabled,
            [S::ReadyToSwitchOn, S::SwitchedOn, S::OperationEnabled, S::SwitchOnDisabled, S::QuickStopActive],
        ),
        (
            S::QuickStopActive,
            [
                S::QuickStopActive,
                S::QuickStopActive,
                S::OperationEnabled,
                S::SwitchOnDisabled,
                S::QuickStopActive,
            ],
        ),
    ];
    for (from, after) in table {
        for (control, expected) in [6, 7, 15, 0, 2].into_iter().zip(after) {
            let mut axis = Axis::new();
            // The quick stop stays in its state.
            axis.set(0x605a, &6_i16.to_le_bytes());
            for step in way(from) {
                axis.control(*step);
            }
            assert_eq!(axis.drive().state(), from);
            axis.control(control);
            assert_eq!(axis.drive().state(), expected, "{from:?} with controlword {control}");
            assert_eq!(axis.statusword() & 0x6f, expected.statusword());
            assert_eq!(axis.drive().brake_released(), expected.has_power());
        }
    }
}

#[test]
fn each_mode_commands_its_quantity() {
    for (number, mode, command) in [
        (8, Mode::Position, AxisCommand::Position(1000)),
        (9, Mode::Velocity, AxisCommand::Velocity(2000)),
        (10, Mode::Torque, AxisCommand::Torque(300)),
        (0, Mode::None, AxisCommand::QuickStop),
        (1, Mode::None, AxisCommand::QuickStop),
    ] {
        let mut axis = Axis::enabled(number);
        axis.set(0x607a, &1000_i32.to_le_bytes());
        axis.set(0x60ff, &2000_i32.to_le_bytes());
        axis.set(0x6071, &300_i16.to_le_bytes());
        axis.step();
        assert_eq!((axis.drive().mode(), axis.drive().command()), (mode, command));
        assert_eq!(axis.statusword() & 0x1000 != 0, mode != Mode::None, "follows the command");
        axis.control(7);
        assert_eq!(axis.drive().command(), AxisCommand::Off);
    }
}

#[test]
fn limits_bound_the_command_and_are_shown() {
    let internal_limit = |axis: &Axis| axis.statusword() & 0x0800 != 0;
    let mut axis = Axis::enabled(10);
    axis.set(0x6071, &2000_i16.to_le_bytes());
    axis.set(0x6072, &1500_u16.to_le_bytes());
    axis.step();
    assert_eq!(axis.drive().command(), AxisCommand::Torque(1500));
    assert!(internal_limit(&axis));
    // Faster than the motor may be: no more torque in that direction.
    axis.drive_mut().set_actual(0, 7_000_000, 0);
    axis.step();
    assert_eq!(axis.drive().command(), AxisCommand::Torque(0));

    let mut axis = Axis::enabled(9);
    axis.set(0x60ff, &i32::MIN.to_le_bytes());
    axis.set(0x6080, &60_u32.to_le_bytes());
    axis.step();
    assert_eq!(axis.drive().command(), AxisCommand::Velocity(-65536), "one revolution a second");
    // Beyond the lower software limit only the way back is open.
    axis.set_sub(0x607d, 1, &(-100_i32).to_le_bytes());
    axis.set_sub(0x607d, 2, &100_i32.to_le_bytes());
    axis.drive_mut().set_actual(-101, 0, 0);
    axis.step();
    assert_eq!(axis.drive().command(), AxisCommand::Velocity(0));
    assert!(internal_limit(&axis));
    axis.set(0x60ff, &50_i32.to_le_bytes());
    axis.step();
    assert_eq!(axis.drive().command(), AxisCommand::Velocity(50));
    assert!(!internal_limit(&axis));

    let mut axis = Axis::enabled(8);
    axis.set_sub(0x607d, 1, &(-100_i32).to_le_bytes());
    axis.set_sub(0x607d, 2, &100_i32.to_le_bytes());
    axis.set(0x607a, &500_i32.to_le_bytes());
    axis.step();
    assert_eq!(axis.drive().command(), AxisCommand::Position(100));
}

#[test]
fn a_position_that_is_not_followed_is_a_fault_after_its_time() {
    let mut axis = Axis::enabled(8);
    axis.set(0x6065, &100_u32.to_le_bytes());
    axis.set(0x6066, &5_u16.to_le_bytes());
    axis.set(0x607a, &101_i32.to_le_bytes());
    for _ in 0..5 {
        axis.step();
        assert!(axis.statusword() & 0x2000 != 0, "following error");
    }
    assert_eq!(axis.drive().state(), DriveState::OperationEnabled);
    // The window is left for one cycle: the time begins anew.
    axis.drive_mut().set_actual(1, 0, 0);
    axis.step();
    axis.drive_mut().set_actual(0, 0, 0);
    for _ in 0..5 {
        axis.step();
    }
    assert_eq!(axis.drive().state(), DriveState::OperationEnabled);
    axis.step();
    assert_eq!((axis.drive().state(), axis.drive().error_code()), (DriveState::FaultReactionActive, 0x8611));
    assert_eq!(axis.drive().command(), AxisCommand::QuickStop);
    axis.step();
    assert_eq!(axis.drive().state(), DriveState::Fault);
    assert_eq!(axis.0.fetch(0), Some(vec![0, 0x10, 0x11, 0x86, 1, 0, 0, 0, 0, 0]), "emergency");
    assert_eq!(axis.0.upload(0, 0x603f, 0), Ok(vec![0x11, 0x86]));
    assert_eq!(axis.0.upload(0, 0x1001, 0), Ok(vec![1]));
}

#[test]
fn a_fault_is_left_on_the_rising_edge_of_its_reset() {
    let mut axis = Axis::enabled(10);
    axis.control(0x8f);
    axis.drive_mut().raise_fault(0x2310);
    axis.drive_mut().set_actual(0, 5000, 0);
    axis.step();
    assert_eq!(axis.drive().state(), DriveState::FaultReactionActive, "not before the motor rests");
    axis.drive_mut().set_actual(0, 0, 0);
    axis.step();
    for control in [0x8f, 15, 6, 0] {
        axis.control(control);
        assert_eq!(axis.drive().state(), DriveState::Fault, "no edge");
    }
    axis.control(0x80);
    assert_eq!((axis.drive().state(), axis.drive().error_code()), (DriveState::SwitchOnDisabled, 0));
    axis.control(6);
    assert_eq!(axis.drive().state(), DriveState::ReadyToSwitchOn);
}

#[test]
fn the_quick_stop_ends_as_its_option_says() {
    for (option, moving, resting) in [
        (0_i16, DriveState::SwitchOnDisabled, DriveState::SwitchOnDisabled),
        (2, DriveState::QuickStopActive, DriveState::SwitchOnDisabled),
        (6, DriveState::QuickStopActive, DriveState::QuickStopActive),
    ] {
        let mut axis = Axis::enabled(9);
        axis.set(0x605a, &option.to_le_bytes());
        axis.drive_mut().set_actual(0, 100_000, 0);
        axis.control(2);
        assert_eq!(axis.drive().state(), moving, "option {option}");
        axis.drive_mut().set_actual(0, 0, 0);
        axis.step();
        assert_eq!(axis.drive().state(), resting, "option {option}");
    }
}

#[test]
fn a_drive_that_leaves_op_faults() {
    let mut axis = Axis::enabled(10);
    let fault = Fault {
        device: 0,
        kind: FaultKind::DropToSafeOp(sinew_segment::AlStatusCode::Watchdog),
        start_ns: 0,
        duration_ns: None,
    };
    axis.0.segment.inject(fault).unwrap();
    axis.step();
    axis.step();
    assert_eq!((axis.drive().state(), axis.drive().error_code()), (DriveState::Fault, 0x7500));
}
