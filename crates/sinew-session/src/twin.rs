use crate::exchange::{BusFault, Exchange, Feedback};
use crate::plant::Plant;
use sinew::Error;
use sinew::drive::DriveCommand;
use sinew::twin::arm::{ArmTwin, InjectedFault};

/// A simulated machine without wires. A period passes before it is read, the first time excepted, or when it
/// is told to.
///
/// # Example
/// ```
/// use sinew::drive::DriveCommand;
/// use sinew::machine::Machine;
/// use sinew::body::Robot;
/// use sinew::twin::arm::{ArmSpecimen, ArmTwin};
/// use sinew_session::{Feedback, Plant, TwinPlant};
/// let text = sinew_models::LM_ARM;
/// let parts = sinew::description::from_toml("lm_arm.toml", text).expect("a model of this repository").parts;
/// let machine = Machine::from_robot(&Robot::new(parts)?)?;
/// let arm = ArmTwin::new(&ArmSpecimen::nominal(&machine)?, &machine.start, &[40.0; 15], 1)?;
/// let (mut plant, mut feedback) = (TwinPlant::new(arm), Feedback::new(15, 7));
/// for _ in 0..100 {
///     assert!(plant.read(&mut feedback).fault.is_none());
///     plant.write(&[DriveCommand::Velocity(0.0); 15]);
/// }
/// assert!(feedback.tension.iter().all(|tension| tension.is_finite()));
/// # Ok::<(), sinew::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct TwinPlant {
    arm: ArmTwin,
    period: f64,
    /// The commands that came last.
    commands: Vec<DriveCommand>,
    /// Time without commands, s.
    lost_for: f64,
    /// Whether the present exchange is lost.
    lost: bool,
    /// Cycles for which no command has come, by injection.
    stale_for: u32,
    /// In place of what was injected.
    exchange: Option<Exchange>,
    /// Whether a period is to pass before the next reading.
    due: bool,
    failed: bool,
}

impl TwinPlant {
    /// A machine in its initial state, which is read every period of its own.
    #[must_use]
    pub fn new(arm: ArmTwin) -> Self {
        let period = arm.specimen().period;
        let commands = vec![DriveCommand::Velocity(0.0); arm.specimen().drives.len()];
        Self {
            arm,
            period,
            commands,
            lost_for: 0.0,
            lost: false,
            stale_for: 0,
            exchange: None,
            due: false,
            failed: false,
        }
    }

    /// The machine.
    #[must_use]
    pub fn arm(&self) -> &ArmTwin {
        &self.arm
    }

    /// Replaces its failures.
    ///
    /// # Errors
    /// As [`ArmTwin::with_faults`]; nothing changes then.
    pub fn set_faults(&mut self, faults: &[InjectedFault]) -> Result<(), Error> {
        self.arm = self.arm.clone().with_faults(faults)?;
        Ok(())
    }

    /// How exchanges go from the next one on; none: by the failures of the machine.
    pub fn set_exchange(&mut self, exchange: Option<Exchange>) {
        self.exchange = exchange;
    }

    /// Lets the period after a writing pass at once, not before the next reading.
    pub fn pass(&mut self) {
        if std::mem::take(&mut self.due) && !self.failed {
            self.failed = self.arm.step(&self.commands, self.period).is_err();
        }
    }
}

impl Plant for TwinPlant {
    fn read(&mut self, feedback: &mut Feedback) -> Exchange {
        self.pass();
        let injected = BusFault::injected(self.arm.exchange_failure(), &mut self.stale_for, self.period);
        let exchange = self.exchange.unwrap_or(Exchange { fault: injected });
        // What is lost is the exchange of the whole cycle: its reading, and its writing.
        self.lost = !exchange.status().received;
        if self.lost {
            feedback.clear();
            return exchange;
        }
        let reading = self.arm.reading();
        feedback.motor.copy_from_slice(&reading.motor);
        feedback.tension.copy_from_slice(&reading.tension);
        feedback.joint.copy_from_slice(&reading.joint);
        feedback.current.copy_from_slice(&reading.current);
        let temperature = feedback.temperature.iter_mut().enumerate();
        temperature.for_each(|(muscle, place)| *place = self.arm.winding(muscle));
        // The commands of the cycle before, or older ones.
        feedback.setpoint_age.fill(1e6 * (self.period * f64::from(1 + self.stale_for) + self.lost_for));
        exchange
    }

    fn write(&mut self, commands: &[DriveCommand]) {
        self.due = true;
        self.lost_for = if self.lost { self.lost_for + self.period } else { 0.0 };
        if !self.lost {
            self.commands.copy_from_slice(commands);
        } else if self.lost_for > self.arm.specimen().watchdog {
            self.commands.fill(DriveCommand::Velocity(0.0));
        }
    }

    fn simulated(&self) -> Option<&ArmTwin> {
        Some(&self.arm)
    }

    fn has_failed(&self) -> bool {
        self.failed
    }
}
