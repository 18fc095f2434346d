//! One axis: commands of the master in, command to the motor out, actual values back.
//!
//! Source: IEC 61800-7-201 and CiA 402-2: state machine, option codes, cyclic synchronous modes, limits.

use super::DriveState;
use super::objects::Objects;
use super::state::{Command, FAULT_RESET};
use crate::dictionary::Dictionary;

/// Error codes of the drive itself.
const FOLLOWING_ERROR: u16 = 0x8611;
const COMMUNICATION_ERROR: u16 = 0x7500;
/// Bits of the statusword beside the state.
const VOLTAGE: u16 = 1 << 4;
const REMOTE: u16 = 1 << 9;
const LIMIT: u16 = 1 << 11;
const FOLLOWS: u16 = 1 << 12;
const FOLLOWING: u16 = 1 << 13;
/// Generic bit of the error register.
const GENERIC_ERROR: i64 = 1;
/// A motor slower than this, counts/s, is at rest; a stop that takes longer than this, ns, is ended.
const REST: i64 = 100;
const LONGEST_STOP_NS: u64 = 2_000_000_000;
/// The largest torque that the type of the target holds, per mille.
const MAX_TORQUE: i64 = 0x7fff;
/// A following error window of this size is none.
const NO_WINDOW: i64 = 0xffff_ffff;

/// What the drive asks of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AxisCommand {
    /// No torque.
    Off,
    /// Stop as fast as the quick stop deceleration (object 0x6085) allows, then hold. Also without a mode of
    /// operation.
    QuickStop,
    /// Follow a velocity, counts/s.
    Velocity(i32),
    /// Follow a position, counts.
    Position(i32),
    /// Follow a torque, per mille of the rated torque.
    Torque(i16),
}

/// Mode of operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Mode {
    /// None, or one that the drive does not have.
    None,
    /// Cyclic synchronous position.
    Position,
    /// Cyclic synchronous velocity.
    Velocity,
    /// Cyclic synchronous torque.
    Torque,
}

impl Mode {
    fn from_number(number: i64) -> Self {
        match number {
            8 => Self::Position,
            9 => Self::Velocity,
            10 => Self::Torque,
            _ => Self::None,
        }
    }

    /// The number in objects 0x6060 and 0x6061.
    #[must_use]
    pub fn number(self) -> i8 {
        match self {
            Self::None => 0,
            Self::Position => 8,
            Self::Velocity => 9,
            Self::Torque => 10,
        }
    }
}

/// A fault to be told to the master: error code and error register.
pub(crate) type Emergency = (u16, u8);

/// A drive; its objects are in the device's dictionary.
#[derive(Debug, Clone)]
pub struct Drive {
    objects: Objects,
    state: DriveState,
    mode: Mode,
    last_controlword: u16,
    error: u16,
    command: AxisCommand,
    limited: bool,
    beyond_window_ns: u64,
    stopping_ns: u64,
    actual: (i32, i32, i16),
    emergency: Option<Emergency>,
}

impl Drive {
    pub(crate) fn new(dictionary: &Dictionary) -> Self {
        Self {
            objects: Objects::find(dictionary),
            state: DriveState::NotReadyToSwitchOn,
            mode: Mode::None,
            last_controlword: 0,
            error: 0,
            command: AxisCommand::Off,
            limited: false,
            beyond_window_ns: 0,
            stopping_ns: 0,
            actual: (0, 0, 0),
            emergency: None,
        }
    }

    /// What the motor shall do now.
    #[must_use]
    pub fn command(&self) -> AxisCommand {
        self.command
    }

    /// Whether the holding brake is released.
    #[must_use]
    pub fn brake_released(&self) -> bool {
        self.state.has_power()
    }

    /// State of the drive.
    #[must_use]
    pub fn state(&self) -> DriveState {
        self.state
    }

    /// Mode in effect.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Error code of the present or last fault; 0 is none.
    #[must_use]
    pub fn error_code(&self) -> u16 {
        self.error
    }

