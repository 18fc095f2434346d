use super::goals::{Goal, SessionEvent};
use super::observed::Observed;
use super::source::Source;
use super::tape::{CycleInput, Taken, Tape};
use crate::Error;
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::supervisor::{Mode, Supervisor};
use sinew::machine::{Machine, Task};
use sinew::trajectory::Moment;
use sinew::trajectory::online::{
    EndPointStep, JointLimits, Limited, MuscleLengthStep, Setpoint, SetpointFollower,
};
use sinew_link::host::{Input, Port, SessionSettings};
use sinew_link::wire::{MAX_VALUES, flags};
use sinew_link::{Command, Counters, Playout, Pushed, SetpointKind, Snapshot};
use sinew_session::signals::Seen;
use sinew_session::{CycleTime, Desired, References};
use std::collections::VecDeque;
use std::time::Duration;

/// Requests and references from a link, in place of a schedule.
///
/// What sessions and requests make of its goal stands in [`GOAL_ROWS`](super::GOAL_ROWS); set-points count in
/// [`Mode::Run`] alone. In lock-step a command, and the end of its session, is taken once the machine's time
/// is where the one before let it go, so that results do not depend on when packets arrive.
#[derive(Debug)]
pub struct LinkedMotion {
    source: Source,
    settings: SessionSettings,
    playout: Playout,
    follower: SetpointFollower,
    lengths: MuscleLengthStep,
    end_point: Option<EndPointStep>,
    kind: SetpointKind,
    goal: Goal,
    /// Whether there is a client.
    attended: bool,
    /// Machine time of the last command, ns.
    commanded_at: Option<u64>,
    advance_to: u64,
    end: Option<u64>,
    mode: Mode,
    /// Whether the machine was in use, so that its turning off is the end.
    was_on: bool,
    limited: Limited,
    snapshot: Box<Snapshot>,
    observed: Observed,
    late: u64,
    /// Pose, tensions, numbers and rates of the set-point.
    pose: Vec<f64>,
    tensions: Vec<f64>,
    x: Vec<f64>,
    v: Vec<f64>,
}

/// Counts of a link at its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LinkCounts {
    /// Packets.
    pub packets: Counters,
    /// Points that came after their time, or while as many as there is room for were waiting.
    pub late_points: u64,
    /// States that the server did not take in time.
    pub dropped_states: u64,
}

/// Points that wait at most.
const POINTS: usize = 256;
/// Time in which a motion whose points fail to come ends, ns.
const BRAKE: u64 = 50_000_000;
/// Inputs taken in one cycle at most.
const INPUTS: usize = 8;
/// Longest wait in lock-step before the caller may stop.
const WAIT: Duration = Duration::from_millis(20);

impl LinkedMotion {
    /// At rest in a pose. References keep the limits; `end` is the machine's time at which the cycles end,
    /// ns, else they end when a client has turned the machine off.
    ///
    /// # Errors
    /// As [`SetpointFollower::new`].
    pub fn new(
        port: Port,
        settings: SessionSettings,
        machine: &Machine,
        limits: JointLimits,
        pose: &[f64],
        end: Option<u64>,
    ) -> Result<Self, Error> {
        Self::from_source(Source::Server(Box::new(port)), settings, machine, limits, (pose, end))
    }

