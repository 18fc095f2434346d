//! The cycles of a recording at any time, decoded block by block where they are requested.

use super::events::EventList;
use crate::scene::Event;
use crate::signals::Signals;
use sinew_record::{Block, BlockPlace, Error, Head, Recording, Signal};
use std::collections::VecDeque;

/// Decoded blocks that are kept.
const KEPT: usize = 4;

/// A recording in memory.
#[derive(Debug)]
pub(crate) struct Cycles {
    bytes: Vec<u8>,
    pub(crate) head: Head,
    /// What is missing, in words.
    pub(crate) notice: Option<String>,
    pub(crate) events: Vec<Event>,
    /// First cycle, number of cycles and place of every block, in time.
    index: Vec<(u64, usize, BlockPlace)>,
    /// Signals that it has, and their first columns.
    columns: Vec<(Signal, usize)>,
    decoded: VecDeque<(usize, Block)>,
}

impl Cycles {
    /// Reads the head and looks through all cycles for events; `progress` gets the fraction that is done.
    ///
    /// # Errors
    /// As [`Recording::read`]; [`Error::Damaged`] for a recording without a cycle.
    pub(crate) fn open(bytes: Vec<u8>, mut progress: impl FnMut(f64)) -> Result<Self, Error> {
        let recording = Recording::read(&bytes)?;
        let (mut index, mut list) = (Vec::new(), EventList::new(&recording.head));
        let mut blocks = recording.blocks();
        while let Some(place) = blocks.next_place() {
            let block = place.decode(&bytes, &recording.head)?;
            list.add(&block);
            progress((index.len() + 1) as f64 / recording.chunks().max(1) as f64);
            // Cycles that stand twice or out of order would make time ambiguous.
            let after = index.last().map_or(0, |(first, count, _)| first + *count as u64);
            if block.first >= after {
                index.push((block.first, block.count, place));
            }
        }
        if index.is_empty() {
            let expected = "at least one block of cycles";
            let got =
                if recording.complete { "none" } else { "none: the file was cut short before the first" };
            return Err(Error::Damaged { at: bytes.len() as u64, expected, got: got.to_owned() });
        }
        let notice = notice(&recording, list.missing());
        let events = list.finish();
        let head = recording.head;
        let place = |signal: &Signal| Some((*signal, head.place(*signal)?));
        let columns = Signal::ALL.iter().filter_map(place).collect();
        Ok(Self { head, notice, events, index, columns, decoded: VecDeque::new(), bytes })
    }

    /// Index of the last cycle.
    pub(crate) fn last(&self) -> u64 {
        self.index.last().map_or(0, |(first, count, _)| first + *count as u64 - 1)
    }

    /// Time of the last cycle, s.
    pub(crate) fn duration(&self) -> f64 {
        self.last() as f64 * self.head.period_s()
    }

    /// Number of the block that a cycle is in; of one that is missing, the one before it.
    fn block_of(&self, cycle: u64) -> usize {
        self.index.partition_point(|(first, ..)| *first <= cycle).saturating_sub(1)
    }

    /// Decodes a block, unless it is at hand; its place among those that are kept.
    fn decode(&mut self, number: usize) -> Result<usize, Error> {
        if let Some(place) = self.decoded.iter().position(|(other, _)| *other == number) {
            return Ok(place);
        }
        let block = self.index[number].2.decode(&self.bytes, &self.head)?;
        if self.decoded.len() == KEPT {
            self.decoded.pop_front();
        }
        self.decoded.push_back((number, block));
        Ok(self.decoded.len() - 1)
    }

    /// Signals at a time, s; nothing is known after the end.
    ///
    /// # Errors
    /// [`Error::Damaged`]; not for what [`open`](Self::open) has read.
    pub(crate) fn at(&mut self, time: f64) -> Result<Signals, Error> {
        let (muscles, joints) = (self.head.muscles.len(), self.head.joints.len());
        let mut now = Signals::unknown([muscles, joints], self.head.simulated);
        now.time = time;
        let place = time / self.head.period_s();
        let cycle = place.round().max(0.0) as u64;
        if cycle > self.last() {
            return Ok(now);
        }
        let number = self.block_of(cycle);
        let (first, count, _) = self.index[number];
        let row = cycle.saturating_sub(first).min(count as u64 - 1) as usize;
        let at = self.decode(number)?;
        let stride = self.head.stride;
        let block = &self.decoded[at].1;
        for (signal, first) in self.columns.iter().filter(|(signal, _)| !signal.row().slow) {
            let columns = block.fast.iter().skip(*first);
            let numbers = columns.map(|column| column.get(row).copied().unwrap_or(f64::NAN));
            now.frame.of_mut(*signal).iter_mut().zip(numbers).for_each(|(to, from)| *to = from);
        }
        // Slow columns between the two of their rows that the time is between, the second possibly of the
        // next block.
        let lower = (place.max(0.0) / stride as f64).floor();
        let fraction = place.max(0.0) / stride as f64 - lower;
        let rows = [lower as u64 * stride, (lower as u64 + 1) * stride];
        let [before, after] = [self.slow(rows[0])?, self.slow(rows[1])?];
        let (before, after) = match (before, after) {
            (Some(before), Some(after)) => (before, after),
            (Some(only), None) | (None, Some(only)) => (only.clone(), only),
            (None, None) => return Ok(now),
        };
        for (signal, first) in self.columns.iter().filter(|(signal, _)| signal.row().slow) {
            let rows = before.iter().zip(&after).skip(*first);
            for (to, (a, b)) in now.frame.of_mut(*signal).iter_mut().zip(rows) {
                *to = if b.is_finite() { a + fraction * (b - a) } else { *a };
            }
        }
        Ok(now)
    }

    /// Signals that the recording does not have, a bit each.
    pub(crate) fn lacks(&self) -> u64 {
        let has = self.columns.iter().fold(0, |bits, (signal, _)| bits | 1 << *signal as u64);
        !has
    }

    /// Values of all slow columns in a cycle; none where it is missing.
    fn slow(&mut self, cycle: u64) -> Result<Option<Vec<f64>>, Error> {
        let number = self.block_of(cycle);
        let (first, count, _) = self.index[number];
        if cycle < first || cycle >= first + count as u64 {
            return Ok(None);
        }
        let stride = self.head.stride;
        let at = self.decode(number)?;
        let block = &self.decoded[at].1;
        let row = block.slow_row((cycle - first) as usize, stride);
        Ok(row.map(|row| {
            block.slow.iter().map(|column| column.get(row).copied().unwrap_or(f64::NAN)).collect()
        }))
    }
}

/// What is missing in a recording, in words; none where it is whole.
fn notice(recording: &Recording<'_>, missing: u64) -> Option<String> {
    let mut parts = Vec::new();
    if !recording.complete {
        parts.push(format!(
            "The recording was cut short: its end is missing, {} bytes after the last whole part are left out.",
            recording.cut_off
        ));
    }
    if missing > 0 {
        parts.push(format!(
            "{missing} cycles are missing, because the file could not be written fast enough."
        ));
    }
    (!parts.is_empty()).then(|| parts.join(" "))
}
