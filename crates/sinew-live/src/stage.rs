//! One or two simulated machines in time, and what is shown of them.

use crate::choices::Choices;
use crate::command::Command;
use crate::drawing::Drawing;
use crate::error::LiveError;
use crate::frame::{BEHIND, Frame, PAUSED};
use crate::layout::{Contents, Layout};
use crate::scene::{SceneParts, scene};
use crate::simulation::{Simulation, SimulationParts};
use crate::source::Source;
use serde_json::Value;
use sinew::Error;
use sinew::control::supervisor::Request;
use sinew::trajectory::Trajectory;
use sinew::twin::arm::Failure;
use std::sync::Arc;

/// Under what a simulation is prepared.
#[derive(Debug, Clone, PartialEq)]
pub struct Conditions {
    /// Name of the path.
    pub path: String,
    /// Name of the compensation.
    pub variant: String,
    /// kg, at the end point.
    pub payload: f64,
}

/// Prepares simulations; errors are in words for the person at the page.
pub trait SimulationSource: Send {
    /// What can be chosen.
    fn choices(&self) -> Choices;

    /// A simulation at its beginning.
    ///
    /// # Errors
    /// The reason for which these conditions are refused.
    fn prepare(&mut self, conditions: &Conditions) -> Result<SimulationParts, String>;

    /// A failure and its duration, s, by the text of `--fault` without its time.
    ///
    /// # Errors
    /// What is wrong with the text.
    fn failure(&self, text: &str) -> Result<(Failure, f64), String>;
}

/// The machines, their time, and the commands of the page.
pub struct Stage {
    source: Box<dyn SimulationSource>,
    choices: Choices,
    conditions: Conditions,
    first: Simulation,
    second: Option<(String, Simulation)>,
    trajectory: Arc<Trajectory>,
    drawing: Drawing,
    layout: Layout,
    revision: u32,
    sequence: u64,
    speed: f64,
    paused: bool,
    /// Simulated time that is due, s.
    due: f64,
    /// Whether time could not keep up with the clock.
    behind: bool,
}

/// Commands that a simulated machine takes.
const COMMANDS: [&str; 8] = ["mode", "path", "drag", "push", "payload", "fault", "speed", "step"];
/// Most simulated time that is caught up at once, s.
const MAX_DUE: f64 = 0.05;

impl Stage {
    /// A stage with one machine, which was prepared under these conditions.
    ///
    /// # Errors
    /// Parts of different machines.
    pub fn new(
        source: Box<dyn SimulationSource>,
        conditions: Conditions,
        parts: SimulationParts,
    ) -> Result<Self, Error> {
        let choices = source.choices();
        let trajectory = Arc::clone(&parts.trajectory);
        let drawing = Drawing::new(&parts.machine)?;
        let first = Simulation::new(parts)?;
        let layout = Layout::new(&Contents::simulated(first.machine()));
        Ok(Self {
            source,
            choices,
            conditions,
            first,
            second: None,
            trajectory,
            drawing,
            layout,
            revision: 1,
            sequence: 0,
            speed: 1.0,
            paused: false,
            due: 0.0,
            behind: false,
        })
    }

    /// The machine; the first of two.
    #[must_use]
    pub fn simulation(&self) -> &Simulation {
        &self.first
    }

    fn cycle(&mut self) -> Result<(), LiveError> {
        self.first.step()?;
        if let Some((_, second)) = &mut self.second {
            second.step()?;
        }
        Ok(())
    }

    fn each(&mut self, mut call: impl FnMut(&mut Simulation)) {
        call(&mut self.first);
        if let Some((_, second)) = &mut self.second {
            call(second);
        }
    }

    fn compared(&self) -> Option<String> {
        self.second.as_ref().map(|(variant, _)| variant.clone())
    }

    /// Both machines begin anew; nothing changes where the conditions are refused.
    fn restart(&mut self, conditions: Conditions, compared: Option<String>) -> Result<(), String> {
        let parts = self.source.prepare(&conditions)?;
        let trajectory = Arc::clone(&parts.trajectory);
        let words = |error: Error| error.to_string();
        let drawing = Drawing::new(&parts.machine).map_err(words)?;
        let first = Simulation::new(parts).map_err(words)?;
        let second = match compared {
            None => None,
            Some(variant) => {
                let other = Conditions { variant: variant.clone(), ..conditions.clone() };
                let parts = self.source.prepare(&other)?;
                Some((variant, Simulation::new(parts).map_err(words)?))
            }
        };
        let contents = Contents { second: second.is_some(), ..Contents::simulated(first.machine()) };
        self.layout = Layout::new(&contents);
        (self.first, self.second, self.drawing) = (first, second, drawing);
        (self.conditions, self.trajectory, self.due) = (conditions, trajectory, 0.0);
        self.revision += 1;
        Ok(())
    }
}

