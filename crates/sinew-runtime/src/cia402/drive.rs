//! A drive in the process data: commands in SI units to controlword and set-point, statusword and counts to
//! the cable.

use super::image::{Field, Mapping, NotMapped, ObjectAddress};
use super::state::{DriveState, Goal, controlword};
use crate::rest::braked_speed;
use sinew::drive::{DriveCommand, DriveParameters, MeasuredShaft, SpeedControl, TensionLoop};
use sinew::machine::{DriveDevice, DriveMode};

/// Objects of CiA 402.
pub(crate) const CONTROLWORD: u16 = 0x6040;
pub(crate) const STATUSWORD: u16 = 0x6041;
pub(crate) const MODE: u16 = 0x6060;
pub(crate) const POSITION: u16 = 0x6064;
pub(crate) const VELOCITY: u16 = 0x606c;
pub(crate) const TORQUE: u16 = 0x6077;
const CURRENT: u16 = 0x6078;
const ERROR_CODE: u16 = 0x603f;
const TARGET_TORQUE: u16 = 0x6071;
pub(crate) const TARGET_VELOCITY: u16 = 0x60ff;

/// Modes of operation, object 0x6060.
const CYCLIC_VELOCITY: i8 = 9;
const CYCLIC_TORQUE: i8 = 10;

/// One drive of a running machine.
#[derive(Debug, Clone)]
pub(crate) struct DriveSlot {
    pub(crate) device: DriveDevice,
    parameters: DriveParameters,
    control: Field,
    target: Field,
    status: Field,
    position: Field,
    velocity: Option<Field>,
    /// Per mille of the rated current, or where it is not mapped of the rated torque, which goes with it.
    current: Option<Field>,
    error_code: Option<Field>,
    state: DriveState,
    last_control: u16,
    /// Of the last reading: angle and speed of the motor, rad and rad/s; tension at the outlet, N, NaN as
    /// long as none has been measured: without a load cell nothing limits the speed by it.
    angle: f64,
    speed: f64,
    tension: f64,
    speed_control: SpeedControl,
    tension_loop: TensionLoop,
    running: bool,
    /// Speed of the cable that was commanded last, m/s; in a torque command the one that was measured.
    commanded: f64,
}

/// Mode of operation of a drive, as in object 0x6060.
pub(crate) fn mode_of_operation(mode: DriveMode) -> i8 {
    match mode {
        DriveMode::Velocity => CYCLIC_VELOCITY,
        DriveMode::Torque => CYCLIC_TORQUE,
    }
}

/// Entries of a mapping that serves the cycle: outputs, inputs.
pub(crate) fn desired_mapping(mode: DriveMode) -> [Vec<u32>; 2] {
    let target = match mode {
        DriveMode::Velocity => entry(TARGET_VELOCITY, 32),
        DriveMode::Torque => entry(TARGET_TORQUE, 16),
    };
    let inputs = [(STATUSWORD, 16), (POSITION, 32), (VELOCITY, 32), (TORQUE, 16), (ERROR_CODE, 16)];
    [vec![entry(CONTROLWORD, 16), target], inputs.map(|(index, bits)| entry(index, bits)).to_vec()]
}

fn entry(index: u16, bits: u32) -> u32 {
    (u32::from(index) << 16) | bits
}

impl DriveSlot {
    /// Finds the objects of the drive in its process data.
    ///
    /// # Errors
    /// As [`Mapping::require`].
    pub(crate) fn new(
        name: &str,
        device: DriveDevice,
        parameters: DriveParameters,
        [outputs, inputs]: [&Mapping; 2],
    ) -> Result<Self, NotMapped> {
        let object = |index| ObjectAddress { index, subindex: 0 };
        let (target, octets) = match device.mode {
            DriveMode::Velocity => (TARGET_VELOCITY, 4),
            DriveMode::Torque => (TARGET_TORQUE, 2),
        };
        let velocity = match device.mode {
            DriveMode::Velocity => inputs.find(object(VELOCITY), &[4]),
            DriveMode::Torque => Some(inputs.require(name, object(VELOCITY), &[4])?),
        };
        Ok(Self {
            control: outputs.require(name, object(CONTROLWORD), &[2])?,
            target: outputs.require(name, object(target), &[octets])?,
            status: inputs.require(name, object(STATUSWORD), &[2])?,
            position: inputs.require(name, object(POSITION), &[4])?,
            velocity,
            current: inputs.find(object(CURRENT), &[2]).or_else(|| inputs.find(object(TORQUE), &[2])),
            error_code: inputs.find(object(ERROR_CODE), &[2]),
            state: DriveState::NotReadyToSwitchOn,
            last_control: 0,
            angle: 0.0,
            speed: 0.0,
            tension: f64::NAN,
            speed_control: SpeedControl::new(),
            tension_loop: TensionLoop::of_drive(),
            running: false,
            commanded: 0.0,
            device,
            parameters,
        })
    }

    pub(crate) fn state(&self) -> DriveState {
        self.state
    }

