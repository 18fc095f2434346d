//! What a recording says about itself, and its columns.

use crate::grid::Grid;
use serde::{Deserialize, Serialize};
use sinew::control::arm::{ArmStatus, Fault};
use sinew::machine::{self, Device, DeviceRole, DriveDevice, Machine};
use sinew_session::signals::{Axis, Kind, Resolution, Signal, fault_of};

/// Version of the format that this crate writes, and the newest that it reads.
pub const FORMAT: u32 = 2;
/// Cycles of a millisecond between two values of a slow column; see [`Head::cycles_of`].
pub const STRIDE: u64 = 20;
/// Cycles of a millisecond in a block, at most: what a recording loses at most where its writer is killed,
/// with what is in the ring.
pub const BLOCK: usize = 500;

/// Attachment `head.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Head {
    /// See [`FORMAT`].
    pub format: u32,
    /// Version of the program that wrote it.
    pub program: String,
    /// Commit of its sources.
    pub commit: String,
    /// Whether the machine was simulated.
    pub simulated: bool,
    /// Whether the cycle did not wait for its deadlines.
    pub virtual_time: bool,
    /// Start, ns since 1970; 0 on virtual time.
    pub start_ns: u64,
    /// Control cycle, ns.
    pub period_ns: u64,
    /// See [`STRIDE`].
    pub stride: u64,
    /// Name of the machine.
    pub machine: String,
    /// Names of the muscles.
    pub muscles: Vec<String>,
    /// Names and units of the independent joints.
    pub joints: Vec<JointColumn>,
    /// With a value in every cycle.
    pub fast: Vec<ColumnSpec>,
    /// With a value in every cycle whose index is a multiple of the stride.
    pub slow: Vec<ColumnSpec>,
}

/// A joint as columns name it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct JointColumn {
    /// Its name.
    pub name: String,
    /// `rad` or `m`.
    pub unit: String,
}

/// A column: its name ends with its unit, and where there are several with `:` and the name of a muscle or
/// joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ColumnSpec {
    /// Its name.
    pub name: String,
    /// How exactly it is kept.
    pub coding: Coding,
}

/// How exactly the numbers of a column are kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Coding {
    /// Bit for bit, with the grids that readings are expected on.
    Exact(Vec<Grid>),
    /// In multiples of a resolution; what is not finite as NaN.
    Rounded(f64),
}

/// Resolution of commands, m/s, A or N.
pub const COMMAND: f64 = 1e-4;

/// Circumstances of a recording.
#[derive(Debug, Clone)]
pub struct Circumstances {
    /// Version of the program.
    pub program: String,
    /// Commit of its sources.
    pub commit: String,
    /// Whether the machine is simulated.
    pub simulated: bool,
    /// Whether the cycle does not wait for its deadlines.
    pub virtual_time: bool,
    /// Start, ns since 1970; 0 on virtual time.
    pub start_ns: u64,
    /// Control cycle, ns.
    pub period_ns: u64,
}

impl Head {
    /// Of a machine.
    #[must_use]
    pub fn new(machine: &Machine, of: Circumstances) -> Self {
        let parts = machine.robot.parts();
        let muscles: Vec<String> = parts.tendons.iter().map(|tendon| tendon.name.clone()).collect();
        let joints: Vec<JointColumn> = machine
            .robot
            .independent_joints()
            .into_iter()
            .map(|joint| {
                let unit = parts.joints[joint].kind.unit();
                JointColumn { name: parts.joints[joint].name.clone(), unit: unit.to_owned() }
            })
            .collect();
        let mut head = Self {
            format: FORMAT,
            program: of.program,
            commit: of.commit,
            simulated: of.simulated,
            virtual_time: of.virtual_time,
            start_ns: of.start_ns,
            period_ns: of.period_ns,
            stride: cycles_of(STRIDE, of.period_ns),
            machine: parts.name.clone(),
            muscles,
            joints,
            fast: Vec::new(),
            slow: Vec::new(),
        };
        head.lay_out(machine);
        head
    }

    /// Names of the columns of a signal, one for every part.
    pub(crate) fn names(&self, signal: Signal) -> Vec<String> {
        match signal.row().axis {
            Axis::Cycle => vec![signal.column("", "")],
            Axis::Joint => self.joints.iter().map(|joint| signal.column(&joint.name, &joint.unit)).collect(),
            Axis::Muscle => self.muscles.iter().map(|muscle| signal.column(muscle, "")).collect(),
        }
    }

    /// Whether a signal is among the slow columns.
    #[must_use]
    pub fn is_slow(&self, signal: Signal) -> bool {
        let names = self.names(signal);
        self.slow.iter().any(|column| Some(&column.name) == names.first())
    }

    /// Where the columns of a signal begin, among the fast ones or the slow ones; none where the recording
    /// lacks one of them.
    #[must_use]
    pub fn place(&self, signal: Signal) -> Option<usize> {
        let columns = if self.is_slow(signal) { &self.slow } else { &self.fast };
        let names = self.names(signal);
        let first = columns.iter().position(|column| Some(&column.name) == names.first())?;
        let found = columns.get(first..first + names.len())?;
        found.iter().zip(&names).all(|(column, name)| column.name == *name).then_some(first)
    }

    /// Cycles of so many milliseconds, at least one.
    #[must_use]
    pub fn cycles_of(&self, milliseconds: u64) -> u64 {
        cycles_of(milliseconds, self.period_ns)
    }

