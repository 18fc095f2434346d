use sinew::control::arm::ArmCommand;
use sinew::control::supervisor::{Mode, NamedFault};
use sinew::trajectory::Reference;
use sinew::twin::arm::{ArmReading, ArmTruth};
use sinew_session::signals::{FrameLayout, Seen};
use std::sync::Arc;

/// One control cycle of a run.
#[derive(Clone, Copy)]
pub struct TrackRow<'a> {
    /// Time since the run began, s: the motion starts at [`TrackRun::before`](super::run::TrackRun::before).
    pub time: f64,
    /// Index of the repeat; none at rest before and after.
    pub repeat: Option<u32>,
    /// Time since the end of the last repeat, s; 0 before.
    pub rested: f64,
    /// Reference of the joints.
    pub reference: &'a Reference,
    /// Reference of the end point, m.
    pub reference_point: [f64; 3],
    /// True end point, m.
    pub end_point: [f64; 3],
    /// End point in the pose in which every joint encoder reads its reference, m: it differs from the
    /// reference by the zero errors of the encoders, which no controller without a sensor at the end point
    /// can compensate.
    pub encoder_point: [f64; 3],
    /// True coordinates of the joints minus those in which every encoder reads its reference, rad or m:
    /// `[joints]`.
    pub joint_error: &'a [f64],
    /// Pretension of every cable of the specimen at the start of the run, before any wear, N: `[muscles]`.
    pub pretension: &'a [f64],
    /// Lengths of the muscles in the reference pose, m: `[muscles]`.
    pub length: &'a [f64],
    /// True minus reference lengths, m: `[muscles]`.
    pub length_error: &'a [f64],
    /// True lengths minus those in which every joint encoder reads its reference, m: `[muscles]`; empty where
    /// motors hold every joint.
    pub closure_error: &'a [f64],
    /// What of `joint_error` no cable controls, rad or m: `[joints]`; empty where motors hold every joint.
    pub off_manifold: &'a [f64],
    /// Mode of the supervisor.
    pub mode: Mode,
    /// Fault that the supervisor reports, if any.
    pub fault: Option<NamedFault>,
    /// Commands of the drives and estimates of the controller.
    pub command: &'a ArmCommand<'a>,
    /// Readings of the sensors.
    pub reading: &'a ArmReading,
    /// True state of the plant.
    pub truth: ArmTruth<'a>,
    /// The cycle, and the layout of its signals.
    pub cycle: &'a Seen<'a>,
    /// See `cycle`.
    pub layout: &'a Arc<FrameLayout>,
}

impl std::fmt::Debug for TrackRow<'_> {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "cycle at {} s, {:?}", self.time, self.mode)
    }
}
