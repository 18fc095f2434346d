//! Nodes in operation: commands and requests; the answers are collected when the next cycle begins.

use super::device::{CanDevice, Protocol};
use super::error::CanError;
use super::sign::Sign;
use super::slot::{Heard, Slot};
use super::{Link, SimulatedMachine, canopen, cansimple, mit, moteus};
use crate::rest::{Drives, bring_to_rest};
use sinew::drive::DriveCommand;
use sinew::machine::Machine;
use sinew::twin::arm::ArmTwin;
use sinew_segment::CanFrame as Frame;
use sinew_session::{BusFault, Exchange, Feedback, Plant};

/// Nodes that matched the machine and are configured. It owns them: dropped it brings them to rest.
#[derive(Debug)]
pub struct CanBus<L: Link> {
    link: L,
    nodes: Vec<Node>,
    out: Vec<Frame>,
    /// Whether there is a SYNC, and a heartbeat of the master.
    canopen: bool,
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
    /// What a watchdog of ours is told, where there is one, and whether it has ended.
    sign: Option<Sign>,
    unguarded: bool,
}

#[derive(Debug)]
struct Node {
    device: CanDevice,
    slot: Box<dyn Slot>,
    /// Cycles without an answer.
    silent: u32,
    /// When it was heard last in its heartbeat, ns.
    alive: u64,
    /// Whether it has left operation: it does not come back by itself.
    left: bool,
    /// Whether its drive is to be enabled, and for how many cycles it has not been.
    wanted: bool,
    waiting: u64,
}

/// A node that does not answer for so many cycles counts as missing.
const SILENT_CYCLES: u32 = 3;
/// Since the beginning of a cycle, when answers are waited for no longer: a fraction of the period.
const READ_FRACTION: f64 = 0.5;
/// Part of the period that the bus may be busy.
const BUS_FRACTION: f64 = 0.95;
/// Codes of [`BusFault::NotReady`].
const SILENT: u16 = 0;
pub(super) const HEARTBEAT_LOST: u16 = 1;
pub(super) const RESTARTED: u16 = 2;
pub(super) const UNGUARDED: u16 = 3;
/// Time until all nodes answer without a fault, and until a drive is enabled, at most, ns.
const START_TIME: u64 = 4_000_000_000;
const ENABLE_TIME: u64 = 500_000_000;
/// Cycles of any such time, at least: a drive takes one state after the other.
const MIN_CYCLES: u64 = 8;

