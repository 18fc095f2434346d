use super::clock::Clock;
use crate::Error;
use crate::bus::{Bus, BusFault, BusStatistics, Exchange, Feedback};
use sinew::control::arm::{ArmCommand, ArmController, Fault, PreviewedReference};
use sinew::control::stretch::PREVIEW_HORIZON;
use sinew::trajectory::{Moment, Reference, Schedule};

/// A machine under control: its bus, its controller and its reference.
#[derive(Debug)]
pub struct Cycle<'a, B> {
    bus: B,
    controller: ArmController,
    schedule: Schedule<'a>,
    period: f64,
    feedback: Feedback,
    current: Reference,
    previewed: Reference,
    count: u64,
    missed: u32,
    statistics: BusStatistics,
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
    /// Output of the controller.
    pub command: ArmCommand<'a>,
}

/// When the parts of a cycle ended, by the clock of the cycle, ns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CycleTimes {
    /// It began.
    pub woken: u64,
    /// The sensors were read.
    pub read: u64,
    /// The commands were computed.
    pub controlled: u64,
    /// The commands were written.
    pub written: u64,
}

/// Exchanges in a row without any reading after which the machine is stopped, before the controller takes the first
/// missing sensor for a fault of that sensor.
const MAX_MISSED: u32 = 15;

impl<'a, B: Bus> Cycle<'a, B> {
    /// Before the first cycle; `period` is in s.
    #[must_use]
    pub fn new(bus: B, controller: ArmController, schedule: Schedule<'a>, period: f64) -> Self {
        let [muscles, joints] = controller.dimensions();
        Self {
            bus,
            controller,
            schedule,
            period,
            feedback: Feedback::new(muscles, joints),
            current: Reference::new(joints),
            previewed: Reference::new(joints),
            count: 0,
            missed: 0,
            statistics: BusStatistics::default(),
        }
    }

    /// The bus.
    #[must_use]
    pub fn bus(&self) -> &B {
        &self.bus
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

    /// Whether the schedule is at its end.
    #[must_use]
    pub fn is_finished(&self) -> bool {
        self.count >= (self.schedule.duration() / self.period).round() as u64
    }

    /// One cycle: reads the sensors; observers, fault detection and computed muscle force; writes the commands of the winches.
    /// Nothing is allocated.
    ///
    /// # Errors
    /// As [`ArmController::step`] and [`Schedule::sample`].
    pub fn step(&mut self, clock: &mut impl Clock) -> Result<CycleRecord<'_, B>, Error> {
        let woken = clock.now();
        let exchange = self.bus.read(&mut self.feedback);
        let read = clock.now();
        self.count_exchange(exchange);

        let time = self.count as f64 * self.period;
        let Self { bus, controller, current, previewed, feedback, .. } = self;
        let moment = self.schedule.sample(time, PREVIEW_HORIZON, current, previewed)?;
        match exchange.fault {
            Some(BusFault::Drive { muscle, .. } | BusFault::NotOperational { muscle: Some(muscle), .. }) => {
                controller.stop(Fault::Drive(muscle));
            }
            _ if self.missed > MAX_MISSED => controller.stop(Fault::Bus),
            _ => {}
        }
        let reference = PreviewedReference { current, previewed, repeat_time: moment.repeat_time };
        let command = controller.step(self.period, &feedback.measurement(), &reference)?;
        let controlled = clock.now();

        bus.write(command.drives);
        let times = CycleTimes { woken, read, controlled, written: clock.now() };
        self.count += 1;
        Ok(CycleRecord { bus, moment, times, exchange, feedback, reference: current, command })
    }

    fn count_exchange(&mut self, exchange: Exchange) {
        self.statistics.record(exchange);
        let missing = matches!(exchange.fault, Some(BusFault::Lost | BusFault::WorkingCounter { .. }));
        self.missed = if missing { self.missed + 1 } else { 0 };
    }
}
