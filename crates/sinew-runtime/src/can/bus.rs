//! Nodes in operation: commands, then SYNC; the answers to it are collected when the next cycle begins.

use super::bring_up::{
    Configuring, EMERGENCY, HEARTBEAT, HEARTBEAT_MS, INPUTS, OUTPUTS, PRE_OPERATIONAL, START, TO_MASTER,
    TO_NODE, manage,
};
use super::device::{CanDevice, MASTER};
use super::error::CanError;
use super::sdo::SdoClient;
use super::{Link, SimulatedMachine};
use crate::cia402::{DriveSlot, DriveState, Mapping};
use crate::rest::{Drives, bring_to_rest};
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::twin::arm::ArmTwin;
use sinew_segment::CanFrame as Frame;
use sinew_session::{BusFault, Exchange, Feedback, Plant, watchdog};

/// Nodes that matched the machine and are configured. It owns them: dropped it brings them to rest.
#[derive(Debug)]
pub struct CanBus<L: Link> {
    link: L,
    nodes: Vec<Node>,
    out: Vec<Frame>,
    muscles: usize,
    /// Control period and time between two heartbeats of the master, ns.
    period: u64,
    heartbeat: u64,
    next_heartbeat: u64,
    /// When the cycle began, and when commands were last written, ns.
    begin: u64,
    commanded: Option<u64>,
    in_operation: bool,
    /// Whether the last writing did not leave the computer.
    lost: bool,
}

#[derive(Debug)]
struct Node {
    device: CanDevice,
    drive: DriveSlot,
    inputs: [u8; 8],
    /// SYNCs without an answer.
    silent: u32,
    /// When it was heard last in its heartbeat, ns.
    alive: u64,
    /// Whether it has answered a SYNC, and has left operation since: it does not come back by itself.
    operational: bool,
    left: bool,
    /// Whether its drive is to be enabled, and for how many cycles it has not been.
    wanted: bool,
    waiting: u64,
    /// Code of its emergency; 0 is none.
    emergency: u16,
    cable: f64,
    fault: Option<u16>,
}

/// A node that answers no SYNC for so many cycles counts as missing.
const SILENT_CYCLES: u32 = 3;
/// Since the beginning of a cycle, when answers are waited for no longer: a fraction of the period.
const READ_FRACTION: f64 = 0.5;
/// Part of the period that the bus may be busy.
const BUS_FRACTION: f64 = 0.95;
/// Codes of [`BusFault::NotReady`].
const SILENT: u16 = 0;
pub(super) const HEARTBEAT_LOST: u16 = 1;
pub(super) const RESTARTED: u16 = 2;
/// Time without a heartbeat of a node after which it is lost, ns.
const HEARTBEAT_PATIENCE: u64 = 4 * HEARTBEAT_MS as u64 * 1_000_000;
/// State of an operational node in its heartbeat.
const OPERATIONAL: u8 = 5;
/// Time until all nodes answer without a fault, and until a drive is enabled, at most, ns.
const START_TIME: u64 = 4_000_000_000;
const ENABLE_TIME: u64 = 500_000_000;
/// Cycles of any such time, at least: a drive takes one state after the other.
const MIN_CYCLES: u64 = 8;

