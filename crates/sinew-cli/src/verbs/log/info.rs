//! `sinew log info`.

use crate::answer::{Answer, Content};
use crate::arguments::{General, LogInfoArguments};
use crate::error::Error;
use crate::verbs::recording::{RunSetup, read_bytes, recording};
use serde::Serialize;
use sinew_record::{Block, Recording, bus_fault_of, status_of};
use std::fmt::Write;
use std::path::Path;

pub(super) fn run(arguments: &LogInfoArguments, general: &General) -> Result<Answer, Error> {
    let bytes = read_bytes(&arguments.file)?;
    let recording = recording(&arguments.file, &bytes)?;
    let setup = RunSetup::from_recording(&arguments.file, &recording)?;
    let info = Info::new(&arguments.file, &recording, &setup, bytes.len() as u64)?;
    let content = if general.json { Content::json(&info)? } else { Content::Text(info.text(&setup)) };
    Ok(Answer::done(content, Vec::new()))
}

/// What a recording holds.
#[derive(Debug, Serialize)]
struct Info {
    machine: String,
    simulated: bool,
    virtual_time: bool,
    program: String,
    commit: String,
    path: String,
    /// In words.
    #[serde(skip)]
    motion: String,
    seed: u64,
    compensation: String,
    bus: String,
    complete: bool,
    /// Bytes after the last whole chunk.
    cut_off_bytes: u64,
    bytes: u64,
    cycles: u64,
    duration_s: f64,
    bytes_per_hour: f64,
    dropped: u64,
    /// Cycles in which the bus had a fault.
    bus_faults: u64,
    chunks: usize,
    muscles: usize,
    joints: usize,
    /// Intervals of one status, the first [`MAX_INTERVALS`], and how many more there are.
    status: Vec<StatusInterval>,
    status_left_out: usize,
    attachments: Vec<Attachment>,
}

#[derive(Debug, Serialize)]
pub(super) struct StatusInterval {
    pub(super) from_s: f64,
    pub(super) status: String,
}

#[derive(Debug, Serialize)]
struct Attachment {
    name: String,
    bytes: u64,
}

/// Intervals that are listed.
const MAX_INTERVALS: usize = 200;

/// A number of a column; 0 where the recording has no such column.
fn at(block: &Block, place: Option<usize>, row: usize) -> f64 {
    place.and_then(|place| block.fast.get(place)).map_or(0.0, |column| column[row])
}

/// Modes, states and faults of a recording, one after the other.
pub(super) fn intervals(file: &Path, recording: &Recording<'_>) -> Result<Vec<StatusInterval>, Error> {
    let head = &recording.head;
    let places = ["status", "fault", "mode", "mode_fault"]
        .map(|name| head.fast.iter().position(|column| column.name == name));
    let (mut last, mut intervals) = (None, Vec::new());
    for block in recording.blocks() {
        let block = block.map_err(Error::recording(file))?;
        for row in 0..block.count {
            let now = places.map(|place| at(&block, place, row));
            if last != Some(now) {
                let status = head.mode_name(now[2], now[3], status_of(now[0], now[1]));
                let from_s = (block.first + row as u64) as f64 * head.period_s();
                intervals.push(StatusInterval { from_s, status });
            }
            last = Some(now);
        }
    }
    Ok(intervals)
}

impl Info {
    fn new(file: &Path, recording: &Recording<'_>, setup: &RunSetup, bytes: u64) -> Result<Self, Error> {
        let head = &recording.head;
        let place = |name: &str| head.fast.iter().position(|column| column.name == name);
        let [kind, detail] = ["bus_fault", "bus_detail"].map(place);
        let (mut cycles, mut dropped, mut bus_faults, mut end) = (0, 0, 0, 0.0_f64);
        for block in recording.blocks() {
            let block = block.map_err(Error::recording(file))?;
            (cycles, dropped) = (cycles + block.count as u64, block.dropped);
            end = end.max((block.first + block.count as u64) as f64 * head.period_s());
            for row in 0..block.count {
                let [kind, detail] = [kind, detail].map(|place| at(&block, place, row));
                bus_faults += u64::from(bus_fault_of(kind, detail).is_some());
            }
        }
        let mut intervals = intervals(file, recording)?;
        let left_out = intervals.len().saturating_sub(MAX_INTERVALS);
        intervals.truncate(MAX_INTERVALS);
        let attachments = recording
            .files
            .iter()
            .map(|file| Attachment { name: file.name.clone(), bytes: file.bytes.len() as u64 });
        Ok(Self {
            machine: head.machine.clone(),
            simulated: head.simulated,
            virtual_time: head.virtual_time,
            program: head.program.clone(),
            commit: head.commit.clone(),
            path: setup.path.clone(),
            motion: setup.motion(),
            seed: setup.seed,
            compensation: setup.compensation.clone(),
            bus: setup.bus.clone(),
            complete: recording.complete,
            cut_off_bytes: recording.cut_off,
            bytes,
            cycles,
            duration_s: end,
            bytes_per_hour: if end > 0.0 { bytes as f64 / end * 3600.0 } else { 0.0 },
            dropped,
            bus_faults,
            chunks: recording.chunks(),
            muscles: head.muscles.len(),
            joints: head.joints.len(),
            status: intervals,
            status_left_out: left_out,
            attachments: attachments.collect(),
        })
    }

    fn text(&self, setup: &RunSetup) -> String {
        let mut text = String::new();
        let simulated = if self.simulated { "SIMULATED " } else { "" };
        let ended = if self.complete { "complete" } else { "cut off: its end is missing" };
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "{simulated}{}, {} joints, {} muscles, {}, compensation {}, seed {}, bus {}",
            self.machine, self.joints, self.muscles, self.motion, self.compensation, self.seed, self.bus
        );
        let _ = writeln!(text, "By sinew {} ({})", self.program, self.commit);
        let _ = writeln!(
            text,
            "{} cycles, {:.3} s, {} missing, {} with a fault of the bus; {ended}",
            self.cycles, self.duration_s, self.dropped, self.bus_faults
        );
        let _ = writeln!(
            text,
            "{:.2} MB in {} chunks, {:.0} MB per hour",
            1e-6 * self.bytes as f64,
            self.chunks,
            1e-6 * self.bytes_per_hour
        );
        if !setup.faults.is_empty() {
            let _ = writeln!(text, "Injected faults: {}", setup.faults.join(", "));
        }
        for interval in &self.status {
            let _ = writeln!(text, "{:>10.3} s  {}", interval.from_s, interval.status);
        }
        if self.status_left_out > 0 {
            let _ = writeln!(text, "{} more intervals", self.status_left_out);
        }
        for attachment in &self.attachments {
            let _ = writeln!(text, "Attachment: {} ({} bytes)", attachment.name, attachment.bytes);
        }
        text
    }
}
