use crate::exchange::{Exchange, Feedback};
use crate::plant::Plant;
use sinew::control::supervisor::SupervisorCommand;
use sinew::trajectory::{Moment, Reference};
use sinew::twin::arm::{ArmTruth, ArmTwin};

/// One control cycle: what was read, what was desired, what is commanded.
#[derive(Debug, Clone, Copy)]
pub struct CycleRecord<'a, P: ?Sized> {
    /// The plant, after the commands were written and before they have moved it.
    pub plant: &'a P,
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

impl<P: Plant + ?Sized> CycleRecord<'_, P> {
    /// The true state of the machine, where it is simulated.
    #[must_use]
    pub fn truth(&self) -> Option<ArmTruth<'_>> {
        self.plant.simulated().map(ArmTwin::truth)
    }
}

impl<'a, P: Plant> CycleRecord<'a, P> {
    /// The same, whatever the plant.
    #[must_use]
    pub fn seen(&self) -> CycleRecord<'a, dyn Plant + 'a> {
        let Self { plant, moment, times, exchange, feedback, reference, command, stopping } = *self;
        CycleRecord { plant, moment, times, exchange, feedback, reference, command, stopping }
    }
}

/// When the parts of a cycle ended, by its clock, ns.
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