    /// Position in counts, velocity in counts/s and torque in per mille of the rated torque, as measured. The
    /// master sees them after the next [`Segment::advance`](crate::Segment::advance).
    pub fn set_actual(&mut self, position: i32, velocity: i32, torque: i16) {
        self.actual = (position, velocity, torque);
    }

    /// The drive detects a fault; the fault reaction begins.
    pub fn raise_fault(&mut self, code: u16) {
        if matches!(self.state, DriveState::Fault | DriveState::FaultReactionActive) {
            return;
        }
        self.error = code;
        self.emergency = Some((code, GENERIC_ERROR as u8));
        self.stopping_ns = 0;
        let moving = self.state.has_power();
        self.state = if moving { DriveState::FaultReactionActive } else { DriveState::Fault };
        self.command = if moving { AxisCommand::QuickStop } else { AxisCommand::Off };
    }

    /// The master does not command any more: a fault where the motor had torque.
    pub(crate) fn outputs_lost(&mut self) {
        if matches!(self.state, DriveState::OperationEnabled | DriveState::QuickStopActive) {
            self.raise_fault(COMMUNICATION_ERROR);
        }
    }

    pub(crate) fn take_emergency(&mut self) -> Option<Emergency> {
        self.emergency.take()
    }

    /// The firmware's cycle: `elapsed` ns have passed since the last one.
    pub(crate) fn step(&mut self, dictionary: &mut Dictionary, elapsed: u64) {
        self.follow_controlword(dictionary);
        self.follow_stop(dictionary, elapsed);
        self.mode = Mode::from_number(dictionary.get(self.objects.mode));
        (self.command, self.limited) = match self.state {
            DriveState::OperationEnabled => self.target(dictionary),
            DriveState::QuickStopActive | DriveState::FaultReactionActive => (AxisCommand::QuickStop, false),
            _ => (AxisCommand::Off, false),
        };
        let following = self.supervise_following(dictionary, elapsed);
        self.show(dictionary, following);
    }

    fn follow_controlword(&mut self, dictionary: &Dictionary) {
        let controlword = dictionary.get(self.objects.controlword) as u16;
        let reset = controlword & !self.last_controlword & FAULT_RESET != 0;
        self.last_controlword = controlword;
        if self.state == DriveState::Fault {
            if reset {
                (self.state, self.error) = (DriveState::SwitchOnDisabled, 0);
            }
            return;
        }
        let option = dictionary.get(self.objects.quick_stop_option);
        let next = self.state.next(Command::from_controlword(controlword), option >= 5);
        if next == DriveState::QuickStopActive && self.state != next {
            self.stopping_ns = 0;
        }
        self.state = next;
    }

    /// A stop ends at rest, or at once where its option says so.
    fn follow_stop(&mut self, dictionary: &Dictionary, elapsed: u64) {
        self.stopping_ns = self.stopping_ns.saturating_add(elapsed);
        let at_rest = i64::from(self.actual.1).abs() <= REST || self.stopping_ns > LONGEST_STOP_NS;
        match self.state {
            DriveState::QuickStopActive => {
                let option = dictionary.get(self.objects.quick_stop_option);
                if option == 0 || (at_rest && option < 5) {
                    self.state = DriveState::SwitchOnDisabled;
                }
            }
            DriveState::FaultReactionActive if at_rest || dictionary.get(self.objects.fault_option) == 0 => {
                self.state = DriveState::Fault;
            }
            _ => {}
        }
    }

