use sinew::control::arm::ArmMeasurement;
use sinew::control::supervisor::ExchangeStatus;
use sinew::twin::arm::ExchangeFailure;

/// Readings of all sensors; a number that is missing in this cycle is NaN.
#[derive(Debug, Clone, PartialEq)]
pub struct Feedback {
    /// Position of every cable by its motor's encoder, m, + toward the motor: `[muscles]`.
    pub motor: Vec<f64>,
    /// Tension at every drive's outlet by its load cell, N: `[muscles]`.
    pub tension: Vec<f64>,
    /// Coordinate of every independent joint by its encoder, rad or m: `[joints]`.
    pub joint: Vec<f64>,
    /// Current, A, and temperature, degC, of every motor as its drive says, and age of the set-point that the
    /// drive follows, us: `[muscles]`. Nobody controls by them.
    pub current: Vec<f64>,
    /// See `current`.
    pub temperature: Vec<f64>,
    /// See `current`.
    pub setpoint_age: Vec<f64>,
}

impl Feedback {
    /// Nothing has been read.
    #[must_use]
    pub fn new(muscles: usize, joints: usize) -> Self {
        Self {
            motor: vec![f64::NAN; muscles],
            tension: vec![f64::NAN; muscles],
            joint: vec![f64::NAN; joints],
            current: vec![f64::NAN; muscles],
            temperature: vec![f64::NAN; muscles],
            setpoint_age: vec![f64::NAN; muscles],
        }
    }

    /// Marks every reading as missing.
    pub fn clear(&mut self) {
        let Self { motor, tension, joint, current, temperature, setpoint_age } = self;
        for readings in [motor, tension, joint, current, temperature, setpoint_age] {
            readings.fill(f64::NAN);
        }
    }

    /// As the controller takes it.
    #[must_use]
    pub fn measurement(&self) -> ArmMeasurement<'_> {
        ArmMeasurement { motor: &self.motor, tension: &self.tension, joint: &self.joint }
    }
}

/// How the exchange of a cycle went.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Exchange {
    /// What is wrong with the bus in this cycle; none where every device took part.
    pub fault: Option<BusFault>,
}

impl Exchange {
    /// As the supervisor takes it, of a cycle that began in time but for what a simulation says.
    #[must_use]
    pub fn status(&self) -> ExchangeStatus {
        let received = !matches!(self.fault, Some(BusFault::Lost | BusFault::Missing { .. }));
        let drive = match self.fault {
            Some(BusFault::Drive { muscle, .. } | BusFault::NotReady { muscle: Some(muscle), .. }) => {
                Some(muscle)
            }
            _ => None,
        };
        let complete = ExchangeStatus { received, drive, ..ExchangeStatus::default() };
        match self.fault {
            Some(BusFault::Late { by_ns }) => {
                ExchangeStatus { lateness: f64::from(by_ns) * 1e-9, ..complete }
            }
            Some(BusFault::Stale { age_us }) => {
                ExchangeStatus { command_age: Some(f64::from(age_us) * 1e-6), ..complete }
            }
            _ => complete,
        }
    }
}

/// What is wrong with a bus in one cycle. Codes are the bus's own: the room that drives it has words for
/// them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BusFault {
    /// No answer came back in time: all readings are missing, or the commands may not have arrived.
    Lost,
    /// Devices are missing from the exchange, and the bus does not say which: all readings are missing.
    Missing {
        /// As the bus counts those that take part: of all devices.
        expected: u16,
        /// Of this cycle.
        got: u16,
    },
    /// A device is missing or not ready: its readings are missing, and its drive stands.
    NotReady {
        /// Index in the machine's list of devices.
        device: usize,
        /// Its state.
        code: u16,
        /// The muscle that it drives.
        muscle: Option<usize>,
    },
    /// The drive of a muscle reports a fault.
    Drive {
        /// Its muscle.
        muscle: usize,
        /// Its error code.
        code: u16,
    },
    /// Of a simulation: the cycle counts as begun this late.
    Late {
        /// By how much, ns.
        by_ns: u32,
    },
    /// Of a simulation: the last command counts as this old.
    Stale {
        /// us.
        age_us: u32,
    },
}

impl BusFault {
    /// The fault of a simulated exchange, by what was injected; `stale_for` are the cycles of a `period`, s,
    /// for which no command has come, and are counted on.
    #[must_use]
    pub fn injected(failure: Option<ExchangeFailure>, stale_for: &mut u32, period: f64) -> Option<Self> {
        *stale_for = if failure == Some(ExchangeFailure::Stale) { stale_for.saturating_add(1) } else { 0 };
        Some(match failure? {
            ExchangeFailure::Lost => Self::Lost,
            ExchangeFailure::Late => Self::Late { by_ns: (LATE_FRACTION * period * 1e9) as u32 },
            ExchangeFailure::Stale => Self::Stale { age_us: (f64::from(*stale_for) * period * 1e6) as u32 },
        })
    }
}

/// Lateness of a cycle that is late by injection, periods.
const LATE_FRACTION: f64 = 0.5;

/// Exchanges of a run by their outcome.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BusStatistics {
    /// All exchanges.
    pub exchanges: u64,
    /// Without an answer.
    pub lost: u64,
    /// From which devices were missing.
    pub missing: u64,
    /// In which a device was not ready.
    pub not_ready: u64,
    /// In which a drive reported a fault.
    pub drive: u64,
    /// Of a simulation: that counted as late, or without a new command.
    pub late: u64,
    /// The first fault, and the cycle in which it was.
    pub first: Option<(u64, BusFault)>,
}

impl BusStatistics {
    /// Counts one exchange.
    pub fn record(&mut self, exchange: Exchange) {
        if let Some(fault) = exchange.fault {
            *match fault {
                BusFault::Lost => &mut self.lost,
                BusFault::Missing { .. } => &mut self.missing,
                BusFault::NotReady { .. } => &mut self.not_ready,
                BusFault::Drive { .. } => &mut self.drive,
                BusFault::Late { .. } | BusFault::Stale { .. } => &mut self.late,
            } += 1;
            self.first = self.first.or(Some((self.exchanges, fault)));
        }
        self.exchanges += 1;
    }
}

/// How a cycle and the clocks of its devices agree.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ClockReport {
    /// Drives that take their set-points over at a time of their own clocks.
    pub synchronized: usize,
    /// How much faster the devices' time runs than the computer's, parts per million.
    pub drift_ppm: f64,
    /// Root mean square and largest magnitude of the difference between the cycle's beginning and the
    /// devices' time, us.
    pub phase_rms_us: f64,
    /// us.
    pub phase_max_us: f64,
    /// Largest difference between a device's time and the reference's, ns.
    pub device_difference_ns: u32,
}