impl<L: Link> CanBus<L> {
    /// Finds the nodes of a machine, sets them up and reads everything back. None has power until the first
    /// command.
    ///
    /// # Errors
    /// The first node that is missing, another one, faulty, or does not take what it is told.
    pub fn start(mut link: L, machine: &Machine, devices: &[CanDevice]) -> Result<Self, CanError> {
        if let Some(of) = machine.devices.iter().find(|of| !of.channels().is_empty()) {
            return Err(CanError::Sensor { device: of.name.clone() });
        }
        if devices.len() != machine.devices.iter().filter(|of| of.driven_muscle().is_some()).count() {
            return Err(CanError::OtherBus);
        }
        check(devices, machine.period)?;
        let mut client = SdoClient::new(&mut link);
        for device in devices {
            Configuring { client: &mut client, device }.configure(machine)?;
        }
        let (mut outputs, mut inputs) = (Mapping::default(), Mapping::default());
        OUTPUTS.iter().for_each(|entry| outputs.push(*entry));
        INPUTS.iter().for_each(|entry| inputs.push(*entry));
        let alive = link.now();
        let node = |device: &CanDevice| {
            let parameters = machine.muscles[device.drive.muscle].drive;
            let drive = DriveSlot::new(&device.name, device.drive, parameters, [&outputs, &inputs])
                .map_err(|error| device.wrong(error.to_string()))?;
            Ok(Node {
                device: device.clone(),
                drive,
                inputs: [0; 8],
                silent: 0,
                alive,
                operational: false,
                left: false,
                wanted: false,
                waiting: 0,
                emergency: 0,
                cable: f64::NAN,
                fault: None,
            })
        };
        let mut bus = Self {
            nodes: devices.iter().map(node).collect::<Result<_, CanError>>()?,
            link,
            out: Vec::with_capacity(devices.len() + 4),
            muscles: machine.muscles.len(),
            period: machine.period_ns(),
            heartbeat: (0.25e9 * watchdog(machine.period)) as u64,
            next_heartbeat: 0,
            begin: alive,
            commanded: None,
            in_operation: true,
            lost: false,
        };
        bus.probe()?;
        Ok(bus)
    }

    /// Starts the nodes and exchanges process data until all answer and no drive has a fault. The master
    /// sends no heartbeat yet, so that none watches for the next before the first command.
    fn probe(&mut self) -> Result<(), CanError> {
        let start: Vec<Frame> = self.nodes.iter().map(|node| manage(START, node.device.node)).collect();
        let port = |source| CanError::Port { port: "the adapter".to_owned(), source };
        self.link.send(&start).map_err(port)?;
        let off = vec![DriveCommand::Off; self.muscles];
        let mut feedback = Feedback::new(self.muscles, 0);
        let ready = |node: &Node| node.silent == 0 && node.drive.state() == DriveState::SwitchOnDisabled;
        for _ in 0..self.cycles_of(START_TIME) {
            self.exchange(&off);
            self.link.rest_until(self.begin.saturating_add(self.period));
            self.read(&mut feedback);
            if self.nodes.iter().all(ready) {
                // What was reported until here belongs to an earlier run.
                self.nodes.iter_mut().for_each(|node| node.emergency = 0);
                // The first cycle finds its readings as every other.
                self.exchange(&off);
                return Ok(());
            }
            if let Some(node) = self.nodes.iter().find(|node| node.left) {
                return Err(node.device.wrong("starts anew"));
            }
        }
        let node = self.nodes.iter().find(|node| !ready(node)).ok_or(CanError::OtherBus)?;
        let (state, code) = (node.drive.state(), node.emergency);
        Err(node.device.wrong(if node.silent > 0 {
            "does not answer to SYNC".to_owned()
        } else {
            format!("stays in state {state:?}, emergency {code:#06x}")
        }))
    }

    /// Sends commands and SYNC.
    fn exchange(&mut self, commands: &[DriveCommand]) {
        let h = self.period as f64 * 1e-9;
        for node in &mut self.nodes {
            let command = commands.get(node.device.drive.muscle).copied().unwrap_or(DriveCommand::Brake);
            node.wanted = !matches!(command, DriveCommand::Off | DriveCommand::Brake);
            let mut octets = [0; 6];
            node.drive.write(&mut octets, command, h);
            self.out.push(Frame::new(TO_NODE + u16::from(node.device.node), &octets));
        }
        self.out.push(Frame::new(0x80, &[]));
        self.lost = self.link.send(&self.out).is_err();
        self.out.clear();
    }

    /// The link.
    pub fn link_mut(&mut self) -> &mut L {
        &mut self.link
    }

