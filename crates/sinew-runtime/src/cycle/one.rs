use super::clock::Clock;
use crate::Error;
use crate::bus::{Bus, BusStatistics, Exchange, Feedback};
use crate::link::{CycleInput, LinkedMotion, Taken, Tape};
use sinew::control::arm::PreviewedReference;
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::control::supervisor::{ExchangeStatus, Mode, Request, Supervisor, SupervisorCommand};
use sinew::trajectory::{Moment, Reference, Schedule};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A machine under control: its bus, its supervisor and its reference.
#[derive(Debug)]
pub struct Cycle<'a, B> {
    bus: B,
    supervisor: Supervisor,
    motion: Motion<'a>,
    period: f64,
    request: Request,
    /// Whoever sets one of them asks for a safe stop.
    stops: Vec<Arc<AtomicBool>>,
    /// Machine time at which a recorded run was asked for one, ns.
    stop_at: Option<u64>,
    /// Whether a safe stop has been asked for.
    stopping: bool,
    mode: Mode,
    /// What is taken from elsewhere goes here as well.
    tape: Option<Tape>,
    command_age: Option<f64>,
    waits: bool,
    feedback: Feedback,
    current: Reference,
    previewed: Reference,
    count: u64,
    statistics: BusStatistics,
}

/// Where references come from.
#[derive(Debug)]
enum Motion<'a> {
    Schedule(Schedule<'a>),
    Linked(Box<LinkedMotion>),
}

/// One control cycle: what was read, what was wanted, what is commanded.
#[derive(Debug)]
pub struct CycleRecord<'a, B> {
    /// The bus, after the commands were written.
    pub bus: &'a B,
    /// When, and where in the motion.
    pub moment: Moment,
    /// When its parts ended.
    pub times: CycleTimes,
    /// How the exchange went.
    pub exchange: Exchange,
    /// Readings of the sensors.
    pub feedback: &'a Feedback,
    /// Reference of the joints.
    pub reference: &'a Reference,
    /// Mode, fault and commands.
    pub command: SupervisorCommand<'a>,
    /// Whether a stop has been asked for, from the page or the terminal.
    pub stopping: bool,
}

/// When the parts of a cycle ended, by the clock of the cycle, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CycleTimes {
    /// It was to begin.
    pub deadline: u64,
    /// It began.
    pub woken: u64,
    /// The sensors were read.
    pub read: u64,
    /// The commands were computed.
    pub controlled: u64,
    /// The commands were written.
    pub written: u64,
}

impl<'a, B: Bus> Cycle<'a, B> {
    /// Before the first cycle, with the goal to run; `period` is in s.
    #[must_use]
    pub fn new(bus: B, supervisor: Supervisor, schedule: Schedule<'a>, period: f64) -> Self {
        Self::following(bus, supervisor, Motion::Schedule(schedule), period)
    }

    /// The same with requests and references from a link.
    #[must_use]
    pub fn linked(bus: B, supervisor: Supervisor, motion: LinkedMotion, period: f64) -> Self {
        Self::following(bus, supervisor, Motion::Linked(Box::new(motion)), period)
    }

    fn following(bus: B, supervisor: Supervisor, motion: Motion<'a>, period: f64) -> Self {
        let [muscles, joints] = supervisor.dimensions();
        Self {
            bus,
            supervisor,
            motion,
            period,
            request: Request::Run,
            stops: Vec::new(),
            stop_at: None,
            stopping: false,
            mode: Mode::Off,
            tape: None,
            command_age: None,
            waits: false,
            feedback: Feedback::new(muscles, joints),
            current: Reference::new(joints),
            previewed: Reference::new(joints),
            count: 0,
            statistics: BusStatistics::default(),
        }
    }

    /// The bus.
    #[must_use]
    pub fn bus(&self) -> &B {
        &self.bus
    }

    /// The supervisor.
    #[must_use]
    pub fn supervisor(&self) -> &Supervisor {
        &self.supervisor
    }

    /// What is asked for from the next cycle on.
    pub fn set_request(&mut self, request: Request) {
        self.request = request;
    }

    /// Age of the last command in the next cycle, s; none where the reference is not commanded from elsewhere.
    pub fn set_command_age(&mut self, age: Option<f64>) {
        self.command_age = age;
    }

    /// The same with a safe stop that can be asked for from elsewhere, whatever else is asked for: by setting the flag. The cycles then
    /// go on until the machine is let down. There may be several such flags.
    #[must_use]
    pub fn with_stop(mut self, stop: Arc<AtomicBool>) -> Self {
        self.stops.push(stop);
        self
    }

    /// The same with everything that is taken from elsewhere, from a link or as a stop, on a tape.
    #[must_use]
    pub fn with_tape(self, tape: Tape) -> Self {
        Self { tape: Some(tape), ..self }
    }

