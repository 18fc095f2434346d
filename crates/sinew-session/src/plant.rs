use crate::exchange::{ClockReport, Exchange, Feedback};
use sinew::drive::DriveCommand;
use sinew::twin::arm::ArmTwin;

/// Drives and sensors of a machine: a cycle reads once and then writes once.
///
/// A plant whose drives have power owns them: dropped, by an error or a panic as well, it brings them to
/// rest.
pub trait Plant {
    /// Begins a cycle and reads the sensors. What went wrong since the last reading is in the answer, the
    /// last writing included.
    fn read(&mut self, feedback: &mut Feedback) -> Exchange;

    /// Writes the commands, which hold until the next ones. Before the first the drives stand.
    ///
    /// # Shapes
    /// `commands: [muscles]`.
    fn write(&mut self, commands: &[DriveCommand]);

    /// Brings the machine to rest and takes the power of its drives, as a drop does; once.
    fn stop(&mut self) {}

    /// Time, ns, by which the next period is to be longer than its nominal length, so that the cycle keeps
    /// pace with the clocks of the devices.
    fn period_correction(&self) -> i64 {
        0
    }

    /// How the cycle and the clocks of the devices agree; none where no device has a clock.
    fn clocks(&self) -> Option<ClockReport> {
        None
    }

    /// The simulated machine behind it, whose true state is known; none of a real one.
    fn simulated(&self) -> Option<&ArmTwin> {
        None
    }

    /// Whether the machine waits for its cycles, so that none is late: a simulated one does.
    fn waits(&self) -> bool {
        self.simulated().is_some()
    }

    /// Whether the machine moved faster than the laws of its cables allow, which ends its simulation.
    fn has_failed(&self) -> bool {
        false
    }
}

impl<P: Plant + ?Sized> Plant for Box<P> {
    fn read(&mut self, feedback: &mut Feedback) -> Exchange {
        (**self).read(feedback)
    }

    fn write(&mut self, commands: &[DriveCommand]) {
        (**self).write(commands);
    }

    fn stop(&mut self) {
        (**self).stop();
    }

    fn period_correction(&self) -> i64 {
        (**self).period_correction()
    }

    fn clocks(&self) -> Option<ClockReport> {
        (**self).clocks()
    }

    fn simulated(&self) -> Option<&ArmTwin> {
        (**self).simulated()
    }

    fn waits(&self) -> bool {
        (**self).waits()
    }

    fn has_failed(&self) -> bool {
        (**self).has_failed()
    }
}
