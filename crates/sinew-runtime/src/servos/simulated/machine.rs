//! The simulated machine behind simulated servos: their goals move it, its sensors fill their tables.

use super::chain::SimulatedChain;
use super::servo::{ENCODER, OVERHEATING, OVERLOAD, ServoGoal, SimulatedServo};
use crate::servos::device::ServoDevice;
use crate::servos::registers::BAUD;
use crate::servos::series::Series;
use crate::virtual_time::Simulated;
use sinew::drive::{DriveCommand, DriveFault, DriveParameters};
use sinew::machine::{DriveDevice, Machine};
use sinew::twin::arm::ArmTwin;
use sinew_session::BusFault;

/// A machine as built, with its servos on their lines.
#[derive(Debug, Clone)]
pub struct SimulatedMachine {
    arm: ArmTwin,
    chains: Vec<SimulatedChain>,
    servos: Vec<Place>,
    commands: Vec<DriveCommand>,
    started: bool,
    failed: bool,
    stale_for: u32,
}

/// A servo of the machine.
#[derive(Debug, Clone)]
struct Place {
    chain: usize,
    servo: usize,
    drive: DriveDevice,
    /// Of the design, from which it was configured.
    parameters: DriveParameters,
}

/// Speed with which a servo approaches a position, per s.
const POSITION_GAIN: f64 = 80.0;

impl SimulatedMachine {
    /// A machine as built; `machine` is its design. Its servos are on one line for each of `ports`, which
    /// are as in [`ServoDevice::port`]; `heard` says whether every servo hears everything, at any rate.
    #[must_use]
    pub fn new(
        arm: ArmTwin,
        machine: &Machine,
        devices: &[ServoDevice],
        ports: &[Option<String>],
        heard: bool,
    ) -> Self {
        let (mut chains, mut servos) = (Vec::new(), Vec::new());
        for (chain, port) in ports.iter().enumerate() {
            let on_port = || devices.iter().filter(|device| device.port == *port);
            let baud = on_port().next().map_or(BAUD[3], |device| device.baud);
            let series = on_port().next().map_or(Series::X, |device| device.model.series);
            let number = series.baud().iter().position(|rate| *rate == baud).unwrap_or(0) as u8;
            for (servo, device) in on_port().enumerate() {
                let (drive, parameters) = (device.drive, machine.muscles[device.drive.muscle].drive);
                servos.push(Place { chain, servo, drive, parameters });
            }
            let simulated =
                on_port().map(|device| SimulatedServo::new(device.model.clone(), device.id, number));
            chains.push(SimulatedChain::new(simulated.collect(), (!heard).then_some(baud)));
        }
        let commands = vec![DriveCommand::Brake; machine.muscles.len()];
        let mut machine = Self { arm, chains, servos, commands, started: false, failed: false, stale_for: 0 };
        machine.show();
        machine
    }

    /// The machine.
    #[must_use]
    pub fn arm(&self) -> &ArmTwin {
        &self.arm
    }

    /// Whether it moved faster than the laws of its cables allow; it stands since.
    #[must_use]
    pub fn failed(&self) -> bool {
        self.failed
    }

    /// Its chains, a line each.
    #[must_use]
    pub fn chains(&self) -> &[SimulatedChain] {
        &self.chains
    }

    /// Its chains, to talk to them or to let servos fail.
    pub fn chains_mut(&mut self) -> &mut [SimulatedChain] {
        &mut self.chains
    }

    /// The machine follows the goals of its servos for a period, ns, that ends at `now`, and shows its
    /// measurements. It is held until all of them have had torque.
    pub fn advance(&mut self, period: u64, now: u64) {
        let Self { chains, servos, commands, .. } = self;
        chains.iter_mut().for_each(|chain| chain.watch(now));
        let all = chains.iter().flat_map(SimulatedChain::servos);
        self.started = self.started || all.clone().all(SimulatedServo::has_torque);
        if !self.started || self.failed {
            return;
        }
        for place in servos.iter() {
            let Some(servo) = chains.get(place.chain).and_then(|chain| chain.servos().get(place.servo))
            else {
                continue;
            };
            commands[place.drive.muscle] = place.command(servo, &self.arm);
        }
        self.failed = self.arm.step(&self.commands, period as f64 * 1e-9).is_err();
        self.show();
    }

    /// All measurements.
    fn show(&mut self) {
        let truth = self.arm.truth();
        for place in &self.servos {
            let muscle = place.drive.muscle;
            let chain = self.chains.get_mut(place.chain);
            let Some(servo) = chain.and_then(|chain| chain.servos_mut().get_mut(place.servo)) else {
                continue;
            };
            let angle = place.motor_angle(&self.arm);
            if !angle.is_finite() {
                servo.raise(ENCODER);
                continue;
            }
            match truth.drives[muscle].fault {
                Some(DriveFault::Hot { .. }) => servo.raise(OVERHEATING),
                Some(DriveFault::DrumFull | DriveFault::DrumEmpty) => servo.raise(OVERLOAD),
                None => {}
            }
            let sign = place.drive.counts_per_turn.signum();
            let speed = truth.drives[muscle].speed / place.arm(angle) * sign;
            let current = self.arm.reading().current[muscle] * sign;
            let position = place.drive.counts(angle).round() as i32;
            servo.show(current, speed, position, self.arm.winding(muscle));
        }
    }
}

impl Simulated for SimulatedMachine {
    fn injected(&mut self, period: u64) -> Option<BusFault> {
        BusFault::injected(self.arm.exchange_failure(), &mut self.stale_for, period as f64 * 1e-9)
    }

    fn advance(&mut self, period: u64, now: u64) {
        Self::advance(self, period, now);
    }
}

impl Place {
    /// The goal of a servo in SI units.
    fn command(&self, servo: &SimulatedServo, arm: &ArmTwin) -> DriveCommand {
        let (angle, sign) = (self.motor_angle(arm), self.drive.counts_per_turn.signum());
        match servo.goal() {
            ServoGoal::Off => DriveCommand::Off,
            ServoGoal::Velocity(speed) => DriveCommand::Velocity(speed * sign * self.arm(angle)),
            ServoGoal::Current(current) => DriveCommand::Current(current * sign),
            ServoGoal::Position(counts) => {
                let ahead = (self.drive.angle(f64::from(counts)) - angle) / self.parameters.reducer.ratio;
                DriveCommand::Velocity(POSITION_GAIN * ahead * self.arm(angle))
            }
        }
    }

    /// Angle of the motor by its encoder, rad; NaN where the encoder gives none.
    fn motor_angle(&self, arm: &ArmTwin) -> f64 {
        let muscle = self.drive.muscle;
        let built = &arm.specimen().drives[muscle];
        built.winch.angle(arm.reading().motor[muscle]) * built.reducer.ratio
    }

    /// Cable per angle of the horn, m/rad.
    fn arm(&self, angle: f64) -> f64 {
        let ratio = self.parameters.reducer.ratio;
        DriveDevice::cable(&self.parameters.winch, ratio, angle)[1] * ratio
    }
}
