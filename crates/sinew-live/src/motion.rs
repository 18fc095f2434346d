//! References of the joints: along the path, to where the end point is dragged, or at rest.

use sinew::Error;
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::supervisor::{Mode, Request, Supervisor};
use sinew::machine::{Machine, Task};
use sinew::trajectory::online::{JointLimits, Setpoint, SetpointFollower};
use sinew::trajectory::{Moment, Trajectory, finite_ranges};
use sinew_session::signals::Seen;
use sinew_session::{CycleTime, Desired, Motion, References};
use std::sync::Arc;

/// What is followed in [`Mode::Run`].
#[derive(Debug, Clone, Copy, PartialEq)]
enum Goal {
    /// The path, `time` s after its beginning.
    Path { time: f64 },
    /// The beginning of the path.
    PathStart { near_for: f64 },
    /// A place of the end point, m.
    Drag([f64; 3]),
    /// Rest.
    Stay,
}

/// What the page asks of one simulated machine.
#[derive(Debug, Clone)]
pub(crate) struct PageMotion {
    trajectory: Arc<Trajectory>,
    closed: bool,
    follower: SetpointFollower,
    goal: Goal,
    request: Request,
    /// Where the end point is to go once the machine rests.
    waiting: Option<[f64; 3]>,
    first: Vec<f64>,
    /// Mode after the last cycle.
    mode: Mode,
}

/// Joint error, rad or m, and time, s, at which the beginning of the path counts as reached.
const NEAR: f64 = 1e-3;
const NEAR_FOR: f64 = 0.3;

impl PageMotion {
    /// Along a trajectory, from its beginning.
    pub(crate) fn new(
        machine: &Machine,
        trajectory: Arc<Trajectory>,
        h: f64,
        mode: Mode,
    ) -> Result<Self, Error> {
        let ranges = finite_ranges(&machine.robot, &machine.start)?;
        let limits = JointLimits::of_motion(&trajectory, ranges)?;
        let point = match machine.task {
            Task::EndPoint { site, axes } => Some((site, axes, &machine.redundancy)),
            Task::Joints => None,
        };
        let (first, standing) = (trajectory.first()?, machine.standing(&trajectory)?);
        let follower = SetpointFollower::new(&machine.robot, limits, point, &standing, [PREVIEW_HORIZON, h])?;
        let begins =
            if standing == first { Goal::Path { time: 0.0 } } else { Goal::PathStart { near_for: 0.0 } };
        Ok(Self {
            closed: trajectory.is_closed(),
            trajectory,
            follower,
            goal: begins,
            request: Request::Run,
            waiting: None,
            first,
            mode,
        })
    }

    /// The newest reference, rad or m: `[joints]`.
    pub(crate) fn newest(&self) -> &[f64] {
        &self.follower.newest().q
    }

    /// Asks for a mode; to run leads to the beginning of the path and along it.
    pub(crate) fn ask(&mut self, request: Request) {
        self.waiting = None;
        self.request = request;
        let on_its_path = self.mode == Mode::Run && matches!(self.goal, Goal::Path { .. });
        if request == Request::Run && !on_its_path {
            self.goal = Goal::PathStart { near_for: 0.0 };
        }
    }

    /// The end point is dragged; a machine that moves along its path comes to rest first.
    ///
    /// Only where running or holding is asked for: a stop of the same picture, from this page or another,
    /// must stand.
    pub(crate) fn drag(&mut self, target: [f64; 3]) {
        if !matches!(self.request, Request::Run | Request::Hold) {
            return;
        }
        match self.goal {
            Goal::Drag(_) if self.mode == Mode::Run => self.goal = Goal::Drag(target),
            _ => {
                self.waiting = Some(target);
                if self.mode == Mode::Run && !matches!(self.goal, Goal::Stay) {
                    self.request = Request::Hold;
                }
            }
        }
    }

    /// The end point stays.
    pub(crate) fn release(&mut self) {
        self.waiting = None;
        if matches!(self.goal, Goal::Drag(_)) {
            self.goal = Goal::Stay;
        }
    }

    /// The references of the next cycle, `h` s after the last.
    fn follow(&mut self, h: f64, References { current, previewed }: &mut References) -> Result<(), Error> {
        let mode = self.mode;
        if let Some(target) = self.waiting
            && (mode == Mode::Hold || (mode == Mode::Run && self.goal == Goal::Stay))
        {
            (self.goal, self.waiting, self.request) = (Goal::Drag(target), None, Request::Run);
        }
        let Self { trajectory, follower, .. } = self;
        let running = mode == Mode::Run;
        let setpoint = match self.goal {
            Goal::Path { time } => {
                let duration = trajectory.duration();
                let again = |time: f64| if self.closed && time > duration { time - duration } else { time };
                trajectory.sample(time, current)?;
                trajectory.sample(again(time + PREVIEW_HORIZON), previewed)?;
                if running {
                    self.goal = Goal::Path { time: again(time + h) };
                }
                return Ok(());
            }
            _ if !running => Setpoint::Hold,
            Goal::PathStart { near_for } => {
                let newest = &follower.newest().q;
                let near = newest.iter().zip(&self.first).all(|(q, first)| (q - first).abs() < NEAR);
                let near_for = if near { near_for + h } else { 0.0 };
                self.goal = if near_for > NEAR_FOR + PREVIEW_HORIZON {
                    Goal::Path { time: 0.0 }
                } else {
                    Goal::PathStart { near_for }
                };
                Setpoint::Joints(&self.first, &[])
            }
            Goal::Drag(target) => Setpoint::EndPoint(target),
            Goal::Stay => Setpoint::Hold,
        };
        self.follower.step(setpoint, current, previewed).map(drop)
    }
}

impl Motion for PageMotion {
    fn sample(
        &mut self,
        at: CycleTime,
        _supervisor: &mut Supervisor,
        references: &mut References,
    ) -> Result<Desired, Error> {
        self.follow(at.period, references)?;
        let moment = Moment { time: at.seconds(), repeat: None, repeat_time: None, rested: 0.0 };
        Ok(Desired { moment, request: self.request, command_age: None })
    }

    /// What is held is where set-points begin.
    fn see(&mut self, _at: CycleTime, cycle: &Seen<'_>) {
        let command = &cycle.command;
        self.mode = command.mode;
        if self.mode != Mode::Run {
            self.follower.rest_at(&command.reference.q);
            if matches!(self.goal, Goal::Path { time } if time > 0.0) {
                self.goal = Goal::PathStart { near_for: 0.0 };
            }
        }
    }
}
