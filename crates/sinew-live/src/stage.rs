//! One or two simulated machines in time, and what is shown of them.

use crate::choices::Choices;
use crate::command::Command;
use crate::drawing::{Drawing, POINTS};
use crate::error::LiveError;
use crate::layout::Layout;
use crate::scene::{SceneParts, scene};
use crate::simulation::{CYCLE, Simulation, SimulationParts};
use serde_json::Value;
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

/// Most simulated time that is caught up at once, s.
const MOST_DUE: f64 = 0.05;

impl Stage {
    /// A stage with one machine under these conditions.
    ///
    /// # Errors
    /// The reason for which they are refused.
    pub fn new(mut source: Box<dyn SimulationSource>, conditions: Conditions) -> Result<Self, String> {
        let choices = source.choices();
        let parts = source.prepare(&conditions)?;
        let trajectory = Arc::clone(&parts.trajectory);
        let drawing = Drawing::new(&parts.machine).map_err(|error| error.to_string())?;
        let first = Simulation::new(parts).map_err(|error| error.to_string())?;
        let layout = Layout::new(sizes(&first), false);
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

    /// Number of the present scene.
    pub(crate) fn revision(&self) -> u32 {
        self.revision
    }

    /// The answer to `/scene`.
    pub(crate) fn scene(&mut self) -> Result<Value, LiveError> {
        let parts = SceneParts {
            machine: self.first.machine(),
            trajectory: &self.trajectory,
            layout: &self.layout,
            choices: &self.choices,
            compared: self.second.as_ref().map(|(variant, _)| variant.as_str()),
            path: &self.conditions.path,
            revision: self.revision,
        };
        Ok(scene(&parts, &mut self.drawing)?)
    }

    /// Lets real time pass, s, until `is_spent` says that the next picture is due or a command waits.
    ///
    /// # Errors
    /// As [`Simulation::step`].
    pub(crate) fn advance(
        &mut self,
        seconds: f64,
        mut is_spent: impl FnMut() -> bool,
    ) -> Result<(), LiveError> {
        if self.paused {
            self.behind = false;
            return Ok(());
        }
        self.due += seconds * self.speed;
        while self.due >= CYCLE {
            if is_spent() {
                self.behind = self.due > MOST_DUE;
                self.due = self.due.min(MOST_DUE);
                return Ok(());
            }
            self.cycle()?;
            self.due -= CYCLE;
        }
        self.behind = false;
        Ok(())
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

    /// Executes a command.
    ///
    /// # Errors
    /// The reason for which it is refused, for the person at the page.
    pub fn command(&mut self, command: &Command) -> Result<(), String> {
        let words = |error: sinew::Error| error.to_string();
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
                self.first.push(&mut self.drawing, at, *force, *duration).map_err(words)?;
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
            Command::Speed { factor, paused } => (self.speed, self.paused) = (*factor, *paused),
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

    fn compared(&self) -> Option<String> {
        self.second.as_ref().map(|(variant, _)| variant.clone())
    }

    /// Both machines begin anew; nothing changes where the conditions are refused.
    fn restart(&mut self, conditions: Conditions, compared: Option<String>) -> Result<(), String> {
        let parts = self.source.prepare(&conditions)?;
        let trajectory = Arc::clone(&parts.trajectory);
        let words = |error: sinew::Error| error.to_string();
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
        self.layout = Layout::new(sizes(&first), second.is_some());
        (self.first, self.second, self.drawing) = (first, second, drawing);
        (self.conditions, self.trajectory, self.due) = (conditions, trajectory, 0.0);
        self.revision += 1;
        Ok(())
    }

    /// The next state message.
    pub(crate) fn state(&mut self) -> Result<Vec<u8>, LiveError> {
        self.sequence += 1;
        let Self { first, second, drawing, layout, .. } = self;
        let (mut poses, mut ghost, mut points, mut poses_2) =
            (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut end_2 = None;
        if let Some((_, second)) = second {
            drawing.evaluate(second.plant().truth().q)?;
            drawing.bodies(&mut poses_2);
            end_2 = drawing.end_point();
        }
        drawing.evaluate(&first.shown().reference)?;
        drawing.bodies(&mut ghost);
        let end_reference = drawing.end_point();
        drawing.evaluate(first.plant().truth().q)?;
        drawing.bodies(&mut poses);
        drawing.cables(&mut points)?;
        let end = drawing.end_point();
        let (tension, sliding) = first.along_cables()?;
        let flags = f64::from(u8::from(self.paused) + 2 * u8::from(self.behind));
        let (shown, plant) = (first.shown(), first.plant());
        let (truth, reading) = (plant.truth(), plant.reading());
        let fault = shown.fault;
        Ok(layout.message(self.revision, |name, out| match name {
            "time_s" => out.push(first.time()),
            "sequence" => out.push(self.sequence as f64),
            "mode" => out.push(f64::from(shown.mode as u8)),
            "fault" => out.push(fault.map_or(0.0, |fault| f64::from(fault.kind() as u8))),
            "fault_index" => out.push(fault.and_then(|fault| fault.index()).unwrap_or(0) as f64),
            "flags" => out.push(flags),
            "speed" => out.push(self.speed),
            "body_pose" => out.extend(&poses),
            "reference_pose" => out.extend(&ghost),
            "body_pose_2" => out.extend(&poses_2),
            "cable_points" => out.extend(&points),
            "cable_tension" => out.extend(&tension),
            "cable_sliding" => out.extend(&sliding),
            "end_point" => out.extend(end.into_iter().flatten()),
            "end_point_reference" => out.extend(end_reference.into_iter().flatten()),
            "end_point_2" => out.extend(end_2.into_iter().flatten()),
            "joint_true" => out.extend(truth.q),
            "joint_estimated" => out.extend(&shown.estimated),
            "joint_reference" => out.extend(&shown.reference),
            "tension_in" => out.extend(&reading.tension),
            "tension_out_desired" => out.extend(&shown.desired_tension),
            "tension_out_estimated" => out.extend(&shown.estimated_tension),
            "tension_out_true" => out.extend(truth.cables.iter().map(|cable| cable.tension_out)),
            "winch_position" => out.extend(&reading.motor),
            "motor_temperature" => out.extend((0..reading.motor.len()).map(|k| plant.winding(k))),
            _ => {}
        }))
    }
}

/// Bodies, joints, muscles and points of a simulation.
fn sizes(simulation: &Simulation) -> [usize; 4] {
    let machine = simulation.machine();
    let robot = &machine.robot;
    let muscles = machine.muscles.len();
    [robot.parts().bodies.len(), robot.independent_joints().len(), muscles, muscles * POINTS]
}