    /// Collects answers until all have come or the deadline has; whether any came.
    fn gather(&mut self, deadline: u64) -> bool {
        let (mut left, mut any) = (self.nodes.len(), false);
        self.nodes.iter_mut().for_each(|node| node.silent = node.silent.saturating_add(1));
        while left > 0 {
            let Ok(Some(frame)) = self.link.receive(deadline) else { break };
            let of = frame.id() & 0x7f;
            let Some(node) = self.nodes.iter_mut().find(|node| u16::from(node.device.node) == of) else {
                continue;
            };
            any = true;
            left -= usize::from(node.take(&frame, self.begin));
        }
        any
    }

    /// Takes over the readings of the nodes that answered; the first thing that is wrong.
    fn take_over(&mut self, feedback: &mut Feedback) -> Option<BusFault> {
        let age = self.commanded.map_or(f64::NAN, |at| self.begin.saturating_sub(at) as f64 * 1e-3);
        feedback.setpoint_age.fill(age);
        let (mut fault, mut silent) = (None, None);
        let patience = self.cycles_of(ENABLE_TIME);
        for node in &mut self.nodes {
            let (muscle, device) = (node.device.drive.muscle, node.device.device);
            let not_ready = |code, muscle| BusFault::NotReady { device, code, muscle };
            if node.left {
                node.drive.forget_state();
                fault = fault.or(Some(not_ready(RESTARTED, Some(muscle))));
                continue;
            }
            if node.silent > 0 {
                // One that is silent for long is missing; until then its reading is bridged.
                if node.silent >= SILENT_CYCLES {
                    fault = fault.or(Some(not_ready(SILENT, Some(muscle))));
                } else {
                    silent = silent.or(Some(not_ready(SILENT, None)));
                }
                continue;
            }
            let waits = node.wanted && node.drive.state() != DriveState::OperationEnabled;
            node.waiting = if waits { node.waiting + 1 } else { 0 };
            let refuses = node.waiting > patience;
            if node.emergency != 0 || node.fault.is_some() || refuses {
                let code = if node.emergency == 0 { node.fault.unwrap_or(0) } else { node.emergency };
                fault = fault.or(Some(BusFault::Drive { muscle, code }));
            } else if self.begin.saturating_sub(node.alive) > HEARTBEAT_PATIENCE {
                fault = fault.or(Some(not_ready(HEARTBEAT_LOST, Some(muscle))));
            }
            feedback.motor[muscle] = node.cable;
            feedback.current[muscle] = node.drive.current(&node.inputs);
        }
        fault.or(silent)
    }

    /// Brings all drives to rest without power, and ends their operation.
    fn end_operation(&mut self) {
        if !std::mem::take(&mut self.in_operation) {
            return;
        }
        bring_to_rest(self);
        // Where the adapter is gone, the watchdogs of the nodes have stopped them.
        let end: Vec<Frame> =
            self.nodes.iter().map(|node| manage(PRE_OPERATIONAL, node.device.node)).collect();
        let _ = self.link.send(&end);
    }
}

impl Node {
    /// Takes over a frame of the node that comes in a cycle which began at `now`; whether it is the first
    /// answer to SYNC.
    fn take(&mut self, frame: &Frame, now: u64) -> bool {
        match (frame.id() & !0x7f, frame.octets()) {
            (TO_MASTER, octets) => {
                let Some(inputs) = octets.first_chunk() else { return false };
                let first = self.silent > 0;
                (self.inputs, self.silent, self.operational) = (*inputs, 0, true);
                (self.cable, self.fault) = self.drive.read(inputs);
                return first;
            }
            // Code 0 says that an earlier one is over, which does not undo it in this run.
            (EMERGENCY, [low, high, ..]) => {
                let code = u16::from_le_bytes([*low, *high]);
                self.emergency = if code == 0 { self.emergency } else { code };
            }
            (HEARTBEAT, [state]) => {
                self.alive = now;
                self.left |= self.operational && state & 0x7f != OPERATIONAL;
            }
            _ => {}
        }
        false
    }
}

