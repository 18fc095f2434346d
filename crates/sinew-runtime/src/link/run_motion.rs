use super::motion::LinkedMotion;
use super::tape::{CycleInput, Taken, Tape};
use sinew::Error;
use sinew::control::supervisor::{Request, Supervisor};
use sinew_session::signals::Seen;
use sinew_session::{CycleTime, Desired, Motion, References, Scheduled};

/// Along a schedule or commanded by a client, with a tape of what is taken from elsewhere, so that the run
/// can be replayed.
#[derive(Debug)]
pub struct RunMotion<'a> {
    way: Way<'a>,
    tape: Option<Tape>,
    /// Machine time at which a recorded run was asked to stop, ns.
    stop_at: Option<u64>,
}

#[derive(Debug)]
enum Way<'a> {
    Schedule(Scheduled<'a>),
    Linked(Box<LinkedMotion>),
}

impl<'a> From<Scheduled<'a>> for RunMotion<'a> {
    fn from(scheduled: Scheduled<'a>) -> Self {
        Self { way: Way::Schedule(scheduled), tape: None, stop_at: None }
    }
}

impl From<LinkedMotion> for RunMotion<'_> {
    fn from(motion: LinkedMotion) -> Self {
        Self { way: Way::Linked(Box::new(motion)), tape: None, stop_at: None }
    }
}

impl RunMotion<'_> {
    /// The same with everything that is taken from elsewhere, from a link or as a stop, on a tape, if there
    /// is one.
    #[must_use]
    pub fn with_tape(self, tape: Option<Tape>) -> Self {
        Self { tape, ..self }
    }

    /// Asks something else of the supervisor, from the next cycle on, along a schedule; a client asks for
    /// itself.
    pub fn ask(&mut self, request: Request) {
        if let Way::Schedule(scheduled) = &mut self.way {
            scheduled.ask(request);
        }
    }

    /// Adds what was taken in a recorded run, in its order, before the cycle that took it.
    pub fn supply(&mut self, input: CycleInput) {
        match (input.what, &mut self.way) {
            (Taken::Stop, _) => self.stop_at = self.stop_at.or(Some(input.at_ns)),
            (Taken::Link(what), Way::Linked(motion)) => motion.supply(input.at_ns, what),
            (Taken::Link(_), Way::Schedule(_)) => {}
        }
    }

    /// The link, if there is one.
    #[must_use]
    pub fn link(&self) -> Option<&LinkedMotion> {
        match &self.way {
            Way::Schedule(_) => None,
            Way::Linked(motion) => Some(motion),
        }
    }
}

impl Motion for RunMotion<'_> {
    fn sample(
        &mut self,
        at: CycleTime,
        supervisor: &mut Supervisor,
        references: &mut References,
    ) -> Result<Desired, Error> {
        match &mut self.way {
            Way::Schedule(scheduled) => scheduled.sample(at, supervisor, references),
            Way::Linked(motion) => motion.sample(at, supervisor, references, self.tape.as_mut()),
        }
    }

    fn see(&mut self, at: CycleTime, cycle: &Seen<'_>) {
        match &mut self.way {
            Way::Schedule(scheduled) => scheduled.see(at, cycle),
            Way::Linked(motion) => motion.publish(at.ns(), cycle),
        }
    }

    fn is_finished(&self, at: CycleTime) -> bool {
        match &self.way {
            Way::Schedule(scheduled) => scheduled.is_finished(at),
            Way::Linked(motion) => motion.is_finished(at.ns()),
        }
    }

    fn is_due(&mut self, at: CycleTime) -> bool {
        match &mut self.way {
            Way::Schedule(_) => true,
            Way::Linked(motion) => motion.wait(at.ns(), self.tape.as_mut()),
        }
    }

    fn is_stopped(&self, at: CycleTime) -> bool {
        self.stop_at.is_some_and(|stop| stop <= at.ns())
    }

    fn stop_begins(&mut self, at: CycleTime) {
        if let Some(tape) = &mut self.tape {
            tape.put(CycleInput { at_ns: at.ns(), what: Taken::Stop });
        }
    }
}
