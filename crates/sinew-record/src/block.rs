//! Consecutive cycles as the messages of a chunk, and back.

use crate::error::Error;
use crate::fields::Fields;
use crate::grid::{Grid, round, shorten, snapped};
use crate::head::{Coding, ColumnSpec, Head};
use crate::messages::BlockMessage;
use crate::{format1, head};
use crc32fast::Hasher;
use sinew_runtime::link::CycleInput;
use sinew_session::signals::{FrameLayout, Signal};
use std::sync::Arc;

/// Collects samples of consecutive cycles.
#[derive(Debug)]
pub(crate) struct BlockBuilder {
    layout: Arc<FrameLayout>,
    /// Places in a frame of the columns.
    places: [Vec<usize>; 2],
    stride: u64,
    first: u64,
    count: usize,
    /// `[columns][cycles]`.
    fast: Vec<Vec<f64>>,
    slow: Vec<Vec<f64>>,
    cycle_checks: Vec<u8>,
    /// `[muscles]`, `[joints]`.
    command_checks: Vec<Hasher>,
    reference_checks: Vec<Hasher>,
}

impl BlockBuilder {
    /// With a value of slow columns in every cycle that is a multiple of the stride.
    pub(crate) fn new(layout: Arc<FrameLayout>, head: &Head) -> Self {
        let places = [false, true].map(|slow| {
            let signals = Signal::ALL.iter().filter(|signal| head.is_slow(**signal) == slow);
            signals.flat_map(|signal| layout.place(*signal)).collect::<Vec<_>>()
        });
        let [fast, slow] = [0, 1].map(|k: usize| vec![Vec::with_capacity(head::BLOCK); places[k].len()]);
        let [muscles, joints] = layout.sizes();
        Self {
            layout,
            places,
            stride: head.stride.max(1),
            first: 0,
            count: 0,
            fast,
            slow,
            cycle_checks: Vec::new(),
            command_checks: vec![Hasher::new(); muscles],
            reference_checks: vec![Hasher::new(); joints],
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.count
    }

    /// Whether a cycle follows those collected.
    pub(crate) fn continues(&self, index: u64) -> bool {
        self.count == 0 || index == self.first + self.count as u64
    }

    /// Adds the frame of a cycle, and the rates of its reference.
    pub(crate) fn push(&mut self, index: u64, frame: &[f64], rates: &[f64]) {
        if self.count == 0 {
            self.first = index;
        }
        self.count += 1;
        let Self { places: [fast, slow], layout, stride, .. } = self;
        self.fast.iter_mut().zip(fast).for_each(|(column, place)| column.push(frame[*place]));
        if index.is_multiple_of(*stride) {
            self.slow.iter_mut().zip(slow).for_each(|(column, place)| column.push(frame[*place]));
        }
        let commands = COMMANDS.map(|signal| layout.of(signal, frame));
        self.cycle_checks.push(cycle_check(commands.into_iter().flatten()));
        commands.iter().for_each(|numbers| add_checks(&mut self.command_checks, numbers));
        for numbers in [layout.of(Signal::JointReference, frame), rates] {
            add_checks(&mut self.reference_checks, numbers);
        }
    }

    /// Index of the first cycle.
    pub(crate) fn first(&self) -> u64 {
        self.first
    }

    /// Index of the cycle after the last one.
    pub(crate) fn end(&self) -> u64 {
        self.first + self.count as u64
    }

    /// The message of the block, and short numbers for its columns; nothing is collected afterwards.
    pub(crate) fn take(&mut self, head: &Head, dropped: u64) -> (BlockMessage, [Vec<Vec<f64>>; 2]) {
        let mut grids = Vec::new();
        let mut short = |specs: &[ColumnSpec], columns: &mut [Vec<f64>]| {
            let pairs = specs.iter().zip(columns);
            let kept = pairs.map(|(spec, values)| {
                let (short, grid) = match &spec.coding {
                    Coding::Rounded(resolution) => (round(values, *resolution), 1),
                    Coding::Exact(grids) => shorten(values, grids),
                };
                values.clear();
                grids.push(grid);
                short
            });
            kept.collect::<Vec<_>>()
        };
        let columns = [short(&head.fast, &mut self.fast), short(&head.slow, &mut self.slow)];
        let message = BlockMessage {
            first: self.first,
            count: self.count as u32,
            cycle_checks: std::mem::take(&mut self.cycle_checks),
            command_checks: take_checks(&mut self.command_checks),
            reference_checks: take_checks(&mut self.reference_checks),
            dropped,
            grids,
            ..BlockMessage::default()
        };
        self.count = 0;
        (message, columns)
    }
}

/// What a command is made of.
pub(crate) const COMMANDS: [Signal; 3] = [Signal::CommandKind, Signal::Command, Signal::Feed];

/// Low 8 bits of the CRC-32 over the exact commands: kinds, first numbers, second numbers.
pub(crate) fn cycle_check<'a>(commands: impl IntoIterator<Item = &'a f64>) -> u8 {
    let mut hasher = Hasher::new();
    commands.into_iter().for_each(|x| hasher.update(&x.to_bits().to_le_bytes()));
    hasher.finalize() as u8
}

