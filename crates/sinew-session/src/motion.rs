use crate::signals::Seen;
use sinew::Error;
use sinew::control::arm::PreviewedReference;
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::supervisor::{Request, Supervisor};
use sinew::trajectory::{Moment, Reference, Schedule};

/// What a machine is to do, cycle by cycle.
pub trait Motion {
    /// The references of a cycle, and what is asked of the supervisor. Nothing is allocated.
    ///
    /// # Errors
    /// For references of another machine.
    fn sample(
        &mut self,
        at: CycleTime,
        supervisor: &mut Supervisor,
        references: &mut References,
    ) -> Result<Desired, Error>;

    /// After the supervisor: what came of it. Nothing is allocated.
    fn see(&mut self, _at: CycleTime, _cycle: &Seen<'_>) {}

    /// Whether the cycles end before this one.
    fn is_finished(&self, _at: CycleTime) -> bool {
        false
    }

    /// Whether this cycle may begin; where not, it is asked again.
    fn is_due(&mut self, _at: CycleTime) -> bool {
        true
    }

    /// Whether a safe stop belongs to the motion from this cycle on, as to that of a run in which one was
    /// asked for.
    fn is_stopped(&self, _at: CycleTime) -> bool {
        false
    }

    /// In the first cycle that knows of a safe stop, wherever it was asked for.
    fn stop_begins(&mut self, _at: CycleTime) {}
}

/// When a cycle is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CycleTime {
    /// Cycles before it.
    pub index: u64,
    /// From one to the next, s.
    pub period: f64,
}

impl CycleTime {
    /// Since the first, s.
    #[must_use]
    pub fn seconds(self) -> f64 {
        self.index as f64 * self.period
    }

    /// Since the first, ns.
    #[must_use]
    pub fn ns(self) -> u64 {
        (self.seconds() * 1e9).round() as u64
    }
}

/// References of the joints.
#[derive(Debug, Clone, PartialEq)]
pub struct References {
    /// Of the cycle.
    pub current: Reference,
    /// Of [`PREVIEW_HORIZON`] later.
    pub previewed: Reference,
}

impl References {
    /// Of a number of joints, at zero.
    #[must_use]
    pub fn new(joints: usize) -> Self {
        Self { current: Reference::new(joints), previewed: Reference::new(joints) }
    }

    /// As the supervisor takes them.
    #[must_use]
    pub fn at(&self, moment: &Moment) -> PreviewedReference<'_> {
        let Self { current, previewed } = self;
        PreviewedReference { current, previewed, repeat_time: moment.repeat_time }
    }
}

/// What a motion wants of a cycle beside its references.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Desired {
    /// Where in the motion.
    pub moment: Moment,
    /// What is asked of the supervisor.
    pub request: Request,
    /// Age of the last command, s; none where the references are not commanded from elsewhere.
    pub command_age: Option<f64>,
}

/// A trajectory with rests and repeats.
#[derive(Debug, Clone)]
pub struct Scheduled<'a> {
    schedule: Schedule<'a>,
    request: Request,
}

impl<'a> Scheduled<'a> {
    /// With the goal to run.
    #[must_use]
    pub fn new(schedule: Schedule<'a>) -> Self {
        Self { schedule, request: Request::Run }
    }

    /// Asks something else of the supervisor, from the next cycle on.
    pub fn ask(&mut self, request: Request) {
        self.request = request;
    }
}

impl Motion for Scheduled<'_> {
    fn sample(
        &mut self,
        at: CycleTime,
        _supervisor: &mut Supervisor,
        references: &mut References,
    ) -> Result<Desired, Error> {
        let References { current, previewed } = references;
        let moment = self.schedule.sample(at.seconds(), PREVIEW_HORIZON, current, previewed)?;
        Ok(Desired { moment, request: self.request, command_age: None })
    }

    fn is_finished(&self, at: CycleTime) -> bool {
        at.index >= (self.schedule.duration() / at.period).round() as u64
    }
}