    /// The command of the mode, and whether a limit has changed it.
    fn target(&self, dictionary: &Dictionary) -> (AxisCommand, bool) {
        let objects = &self.objects;
        let get = |slot| dictionary.get(slot);
        let (low, high) = (get(objects.min_position), get(objects.max_position));
        let (position, velocity) = (i64::from(self.actual.0), i64::from(self.actual.1));
        // Limits of which the lower is not below the upper are none.
        let (at_low, at_high) = (low < high && position <= low, low < high && position >= high);
        match self.mode {
            Mode::None => (AxisCommand::QuickStop, false),
            Mode::Position => {
                let desired = get(objects.target_position);
                let allowed = if low < high { desired.clamp(low, high) } else { desired };
                (AxisCommand::Position(allowed as i32), allowed != desired)
            }
            Mode::Velocity => {
                let desired = get(objects.target_velocity) + get(objects.velocity_offset);
                let most = max_velocity(dictionary, objects);
                let allowed = desired.clamp(if at_low { 0 } else { -most }, if at_high { 0 } else { most });
                (AxisCommand::Velocity(allowed as i32), allowed != desired)
            }
            Mode::Torque => {
                let desired = get(objects.target_torque) + get(objects.torque_offset);
                let most = objects.max_torque.map_or(MAX_TORQUE, |slot| get(Some(slot)).min(MAX_TORQUE));
                let speed = max_velocity(dictionary, objects);
                let lowest = if at_low || velocity < -speed { 0 } else { -most };
                let highest = if at_high || velocity > speed { 0 } else { most };
                let allowed = desired.clamp(lowest, highest);
                (AxisCommand::Torque(allowed as i16), allowed != desired)
            }
        }
    }

    /// Whether the actual position is outside of the window around the demand; a fault where it stays there.
    fn supervise_following(&mut self, dictionary: &mut Dictionary, elapsed: u64) -> bool {
        let AxisCommand::Position(demand) = self.command else {
            self.beyond_window_ns = 0;
            dictionary.set(self.objects.position_demand, i64::from(self.actual.0));
            dictionary.set(self.objects.following_error, 0);
            return false;
        };
        let error = i64::from(demand) - i64::from(self.actual.0);
        dictionary.set(self.objects.position_demand, i64::from(demand));
        dictionary.set(self.objects.following_error, error);
        let window = self.objects.following_window.map_or(NO_WINDOW, |slot| dictionary.get(Some(slot)));
        let beyond = window != NO_WINDOW && error.abs() > window;
        self.beyond_window_ns = if beyond { self.beyond_window_ns.saturating_add(elapsed) } else { 0 };
        let limit_ns = dictionary.get(self.objects.following_timeout) as u64 * 1_000_000;
        if beyond && elapsed > 0 && self.beyond_window_ns > limit_ns {
            self.raise_fault(FOLLOWING_ERROR);
        }
        beyond
    }

    fn show(&self, dictionary: &mut Dictionary, following: bool) {
        let flag = |set: bool, bit: u16| if set { bit } else { 0 };
        let enabled = self.state == DriveState::OperationEnabled;
        let statusword = self.state.statusword()
            | VOLTAGE
            | REMOTE
            | flag(self.limited, LIMIT)
            | flag(enabled && self.mode != Mode::None, FOLLOWS)
            | flag(following, FOLLOWING);
        let objects = &self.objects;
        dictionary.set(objects.statusword, i64::from(statusword));
        dictionary.set(objects.mode_display, i64::from(self.mode.number()));
        dictionary.set(objects.error_code, i64::from(self.error));
        dictionary.set(objects.error_register, if self.error == 0 { 0 } else { GENERIC_ERROR });
        dictionary.set(objects.position, i64::from(self.actual.0));
        dictionary.set(objects.velocity, i64::from(self.actual.1));
        dictionary.set(objects.torque, i64::from(self.actual.2));
    }
}

/// Object 0x6080 in counts/s; without it the range of the type.
fn max_velocity(dictionary: &Dictionary, objects: &Objects) -> i64 {
    let (Some(_), Some(_)) = (objects.max_speed, objects.increments) else { return i64::from(i32::MAX) };
    let counts = dictionary.get(objects.increments).max(1);
    let revolutions = objects.revolutions.map_or(1, |slot| dictionary.get(Some(slot))).max(1);
    let per_minute = dictionary.get(objects.max_speed).saturating_mul(counts) / revolutions;
    (per_minute / 60).min(i64::from(i32::MAX))
}
