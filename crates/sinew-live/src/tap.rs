//! From the control cycle of a run to the page: a ring that never blocks the cycle, and a request to stop on
//! the way back.

use crate::choices::Choices;
use crate::command::Command;
use crate::drawing::Drawing;
use crate::error::LiveError;
use crate::frame::{Along, Frame, SILENT};
use crate::layout::{Contents, Layout};
use crate::scene::{SceneParts, scene};
use crate::signals::Signals;
use crate::source::Source;
use rtrb::{Consumer, Producer, RingBuffer};
use serde_json::Value;
use sinew::Error;
use sinew::control::supervisor::Request;
use sinew::machine::Machine;
use sinew::trajectory::Trajectory;
use sinew_session::signals::FrameLayout;
use sinew_session::{CycleRecord, Plant};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Time from a cycle that is shown to the next, s.
const EVERY: f64 = 0.016;
/// Shown cycles that the ring holds.
const RING: usize = 16;
/// Time without a cycle after which the run counts as silent.
const SILENCE: Duration = Duration::from_millis(500);

/// A run that is shown.
pub struct RunParts {
    /// With its payload.
    pub machine: Machine,
    /// The motion; none where a client commands it.
    pub trajectory: Option<Trajectory>,
    /// Name of the path.
    pub path: String,
    /// What moves: `twin`, `segment` or `ethercat`.
    pub bus: &'static str,
    /// Whether the machine is simulated.
    pub simulated: bool,
    /// Whether the cycle keeps deadlines.
    pub timed: bool,
    /// Smallest and largest tension at every anchor, N: `[muscles]`.
    pub tension_limits: Vec<[f64; 2]>,
}

/// The side of the control cycle.
#[derive(Debug)]
pub struct Tap {
    ring: Producer<f64>,
    layout: Arc<FrameLayout>,
    count: u64,
    /// Cycles from one that is shown to the next.
    every: u64,
    stop: Arc<AtomicBool>,
}

/// The side of the page: shows what the tap was given.
#[derive(Debug)]
pub struct Run {
    ring: Consumer<f64>,
    words: Vec<f64>,
    now: Signals,
    /// When the last cycle came.
    heard: Option<Instant>,
    parts: RunParts,
    choices: Choices,
    drawing: Drawing,
    layout: Layout,
    sequence: u64,
    stop: Arc<AtomicBool>,
}

impl std::fmt::Debug for RunParts {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "{} along {} on {}", self.machine.robot.parts().name, self.path, self.bus)
    }
}

/// Both sides of a run's page.
///
/// # Errors
/// For a machine whose kinematics cannot be evaluated.
pub fn tap(parts: RunParts) -> Result<(Tap, Run), Error> {
    let contents =
        Contents { truth: parts.simulated, timed: parts.timed, ..Contents::simulated(&parts.machine) };
    let [_, joints, muscles] = contents.sizes;
    let now = Signals::unknown([muscles, joints], parts.simulated);
    let cycle = Arc::clone(now.frame.layout());
    let (producer, consumer) = RingBuffer::new(RING * (1 + cycle.words()));
    let every = (EVERY / parts.machine.period).round().max(1.0) as u64;
    let stop = Arc::new(AtomicBool::new(false));
    let choices = Choices { tension_limits: parts.tension_limits.clone(), ..Choices::default() };
    let run = Run {
        ring: consumer,
        words: vec![f64::NAN; 1 + cycle.words()],
        now,
        heard: None,
        choices,
        drawing: Drawing::new(&parts.machine)?,
        layout: Layout::new(&contents),
        sequence: 0,
        stop: Arc::clone(&stop),
        parts,
    };
    Ok((Tap { ring: producer, layout: cycle, count: 0, every, stop }, run))
}

impl Tap {
    /// Offers a cycle to the page, which takes one of some; where the page is slow, it misses it. Allocates
    /// nothing, takes no lock and makes no system call.
    pub fn show<P: Plant>(&mut self, record: &CycleRecord<'_, P>) {
        let due = self.count.is_multiple_of(self.every);
        self.count += 1;
        if !due {
            return;
        }
        // The ring holds whole cycles only, so that none is split at its end.
        let Ok(mut chunk) = self.ring.write_chunk(1 + self.layout.words()) else { return };
        let (words, _) = chunk.as_mut_slices();
        let (time, frame) = words.split_at_mut(1);
        time.fill(record.moment.time);
        self.layout.fill(frame, &record.seen());
        chunk.commit_all();
    }

    /// Whether the page has asked for a safe stop: what a control cycle looks at.
    #[must_use]
    pub fn stop(&self) -> &Arc<AtomicBool> {
        &self.stop
    }
}

impl Source for Run {
    fn revision(&self) -> u32 {
        1
    }

    fn scene(&mut self) -> Result<Value, LiveError> {
        let Self { parts, choices, drawing, layout, .. } = self;
        let parts = SceneParts {
            machine: &parts.machine,
            layout,
            choices,
            revision: 1,
            source: parts.bus,
            simulated: parts.simulated,
            trajectory: parts.trajectory.as_ref(),
            path: &parts.path,
            notice: None,
            compared: None,
            commands: &["mode"],
            requests: vec![Request::SafeStop.name()],
            failures: &[],
            interpolated: true,
            recorded: None,
        };
        Ok(scene(&parts, drawing)?)
    }

    fn state(&mut self) -> Result<Vec<u8>, LiveError> {
        self.sequence += 1;
        let heard = self.heard.is_some_and(|heard| heard.elapsed() < SILENCE);
        let frame = Frame {
            revision: 1,
            sequence: self.sequence,
            flags: if heard { 0 } else { SILENT },
            speed: 1.0,
            now: &self.now,
            along: &Along::between_ends(&self.parts.machine, &self.now),
            second: None,
        };
        Ok(frame.message(&self.layout, &mut self.drawing)?)
    }

    fn advance(&mut self, _: f64, _: &mut dyn FnMut() -> bool) -> Result<(), LiveError> {
        while self.ring.pop_entire_slice(&mut self.words).is_ok() {
            self.now.time = self.words[0];
            self.now.frame.words_mut().copy_from_slice(&self.words[1..]);
            self.heard = Some(Instant::now());
        }
        Ok(())
    }

    fn command(&mut self, command: &Command) -> Result<(), String> {
        match command {
            Command::Mode(Request::SafeStop) => {
                self.stop.store(true, Ordering::Relaxed);
                Ok(())
            }
            Command::Mode(_) => Err("a run of its own can be stopped from the page, nothing else".to_owned()),
            _ => Err("a run of its own is watched, and stopped, but not commanded from the page".to_owned()),
        }
    }
}
