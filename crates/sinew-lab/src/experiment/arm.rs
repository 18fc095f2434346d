//! An arm along a trajectory: the twin as the plant, under a controller.

use super::evaluation::Evaluation;
pub use super::run::TrackRun;
use super::track_row::TrackRow;
use super::track_summary::TrackSummary;
use sinew::Error;
use sinew::control::arm::ArmController;
use sinew::control::supervisor::{Limits, Request, Supervisor};
use sinew::twin::arm::{ArmTwin, InjectedFault};
use sinew_session::{Exchange, Plant, Scheduled, Session, TwinPlant, VirtualClock};

/// Runs the plant under the controller, calls `see` with every row, and returns the errors of the run.
///
/// # Errors
/// As [`TrackSession::new`] and [`TrackSession::step`].
pub fn track(
    run: &TrackRun<'_>,
    controller: ArmController,
    see: impl FnMut(&TrackRow<'_>),
) -> Result<TrackSummary, Error> {
    track_supervised(run, Supervisor::from_controller(controller)?, see)
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
/// The arm starts at rest in the first pose of the trajectory or where it stands before, with tensions that
/// balance gravity and cables that have slid toward their motors.
#[derive(Debug, Clone)]
pub struct TrackSession<'a> {
    session: Session<TwinPlant, Scheduled<'a>>,
    evaluation: Evaluation<'a>,
}

impl<'a> TrackSession<'a> {
    /// A run before its first control cycle, with the limits that the controller's gains alone tell.
    ///
    /// # Errors
    /// As [`supervised`](Self::supervised) and [`Supervisor::from_controller`].
    pub fn new(run: &TrackRun<'a>, controller: ArmController) -> Result<Self, Error> {
        Self::supervised(run, Supervisor::from_controller(controller)?)
    }

    /// A run before its first control cycle.
    ///
    /// # Errors
    /// As [`TrackRun::scheduled`] and [`TrackRun::plant`].
    pub fn supervised(run: &TrackRun<'a>, supervisor: Supervisor) -> Result<Self, Error> {
        let motion = run.scheduled()?;
        let session = Session::new(TwinPlant::new(run.plant()?), supervisor, motion, run.specimen.period);
        Ok(Self { session, evaluation: Evaluation::new(run)? })
    }

    /// Replaces the failures of the plant.
    ///
    /// # Errors
    /// As [`ArmTwin::with_faults`].
    pub fn with_faults(mut self, faults: &[InjectedFault]) -> Result<Self, Error> {
        self.session.plant_mut().set_faults(faults)?;
        Ok(self)
    }

    /// Time of the next control cycle, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.session.time().seconds()
    }

    /// Time by which the motion begins later than its rest before tells, s: that of the way to its first
    /// pose.
    #[must_use]
    pub fn delay(&self) -> f64 {
        self.session.motion().behind() as f64 * self.session.time().period
    }

    /// The supervisor.
    #[must_use]
    pub fn supervisor(&self) -> &Supervisor {
        self.session.supervisor()
    }

    /// Other limits of the supervisor.
    ///
    /// # Errors
    /// As [`Supervisor::set_limits`].
    pub fn with_limits(mut self, limits: Limits) -> Result<Self, Error> {
        self.session.supervisor_mut().set_limits(limits)?;
        Ok(self)
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &ArmTwin {
        self.session.plant().arm()
    }

    /// Asks something else than to run of the supervisor, from the next cycle on.
    pub fn ask(&mut self, request: Request) {
        self.session.motion_mut().ask(request);
    }

    /// How exchanges go from the next cycle on; none: by the injected failures.
    pub fn set_exchange(&mut self, exchange: Option<Exchange>) {
        self.session.plant_mut().set_exchange(exchange);
    }

    /// One control cycle on the way to the reference; `false` after the last one, and where the integration
    /// of the plant failed.
    ///
    /// # Errors
    /// As [`Session::step`].
    pub fn step(&mut self, see: impl FnOnce(&TrackRow<'_>)) -> Result<bool, Error> {
        let Self { session, evaluation } = self;
        if session.is_finished() {
            return Ok(false);
        }
        let cycle = session.step(&mut VirtualClock::default(), 0)?;
        let time = cycle.moment.time;
        see(&evaluation.record(&cycle.seen(), cycle.plant.arm())?);
        session.plant_mut().pass();
        let goes_on = !session.plant().has_failed();
        if !goes_on {
            evaluation.plant_failed(time);
        }
        Ok(goes_on)
    }

    /// The errors of the control cycles so far.
    #[must_use]
    pub fn finish(self) -> TrackSummary {
        self.evaluation.finish(self.session.supervisor())
    }
}