/// Refuses nodes that cannot be on one bus, and a bus that is too slow for the period, s.
fn check(devices: &[CanDevice], period: f64) -> Result<(), CanError> {
    for (k, device) in devices.iter().enumerate() {
        for other in &devices[..k] {
            let expected = if other.node == device.node {
                "each a node of its own"
            } else if other.bitrate != device.bitrate {
                "the same bitrate"
            } else if other.port != device.port {
                "the same port: a machine has one bus"
            } else {
                continue;
            };
            let (device, other) = (device.name.clone(), other.name.clone());
            return Err(CanError::Bus { device, other, expected });
        }
    }
    let Some(CanDevice { bitrate, .. }) = devices.first() else { return Err(CanError::OtherBus) };
    let bits = |octets: usize| Frame::new(0, &[0; 8][..octets]).bits() as f64;
    // SYNC and a heartbeat of the master, PDOs both ways, and their share of the nodes' heartbeats.
    let share = (1e3 * period / f64::from(HEARTBEAT_MS)).min(1.0);
    let (nodes, bitrate) = (devices.len(), *bitrate);
    let each = bits(6) + bits(8) + share * bits(1);
    let needed = (bits(0) + bits(1) + nodes as f64 * each) / f64::from(bitrate);
    if needed > BUS_FRACTION * period {
        return Err(CanError::Slow { nodes, bitrate, needed, period });
    }
    Ok(())
}

impl<L: Link> Drives for CanBus<L> {
    fn dimensions(&self) -> [usize; 2] {
        [self.muscles, 0]
    }

    fn slow_down(&self, commands: &mut [DriveCommand]) -> bool {
        let h = self.period as f64 * 1e-9;
        let mut standing = true;
        for node in &self.nodes {
            let speed = node.drive.braked_speed(h);
            standing &= speed == 0.0;
            // One that is not enabled does not get power for it.
            let enabled = node.drive.state() == DriveState::OperationEnabled;
            commands[node.device.drive.muscle] =
                if enabled { DriveCommand::Velocity(speed) } else { DriveCommand::Off };
        }
        standing
    }

    fn are_without_power(&self, _last: Exchange) -> bool {
        self.nodes.iter().all(|node| node.silent == 0 && !node.drive.state().has_torque())
    }

    fn write_and_wait(&mut self, commands: &[DriveCommand]) {
        self.write(commands);
        self.link.rest_until(self.begin.saturating_add(self.period));
    }

    fn cycles_of(&self, time: u64) -> u64 {
        (time / self.period.max(1)).max(MIN_CYCLES)
    }
}

impl<L: Link> Drop for CanBus<L> {
    fn drop(&mut self) {
        self.end_operation();
    }
}

impl<L: Link> Plant for CanBus<L> {
    fn read(&mut self, feedback: &mut Feedback) -> Exchange {
        self.link.begin_cycle(self.period);
        self.begin = self.link.now();
        let deadline = self.begin + (self.period as f64 * READ_FRACTION) as u64;
        let any = self.gather(deadline);
        feedback.clear();
        if !any || self.lost {
            return Exchange { fault: Some(BusFault::Lost) };
        }
        Exchange { fault: self.take_over(feedback).or(self.link.injected()) }
    }

    fn write(&mut self, commands: &[DriveCommand]) {
        let now = self.link.now();
        if now >= self.next_heartbeat {
            self.next_heartbeat = now + self.heartbeat;
            self.out.push(Frame::new(HEARTBEAT + u16::from(MASTER), &[OPERATIONAL]));
        }
        self.exchange(commands);
        if !self.lost {
            self.commanded = Some(now);
        }
    }

    fn stop(&mut self) {
        self.end_operation();
    }

    fn simulated(&self) -> Option<&ArmTwin> {
        self.link.simulated().map(SimulatedMachine::arm)
    }

    fn has_failed(&self) -> bool {
        self.link.simulated().is_some_and(SimulatedMachine::failed)
    }
}