    /// Adds what was taken in a recorded run, in its order, before the cycle that took it.
    pub fn supply(&mut self, input: CycleInput) {
        match (input.what, &mut self.motion) {
            (Taken::Stop, _) => self.stop_at = self.stop_at.or(Some(input.at_ns)),
            (Taken::Link(what), Motion::Linked(motion)) => motion.supply(input.at_ns, what),
            (Taken::Link(_), Motion::Schedule(_)) => {}
        }
    }

    /// The same with a machine that waits for its cycles, as a simulated one does: none is late.
    #[must_use]
    pub fn with_waiting_machine(mut self) -> Self {
        self.waits = true;
        self
    }

    /// How the exchanges went.
    #[must_use]
    pub fn statistics(&self) -> BusStatistics {
        self.statistics
    }

    /// The bus, its cycles done.
    #[must_use]
    pub fn into_bus(self) -> B {
        self.bus
    }

    /// Whether the schedule is at its end, or the client's use of the machine; after a stop was asked for, whether it is let down.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        if self.is_stop_asked() {
            return self.stopping && matches!(self.mode, Mode::Off | Mode::Ready | Mode::Fault);
        }
        match &self.motion {
            Motion::Schedule(schedule) => self.count >= (schedule.duration() / self.period).round() as u64,
            Motion::Linked(motion) => motion.is_finished(self.machine_time()),
        }
    }

    /// Whether a stop was asked for, from elsewhere or in a recorded run.
    fn is_stop_asked(&self) -> bool {
        self.stopping
            || self.stops.iter().any(|stop| stop.load(Ordering::Relaxed))
            || self.stop_at.is_some_and(|at| at <= self.machine_time())
    }

    /// Whether the next cycle may begin: false where it waits for a client in lock-step. A stop waits for nobody.
    pub fn is_due(&mut self) -> bool {
        if self.is_stop_asked() {
            return true;
        }
        let now = self.machine_time();
        match &mut self.motion {
            Motion::Schedule(_) => true,
            Motion::Linked(motion) => motion.wait(now, self.tape.as_mut()),
        }
    }

    /// The link, if there is one.
    #[must_use]
    pub fn link(&self) -> Option<&LinkedMotion> {
        match &self.motion {
            Motion::Schedule(_) => None,
            Motion::Linked(motion) => Some(motion),
        }
    }

    /// Of the next cycle, since the first, ns.
    fn machine_time(&self) -> u64 {
        (self.count as f64 * self.period * 1e9).round() as u64
    }

    /// One cycle: reads the sensors; limits and faults, observers, computed muscle force; writes the commands of the winches.
    /// `deadline` is when it was to begin, ns. Nothing is allocated.
    ///
    /// # Errors
    /// As [`Supervisor::step`], [`Schedule::sample`] and [`LinkedMotion::sample`].
    pub fn step(&mut self, clock: &mut impl Clock, deadline: u64) -> Result<CycleRecord<'_, B>, Error> {
        let woken = clock.now();
        let exchange = self.bus.read(&mut self.feedback);
        let read = clock.now();
        self.statistics.record(exchange);

        let time = self.count as f64 * self.period;
        let now = self.machine_time();
        if !self.stopping && self.is_stop_asked() {
            self.stopping = true;
            if let Some(tape) = &mut self.tape {
                tape.put(CycleInput { at_ns: now, what: Taken::Stop });
            }
        }
        let Self { bus, supervisor, current, previewed, feedback, tape, .. } = self;
        let moment = match &mut self.motion {
            Motion::Schedule(schedule) => schedule.sample(time, PREVIEW_HORIZON, current, previewed)?,
            Motion::Linked(motion) => {
                let moment =
                    motion.sample(now, supervisor, [&mut *current, &mut *previewed], tape.as_mut())?;
                (self.request, self.command_age) = (motion.request(), motion.command_age(now));
                moment
            }
        };
        let lateness = if self.waits { 0.0 } else { woken.saturating_sub(deadline) as f64 * 1e-9 };
        let simulated = exchange.status();
        let status = ExchangeStatus {
            lateness: lateness.max(simulated.lateness),
            command_age: self.command_age.or(simulated.command_age),
            ..simulated
        };
        let reference = PreviewedReference { current, previewed, repeat_time: moment.repeat_time };
        // A client that turns the machine off asks for more than a stop.
        let stops = self.stopping && self.request != Request::TurnOff;
        let request = if stops { Request::SafeStop } else { self.request };
        let command = supervisor.step(self.period, &feedback.measurement(), &reference, request, &status)?;
        let controlled = clock.now();

        bus.write(command.arm.drives);
        let times = CycleTimes { deadline, woken, read, controlled, written: clock.now() };
        if let Motion::Linked(motion) = &mut self.motion {
            motion.publish(now, &command, feedback);
        }
        self.count += 1;
        self.mode = command.mode;
        let stopping = self.stopping;
        Ok(CycleRecord { stopping, bus, moment, times, exchange, feedback, reference: current, command })
    }
}
