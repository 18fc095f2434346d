use crate::clock::Clock;
use crate::exchange::{BusStatistics, Feedback};
use crate::motion::{CycleTime, Motion, References};
use crate::plant::Plant;
use crate::record::{CycleRecord, CycleTimes};
use sinew::Error;
use sinew::control::supervisor::{ExchangeStatus, Mode, Request, Supervisor};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A machine under its supervisor: the only place where [`Supervisor::step`] is called.
///
/// The session owns the plant, so that whatever ends it stops the machine: [`end`](Self::end), an error, a
/// panic.
#[derive(Debug, Clone)]
pub struct Session<P, M> {
    plant: P,
    supervisor: Supervisor,
    motion: M,
    period: f64,
    /// Whoever sets one of them asks for a safe stop.
    stops: Vec<Arc<AtomicBool>>,
    /// Whether one has been asked for.
    stopping: bool,
    mode: Mode,
    feedback: Feedback,
    references: References,
    count: u64,
    statistics: BusStatistics,
}

impl<P: Plant, M: Motion> Session<P, M> {
    /// Before the first cycle; `period` is in s.
    #[must_use]
    pub fn new(plant: P, supervisor: Supervisor, motion: impl Into<M>, period: f64) -> Self {
        let [muscles, joints] = supervisor.dimensions();
        Self {
            plant,
            mode: supervisor.mode(),
            supervisor,
            motion: motion.into(),
            period,
            stops: Vec::new(),
            stopping: false,
            feedback: Feedback::new(muscles, joints),
            references: References::new(joints),
            count: 0,
            statistics: BusStatistics::default(),
        }
    }

    /// The same with a safe stop that can be asked for from elsewhere, whatever else is asked for: by setting
    /// the flag. The cycles then go on until the tension is released. There may be several such flags.
    #[must_use]
    pub fn with_stop(mut self, stop: Arc<AtomicBool>) -> Self {
        self.stops.push(stop);
        self
    }

    /// The plant.
    #[must_use]
    pub fn plant(&self) -> &P {
        &self.plant
    }

    /// The plant, to let it fail.
    pub fn plant_mut(&mut self) -> &mut P {
        &mut self.plant
    }

    /// The supervisor.
    #[must_use]
    pub fn supervisor(&self) -> &Supervisor {
        &self.supervisor
    }

    /// The supervisor, to set its limits.
    pub fn supervisor_mut(&mut self) -> &mut Supervisor {
        &mut self.supervisor
    }

    /// The motion.
    #[must_use]
    pub fn motion(&self) -> &M {
        &self.motion
    }

    /// The motion, to ask for something else.
    pub fn motion_mut(&mut self) -> &mut M {
        &mut self.motion
    }

    /// How the exchanges went.
    #[must_use]
    pub fn statistics(&self) -> BusStatistics {
        self.statistics
    }

    /// When the next cycle is.
    #[must_use]
    pub fn time(&self) -> CycleTime {
        CycleTime { index: self.count, period: self.period }
    }

    /// Mode after the last cycle.
    #[must_use]
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Whether the motion is at its end; after a stop was asked for, whether the machine is released.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        if self.plant.has_failed() {
            return true;
        }
        if self.is_stop_asked() {
            return self.stopping && matches!(self.mode, Mode::Off | Mode::Ready | Mode::Fault);
        }
        self.motion.is_finished(self.time())
    }

    /// Whether the next cycle may begin: false where it waits for a client in lock-step. A stop waits for
    /// nobody.
    pub fn is_due(&mut self) -> bool {
        let at = self.time();
        self.is_stop_asked() || self.motion.is_due(at)
    }

    fn is_stop_asked(&self) -> bool {
        self.stopping
            || self.stops.iter().any(|stop| stop.load(Ordering::Relaxed))
            || self.motion.is_stopped(self.time())
    }

    /// One cycle: reads the sensors; limits and faults, observers, computed muscle force; writes the commands
    /// of the winches. `deadline` is when it was to begin, ns. Nothing is allocated.
    ///
    /// # Errors
    /// As [`Motion::sample`] and [`Supervisor::step`].
    pub fn step(&mut self, clock: &mut impl Clock, deadline: u64) -> Result<CycleRecord<'_, P>, Error> {
        let at = self.time();
        if !self.stopping && self.is_stop_asked() {
            self.stopping = true;
            self.motion.stop_begins(at);
        }
        let Self { plant, supervisor, motion, feedback, references, .. } = self;
        let woken = clock.now();
        let exchange = plant.read(feedback);
        let read = clock.now();
        self.statistics.record(exchange);

        let desired = motion.sample(at, supervisor, references)?;
        let injected = exchange.status();
        let late = if plant.waits() { 0.0 } else { woken.saturating_sub(deadline) as f64 * 1e-9 };
        let status = ExchangeStatus {
            lateness: late.max(injected.lateness),
            command_age: desired.command_age.or(injected.command_age),
            ..injected
        };
        // A client that turns the machine off asks for more than a stop.
        let stops = self.stopping && desired.request != Request::TurnOff;
        let request = if stops { Request::SafeStop } else { desired.request };
        let reference = references.at(&desired.moment);
        supervisor.set_currents(&feedback.current)?;
        let command = supervisor.step(self.period, &feedback.measurement(), &reference, request, &status)?;
        let controlled = clock.now();

        plant.write(command.arm.drives);
        let times = CycleTimes { deadline, woken, read, controlled, written: clock.now() };
        self.count += 1;
        self.mode = command.mode;
        let record = CycleRecord {
            plant,
            moment: desired.moment,
            times,
            exchange,
            feedback,
            reference: &references.current,
            command,
            stopping: self.stopping,
        };
        motion.see(at, &record.seen());
        Ok(record)
    }

    /// Stops the machine and hands the plant back.
    #[must_use]
    pub fn end(mut self) -> P {
        self.plant.stop();
        self.plant
    }
}
