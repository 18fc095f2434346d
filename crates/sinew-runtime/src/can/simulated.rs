//! Simulated nodes on a bus in virtual time, and the machine behind: their set-points move it, its sensors
//! are what they show.

use super::device::{CanDevice, Protocol};
use crate::cia402::{Axis, Measured, WinchFault};
use crate::virtual_time::Simulated;
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::twin::arm::ArmTwin;
use sinew_segment::{CanDrive, CanFrame as Frame, CanNode};
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
}

/// Errors of an axis on CANSimple, and faults of a moteus: encoder, heat, position.
const CANSIMPLE_ERRORS: [u32; 3] = [1 << 3, 1 << 13, 1 << 16];
const MOTEUS_FAULTS: [u32; 3] = [35, 38, 39];
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
        let Self { nodes, answers, commands, arm, .. } = self;
        for (node, axis) in nodes.iter_mut() {
            node.advance(now, period, answers);
            self.started |= node.has_power();
            commands[axis.drive.muscle] = match node.drive_mut() {
                CanDrive::Canopen(drive) => axis.command(arm, drive),
                CanDrive::Cansimple(drive) => axis.turns(arm, drive.command()),
                CanDrive::Moteus(drive) => axis.turns(arm, drive.command()),
            };
        }
        self.free = self.free.max(now);
        self.enqueue();
        if self.started && !self.failed {
            self.failed = self.arm.step(&self.commands, period as f64 * 1e-9).is_err();
            self.show();
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
            };
            match fault {
                Some(WinchFault::Encoder) => node.raise_fault(faults[0]),
                Some(WinchFault::Hot) => node.raise_fault(faults[1]),
                Some(WinchFault::DrumEnd) => node.raise_fault(faults[2]),
                None => {}
            }
            let Measured { position, velocity, current } = axis.measured(arm);
            let (position, velocity) = (position as f32, velocity as f32);
            match node.drive_mut() {
                CanDrive::Canopen(_) => {}
                CanDrive::Cansimple(drive) => drive.set_actual(position, velocity, current as f32),
                CanDrive::Moteus(drive) => {
                    let torque = axis.parameters.motor.torque_constant * current;
                    let torque = torque / axis.drive.counts_per_turn.abs();
                    drive.set_actual(position, velocity, torque as f32);
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
