use sinew::drive::DriveCommand;
use sinew_segment::CanFrame as Frame;
use std::fmt::Debug;

/// A node in operation, as its protocol has it.
pub(super) trait Slot: Debug + Send {
    /// Whether a frame can be one of the node.
    fn sends(&self, frame: &Frame) -> bool;

    /// The frame that begins or ends its operation.
    fn operate(&self, begin: bool) -> Frame;

    /// Appends the frames that command it; `h` s since the last ones, at a time, ns.
    fn command(&mut self, command: DriveCommand, h: f64, now: u64, out: &mut Vec<Frame>);

    /// Takes over a data frame of the node.
    fn take(&mut self, frame: &Frame) -> Heard;

    /// Time without its heartbeat after which that is lost, ns.
    fn patience(&self) -> u64;

    /// Whether it has no power and no fault.
    fn is_ready(&self) -> bool;

    /// What it is in, in words.
    fn state(&self) -> String;

    /// Whether its motor follows the commands, and whether it has torque.
    fn is_enabled(&self) -> bool;

    /// As [`is_enabled`](Self::is_enabled).
    fn has_torque(&self) -> bool;

    /// Code of its fault, where it has one.
    fn fault(&self) -> Option<u16>;

    /// What was reported until here belongs to an earlier run.
    fn forgive(&mut self);

    /// It has left operation: there is no set-point until it is read again.
    fn forget_state(&mut self);

    /// Position of the cable, m, and current of the motor, A, + winds in.
    fn readings(&self) -> [f64; 2];

    /// The speed, m/s, that follows the one that was commanded last on the way to rest, `h` s later.
    fn braked_speed(&self, h: f64) -> f64;
}

/// What a frame says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Heard {
    /// Nothing that is counted.
    Other,
    /// With it the readings of a cycle are complete.
    Readings,
    /// The node is alive, and whether it has left operation by itself.
    Alive {
        /// It starts anew, or has ended its operation.
        left: bool,
    },
    /// With it the readings of a cycle are complete, and it has left operation by itself.
    Left,
}
