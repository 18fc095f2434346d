//! The time of a recording, and what is shown of it.

use super::cycles::Cycles;
use crate::choices::Choices;
use crate::command::Command;
use crate::drawing::Drawing;
use crate::error::LiveError;
use crate::frame::{Along, Frame, HistoryRow, PAUSED};
use crate::layout::{Contents, Layout, MessageKind, message};
use crate::scene::{Recorded, SceneParts, scene};
use crate::signals::Signals;
use crate::source::Source;
use serde_json::Value;
use sinew::machine::Machine;
use sinew::trajectory::Trajectory;

/// Time before now that a history shows, s, and its rows at most.
const HISTORY: f64 = 60.0;
const ROWS: f64 = 1500.0;
const COMMANDS: [&str; 3] = ["speed", "step", "seek"];

/// What a playback is made of.
#[derive(Debug)]
pub struct PlaybackParts {
    /// The machine as it was recorded, with its payload.
    pub machine: Machine,
    /// Its motion, if it had one.
    pub trajectory: Option<Trajectory>,
    /// Name of the path.
    pub path: String,
    /// The bytes of the file.
    pub bytes: Vec<u8>,
    /// Names and bytes of recordings of the same machine that can be laid over it; the first is at the start.
    pub overlays: Vec<(String, Vec<u8>)>,
    /// Smallest and largest tension at every anchor, N: `[muscles]`.
    pub tension_limits: Vec<[f64; 2]>,
}

/// A recording, played, and possibly a second one over it.
#[derive(Debug)]
pub struct Playback {
    machine: Machine,
    trajectory: Option<Trajectory>,
    path: String,
    choices: Choices,
    first: Cycles,
    names: Vec<String>,
    others: Vec<Cycles>,
    /// Which of the others is shown.
    over: Option<usize>,
    drawing: Drawing,
    layout: Layout,
    revision: u32,
    sequence: u64,
    /// Time that is shown, s.
    time: f64,
    speed: f64,
    paused: bool,
}

impl Playback {
    /// At the beginning of a recording, paused. `progress` gets the fraction of the files that was looked
    /// through.
    ///
    /// # Errors
    /// [`LiveError::Recording`] for a file that is none; [`LiveError::Overlay`] for recordings of different
    /// machines.
    pub fn new(parts: PlaybackParts, mut progress: impl FnMut(f64)) -> Result<Self, LiveError> {
        let PlaybackParts { machine, trajectory, path, bytes, overlays, tension_limits } = parts;
        let count = (1 + overlays.len()) as f64;
        let first = Cycles::open(bytes, |fraction| progress(fraction / count))?;
        let of_file = [first.head.muscles.len(), first.head.joints.len()];
        let of_machine = [machine.muscles.len(), machine.robot.independent_joints().len()];
        if of_file != of_machine {
            let reason = format!(
                "expected the {} muscles and {} joints of its machine file, got {} and {}",
                of_machine[0], of_machine[1], of_file[0], of_file[1]
            );
            return Err(sinew_record::Error::Attachment { name: "head.json".to_owned(), reason }.into());
        }
        let (mut names, mut others) = (Vec::new(), Vec::new());
        for (name, bytes) in overlays {
            let done = (1 + others.len()) as f64;
            let cycles = Cycles::open(bytes, |fraction| progress((done + fraction) / count))
                .map_err(|error| LiveError::Overlay { name: name.clone(), reason: error.to_string() })?;
            if (&cycles.head.muscles, &cycles.head.joints) != (&first.head.muscles, &first.head.joints) {
                let reason = format!(
                    "expected a recording of {} with the same muscles and joints, got one of {}",
                    first.head.machine, cycles.head.machine
                );
                return Err(LiveError::Overlay { name, reason });
            }
            names.push(name);
            others.push(cycles);
        }
        let drawing = Drawing::new(&machine)?;
        let mut playback = Self {
            choices: Choices { tension_limits, ..Choices::default() },
            over: (!others.is_empty()).then_some(0),
            drawing,
            layout: Layout::new(&Contents::simulated(&machine)),
            machine,
            trajectory,
            path,
            first,
            names,
            others,
            revision: 0,
            sequence: 0,
            time: 0.0,
            speed: 1.0,
            // The page plays it once it is open.
            paused: true,
        };
        playback.lay_out();
        Ok(playback)
    }