impl<L: Link> CanBus<L> {
    /// Finds the nodes of a machine, sets them up and reads everything back. None has power until the first
    /// command, but for a drive that is not on CANopen while its watchdog is tried, at standstill.
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
        let mut nodes = Vec::with_capacity(devices.len());
        for device in devices {
            let slot = match device.protocol {
                Protocol::Canopen => canopen::start(&mut link, device, machine)?,
                Protocol::Cansimple => cansimple::start(&mut link, device, machine)?,
                Protocol::Moteus => moteus::start(&mut link, device, machine)?,
                Protocol::Mit => mit::start(&mut link, device, machine)?,
            };
            let device = device.clone();
            nodes.push(Node { device, slot, silent: 0, alive: 0, left: false, wanted: false, waiting: 0 });
        }
        let guarded = devices.iter().any(|device| device.protocol == Protocol::Mit);
        if guarded {
            mit::prove_watchdog(&mut link, devices, machine)?;
        }
        let alive = link.now();
        nodes.iter_mut().for_each(|node| node.alive = alive);
        let mut bus = Self {
            nodes,
            link,
            out: Vec::with_capacity(4 * (devices.len() + 1)),
            canopen: devices.iter().any(|device| device.protocol == Protocol::Canopen),
            muscles: machine.muscles.len(),
            period: machine.period_ns(),
            heartbeat: (0.25e9 * machine.watchdog()) as u64,
            next_heartbeat: 0,
            begin: alive,
            commanded: None,
            in_operation: true,
            lost: false,
            sign: guarded.then_some(Sign::Rest),
            unguarded: false,
        };
        bus.probe()?;
        Ok(bus)
    }

    /// Starts the nodes and exchanges process data until all answer and no drive has a fault. The master
    /// sends no heartbeat yet, so that none watches for the next before the first command.
    fn probe(&mut self) -> Result<(), CanError> {
        let start: Vec<Frame> = self.nodes.iter().map(|node| node.slot.operate(true)).collect();
        let port = |source| CanError::Port { port: "the adapter".to_owned(), source };
        self.link.send(&start).map_err(port)?;
        let off = vec![DriveCommand::Off; self.muscles];
        let mut feedback = Feedback::new(self.muscles, 0);
        let ready = |node: &Node| node.silent == 0 && node.slot.is_ready();
        for _ in 0..self.cycles_of(START_TIME) {
            self.exchange(&off);
            self.link.rest_until(self.begin.saturating_add(self.period));
            self.read(&mut feedback);
            if self.nodes.iter().all(ready) {
                // What was reported until here belongs to an earlier run.
                self.nodes.iter_mut().for_each(|node| node.slot.forgive());
                // The first cycle finds its readings as every other.
                self.exchange(&off);
                return Ok(());
            }
            if let Some(node) = self.nodes.iter().find(|node| node.left) {
                return Err(node.device.wrong("starts anew"));
            }
        }
        let node = self.nodes.iter().find(|node| !ready(node)).ok_or(CanError::OtherBus)?;
        Err(node.device.wrong(if node.silent > 0 {
            "does not answer in operation".to_owned()
        } else {
            format!("stays in state {}", node.slot.state())
        }))
    }

    /// Sends commands and what asks for the answers.
    fn exchange(&mut self, commands: &[DriveCommand]) {
        let (h, now) = (self.period as f64 * 1e-9, self.begin);
        let off = |node: &Node| commands.get(node.device.drive.muscle) == Some(&DriveCommand::Off);
        let sign = if self.nodes.iter().all(off) { Sign::Rest } else { Sign::Alive };
        self.sign = self.sign.map(|_| sign);
        self.sign();
        for node in &mut self.nodes {
            let command = commands.get(node.device.drive.muscle).copied().unwrap_or(DriveCommand::Brake);
            // Without the watchdog none gets power.
            let command = if self.unguarded && !node.slot.is_enabled() { DriveCommand::Off } else { command };
            node.wanted = !matches!(command, DriveCommand::Off | DriveCommand::Brake);
            node.slot.command(command, h, now, &mut self.out);
        }
        if self.canopen {
            self.out.push(canopen::sync());
        }
        self.lost = self.link.send(&self.out).is_err();
        self.out.clear();
    }

    /// A sign of life to the watchdog of ours.
    fn sign(&mut self) {
        self.unguarded |= self.sign.is_some_and(|sign| self.link.sign(sign).is_err());
    }

    /// The link.
    pub fn link_mut(&mut self) -> &mut L {
        &mut self.link
    }

    /// Collects answers until all have come or the deadline has; whether any came.
    fn gather(&mut self, deadline: u64) -> bool {
        let (mut left, mut any) = (self.nodes.len(), false);
        self.nodes.iter_mut().for_each(|node| node.silent = node.silent.saturating_add(1));
        // When all have come, what has come beside them is not left for the next cycle.
        while let Ok(Some(frame)) = self.link.receive(if left > 0 { deadline } else { 0 }) {
            let from = self.nodes.iter_mut().find(|node| !frame.is_remote() && node.slot.sends(&frame));
            let Some(node) = from else { continue };
            any = true;
            match node.slot.take(&frame) {
                Heard::Readings => {
                    left -= usize::from(node.silent > 0);
                    node.silent = 0;
                }
                Heard::Alive { left } => (node.alive, node.left) = (self.begin, node.left | left),
                Heard::Left => node.left = true,
                Heard::Other => {}
            }
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
                node.slot.forget_state();
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
            node.waiting = if node.wanted && !node.slot.is_enabled() { node.waiting + 1 } else { 0 };
            let refuses = (node.waiting > patience).then_some(0);
            if let Some(code) = node.slot.fault().or(refuses) {
                fault = fault.or(Some(BusFault::Drive { muscle, code }));
            } else if self.begin.saturating_sub(node.alive) > node.slot.patience() {
                fault = fault.or(Some(not_ready(HEARTBEAT_LOST, Some(muscle))));
            }
            [feedback.motor[muscle], feedback.current[muscle]] = node.slot.readings();
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
        let end: Vec<Frame> = self.nodes.iter().map(|node| node.slot.operate(false)).collect();
        let _ = self.link.send(&end);
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
            } else if other.protocol != device.protocol {
                "the same protocol"
            } else if other.port != device.port {
                "the same port: a machine has one bus"
            } else {
                continue;
            };
            let (device, other) = (device.name.clone(), other.name.clone());
            return Err(CanError::Bus { device, other, expected });
        }
    }
    let Some(CanDevice { bitrate, protocol, .. }) = devices.first() else { return Err(CanError::OtherBus) };
    let (nodes, bitrate) = (devices.len(), *bitrate);
    let needed = match protocol {
        Protocol::Canopen => canopen::time(nodes, period, bitrate),
        Protocol::Cansimple => cansimple::time(nodes, period, bitrate),
        Protocol::Moteus => moteus::time(nodes, bitrate),
        Protocol::Mit => mit::time(nodes, bitrate),
    };
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
            let speed = node.slot.braked_speed(h);
            standing &= speed == 0.0;
            // One that is not enabled does not get power for it.
            commands[node.device.drive.muscle] =
                if node.slot.is_enabled() { DriveCommand::Velocity(speed) } else { DriveCommand::Off };
        }
        standing
    }

    fn are_without_power(&self, _last: Exchange) -> bool {
        self.nodes.iter().all(|node| node.silent == 0 && !node.slot.has_torque())
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
        // After a stall: that it has acted is known before the drives say that they have no power.
        self.sign();
        let deadline = self.begin + (self.period as f64 * READ_FRACTION) as u64;
        let any = self.gather(deadline);
        feedback.clear();
        if !any || self.lost {
            return Exchange { fault: Some(BusFault::Lost) };
        }
        let unguarded = self.nodes.first().filter(|_| self.unguarded).map(|node| BusFault::NotReady {
            device: node.device.device,
            code: UNGUARDED,
            muscle: Some(node.device.drive.muscle),
        });
        let found = self.take_over(feedback);
        Exchange { fault: unguarded.or(found).or(self.link.injected()) }
    }

    fn write(&mut self, commands: &[DriveCommand]) {
        let now = self.link.now();
        if self.canopen && now >= self.next_heartbeat {
            self.next_heartbeat = now + self.heartbeat;
            self.out.push(canopen::heartbeat());
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
