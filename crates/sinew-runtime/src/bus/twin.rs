use super::exchange::{Bus, BusFault, ClockReport, Exchange, Feedback};
use sinew::drive::DriveCommand;
use sinew::twin::arm::ArmTwin;

/// Time without commands after which the drives stop by themselves, s.
const WATCHDOG: f64 = 0.02;

/// A simulated machine as a bus without wires: it advances by one cycle before it is read, the first time excepted.
///
/// # Example
/// ```
/// use sinew::drive::DriveCommand;
/// use sinew::machine::Machine;
/// use sinew::body::Robot;
/// use sinew::twin::arm::{ArmSpecimen, ArmTwin};
/// use sinew_runtime::bus::{Bus, Feedback, TwinBus};
/// let text = include_str!("../../../../models/lm_arm.toml");
/// let parts = sinew::description::from_toml("lm_arm.toml", text).expect("a model of this repository").parts;
/// let machine = Machine::of(&Robot::new(parts)?)?;
/// let arm = ArmTwin::new(&ArmSpecimen::nominal(&machine)?, &machine.start, &[40.0; 15], 1)?;
/// let (mut bus, mut feedback) = (TwinBus::new(arm, 1e-3), Feedback::new(15, 7));
/// for _ in 0..100 {
///     assert!(bus.read(&mut feedback).fault.is_none());
///     bus.write(&[DriveCommand::Velocity(0.0); 15]);
/// }
/// assert!(feedback.tension.iter().all(|tension| tension.is_finite()));
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct TwinBus {
    arm: ArmTwin,
    period: f64,
    /// The commands that came last.
    commands: Vec<DriveCommand>,
    /// Time since then, s.
    lost_for: f64,
    /// Whether the present exchange is lost.
    lost: bool,
    /// Cycles for which no command has come, by injection.
    stale_for: u32,
    started: bool,
    failed: bool,
}

impl TwinBus {
    /// A bus whose machine advances by a period, s, before every reading but the first, which is of its initial state.
    #[must_use]
    pub fn new(arm: ArmTwin, period: f64) -> Self {
        let commands = vec![DriveCommand::Velocity(0.0); arm.specimen().drives.len()];
        Self {
            arm,
            period,
            commands,
            lost_for: 0.0,
            lost: false,
            stale_for: 0,
            started: false,
            failed: false,
        }
    }
}

/// A bus whose machine is simulated, so that its true state is known.
pub trait SimulatedBus {
    /// The machine.
    fn arm(&self) -> &ArmTwin;

    /// Whether the machine moved faster than the laws of its cables allow, which ends its simulation.
    fn plant_failed(&self) -> bool;

    /// How the cycle and the clocks of the devices agree; none where no device has a clock.
    fn clocks(&self) -> Option<ClockReport> {
        None
    }
}

impl SimulatedBus for TwinBus {
    fn arm(&self) -> &ArmTwin {
        &self.arm
    }

    fn plant_failed(&self) -> bool {
        self.failed
    }
}

impl Bus for TwinBus {
    fn read(&mut self, feedback: &mut Feedback) -> Exchange {
        // What is lost is the exchange of the whole cycle: its reading, and its writing.
        let fault = BusFault::injected(self.arm.exchange_failure(), &mut self.stale_for, self.period);
        self.lost = fault == Some(BusFault::Lost);
        self.lost_for = if self.lost { self.lost_for + self.period } else { 0.0 };
        if self.lost_for > WATCHDOG {
            self.commands.fill(DriveCommand::Velocity(0.0));
        }
        self.failed = self.failed || (self.started && self.arm.step(&self.commands, self.period).is_err());
        self.started = true;
        if self.lost {
            feedback.clear();
            return Exchange { fault };
        }
        let reading = self.arm.reading();
        feedback.motor.copy_from_slice(&reading.motor);
        feedback.tension.copy_from_slice(&reading.tension);
        feedback.joint.copy_from_slice(&reading.joint);
        Exchange { fault }
    }

    fn write(&mut self, commands: &[DriveCommand]) {
        if !self.lost {
            self.commands.copy_from_slice(commands);
        }
    }
}
