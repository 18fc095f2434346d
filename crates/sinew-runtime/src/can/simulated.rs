//! Simulated nodes on a bus in virtual time, and the machine behind: their set-points move it, its sensors
//! are what they show.

use super::device::{CanDevice, Protocol};
use super::mit::MitMotor;
use crate::cia402::{Axis, Measured, WinchFault};
use crate::virtual_time::Simulated;
use core::f64::consts::TAU;
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::twin::arm::ArmTwin;
use sinew_segment::{CanDrive, CanFrame as Frame, CanNode, MitFamily, MitReadings};
use sinew_session::BusFault;
use std::collections::VecDeque;

/// A machine as built, with its drives on a bus.
#[derive(Debug, Clone)]
pub struct SimulatedMachine {
    arm: ArmTwin,
    nodes: Vec<(CanNode, Axis)>,
    commands: Vec<DriveCommand>,
    started: bool,
    failed: bool,
    stale_for: u32,
    /// Rate of the bus, bit/s, with the times that its frames take; none: they come at once.
    bitrate: Option<u32>,
    /// Frames for the master, and when each has come, ns.
    queue: VecDeque<(Frame, u64)>,
    /// When the bus is free, ns.
    free: u64,
    answers: Vec<Frame>,
    /// Whether motors compute their torques by themselves: many times in a period.
    torques: bool,
}

/// Errors of an axis on CANSimple, and faults of a moteus: encoder, heat, position.
const CANSIMPLE_ERRORS: [u32; 3] = [1 << 3, 1 << 13, 1 << 16];
const MOTEUS_FAULTS: [u32; 3] = [35, 38, 39];
/// Errors of a CubeMars and of a DAMIAO, which has none of its encoder and of the travel.
const CUBEMARS_ERRORS: [u32; 3] = [5, 1, 7];
const DAMIAO_ERRORS: [u32; 3] = [14, 12, 14];
/// Time between two torques of a motor, at most, ns; that of a real one is much shorter.
const TORQUE_TIME: u64 = 1_000_000;
/// Frames under way, at most; more are lost.
const CAPACITY: usize = 4096;

