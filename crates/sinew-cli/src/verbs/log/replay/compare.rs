//! Commands of a replay beside those of the recording and beside those of another controller.

use super::super::command_kinds::CommandKinds;
use super::controllers::Motion;
use crate::error::Error;
use sinew::control::supervisor::Supervisor;
use sinew_record::{COMMAND, Recording};
use std::path::Path;

/// What a replay has shown.
pub(super) struct Compared {
    pub(super) cycles: u64,
    /// First cycle that is missing in the recording.
    pub(super) gap: Option<u64>,
    /// Cycles whose commands differ from the recorded ones, and the first of them.
    pub(super) different: u64,
    pub(super) first: Option<u64>,
    /// Against the recorded commands: `[muscles]`.
    pub(super) muscles: Vec<Deviation>,
    /// Blocks in which the reference of a joint is not the recorded one: `[joints]`.
    pub(super) moved_references: Vec<u64>,
    pub(super) blocks: u64,
    /// Of another controller against the recorded one.
    pub(super) other: Option<Vec<Deviation>>,
    /// Of the commands of every muscle.
    pub(super) kinds: Vec<CommandKinds>,
    /// Time, s, recorded controller, another one: commands of every muscle, decimated.
    pub(super) trace: Vec<(f64, Vec<f64>, Vec<f64>)>,
}

/// Deviation of a muscle's command.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Deviation {
    /// First cycle, exactly for another controller, of a block for a recording.
    pub(super) first: Option<u64>,
    /// Cycles, or blocks, that differ.
    pub(super) count: u64,
    /// m/s, A or N; beyond the resolution of the recording.
    pub(super) max: f64,
    sum_of_squares: f64,
    cycles: u64,
}

impl Deviation {
    pub(super) fn rms(&self) -> f64 {
        (self.sum_of_squares / self.cycles.max(1) as f64).sqrt()
    }

    fn add(&mut self, difference: f64) {
        // A command without a number, as that of a brake, has none to compare.
        if difference.is_finite() {
            self.max = self.max.max(difference.abs());
            self.sum_of_squares += difference * difference;
        }
        self.cycles += 1;
    }

    fn mark(&mut self, index: u64) {
        self.first = self.first.or(Some(index));
        self.count += 1;
    }
}

impl Compared {
    /// Whether the commands are those of the recording, bit for bit.
    pub(super) fn reproduced(&self) -> bool {
        self.different == 0
            && self.muscles.iter().all(|muscle| muscle.count == 0)
            && self.moved_references.iter().all(|moved| *moved == 0)
    }
}

/// Rows of the trace.
const TRACE_ROWS: u64 = 3000;

/// Replays a recording with its controller and, in lockstep, with another one.
pub(super) fn compare(
    file: &Path,
    recording: &Recording<'_>,
    motion: &Motion,
    controller: Supervisor,
    other: Option<Supervisor>,
) -> Result<Compared, Error> {
    let refuse = Error::recording(file);
    let (muscles, joints) = (recording.head.muscles.len(), recording.head.joints.len());
    let mut replay = motion.replay(file, recording, controller)?;
    let mut beside = match other {
        Some(other) => Some(motion.replay(file, recording, other)?),
        None => None,
    };
    let mut all = Compared {
        cycles: 0,
        gap: None,
        different: 0,
        first: None,
        muscles: vec![Deviation::default(); muscles],
        moved_references: vec![0; joints],
        blocks: 0,
        other: beside.as_ref().map(|_| vec![Deviation::default(); muscles]),
        kinds: vec![CommandKinds::default(); muscles],
        trace: Vec::new(),
    };
    let last = recording.blocks().last().transpose().map_err(&refuse)?;
    let cycles = last.map_or(0, |block| block.first + block.count as u64);
    let stride = (cycles / TRACE_ROWS).max(1);
    while let Some(cycle) = replay.step().map_err(&refuse)? {
        all.cycles += 1;
        if !cycle.same {
            all.different += 1;
            all.first = all.first.or(Some(cycle.index));
        }
        for (k, muscle) in all.muscles.iter_mut().enumerate() {
            let difference = cycle.commands[muscles + k] - cycle.recorded[muscles + k];
            // Within the rounding of the recording a difference means nothing.
            let beyond = if difference.abs() > 0.501 * COMMAND { difference } else { 0.0 };
            muscle.add(beyond);
        }
        if let Some(block) = cycle.block {
            all.blocks += 1;
            let muscles = all.muscles.iter_mut().zip(block.commands);
            muscles.filter(|(_, same)| !**same).for_each(|(muscle, _)| muscle.mark(block.first));
            let joints = all.moved_references.iter_mut().zip(block.references);
            joints.filter(|(_, same)| !**same).for_each(|(moved, _)| *moved += 1);
        }
        let (index, mine) = (cycle.index, &cycle.commands[..2 * muscles]);
        let with = match &mut beside {
            Some(beside) => {
                let Some(with) = beside.step().map_err(&refuse)? else { break };
                Some(&with.commands[..2 * muscles])
            }
            None => None,
        };
        if let (Some(with), Some(deviations)) = (with, &mut all.other) {
            for (k, deviation) in deviations.iter_mut().enumerate() {
                let differs = |place: usize| mine[place].to_bits() != with[place].to_bits();
                if differs(k) || differs(muscles + k) {
                    deviation.mark(index);
                }
                deviation.add(with[muscles + k] - mine[muscles + k]);
            }
        }
        if index.is_multiple_of(stride) {
            let time = index as f64 * recording.head.period_s();
            let beside = with.unwrap_or(&cycle.recorded[..2 * muscles]);
            all.kinds.iter_mut().zip(mine).for_each(|(kinds, kind)| kinds.see(*kind));
            all.trace.push((time, mine[muscles..].to_vec(), beside[muscles..].to_vec()));
        }
    }
    all.gap = replay.gap();
    Ok(all)
}