    /// The device left OP: until its drive is read again there is no set-point, and it is enabled from the
    /// beginning.
    pub(crate) fn forget_state(&mut self) {
        (self.state, self.running) = (DriveState::NotReadyToSwitchOn, false);
    }

    /// Writes the controlword that leads towards the command, and its set-point, 0 until the drive is
    /// enabled.
    pub(crate) fn write(&mut self, outputs: &mut [u8], command: DriveCommand, h: f64) {
        let goal = match command {
            DriveCommand::Off => Goal::Disabled,
            DriveCommand::Brake => Goal::Stopped,
            _ => Goal::Enabled,
        };
        let enabled = self.state == DriveState::OperationEnabled && goal == Goal::Enabled;
        if enabled && !self.running {
            self.speed_control.take_over(self.speed);
            self.tension_loop.reset();
        }
        self.running = enabled;
        self.last_control = controlword(self.state, goal, self.last_control);
        self.control.write_word(outputs, self.last_control);
        if !enabled {
            self.commanded = 0.0;
        }
        let target = if enabled { self.set_point(command, h) } else { 0.0 };
        // Casts of floating-point numbers saturate; NaN becomes 0.
        self.target.write(outputs, target.round() as i32);
    }

    /// As [`braked_speed`].
    pub(crate) fn braked_speed(&self, h: f64) -> f64 {
        braked_speed(&self.parameters, self.commanded, h)
    }

    /// In counts/s or per mille of the rated torque.
    fn set_point(&mut self, command: DriveCommand, h: f64) -> f64 {
        let (parameters, device) = (self.parameters, self.device);
        let [_, per_radian] = DriveDevice::cable(&parameters.winch, parameters.reducer.ratio, self.angle);
        let velocity = match command {
            DriveCommand::Velocity(velocity) => velocity,
            DriveCommand::Tension { tension, feed } => {
                let desired = tension.clamp(parameters.min_tension, parameters.max_tension);
                self.tension_loop.speed(desired, self.tension, feed, h)
            }
            DriveCommand::Current(current) if device.mode == DriveMode::Torque => {
                self.commanded = self.speed * per_radian;
                return self.per_mille(parameters.motor.torque_constant * current);
            }
            DriveCommand::Current(_) | DriveCommand::Off | DriveCommand::Brake => 0.0,
        };
        let velocity = if velocity.is_finite() { velocity } else { 0.0 };
        self.commanded = velocity;
        match device.mode {
            DriveMode::Velocity => {
                let limited = parameters.limited_speed(velocity, self.tension);
                self.commanded = limited;
                limited / per_radian * (device.counts_per_turn / core::f64::consts::TAU)
            }
            DriveMode::Torque => {
                let arm = per_radian * parameters.reducer.ratio;
                let tension = if self.tension.is_finite() { self.tension } else { 0.0 };
                let measured = MeasuredShaft { tension, speed: self.speed, arm };
                let torque = self.speed_control.torque(&parameters, velocity, measured, h);
                self.per_mille(torque)
            }
        }
    }

    fn per_mille(&self, torque: f64) -> f64 {
        1000.0 * torque / self.device.rated_torque * self.device.counts_per_turn.signum()
    }

    /// Reads the inputs: position of the cable, m, and the error code where the drive reports a fault or has
    /// left operation without being told.
    pub(crate) fn read(&mut self, inputs: &[u8]) -> (f64, Option<u16>) {
        self.state = DriveState::from_statusword(self.status.word(inputs).unwrap_or(0));
        let counts = self.position.signed(inputs).map_or(f64::NAN, f64::from);
        self.angle = self.device.angle(counts);
        let per_count = core::f64::consts::TAU / self.device.counts_per_turn;
        self.speed = self.velocity.and_then(|field| field.signed(inputs)).map_or(0.0, f64::from) * per_count;
        let left = self.running && self.state != DriveState::OperationEnabled;
        let fault = left || matches!(self.state, DriveState::Fault | DriveState::FaultReactionActive);
        let [cable, _] =
            DriveDevice::cable(&self.parameters.winch, self.parameters.reducer.ratio, self.angle);
        (cable, fault.then(|| self.error_code(inputs)))
    }

    /// Current of the motor, A, + winds in; NaN where the drive does not say.
    pub(crate) fn current(&self, inputs: &[u8]) -> f64 {
        let per_mille = self.current.and_then(|field| field.signed(inputs)).map_or(f64::NAN, f64::from);
        let rated = self.device.rated_torque / self.parameters.motor.torque_constant;
        1e-3 * per_mille * rated * self.device.counts_per_turn.signum()
    }

    /// Error code of the drive, 0 where it is not in the process data.
    pub(crate) fn error_code(&self, inputs: &[u8]) -> u16 {
        self.error_code.and_then(|field| field.word(inputs)).unwrap_or(0)
    }

    /// The tension that limits its speed and is fed forward, N: the last one that was measured.
    pub(crate) fn set_tension(&mut self, tension: f64) {
        if tension.is_finite() {
            self.tension = tension;
        }
    }
}