impl Source for Stage {
    fn revision(&self) -> u32 {
        self.revision
    }

    fn scene(&mut self) -> Result<Value, LiveError> {
        let mut commands = COMMANDS.to_vec();
        commands.retain(|command| *command != "drag" || self.first.machine().task.site().is_some());
        if self.choices.variants.len() > 1 {
            commands.push("compare");
        }
        let parts = SceneParts {
            machine: self.first.machine(),
            layout: &self.layout,
            choices: &self.choices,
            revision: self.revision,
            source: "twin",
            simulated: true,
            trajectory: Some(&self.trajectory),
            path: &self.conditions.path,
            notice: None,
            compared: self.second.as_ref().map(|(variant, _)| variant.as_str()),
            commands: &commands,
            requests: Request::ALL[1..].iter().map(|request| request.name()).collect(),
            failures: &self.choices.failures,
            interpolated: false,
            recorded: None,
        };
        Ok(scene(&parts, &mut self.drawing)?)
    }

    fn state(&mut self) -> Result<Vec<u8>, LiveError> {
        self.sequence += 1;
        let along = self.first.along_cables()?;
        let flag = |set: bool, flag: u16| if set { flag } else { 0 };
        let second = self.second.as_ref().map(|(_, second)| second.signals());
        let frame = Frame {
            revision: self.revision,
            sequence: self.sequence,
            flags: flag(self.paused, PAUSED) | flag(self.behind, BEHIND),
            speed: self.speed,
            now: &self.first.signals(),
            along: &along,
            second: second.as_ref(),
        };
        Ok(frame.message(&self.layout, &mut self.drawing)?)
    }

    fn advance(&mut self, seconds: f64, is_spent: &mut dyn FnMut() -> bool) -> Result<(), LiveError> {
        if self.paused {
            self.behind = false;
            return Ok(());
        }
        self.due += seconds * self.speed;
        let period = self.first.machine().period;
        while self.due >= period {
            if is_spent() {
                self.behind = self.due > MAX_DUE;
                self.due = self.due.min(MAX_DUE);
                return Ok(());
            }
            self.cycle()?;
            self.due -= period;
        }
        self.behind = false;
        Ok(())
    }

    fn command(&mut self, command: &Command) -> Result<(), String> {
        let words = |error: Error| error.to_string();
        match command {
            Command::Mode(request) => self.each(|simulation| simulation.ask(*request)),
            Command::Drag(target) => {
                self.first.drag(*target)?;
                if let Some((_, second)) = &mut self.second {
                    second.drag(*target)?;
                }
            }
            Command::DragEnd => self.each(Simulation::release),
            Command::Push { body, point, force, duration } => {
                let bodies = self.first.machine().robot.parts().bodies.len();
                if !(1..bodies).contains(body) {
                    return Err(format!("body is {body}; expected 1 to {}", bodies - 1));
                }
                let at = (*body, *point);
                let felt = self.first.push(&mut self.drawing, at, *force, *duration).map_err(words)?;
                if felt == 0 {
                    return Err("a force on this body in this direction moves no joint".to_owned());
                }
                if let Some((_, second)) = &mut self.second {
                    second.push(&mut self.drawing, at, *force, *duration).map_err(words)?;
                }
            }
            Command::Fault(text) => {
                let (failure, duration) = self.source.failure(text)?;
                self.first.inject(failure, duration).map_err(words)?;
                if let Some((_, second)) = &mut self.second {
                    second.inject(failure, duration).map_err(words)?;
                }
            }
            Command::Speed { factor, paused } => {
                self.speed = factor.unwrap_or(self.speed);
                self.paused = paused.unwrap_or(self.paused);
            }
            Command::Seek(_) | Command::Overlay(_) => {
                return Err("only a recording has a time to go to and others to lay over it".to_owned());
            }
            Command::Step(cycles) => {
                self.paused = true;
                for _ in 0..*cycles {
                    self.cycle().map_err(|error| error.to_string())?;
                }
            }
            Command::Path(name) => {
                let conditions = Conditions { path: name.clone(), ..self.conditions.clone() };
                self.restart(conditions, self.compared())?;
            }
            Command::Payload(payload) => {
                let conditions = Conditions { payload: *payload, ..self.conditions.clone() };
                self.restart(conditions, self.compared())?;
            }
            Command::Compare(variant) => self.restart(self.conditions.clone(), variant.clone())?,
        }
        Ok(())
    }
}
