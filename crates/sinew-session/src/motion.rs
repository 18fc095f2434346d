use crate::signals::Seen;
use sinew::Error;
use sinew::body::Robot;
use sinew::control::arm::PreviewedReference;
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::supervisor::{Mode, Request, Supervisor};
use sinew::trajectory::{Approach, Moment, Reference, Schedule};

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

/// A trajectory with rests and repeats, and the way to its first pose.
///
/// ```text
/// wait until the machine is under tension    approach    rest    repeats    rest
/// ```
///
/// The first rest passes while the machine is brought under tension, and lasts until it is. One that stands
/// elsewhere than where the motion begins is led there, and rests again.
#[derive(Debug, Clone)]
pub struct Scheduled<'a> {
    schedule: Schedule<'a>,
    approach: Approach,
    stage: Stage,
    /// Cycles after those of the machine with which those of the schedule begin.
    behind: u64,
    request: Request,
}

/// Where a machine is on the way to its motion.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    /// It does not follow yet.
    Waiting,
    /// On the way to the first pose, since a cycle.
    Approaching(u64),
    /// At the first pose or beyond, or it will follow no more.
    Scheduled,
}

impl<'a> Scheduled<'a> {
    /// Of a machine that is taken to stand in a pose before, with the goal to run; joints that are measured
    /// begin where they are.
    ///
    /// # Shapes
    /// `standing: [joints]`, rad or m.
    ///
    /// # Errors
    /// As [`Approach::new`].
    pub fn new(schedule: Schedule<'a>, robot: &Robot, standing: &[f64]) -> Result<Self, Error> {
        let approach = Approach::new(robot, schedule.trajectory(), standing)?;
        Ok(Self { schedule, approach, stage: Stage::Waiting, behind: 0, request: Request::Run })
    }

    /// Number of independent joints.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.schedule.joints()
    }

    /// Asks something else of the supervisor, from the next cycle on.
    pub fn ask(&mut self, request: Request) {
        self.request = request;
    }

    /// Cycles by which the motion begins later than its first rest tells.
    #[must_use]
    pub fn behind(&self) -> u64 {
        self.behind
    }

    /// The stage of a cycle, from the mode of the one before.
    fn follow(&mut self, at: CycleTime, mode: Mode) {
        match self.stage {
            Stage::Waiting => match mode {
                // What is followed is the pose in which the machine is taken to stand.
                Mode::Run if self.approach.duration() > 0.0 => self.stage = Stage::Approaching(at.index),
                Mode::Run if self.behind > 0 => (self.stage, self.behind) = (Stage::Scheduled, at.index),
                Mode::Run | Mode::SafeStop | Mode::Fault => self.stage = Stage::Scheduled,
                Mode::Off | Mode::Ready | Mode::Pretension | Mode::Hold => {
                    let rested = self.schedule.moves((at.index - self.behind) as f64 * at.period);
                    let waits = at.index > 0 && rested && self.request == Request::Run;
                    self.behind += u64::from(waits);
                }
            },
            Stage::Approaching(since) => {
                let time = (at.index - since) as f64 * at.period;
                if time >= self.approach.duration() {
                    (self.stage, self.behind) = (Stage::Scheduled, at.index);
                }
            }
            Stage::Scheduled => {}
        }
    }
}

impl Motion for Scheduled<'_> {
    fn sample(
        &mut self,
        at: CycleTime,
        supervisor: &mut Supervisor,
        References { current, previewed }: &mut References,
    ) -> Result<Desired, Error> {
        self.follow(at, supervisor.mode());
        let time = (at.index - self.behind) as f64 * at.period;
        let mut moment = self.schedule.sample(time, PREVIEW_HORIZON, current, previewed)?;
        moment.time = at.seconds();
        match self.stage {
            Stage::Waiting if self.approach.duration() > 0.0 => self.approach.rest(current, previewed),
            Stage::Waiting | Stage::Scheduled => {}
            Stage::Approaching(since) => {
                let time = (at.index - since) as f64 * at.period;
                self.approach.sample(time, PREVIEW_HORIZON, current, previewed);
            }
        }
        if self.stage != Stage::Scheduled && at.index > 0 {
            moment = Moment { repeat: None, repeat_time: None, rested: 0.0, ..moment };
        }
        Ok(Desired { moment, request: self.request, command_age: None })
    }

    /// The way begins where the machine is held.
    fn see(&mut self, at: CycleTime, cycle: &Seen<'_>) {
        if self.stage != Stage::Waiting || self.request != Request::Run {
            return;
        }
        let held = &cycle.command.reference.q;
        match cycle.command.mode {
            Mode::Off | Mode::Ready | Mode::Pretension => self.approach.found_at(held),
            // It was tense, so that nobody saw it before.
            Mode::Run => self.approach.found_at(cycle.command.arm.q),
            // The pretension has moved it.
            Mode::Hold => {
                self.approach.begin(held);
                self.stage = Stage::Approaching(at.index + 1);
            }
            Mode::SafeStop | Mode::Fault => {}
        }
    }

    fn is_finished(&self, at: CycleTime) -> bool {
        let ends = (self.schedule.duration() / at.period).round() as u64;
        !matches!(self.stage, Stage::Approaching(_)) && at.index - self.behind >= ends
    }
}