/// Adds numbers to the checks of their muscles or joints; there are several numbers of each:
/// `[numbers x checks]`.
pub(crate) fn add_checks(checks: &mut [Hasher], numbers: &[f64]) {
    for row in numbers.chunks_exact(checks.len().max(1)) {
        checks.iter_mut().zip(row).for_each(|(check, x)| check.update(&x.to_bits().to_le_bytes()));
    }
}

/// The checks so far, which begin anew.
pub(crate) fn take_checks(checks: &mut [Hasher]) -> Vec<u32> {
    checks.iter_mut().map(|check| std::mem::take(check).finalize()).collect()
}

/// Consecutive cycles of a recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// Index of the first cycle.
    pub first: u64,
    /// Number of cycles.
    pub count: usize,
    /// `[columns][cycles]`, in the order of [`Head::fast`].
    pub fast: Vec<Vec<f64>>,
    /// `[columns][cycles/stride]`, in the order of [`Head::slow`].
    pub slow: Vec<Vec<f64>>,
    /// Low 8 bits of the CRC-32 over the exact commands of every cycle.
    pub cycle_checks: Vec<u8>,
    /// CRC-32 over the exact commands of all cycles: `[muscles]`.
    pub command_checks: Vec<u32>,
    /// CRC-32 over the exact references of all cycles: `[joints]`.
    pub reference_checks: Vec<u32>,
    /// Cycles lost before this block, since the start.
    pub dropped: u64,
    /// What its cycles took from a link, in its order.
    pub link: Vec<CycleInput>,
    /// Such inputs lost before the end of this block, since the start.
    pub dropped_link: u64,
}

impl Block {
    /// Decodes a message at a place in a file, with the cycles that follow it: time and message of those of
    /// every cycle and of the slow ones.
    pub(crate) fn decode(
        message: &BlockMessage,
        rows: [&[(u64, &[u8])]; 2],
        head: &Head,
        at: u64,
    ) -> Result<Self, Error> {
        let damaged = |expected, got: String| Error::Damaged { at, expected, got };
        let count = message.count as usize;
        if count == 0 || count > MAX_CYCLES {
            return Err(damaged("1 to 100000 cycles in a block", count.to_string()));
        }
        if message.first > LAST_CYCLE {
            return Err(damaged("a cycle below 2^52", message.first.to_string()));
        }
        let stride = head.stride.max(1);
        let slow_count = (message.first + count as u64).div_ceil(stride) - message.first.div_ceil(stride);
        let (fast_grids, slow_grids) = message.grids.split_at(message.grids.len().min(head.fast.len()));
        let columns = |specs, coded, grids, rows: &[_], count| match head.format {
            1 => format1::decode(specs, coded, count),
            _ => decode(specs, grids, rows, count, head.start_ns),
        };
        let fast = columns(&head.fast, &message.fast, fast_grids, rows[0], count);
        let fast = fast.ok_or_else(|| damaged("the columns of head.json", "other ones".to_owned()))?;
        let slow = columns(&head.slow, &message.slow, slow_grids, rows[1], slow_count as usize);
        let slow = slow.ok_or_else(|| damaged("the slow columns of head.json", "other ones".to_owned()))?;
        let sizes = [
            (message.cycle_checks.len(), count),
            (message.command_checks.len(), head.muscles.len()),
            (message.reference_checks.len(), head.joints.len()),
        ];
        if let Some((got, _)) = sizes.iter().find(|(got, expected)| got != expected) {
            return Err(damaged("checks of every cycle, muscle and joint", got.to_string()));
        }
        let link = message.link.iter().map(|input| {
            CycleInput::from_bytes(input.at_ns, &input.command)
                .map_err(|reason| damaged("the body of a Command packet", reason.about().to_owned()))
        });
        let link = link.collect::<Result<_, Error>>()?;
        Ok(Self {
            first: message.first,
            count,
            fast,
            slow,
            cycle_checks: message.cycle_checks.clone(),
            command_checks: message.command_checks.clone(),
            reference_checks: message.reference_checks.clone(),
            dropped: message.dropped,
            link,
            dropped_link: message.dropped_link,
        })
    }

