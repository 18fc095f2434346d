//! An arm along a trajectory: the twin as the plant, under a controller.

use super::evaluation::Evaluation;
pub use super::run::TrackRun;
use super::track_row::TrackRow;
use super::track_summary::TrackSummary;
use sinew::Error;
use sinew::control::arm::{ArmController, ArmMeasurement, PreviewedReference};
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::supervisor::{ExchangeStatus, Limits, Request, Supervisor};
use sinew::drive::DriveCommand;
use sinew::trajectory::{Reference, Schedule};
use sinew::twin::arm::{ArmReading, ArmTwin, ExchangeFailure, InjectedFault};

/// Control cycle, s.
pub const STEP: f64 = 1e-3;
/// Time without commands after which the drives stop by themselves, s.
const WATCHDOG: f64 = 0.02;
/// Lateness of a late cycle, s.
const LATE: f64 = 0.5e-3;

/// Runs the plant under the controller, calls `see` with every row, and returns the errors of the run.
///
/// # Errors
/// As [`TrackSession::new`] and [`TrackSession::step`].
pub fn track(
    run: &TrackRun<'_>,
    controller: ArmController,
    see: impl FnMut(&TrackRow<'_>),
) -> Result<TrackSummary, Error> {
    track_supervised(run, Supervisor::of(controller)?, see)
}

/// The same under a supervisor.
///
/// # Errors
/// As there.
pub fn track_supervised(
    run: &TrackRun<'_>,
    supervisor: Supervisor,
    mut see: impl FnMut(&TrackRow<'_>),
) -> Result<TrackSummary, Error> {
    let mut session = TrackSession::supervised(run, supervisor)?;
    while session.step(&mut see)? {}
    Ok(session.finish())
}

/// A run in progress, one control cycle per step. A clone continues independently of the original.
///
/// The arm starts at rest in the first pose of the trajectory, with tensions that balance gravity and cables
/// that have slid toward their motors.
#[derive(Debug, Clone)]
pub struct TrackSession<'a> {
    schedule: Schedule<'a>,
    arm: ArmTwin,
    supervisor: Supervisor,
    evaluation: Evaluation<'a>,
    commands: Vec<DriveCommand>,
    /// Age of the last command, s.
    stale_for: f64,
    /// Time without readings, s.
    lost_for: f64,
    /// Readings of a cycle without an answer.
    nothing: ArmReading,
    current: Reference,
    previewed: Reference,
    cycle: u64,
}

impl<'a> TrackSession<'a> {
    /// A run before its first control cycle, with the limits that the controller's gains alone tell.
    ///
    /// # Errors
    /// As [`supervised`](Self::supervised) and [`Supervisor::of`].
    pub fn new(run: &TrackRun<'a>, controller: ArmController) -> Result<Self, Error> {
        Self::supervised(run, Supervisor::of(controller)?)
    }

    /// A run before its first control cycle.
    ///
    /// # Errors
    /// As [`TrackRun::schedule`] and [`TrackRun::plant`].
    pub fn supervised(run: &TrackRun<'a>, supervisor: Supervisor) -> Result<Self, Error> {
        let schedule = run.schedule()?;
        let current = Reference::new(run.robot.independent_joints().len());
        let arm = run.plant()?;
        Ok(Self {
            commands: vec![DriveCommand::Velocity(0.0); arm.specimen().drives.len()],
            stale_for: 0.0,
            lost_for: 0.0,
            nothing: arm.reading().missing(),
            arm,
            supervisor,
            evaluation: Evaluation::new(run)?,
            previewed: current.clone(),
            current,
            cycle: 0,
            schedule,
        })
    }

    /// Replaces the failures of the plant.
    ///
    /// # Errors
    /// As [`ArmTwin::with_faults`].
    pub fn with_faults(mut self, faults: &[InjectedFault]) -> Result<Self, Error> {
        self.arm = self.arm.with_faults(faults)?;
        Ok(self)
    }

    /// Time of the next control cycle, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.cycle as f64 * STEP
    }

    /// The supervisor.
    #[must_use]
    pub fn supervisor(&self) -> &Supervisor {
        &self.supervisor
    }

    /// Other limits of the supervisor.
    ///
    /// # Errors
    /// As [`Supervisor::set_limits`].
    pub fn with_limits(mut self, limits: Limits) -> Result<Self, Error> {
        self.supervisor.set_limits(limits)?;
        Ok(self)
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &ArmTwin {
        &self.arm
    }

    /// One control cycle on the way to the reference; `false` after the last one, and where the integration of the plant
    /// failed.
    ///
    /// # Errors
    /// As [`Supervisor::step`] and [`Schedule::sample`].
    pub fn step(&mut self, see: impl FnMut(&TrackRow<'_>)) -> Result<bool, Error> {
        let exchange = self.exchange();
        self.step_with(Request::Run, &exchange, see)
    }

    /// How the exchange of the next cycle goes, by the injected failures.
    #[must_use]
    pub fn exchange(&self) -> ExchangeStatus {
        let complete = ExchangeStatus::default();
        match self.arm.exchange_failure() {
            None => complete,
            Some(ExchangeFailure::Lost) => ExchangeStatus { received: false, ..complete },
            Some(ExchangeFailure::Late) => ExchangeStatus { lateness: LATE, ..complete },
            Some(ExchangeFailure::Stale) => {
                ExchangeStatus { command_age: Some(self.stale_for + STEP), ..complete }
            }
        }
    }

    /// One control cycle with another request, or after an exchange that was not complete: where no readings came, none
    /// are given to the supervisor, and the drives keep their commands.
    ///
    /// # Errors
    /// As [`step`](Self::step).
    pub fn step_with(
        &mut self,
        request: Request,
        exchange: &ExchangeStatus,
        mut see: impl FnMut(&TrackRow<'_>),
    ) -> Result<bool, Error> {
        let time = self.time();
        self.stale_for = exchange.command_age.unwrap_or(0.0);
        let Self { schedule, arm, supervisor, evaluation, current, previewed, nothing, .. } = self;
        let cycles = libm::round(schedule.duration() / STEP) as u64;
        if self.cycle >= cycles || evaluation.summary().plant_failed.is_some() {
            return Ok(false);
        }
        let moment = schedule.sample(time, PREVIEW_HORIZON, current, previewed)?;
        let reading = if exchange.received { arm.reading() } else { &*nothing };
        let measurement =
            ArmMeasurement { motor: &reading.motor, tension: &reading.tension, joint: &reading.joint };
        let reference = PreviewedReference { current, previewed, repeat_time: moment.repeat_time };
        let command = supervisor.step(STEP, &measurement, &reference, request, exchange)?;
        self.lost_for = if exchange.received { 0.0 } else { self.lost_for + STEP };
        if exchange.received {
            self.commands.copy_from_slice(command.arm.drives);
        } else if self.lost_for > WATCHDOG {
            self.commands.fill(DriveCommand::Velocity(0.0));
        }
        see(&evaluation.record(&moment, current, &command, arm)?);
        self.cycle += 1;
        let failed = arm.step(&self.commands, STEP).is_err();
        if failed {
            evaluation.plant_failed(time);
        }
        Ok(!failed)
    }

    /// The errors of the control cycles so far.
    #[must_use]
    pub fn finish(self) -> TrackSummary {
        self.evaluation.finish(&self.supervisor)
    }
}
