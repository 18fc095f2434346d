//! A machine that is moved along a motion without forces: what is shown of one that cannot make it by its
//! muscles.

use crate::choices::Choices;
use crate::command::Command;
use crate::drawing::Drawing;
use crate::error::LiveError;
use crate::frame::{Along, Frame, PAUSED};
use crate::layout::{Contents, Layout};
use crate::scene::{SceneParts, scene};
use crate::signals::Signals;
use crate::source::Source;
use serde_json::Value;
use sinew::Error;
use sinew::machine::Machine;
use sinew::trajectory::{Reference, Trajectory};
use sinew_session::signals::Signal;

/// Bodies and muscles along a motion; no tension is known.
#[derive(Debug)]
pub struct Kinematic {
    machine: Machine,
    trajectory: Trajectory,
    path: String,
    notice: String,
    choices: Choices,
    drawing: Drawing,
    layout: Layout,
    now: Signals,
    at: Reference,
    sequence: u64,
    time: f64,
    speed: f64,
    paused: bool,
}

impl Kinematic {
    /// At the beginning of a motion; `notice` says why nothing more is shown.
    ///
    /// # Errors
    /// For a machine whose kinematics cannot be evaluated.
    pub fn new(
        machine: Machine,
        trajectory: Trajectory,
        (path, notice): (String, String),
        tension_limits: Vec<[f64; 2]>,
    ) -> Result<Self, Error> {
        let contents = Contents { forces: false, truth: false, ..Contents::simulated(&machine) };
        let [_, joints, muscles] = contents.sizes;
        let mut now = Signals::unknown([muscles, joints], true);
        // No supervisor, no mode.
        now.frame.of_mut(Signal::Mode).fill(f64::from(u8::MAX));
        Ok(Self {
            drawing: Drawing::new(&machine)?,
            layout: Layout::new(&contents),
            now,
            at: Reference::new(trajectory.joints()),
            choices: Choices { tension_limits, ..Choices::default() },
            machine,
            trajectory,
            path,
            notice,
            sequence: 0,
            time: 0.0,
            speed: 1.0,
            paused: false,
        })
    }

    fn pass(&mut self, seconds: f64) {
        let duration = self.trajectory.duration();
        let time = self.time + seconds;
        self.time = if self.trajectory.is_closed() { time } else { time.min(duration) };
    }
}

impl Source for Kinematic {
    fn revision(&self) -> u32 {
        1
    }

    fn scene(&mut self) -> Result<Value, LiveError> {
        let Self { machine, trajectory, path, notice, choices, drawing, layout, .. } = self;
        let parts = SceneParts {
            machine,
            layout,
            choices,
            revision: 1,
            source: "kinematic",
            simulated: true,
            trajectory: Some(trajectory),
            path,
            notice: Some(notice),
            compared: None,
            commands: &["speed", "step"],
            requests: Vec::new(),
            failures: &[],
            interpolated: true,
            recorded: None,
        };
        Ok(scene(&parts, drawing)?)
    }

    fn state(&mut self) -> Result<Vec<u8>, LiveError> {
        self.sequence += 1;
        let duration = self.trajectory.duration().max(self.machine.period);
        let along = if self.trajectory.is_closed() { self.time % duration } else { self.time };
        self.trajectory.sample(along, &mut self.at)?;
        self.now.time = self.time;
        self.now.frame.of_mut(Signal::JointReference).copy_from_slice(&self.at.q);
        let frame = Frame {
            revision: 1,
            sequence: self.sequence,
            flags: if self.paused { PAUSED } else { 0 },
            speed: self.speed,
            now: &self.now,
            along: &Along::between_ends(&self.machine, &self.now),
            second: None,
        };
        Ok(frame.message(&self.layout, &mut self.drawing)?)
    }

    fn advance(&mut self, seconds: f64, _: &mut dyn FnMut() -> bool) -> Result<(), LiveError> {
        if !self.paused {
            self.pass(seconds * self.speed);
        }
        Ok(())
    }

    fn command(&mut self, command: &Command) -> Result<(), String> {
        match command {
            Command::Speed { factor, paused } => {
                self.speed = factor.unwrap_or(self.speed);
                self.paused = paused.unwrap_or(self.paused);
                Ok(())
            }
            Command::Step(cycles) => {
                self.paused = true;
                self.pass(f64::from(*cycles) * self.machine.period);
                Ok(())
            }
            _ => Err("this machine is shown without forces; only its time can be commanded".to_owned()),
        }
    }
}