    /// The same over inputs that were recorded, see [`supply`](Self::supply), from the first cycle on and
    /// without an end.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn replayed(
        settings: SessionSettings,
        machine: &Machine,
        limits: JointLimits,
        pose: &[f64],
    ) -> Result<Self, Error> {
        Self::from_source(Source::Recording(VecDeque::new()), settings, machine, limits, (pose, None))
    }

    fn from_source(
        source: Source,
        settings: SessionSettings,
        machine: &Machine,
        limits: JointLimits,
        (pose, end): (&[f64], Option<u64>),
    ) -> Result<Self, Error> {
        let point = match machine.task {
            Task::EndPoint { site, axes } => Some((site, axes, &machine.redundancy)),
            Task::Joints => None,
        };
        let step = |(site, axes, rule)| EndPointStep::new(&machine.robot, rule, site, axes, &limits.range);
        let end_point = point.map(step).transpose()?;
        let lengths = MuscleLengthStep::new(&machine.robot, &limits.range)?;
        let h = settings.period_ns as f64 * 1e-9;
        let follower = SetpointFollower::new(&machine.robot, limits, point, pose, [PREVIEW_HORIZON, h])?;
        let (joints, muscles) = (pose.len(), machine.muscles.len());
        let mut snapshot = Box::new(Snapshot::new(joints, muscles));
        for (joint, q) in snapshot.joints_mut().iter_mut().zip(pose) {
            (joint.joint_estimated, joint.joint_velocity, joint.joint_reference) = (*q, 0.0, *q);
        }
        Ok(Self {
            source,
            playout: Playout::new(MAX_VALUES, POINTS, settings.playout_delay_ns, BRAKE),
            goal: Goal::new(settings.unattended_ns),
            attended: false,
            settings,
            follower,
            lengths,
            end_point,
            kind: SetpointKind::None,
            commanded_at: None,
            advance_to: 0,
            end,
            mode: Mode::Off,
            was_on: false,
            limited: Limited::No,
            snapshot,
            observed: Observed::new([muscles, joints]),
            late: 0,
            pose: pose.to_vec(),
            tensions: vec![0.0; muscles],
            x: vec![0.0; MAX_VALUES],
            v: vec![0.0; MAX_VALUES],
        })
    }

    /// Kind of the set-points that are followed.
    #[must_use]
    pub fn setpoint(&self) -> SetpointKind {
        self.kind
    }

    /// Time since the last command, s; none before the first.
    fn command_age(&self, now: u64) -> Option<f64> {
        self.commanded_at.map(|at| now.saturating_sub(at) as f64 * 1e-9)
    }

    /// Whether the cycles end before the one of a time, ns.
    #[must_use]
    pub fn is_finished(&self, now: u64) -> bool {
        self.end.is_some_and(|end| now >= end) || (self.was_on && self.mode == Mode::Off)
    }

    /// Counts so far.
    #[must_use]
    pub fn counts(&self) -> LinkCounts {
        LinkCounts {
            packets: self.source.counters(),
            late_points: self.late,
            dropped_states: self.source.dropped_states(),
        }
    }

    /// Lock-step: whether the cycle of a time, ns, may begin; where not, waits a while for the client, with
    /// system calls. What is taken goes on the tape.
    pub fn wait(&mut self, now: u64, mut tape: Option<&mut Tape>) -> bool {
        if !self.settings.lock_step || matches!(self.source, Source::Recording(_)) {
            return true;
        }
        while (!self.attended || self.advance_to < now)
            && let Some(input) = self.source.next()
        {
            self.take(input, now, tape.as_deref_mut());
        }
        if self.advance_to >= now && self.attended {
            return true;
        }
        self.answer();
        self.source.wait(WAIT);
        false
    }

    /// Hands the newest state to the server.
    fn answer(&mut self) {
        self.snapshot.flags |= flags::WAITING;
        self.source.publish(&self.snapshot);
    }

    /// Adds what was taken in a recorded run, in its order, before the cycle that took it.
    pub fn supply(&mut self, at_ns: u64, input: Input) {
        if let Source::Recording(inputs) = &mut self.source {
            inputs.push_back((at_ns, input));
        }
    }

    /// Takes what the client has sent; in lock-step this is done while waiting. Behind another goal nothing
    /// is taken before the supervisor has seen it: no request is lost because the next one came soon.
    fn take_inputs(&mut self, now: u64, mut tape: Option<&mut Tape>) {
        while let Some(input) = self.source.next_recorded(now) {
            self.take(input, now, tape.as_deref_mut());
        }
        if self.settings.lock_step {
            return;
        }
        for _ in 0..INPUTS {
            let Some(input) = self.source.next() else { break };
            if self.take(input, now, tape.as_deref_mut()) {
                break;
            }
        }
    }

    /// A command, or the beginning or end of a session; whether the goal is another one.
    fn take(&mut self, input: Input, now: u64, tape: Option<&mut Tape>) -> bool {
        if let Some(tape) = tape {
            tape.put(CycleInput { at_ns: now, what: Taken::Link(input) });
        }
        let event = SessionEvent::from_input(&input);
        self.attended = event.0 != SessionEvent::Ends;
        match &input {
            Input::Command(command) => self.follow(command, now),
            Input::Begins | Input::Ends => (self.kind, self.advance_to) = (SetpointKind::None, 0),
        }
        let changed = self.goal.follow(event, self.mode, now);
        self.show_goal();
        changed
    }

    /// What the state says of the goal; at once, because in lock-step a client waits for it without a cycle.
    fn show_goal(&mut self) {
        let request = sinew_link::Request::from_number(self.goal.request() as u8);
        self.snapshot.request = request.unwrap_or(sinew_link::Request::None);
    }

    fn follow(&mut self, command: &Command, now: u64) {
        self.advance_to = command.advance_to_ns;
        // In lock-step the client answers for all the time that it grants.
        self.commanded_at = Some(if self.settings.lock_step { now.max(self.advance_to) } else { now });
        let setpoints = &command.setpoints;
        if setpoints.kind() == SetpointKind::None {
            return;
        }
        if setpoints.kind() != self.kind {
            self.begin(setpoints.kind(), now);
        }
        for (at_ns, numbers) in setpoints.iter() {
            if self.playout.push(now, at_ns, numbers) != Pushed::Queued {
                self.late += 1;
            }
        }
    }

    /// Set-points of another kind begin where the machine's reference is.
    fn begin(&mut self, kind: SetpointKind, now: u64) {
        let q = &self.follower.newest().q;
        let point;
        let from: &[f64] = match kind {
            SetpointKind::None => &[],
            SetpointKind::Joint => q,
            SetpointKind::MuscleLength => self.lengths.lengths(q).unwrap_or(&[]),
            SetpointKind::Tension => &self.tensions,
            SetpointKind::EndPoint => {
                let found = self.end_point.as_mut().and_then(|step| step.position(q).ok());
                point = found.unwrap_or_default();
                &point
            }
        };
        self.playout.reset(now, from);
        self.kind = kind;
    }

    /// Before the supervisor: commands, which go on the tape, and the references of this cycle. Nothing is
    /// allocated.
    ///
    /// # Errors
    /// As [`SetpointFollower::step`] and [`Supervisor::set_tensions`].
    pub fn sample(
        &mut self,
        at: CycleTime,
        supervisor: &mut Supervisor,
        References { current, previewed }: &mut References,
        tape: Option<&mut Tape>,
    ) -> Result<Desired, sinew::Error> {
        let now = at.ns();
        self.take_inputs(now, tape);
        self.goal.pass(self.mode, now);
        let values = match self.kind {
            SetpointKind::None => 0,
            SetpointKind::Joint => self.pose.len(),
            SetpointKind::EndPoint => 3,
            SetpointKind::MuscleLength | SetpointKind::Tension => self.tensions.len(),
        };
        let (x, v) = (&mut self.x[..values], &mut self.v[..values]);
        self.playout.sample(now, x, v);
        let tension = self.kind == SetpointKind::Tension && self.mode == Mode::Run;
        let setpoint = match self.kind {
            SetpointKind::None | SetpointKind::Tension => Setpoint::Hold,
            _ if self.mode != Mode::Run => Setpoint::Hold,
            SetpointKind::Joint => Setpoint::Joints(x, v),
            SetpointKind::MuscleLength => Setpoint::MuscleLengths(x),
            SetpointKind::EndPoint => Setpoint::EndPoint([x[0], x[1], x[2]]),
        };
        if tension {
            self.follower.rest_at(&self.pose);
        }
        self.limited = self.follower.step(setpoint, current, previewed)?;
        supervisor.set_tensions(tension.then_some(&*x))?;
        let moment = Moment { time: now as f64 * 1e-9, repeat: None, repeat_time: None, rested: 0.0 };
        Ok(Desired { moment, request: self.goal.request(), command_age: self.command_age(now) })
    }

    /// After the supervisor: what the next cycle begins with, and the state for the client. Nothing is
    /// allocated.
    pub fn publish(&mut self, now: u64, cycle: &Seen<'_>) {
        let command = &cycle.command;
        self.mode = command.mode;
        self.was_on |= command.mode != Mode::Off;
        for (pose, q) in self.pose.iter_mut().zip(command.arm.q) {
            *pose = if q.is_finite() { *q } else { *pose };
        }
        for (tension, estimated) in self.tensions.iter_mut().zip(command.arm.estimated_tension) {
            *tension = if estimated.is_finite() { *estimated } else { *tension };
        }
        if command.mode != Mode::Run {
            // What is held is where set-points begin.
            self.follower.rest_at(&command.reference.q);
            self.kind = SetpointKind::None;
        }
        let period = self.settings.period_ns;
        let snapshot = &mut *self.snapshot;
        self.observed.write(snapshot, period as f64 * 1e-9, cycle);
        (snapshot.machine_time_ns, snapshot.cycle) = (now, now / period.max(1));
        snapshot.setpoint = self.kind;
        snapshot.queued = self.playout.queued() as u16;
        snapshot.late = self.late;
        let age = self.commanded_at.map_or(u64::MAX, |at| now.saturating_sub(at));
        if age > self.settings.timeout_ns {
            snapshot.flags |= flags::TIMED_OUT;
        }
        if self.limited == Limited::Yes {
            snapshot.flags |= flags::LIMITED;
        }
        self.show_goal();
        let due =
            (now / period.max(1)).is_multiple_of((self.settings.state_period_ns / period.max(1)).max(1));
        if due && !self.settings.lock_step {
            self.place_end_point();
            self.source.publish(&self.snapshot);
        } else if self.settings.lock_step && self.advance_to < now + period {
            self.place_end_point();
        }
    }

    fn place_end_point(&mut self) {
        if let Some(point) = self.end_point.as_mut().and_then(|step| step.position(&self.pose).ok()) {
            self.snapshot.end_point = point;
        }
    }
}