    /// Place among the values of slow columns of a cycle of this block.
    #[must_use]
    pub fn slow_row(&self, cycle: usize, stride: u64) -> Option<usize> {
        let index = self.first + cycle as u64;
        let first = self.first.div_ceil(stride.max(1));
        index.is_multiple_of(stride.max(1)).then(|| (index / stride.max(1) - first) as usize)
    }
}

/// Latest cycle that is read: numbers of cycles are exact as floating-point numbers, and their sums do not
/// overflow.
const LAST_CYCLE: u64 = 1 << 52;
/// Longest block that is read.
const MAX_CYCLES: usize = 100_000;

/// Columns from their messages; none where these are of others or not as many.
fn decode(
    specs: &[ColumnSpec],
    grids: &[u32],
    rows: &[(u64, &[u8])],
    count: usize,
    start_ns: u64,
) -> Option<Vec<Vec<f64>>> {
    if rows.len() != count || grids.len() != specs.len() {
        return None;
    }
    let fields = Fields::new(specs);
    let mut columns = vec![vec![0.0; count]; specs.len()];
    for (row, (_, message)) in rows.iter().enumerate() {
        fields.decode(message, &mut columns, row)?;
    }
    for ((spec, column), number) in specs.iter().zip(&mut columns).zip(grids) {
        if spec.name == Signal::Deadline.row().name {
            let times = rows.iter().map(|(time, _)| time.saturating_sub(start_ns) as f64 * 1e-3);
            column.iter_mut().zip(times).for_each(|(to, us)| *to = us);
        }
        match &spec.coding {
            Coding::Rounded(resolution) => {
                let grid = Grid::new(*resolution);
                column.iter_mut().for_each(|x| *x = snapped(*x, &grid) + 0.0);
            }
            Coding::Exact(_) if *number == 0 => {}
            Coding::Exact(grids) => {
                let grid = grids.get(*number as usize - 1)?;
                column.iter_mut().for_each(|x| *x = snapped(*x, grid));
            }
        }
    }
    Some(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROWS: [&[(u64, &[u8])]; 2] = [&[(0, &[])], &[]];

    #[test]
    fn a_cycle_that_no_recording_reaches_is_refused() {
        let head = Head {
            format: head::FORMAT,
            program: String::new(),
            commit: String::new(),
            simulated: true,
            virtual_time: true,
            start_ns: 0,
            period_ns: 1,
            stride: head::STRIDE,
            machine: String::new(),
            muscles: Vec::new(),
            joints: Vec::new(),
            fast: Vec::new(),
            slow: Vec::new(),
        };
        let of = |first| BlockMessage { first, count: 1, cycle_checks: vec![0], ..BlockMessage::default() };
        assert!(Block::decode(&of(LAST_CYCLE), ROWS, &head, 0).is_ok());
        for first in [LAST_CYCLE + 1, u64::MAX] {
            let error = Block::decode(&of(first), ROWS, &head, 7).expect_err("too late").to_string();
            assert!(error.contains("byte 7: expected a cycle below 2^52"), "{error}");
        }
    }
}