impl SimulatedMachine {
    /// A machine as built; `machine` is its design. `timed` says whether frames take their time on the bus.
    #[must_use]
    pub fn new(arm: ArmTwin, machine: &Machine, devices: &[CanDevice], timed: bool) -> Self {
        let node = |device: &CanDevice| {
            let (drive, parameters) = (device.drive, machine.muscles[device.drive.muscle].drive);
            let node = match device.protocol {
                Protocol::Canopen => CanNode::canopen(device.node, device.identity),
                Protocol::Cansimple => CanNode::cansimple(device.node, (1e9 * machine.watchdog()) as u64),
                Protocol::Moteus => CanNode::moteus(device.node),
                Protocol::Mit => {
                    let ranges = device.mit.as_ref().map_or(MitMotor::USUAL.1, |motor| motor.ranges);
                    CanNode::mit(device.node, ranges)
                }
            };
            (node, Axis { drive, parameters })
        };
        let bitrate = devices.first().map(|device| device.bitrate).filter(|_| timed);
        let mut machine = Self {
            arm,
            nodes: devices.iter().map(node).collect(),
            commands: vec![DriveCommand::Brake; machine.muscles.len()],
            started: false,
            failed: false,
            stale_for: 0,
            bitrate,
            queue: VecDeque::with_capacity(CAPACITY),
            free: 0,
            answers: Vec::with_capacity(256),
            torques: devices.iter().any(|device| device.protocol == Protocol::Mit),
        };
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

    /// Its nodes.
    pub fn nodes(&self) -> impl Iterator<Item = &CanNode> {
        self.nodes.iter().map(|(node, _)| node)
    }

    /// Its nodes, to let them fail.
    pub fn nodes_mut(&mut self) -> impl Iterator<Item = &mut CanNode> {
        self.nodes.iter_mut().map(|(node, _)| node)
    }

    /// Takes over a frame of the master at a time, ns.
    pub fn process(&mut self, frame: &Frame, now: u64) {
        self.free = self.free.max(now) + self.time(frame);
        let Self { nodes, answers, .. } = self;
        nodes.iter_mut().for_each(|(node, _)| node.process(frame, now, answers));
        self.enqueue();
    }

    /// When the next frame for the master has come, ns.
    #[must_use]
    pub fn next_due(&self) -> Option<u64> {
        self.queue.front().map(|(_, at)| *at)
    }

    /// The next frame that has come at a time, ns.
    pub fn take(&mut self, now: u64) -> Option<Frame> {
        if self.next_due()? > now {
            return None;
        }
        self.queue.pop_front().map(|(frame, _)| frame)
    }

    /// The machine follows its drives for a period, ns, that ends at `now`. It is held until one has power.
    pub fn advance(&mut self, period: u64, now: u64) {
        for (node, _) in &mut self.nodes {
            node.advance(now, period, &mut self.answers);
            self.started |= node.has_power();
        }
        self.free = self.free.max(now);
        self.enqueue();
        let parts = if self.torques { period.div_ceil(TORQUE_TIME) } else { 1 };
        for _ in 0..parts {
            if self.started && !self.failed {
                self.command();
                self.failed = self.arm.step(&self.commands, period as f64 * 1e-9 / parts as f64).is_err();
                self.show();
            }
        }
    }

    /// What the drives let the machine do.
    fn command(&mut self) {
        let Self { nodes, commands, arm, .. } = self;
        for (node, axis) in nodes {
            commands[axis.drive.muscle] = match node.drive_mut() {
                CanDrive::Canopen(drive) => axis.command(arm, drive),
                CanDrive::Cansimple(drive) => axis.turns(arm, drive.command()),
                CanDrive::Moteus(drive) => axis.turns(arm, drive.command()),
                CanDrive::Mit(motor) => {
                    let Measured { position, velocity, .. } = axis.measured(arm);
                    let torque = motor.torque(TAU * position, TAU * velocity);
                    let turn = axis.drive.counts_per_turn / axis.parameters.motor.torque_constant;
                    torque.map_or(DriveCommand::Brake, |torque| DriveCommand::Current(torque * turn))
                }
            };
        }
    }

    fn time(&self, frame: &Frame) -> u64 {
        self.bitrate.map_or(0, |rate| frame.time(rate))
    }

    /// The frames of the nodes go over the bus, the one with the lowest identifier first.
    fn enqueue(&mut self) {
        self.answers.sort_unstable_by_key(Frame::id);
        for k in 0..self.answers.len() {
            self.free += self.time(&self.answers[k]);
            if self.queue.len() < CAPACITY {
                self.queue.push_back((self.answers[k], self.free));
            }
        }
        self.answers.clear();
    }

    fn show(&mut self) {
        let Self { nodes, arm, .. } = self;
        for (node, axis) in nodes {
            let (faults, fault) = match node.drive_mut() {
                CanDrive::Canopen(drive) => {
                    axis.show(arm, drive);
                    continue;
                }
                CanDrive::Cansimple(_) => (CANSIMPLE_ERRORS, axis.fault(arm)),
                CanDrive::Moteus(_) => (MOTEUS_FAULTS, axis.fault(arm)),
                CanDrive::Mit(motor) => match motor.family() {
                    // It says of no error, but has no power any more.
                    MitFamily::MiniCheetah | MitFamily::Cubemars => (CUBEMARS_ERRORS, axis.fault(arm)),
                    MitFamily::Damiao => (DAMIAO_ERRORS, axis.fault(arm)),
                },
            };
            match fault {
                Some(WinchFault::Encoder) => node.raise_fault(faults[0]),
                Some(WinchFault::Hot) => node.raise_fault(faults[1]),
                Some(WinchFault::DrumEnd) => node.raise_fault(faults[2]),
                None => {}
            }
            let Measured { position, velocity, current } = axis.measured(arm);
            let (shaft, position, velocity) = ([position, velocity], position as f32, velocity as f32);
            match node.drive_mut() {
                CanDrive::Canopen(_) => {}
                CanDrive::Cansimple(drive) => drive.set_actual(position, velocity, current as f32),
                CanDrive::Moteus(drive) => {
                    let torque = axis.parameters.motor.torque_constant * current;
                    let torque = torque / axis.drive.counts_per_turn.abs();
                    drive.set_actual(position, velocity, torque as f32);
                }
                CanDrive::Mit(motor) => {
                    let torque = axis.parameters.motor.torque_constant / axis.drive.counts_per_turn.abs();
                    let torque = if motor.shows_current() { current } else { torque * current };
                    let [position, velocity] = shaft.map(|turns| TAU * turns);
                    motor.set_actual(MitReadings { position, velocity, torque });
                }
            }
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
