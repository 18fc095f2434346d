use super::lanes::DriveLanes;
use super::machine::{Drive, DriveCommand, DriveReading, DriveStep};
use crate::dispatch::InstructionSet;
use alloc::vec::Vec;

/// Drives in a group.
const LANES: usize = 8;
/// Fewer are stepped one by one: a group costs what it costs, however many of its lanes are used.
const FEWEST: usize = 3;

/// Drives of a machine, eight in SIMD lanes: bit for bit the same as as many [`Drive`]s.
#[derive(Debug, Clone)]
pub(crate) struct DriveBatch {
    groups: Vec<DriveLanes<LANES>>,
    /// What does not make a group.
    rest: Vec<DriveLanes<1>>,
    instructions: InstructionSet,
}

impl DriveBatch {
    /// These drives.
    pub(crate) fn new(drives: &[Drive]) -> Self {
        let (mut groups, mut rest) = (Vec::new(), Vec::new());
        for chunk in drives.chunks(LANES) {
            let lanes: Vec<&DriveLanes<1>> = chunk.iter().map(|drive| &drive.lane).collect();
            if lanes.len() < FEWEST {
                rest.extend(lanes.into_iter().cloned());
            } else {
                groups.push(DriveLanes::gathered(&lanes));
            }
        }
        Self { groups, rest, instructions: InstructionSet::detect() }
    }

    /// [`Drive::step`] of all drives, one for each of `steps`: under a command and a tension, N, which `of`
    /// tells.
    pub(crate) fn step(
        &mut self,
        mut of: impl FnMut(usize) -> (DriveCommand, f64),
        h: f64,
        steps: &mut [DriveStep],
    ) {
        let Self { groups, rest, instructions } = self;
        let (mut first, mut steps) = (0, steps);
        for group in groups {
            let (now, others) = steps.split_at_mut(LANES.min(steps.len()));
            group.step(*instructions, |k| of(first + k), h, now);
            (first, steps) = (first + now.len(), others);
        }
        for (lane, step) in rest.iter_mut().zip(steps.chunks_mut(1)) {
            lane.step(InstructionSet::Baseline, |_| of(first), h, step);
            first += 1;
        }
    }

    /// [`Drive::settle`] of one.
    pub(crate) fn settle(&mut self, drive: usize, tension: f64) {
        match self.groups.get_mut(drive / LANES) {
            Some(group) => group.settle(drive % LANES, tension),
            None => self.rest[drive - LANES * self.groups.len()].settle(0, tension),
        }
    }

    /// [`Drive::reading`] of one.
    pub(crate) fn reading(&self, drive: usize) -> DriveReading {
        match self.groups.get(drive / LANES) {
            Some(group) => group.reading(drive % LANES),
            None => self.rest[drive - LANES * self.groups.len()].reading(0),
        }
    }

    /// [`Drive::winding`] of one; NaN for an index out of range.
    pub(crate) fn winding(&self, drive: usize) -> f64 {
        let single = || self.rest.get(drive.wrapping_sub(LANES * self.groups.len()));
        match self.groups.get(drive / LANES) {
            Some(group) => group.winding(drive % LANES),
            None => single().map_or(f64::NAN, |lane| lane.winding(0)),
        }
    }
}
