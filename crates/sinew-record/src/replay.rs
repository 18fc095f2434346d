//! The controller again, over the readings of a recording.

use crate::block::{Block, COMMANDS, add_checks, cycle_check, take_checks};
use crate::error::Error;
use crate::head::Head;
use crate::read::{Blocks, Recording};
use crc32fast::Hasher;
use sinew::control::supervisor::Supervisor;
use sinew::drive::DriveCommand;
use sinew_runtime::cycle::Cycle;
use sinew_runtime::link::{CycleInput, LinkedMotion, RunMotion};
use sinew_session::signals::{Signal, bus_fault_of, command_code};
use sinew_session::{Clock, Exchange, Feedback, Plant, Scheduled};
use std::io;

/// The readings of a recording, one cycle after the other.
#[derive(Debug)]
struct RecordedPlant<'a> {
    blocks: Blocks<'a>,
    block: Block,
    /// Of the next reading.
    row: usize,
    /// First columns of position, tension, joint and of the parts of a command.
    places: [usize; 6],
    /// First column of the currents; none in recordings that hold them for some cycles only.
    current: Option<usize>,
    /// Columns of bus fault and detail.
    fault: [usize; 2],
    /// Whether its machine did.
    waits: bool,
}

/// How a recording goes on.
enum Next {
    Row,
    Block(Block),
    End,
    /// Cycles are missing from this index on.
    Gap(u64),
}

impl RecordedPlant<'_> {
    fn next(&mut self) -> Result<Next, Error> {
        if self.row < self.block.count {
            return Ok(Next::Row);
        }
        let expected = self.block.first + self.block.count as u64;
        Ok(match self.blocks.next().transpose()? {
            None => Next::End,
            Some(block) if block.first == expected => Next::Block(block),
            Some(_) => Next::Gap(expected),
        })
    }

    fn at(&self, column: usize, row: usize) -> f64 {
        self.block.fast.get(column).and_then(|column| column.get(row)).copied().unwrap_or(f64::NAN)
    }

    fn read_into(&self, values: &mut [f64], first: usize) {
        for (k, value) in values.iter_mut().enumerate() {
            *value = self.at(first + k, self.row);
        }
    }
}

impl Plant for RecordedPlant<'_> {
    fn read(&mut self, feedback: &mut Feedback) -> Exchange {
        self.read_into(&mut feedback.motor, self.places[0]);
        self.read_into(&mut feedback.tension, self.places[1]);
        self.read_into(&mut feedback.joint, self.places[2]);
        // A pretension without load cells ends by them.
        if let Some(current) = self.current {
            self.read_into(&mut feedback.current, current);
        }
        let [kind, detail] = self.fault.map(|column| self.at(column, self.row));
        self.row += 1;
        Exchange { fault: bus_fault_of(kind, detail) }
    }

    fn write(&mut self, _commands: &[DriveCommand]) {}

    fn waits(&self) -> bool {
        self.waits
    }
}

/// One cycle of a replay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReplayedCycle<'a> {
    /// Its index.
    pub index: u64,
    /// Commands as [`command_code`] gives them: kinds, first numbers, second numbers, `[3 x muscles]`.
    pub commands: &'a [f64],
    /// The same as recorded, rounded.
    pub recorded: &'a [f64],
    /// Whether the commands are those that were recorded, bit for bit, by a check of 8 bits.
    pub same: bool,
    /// At the end of a block, whether the commands of every muscle and the references of every joint in it
    /// are those that were recorded, by checks of 32 bits.
    pub block: Option<BlockChecks<'a>>,
}

/// Comparison of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockChecks<'a> {
    /// First cycle of the block.
    pub first: u64,
    /// `[muscles]`.
    pub commands: &'a [bool],
    /// `[joints]`.
    pub references: &'a [bool],
}

/// A clock that shows a delay after the deadline 0, ns.
struct Late(u64);

impl Clock for Late {
    fn now(&mut self) -> u64 {
        self.0
    }

    fn wait_until(&mut self, _deadline: u64) -> io::Result<()> {
        Ok(())
    }
}

/// A controller that runs over a recording, cycle by cycle.
#[derive(Debug)]
pub struct Replay<'a> {
    cycle: Cycle<'a, RecordedPlant<'a>>,
    /// Column of the delay after the deadline.
    delay: Option<usize>,
    muscles: usize,
    commands: Vec<f64>,
    recorded: Vec<f64>,
    command_checks: Vec<Hasher>,
    reference_checks: Vec<Hasher>,
    same_commands: Vec<bool>,
    same_references: Vec<bool>,
    gap: Option<u64>,
    empty: bool,
}

impl<'a> Replay<'a> {
    /// A controller in its initial state, under its supervisor, over a recording, along a schedule, with the
    /// way to its first pose.
    ///
    /// # Errors
    /// [`Error::Attachment`] for columns that this program does not know; [`Error::Physics`] for a controller
    /// of other dimensions; those of the first block.
    pub fn new(
        recording: &'a Recording<'_>,
        supervisor: Supervisor,
        schedule: Scheduled<'a>,
    ) -> Result<Self, Error> {
        let joints = recording.head.joints.len();
        if schedule.joints() != joints {
            let (name, got) = ("joints of the motion", schedule.joints());
            return Err(sinew::Error::WrongLength { name, expected: joints, got }.into());
        }
        Self::over(recording, supervisor, schedule.into())
    }