    /// Length of a cycle, s.
    #[must_use]
    pub fn period_s(&self) -> f64 {
        self.period_ns as f64 / 1e9
    }
}

fn cycles_of(milliseconds: u64, period_ns: u64) -> u64 {
    (1_000_000 * milliseconds / period_ns.max(1)).max(1)
}

impl Head {
    /// Sets the columns of all signals.
    fn lay_out(&mut self, machine: &Machine) {
        // A pretension without load cells ends by the currents, which a replay needs then.
        let ends_by_current = machine.muscles.iter().any(|muscle| !muscle.drive.has_load_cell);
        for signal in Signal::ALL.iter().filter(|signal| self.simulated || signal.row().kind != Kind::Truth) {
            let row = signal.row();
            let columns = self.names(*signal).into_iter().enumerate().map(|(k, name)| {
                let coding = match row.resolution {
                    Resolution::Rounded(resolution) => Coding::Rounded(resolution),
                    Resolution::Exact => Coding::Exact(grids(machine, *signal, k)),
                };
                ColumnSpec { name, coding }
            });
            let columns: Vec<ColumnSpec> = columns.collect();
            let slow = row.slow && !(*signal == Signal::Current && ends_by_current);
            if slow { &mut self.slow } else { &mut self.fast }.extend(columns);
        }
    }
}

/// What a reading is expected on.
fn grids(machine: &Machine, signal: Signal, part: usize) -> Vec<Grid> {
    match signal {
        Signal::PositionIn => position_grids(machine, part),
        Signal::TensionIn => tension_grids(machine, part),
        Signal::Joint => joint_grids(machine, part),
        _ => Vec::new(),
    }
}

/// The channels of the devices that measure a signal.
fn channel(machine: &Machine, signal: machine::Signal) -> Option<Grid> {
    let channels = machine.devices.iter().flat_map(Device::channels);
    let mut found = channels.filter(|channel| channel.signal == signal);
    found.next().map(|channel| Grid { offset: channel.offset, ..Grid::new(channel.scale) })
}

/// Counts of the motor's encoder, as designed and as on the fieldbus, in the first layer of the drum, with
/// the factors in the order in which readings are computed.
fn position_grids(machine: &Machine, muscle: usize) -> Vec<Grid> {
    let drive = &machine.muscles[muscle].drive;
    let (ratio, arm, turn) = (drive.reducer.ratio, drive.winch.arm(0), core::f64::consts::TAU);
    let own = Grid { scale: turn / drive.encoder.counts, factor: 1.0 / ratio, arm, ..Grid::new(1.0) };
    let mut grids = vec![own];
    for device in &machine.devices {
        if let DeviceRole::Drive(axis) = &device.role
            && axis.muscle == muscle
        {
            let [offset, _] = DriveDevice::cable(&drive.winch, ratio, axis.offset);
            let scale = turn / axis.counts_per_turn;
            grids.push(Grid { scale, divisor: ratio, arm, offset, ..Grid::new(1.0) });
        }
    }
    usable(grids)
}

/// Counts of the load cell, through the converter of the fieldbus where there is one, and of that alone.
fn tension_grids(machine: &Machine, muscle: usize) -> Vec<Grid> {
    let own = Grid::new(machine.muscles[muscle].drive.load_cell.resolution);
    let on_bus = channel(machine, machine::Signal::Tension(muscle));
    let through = on_bus.map(|bus| Grid { offset: bus.offset, inner: bus.scale, ..own });
    usable([Some(own), through, on_bus].into_iter().flatten().collect())
}

fn joint_grids(machine: &Machine, joint: usize) -> Vec<Grid> {
    let own = machine.encoders.get(joint).copied().flatten().map(|encoder| Grid::new(encoder.resolution));
    usable([own, channel(machine, machine::Signal::Joint(joint))].into_iter().flatten().collect())
}

fn usable(grids: Vec<Grid>) -> Vec<Grid> {
    grids.into_iter().filter(Grid::is_usable).collect()
}

impl Head {
    /// Mode of the supervisor, with its fault, and status of the controller, in words.
    #[must_use]
    pub fn mode_name(&self, mode: f64, fault: f64, status: ArmStatus) -> String {
        let names = ["off", "ready", "pretension", "hold", "run", "safe stop", "fault"];
        let mut text = names.get(mode as usize).copied().unwrap_or("unknown mode").to_owned();
        if let Some(named) = fault_of(fault) {
            text += &format!(" ({})", self.fault_name(named.fault));
        }
        text + ", " + &self.status_name(status)
    }

    /// A status in words.
    #[must_use]
    pub fn status_name(&self, status: ArmStatus) -> String {
        match status {
            ArmStatus::Following => "following".to_owned(),
            ArmStatus::Holding => "holding".to_owned(),
            ArmStatus::Degraded(fault) => format!("degraded: {}", self.fault_name(fault)),
            ArmStatus::Stopped(fault) => format!("stopped: {}", self.fault_name(fault)),
        }
    }

    /// A fault by the name of its muscle or joint.
    #[must_use]
    pub fn fault_name(&self, fault: Fault) -> String {
        let muscle = |k: usize| self.muscles.get(k).map_or("?", String::as_str);
        let joint = |k: usize| self.joints.get(k).map_or("?", |joint| joint.name.as_str());
        fault.name(muscle, joint)
    }
}
