//! Operating state of an arm and the faults that change it.

/// A detected fault, with the index of the joint or muscle concerned.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// The encoder of a joint: its measurement was rejected.
    JointSensor(usize),
    /// The motor encoder of a muscle: its measurement was rejected.
    MotorSensor(usize),
    /// The load cell of a muscle: its measurement was rejected, and the cable's observer runs without it.
    TensionSensor(usize),
    /// The drive of a muscle does not follow its command.
    Drive(usize),
    /// The cable of a muscle lacks the estimated tension: it is broken or off its winch.
    Cable(usize),
    /// The error of a joint is beyond its threshold.
    TrackingError(usize),
    /// The bus: no reading came for longer than the drives' own watchdogs wait.
    Bus,
}

/// Operating state of an arm under control.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ArmStatus {
    /// It tracks its reference.
    #[default]
    Following,
    /// The reference is at rest, all errors are within their tolerances, and the winches stand.
    Holding,
    /// A fault is present for less than its persistence time: the controller continues on estimates.
    Degraded(Fault),
    /// A fault persisted: the winches were braked to rest and stay there.
    Stopped(Fault),
}