    /// The same of a run that a client commanded, with what it sent; `motion` is one that is
    /// [replayed](LinkedMotion::replayed).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn linked(
        recording: &'a Recording<'_>,
        supervisor: Supervisor,
        motion: LinkedMotion,
    ) -> Result<Self, Error> {
        Self::over(recording, supervisor, motion.into())
    }

    fn over(
        recording: &'a Recording<'_>,
        supervisor: Supervisor,
        mut motion: RunMotion<'a>,
    ) -> Result<Self, Error> {
        let head = &recording.head;
        let [muscles, joints] = [head.muscles.len(), head.joints.len()];
        let wrong_length = |name, expected, got| sinew::Error::WrongLength { name, expected, got };
        if supervisor.dimensions() != [muscles, joints] {
            let [of_muscles, of_joints] = supervisor.dimensions();
            let wrong = if of_muscles == muscles {
                wrong_length("joints of the controller", joints, of_joints)
            } else {
                wrong_length("muscles of the controller", muscles, of_muscles)
            };
            return Err(wrong.into());
        }
        let (places, fault) = places(head)?;
        let mut blocks = recording.blocks();
        let first = blocks.next().transpose()?;
        let empty = first.is_none();
        let mut block = first.unwrap_or_default();
        let gap = (block.first > 0 || block.dropped_link > 0).then_some(0);
        let link = std::mem::take(&mut block.link);
        supply(&mut motion, link);
        let current = head.place(Signal::Current).filter(|_| !head.is_slow(Signal::Current));
        let plant = RecordedPlant { blocks, block, row: 0, places, current, fault, waits: head.simulated };
        let cycle = Cycle::new(plant, supervisor, motion, head.period_s());
        let delay = head.place(Signal::WakeUp);
        Ok(Self {
            cycle,
            delay,
            muscles,
            commands: vec![0.0; 3 * muscles],
            recorded: vec![0.0; 3 * muscles],
            command_checks: vec![Hasher::new(); muscles],
            reference_checks: vec![Hasher::new(); joints],
            same_commands: vec![true; muscles],
            same_references: vec![true; joints],
            gap,
            empty,
        })
    }

    /// The first cycle that is missing in the recording, which ends its replay: what the controller knew is
    /// unknown there.
    #[must_use]
    pub fn gap(&self) -> Option<u64> {
        self.gap
    }

    /// Replays the next cycle; none at the end of the recording and at its first gap.
    ///
    /// # Errors
    /// Those of the recording's next block; [`Error::Physics`] as
    /// [`Session::step`](sinew_session::Session::step).
    pub fn step(&mut self) -> Result<Option<ReplayedCycle<'_>>, Error> {
        if self.gap.is_some() || self.empty {
            return Ok(None);
        }
        match self.cycle.plant_mut().next()? {
            Next::Row => {}
            Next::Block(block) if block.dropped_link > 0 => {
                self.gap = Some(block.first);
                return Ok(None);
            }
            Next::Block(mut block) => {
                supply(self.cycle.motion_mut(), std::mem::take(&mut block.link));
                let plant = self.cycle.plant_mut();
                (plant.block, plant.row) = (block, 0);
            }
            Next::End => return Ok(None),
            Next::Gap(index) => {
                self.gap = Some(index);
                return Ok(None);
            }
        }
        let plant = self.cycle.plant();
        let delay = self.delay.map_or(0.0, |column| plant.at(column, plant.row));
        let record = self.cycle.step(&mut Late((delay.max(0.0) * 1e3).round() as u64), 0)?;
        for (k, command) in record.command.arm.drives.iter().enumerate() {
            for (place, number) in command_code(command).into_iter().enumerate() {
                self.commands[place * self.muscles + k] = number;
            }
        }
        for numbers in [&record.reference.q, &record.reference.v, &record.reference.a] {
            add_checks(&mut self.reference_checks, numbers);
        }
        add_checks(&mut self.command_checks, &self.commands);
        let plant = record.plant;
        let row = plant.row - 1;
        for (k, recorded) in self.recorded.iter_mut().enumerate() {
            *recorded = plant.at(plant.places[3 + k / self.muscles] + k % self.muscles, row);
        }
        let same = plant.block.cycle_checks.get(row) == Some(&cycle_check(&self.commands));
        let (index, first) = (plant.block.first + row as u64, plant.block.first);
        let ends = plant.row == plant.block.count;
        if ends {
            compare(&mut self.same_commands, &mut self.command_checks, &plant.block.command_checks);
            compare(&mut self.same_references, &mut self.reference_checks, &plant.block.reference_checks);
        }
        let checks = BlockChecks { first, commands: &self.same_commands, references: &self.same_references };
        let block = ends.then_some(checks);
        Ok(Some(ReplayedCycle { index, commands: &self.commands, recorded: &self.recorded, same, block }))
    }
}

fn supply(motion: &mut RunMotion<'_>, inputs: Vec<CycleInput>) {
    inputs.into_iter().for_each(|input| motion.supply(input));
}

fn compare(same: &mut [bool], checks: &mut [Hasher], recorded: &[u32]) {
    for ((same, found), recorded) in same.iter_mut().zip(take_checks(checks)).zip(recorded) {
        *same = found == *recorded;
    }
}

/// First columns of what a replay needs.
fn places(head: &Head) -> Result<([usize; 6], [usize; 2]), Error> {
    let place = |signal: Signal| {
        head.place(signal).ok_or_else(|| Error::Attachment {
            name: "head.json".to_owned(),
            reason: format!("expected columns {}, got others", signal.row().name),
        })
    };
    let [kind, command, feed] = COMMANDS;
    let places = [
        place(Signal::PositionIn)?,
        place(Signal::TensionIn)?,
        place(Signal::Joint)?,
        place(kind)?,
        place(command)?,
        place(feed)?,
    ];
    Ok((places, [place(Signal::BusFault)?, place(Signal::BusDetail)?]))
}