    /// What is missing in the recording, in words.
    #[must_use]
    pub fn notice(&self) -> Option<&str> {
        self.first.notice.as_deref()
    }

    /// Fields for what is shown now.
    fn lay_out(&mut self) {
        let head = &self.first.head;
        self.layout = Layout::new(&Contents {
            truth: head.simulated,
            lacks: self.first.lacks(),
            timed: !head.virtual_time,
            second: self.over.is_some(),
            ..Contents::simulated(&self.machine)
        });
        self.revision += 1;
    }

    /// The signals at a time, s, of both recordings.
    fn at(&mut self, time: f64) -> Result<(Signals, Option<Signals>), LiveError> {
        let now = self.first.at(time)?;
        let second = match self.over.and_then(|over| self.others.get_mut(over)) {
            Some(other) => Some(other.at(time)?),
            None => None,
        };
        Ok((now, second))
    }
}

impl Source for Playback {
    fn revision(&self) -> u32 {
        self.revision
    }

    fn scene(&mut self) -> Result<Value, LiveError> {
        let Self { machine, layout, choices, first, names, over, .. } = self;
        let mut commands = COMMANDS.to_vec();
        if !names.is_empty() {
            commands.push("overlay");
        }
        let parts = SceneParts {
            machine,
            layout,
            choices,
            revision: self.revision,
            source: "recording",
            simulated: first.head.simulated,
            trajectory: self.trajectory.as_ref(),
            path: &self.path,
            notice: first.notice.as_deref(),
            compared: over.and_then(|over| names.get(over)).map(String::as_str),
            commands: &commands,
            requests: Vec::new(),
            failures: &[],
            interpolated: true,
            recorded: Some(Recorded { duration: first.duration(), events: &first.events, overlays: names }),
        };
        Ok(scene(&parts, &mut self.drawing)?)
    }

    fn state(&mut self) -> Result<Vec<u8>, LiveError> {
        self.sequence += 1;
        let (now, second) = self.at(self.time)?;
        let frame = Frame {
            revision: self.revision,
            sequence: self.sequence,
            flags: if self.paused { PAUSED } else { 0 },
            speed: self.speed,
            now: &now,
            along: &Along::between_ends(&self.machine, &now),
            second: second.as_ref(),
        };
        Ok(frame.message(&self.layout, &mut self.drawing)?)
    }

    fn advance(&mut self, seconds: f64, _: &mut dyn FnMut() -> bool) -> Result<(), LiveError> {
        if !self.paused {
            self.time += seconds * self.speed;
            let end = self.first.duration();
            if self.time >= end {
                (self.time, self.paused) = (end, true);
            }
        }
        Ok(())
    }

    fn command(&mut self, command: &Command) -> Result<(), String> {
        let end = self.first.duration();
        match command {
            Command::Speed { factor, paused } => {
                self.speed = factor.unwrap_or(self.speed);
                self.paused = paused.unwrap_or(self.paused);
                // Played again from the beginning.
                if !self.paused && self.time >= end {
                    self.time = 0.0;
                }
            }
            Command::Step(cycles) => {
                self.paused = true;
                self.time = (self.time + f64::from(*cycles) * self.first.head.period_s()).min(end);
            }
            Command::Seek(time) => self.time = time.min(end),
            Command::Overlay(name) => {
                let place = |name: &String| {
                    let found = self.names.iter().position(|other| other == name);
                    found.ok_or_else(|| {
                        format!("no recording `{name}`; expected one of {}", self.names.join(", "))
                    })
                };
                self.over = name.as_ref().map(place).transpose()?;
                self.lay_out();
            }
            _ => return Err("a recording is watched, not commanded".to_owned()),
        }
        Ok(())
    }

    fn history(&mut self) -> Result<Option<Vec<u8>>, LiveError> {
        let period = self.first.head.period_s();
        let step = ((HISTORY / ROWS / period).round().max(1.0) * period).max(period);
        let count = (self.time.min(HISTORY) / step).floor() as u64;
        let mut rows = Vec::new();
        for k in (1..=count).rev() {
            let (now, second) = self.at(self.time - k as f64 * step)?;
            let row = HistoryRow { now: &now, second: second.as_ref() };
            row.write(&self.layout, &mut self.drawing, &mut rows)?;
        }
        Ok(Some(message(MessageKind::History, self.revision, &rows)))
    }
}
