//! Campaigns of single faults at random parts, times and durations on calibrated machines.

use sinew::control::arm::{ArmStatus, Fault};
use sinew::machine::{Machine, Task};
use sinew::random::Random;
use sinew::trajectory::Trajectory;
use sinew::twin::arm::{Failure, InjectedFault, Sensor, SensorFailure};
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, MAX_JOINT_ERROR_FRACTION, max_end_point_error};
use sinew_lab::experiment::arm::{TrackRun, TrackSession};
use sinew_lab::experiment::{FaultInterval, TrackRow};

/// Rest before and after the motion, s.
const REST: [f64; 2] = [3.0, 2.0];
/// Time after the end of a fault until which a run is observed, s.
const AFTER: f64 = 2.5;
/// Longest fault, s; a broken cable stays broken.
const LONGEST: f64 = 0.2;

/// A run with one fault.
#[derive(Debug)]
#[allow(dead_code, reason = "printed")]
pub(crate) struct Case {
    pub(crate) machine: String,
    pub(crate) seed: u64,
    pub(crate) fault: InjectedFault,
    /// Largest error until the controller stopped the machine, over that of a completed run.
    pub(crate) error: f64,
    /// The same without a fault, up to the time of the fault.
    pub(crate) error_before: f64,
    pub(crate) stopped: bool,
    pub(crate) reported: Vec<FaultInterval>,
}

impl Case {
    /// The part that the controller names: where it stopped the machine, else in its first report.
    pub(crate) fn named(&self) -> Option<Fault> {
        let stop = self.reported.iter().find(|report| report.stopped);
        stop.or(self.reported.first()).map(|report| report.fault)
    }

    pub(crate) fn is_named_rightly(&self) -> bool {
        self.named() == Some(part_of(self.fault.failure))
    }

    /// Whether the run counts as completed without a report.
    pub(crate) fn is_as_planned(&self) -> bool {
        !self.stopped && self.reported.is_empty() && self.error <= 1.0
    }

    /// Time from the fault to its first report, s.
    pub(crate) fn delay(&self) -> Option<f64> {
        self.reported.first().map(|report| report.from - self.fault.start)
    }
}

fn part_of(failure: Failure) -> Fault {
    match failure {
        Failure::Sensor(Sensor::Joint(k), _) => Fault::JointSensor(k),
        Failure::Sensor(Sensor::Motor(k), _) => Fault::MotorSensor(k),
        Failure::Sensor(Sensor::Tension(k), _) => Fault::TensionSensor(k),
        Failure::Amplifier(k) | Failure::Winch(k) => Fault::Drive(k),
        Failure::Cable(k) | Failure::Wear { muscle: k, .. } => Fault::Cable(k),
        Failure::Push { joint, .. } => Fault::TrackingError(joint),
        Failure::Exchange(_) => Fault::Bus,
    }
}

/// Every kind of fault with the same probability, durations uniform in their logarithm; a joint without an
/// encoder has no fault of it.
fn sampled(random: &mut Random, machine: &Machine, motion: f64) -> InjectedFault {
    use SensorFailure::{Lost, NotANumber, Stuck};
    let encoders: Vec<usize> =
        (0..machine.encoders.len()).filter(|k| machine.encoders[*k].is_some()).collect();
    let mut below = |n: usize| (random.unit() * n as f64) as usize % n;
    let first = if encoders.is_empty() { 3 } else { 0 };
    let (kind, muscle) = (first + below(12 - first), below(machine.muscles.len()));
    let joint = encoders.get(below(encoders.len().max(1))).copied().unwrap_or(0);
    let mode = [Lost, Stuck, NotANumber][kind % 3];
    let failure = match kind {
        0..=2 => Failure::Sensor(Sensor::Joint(joint), mode),
        3..=5 => Failure::Sensor(Sensor::Motor(muscle), mode),
        6..=8 => Failure::Sensor(Sensor::Tension(muscle), mode),
        9 => Failure::Cable(muscle),
        10 => Failure::Amplifier(muscle),
        _ => Failure::Winch(muscle),
    };
    let start = (random.unit() * (REST[0] + motion + REST[1] - LONGEST) * 1e3).floor() * 1e-3;
    let milliseconds = (1e3 * LONGEST).powf(random.unit()).round();
    let duration = if kind == 9 { f64::INFINITY } else { 1e-3 * milliseconds };
    InjectedFault { start, duration, failure }
}

/// Runs `count` single faults on the machine of a seed: each branches off one fault-free run, which is
/// continued to its end; what that one reports comes second.
pub(crate) fn campaign(
    machine: &Machine,
    trajectory: &Trajectory,
    seed: u64,
    count: usize,
) -> (Vec<Case>, Vec<FaultInterval>) {
    let arm = CalibratedArm::new(machine, seed).unwrap();
    let controller = arm.controller(CompensationVariant::Observer, trajectory).unwrap();
    let limits = arm.gains(trajectory).unwrap().0.tension_limits();
    let run = TrackRun {
        specimen: &arm.specimen,
        robot: &machine.robot,
        site: machine.task.site(),
        tension_limits: &limits,
        standing: None,
        trajectory,
        repeats: 1,
        before: REST[0],
        after: REST[1],
        faults: &[],
        seed,
    };
    let mut random = Random::new(seed ^ 0x5eed);
    let mut faults: Vec<InjectedFault> =
        (0..count).map(|_| sampled(&mut random, machine, trajectory.duration())).collect();
    faults.sort_by(|a, b| a.start.total_cmp(&b.start));
    let mut healthy = TrackSession::new(&run, controller).unwrap();
    let mut error_before = 0.0_f64;
    let mut cases = Vec::new();
    for fault in faults {
        while healthy.time() < fault.start - 5e-4 {
            healthy.step(|row| error_before = error_before.max(error(machine, row))).unwrap();
        }
        cases.push(case(&healthy, machine, seed, fault, error_before));
    }
    while healthy.step(|_| {}).unwrap() {}
    (cases, healthy.finish().faults)
}

fn case(
    healthy: &TrackSession<'_>,
    machine: &Machine,
    seed: u64,
    fault: InjectedFault,
    error_before: f64,
) -> Case {
    let mut session = healthy.clone().with_faults(&[fault]).unwrap();
    let end = fault.start + fault.duration.min(LONGEST) + AFTER;
    let (mut largest, mut running, mut going) = (0.0_f64, true, true);
    while going && session.time() < end {
        going = session
            .step(|row| {
                running &= !matches!(row.command.status, ArmStatus::Stopped(_));
                largest = if running { largest.max(error(machine, row)) } else { largest };
            })
            .unwrap();
    }
    let summary = session.finish();
    assert!(summary.plant_failed.is_none(), "{}, seed {seed}: {fault:?}", machine.robot.parts().name);
    let stopped = summary.stopped.is_some();
    let name = machine.robot.parts().name.clone();
    Case { machine: name, seed, fault, error: largest, error_before, stopped, reported: summary.faults }
}

/// Error over that of a completed run, 1: of the end point, or of the joints where there is none.
pub(crate) fn error(machine: &Machine, row: &TrackRow<'_>) -> f64 {
    match machine.task {
        Task::EndPoint { .. } => {
            let squares = (0..3).map(|i| (row.end_point[i] - row.reference_point[i]).powi(2));
            squares.sum::<f64>().sqrt() / max_end_point_error(machine)
        }
        Task::Joints => {
            let joints = machine.robot.independent_joints().into_iter().zip(row.joint_error);
            let over = joints.filter_map(|(joint, error)| {
                let [low, high] = machine.robot.parts().joints[joint].range?;
                Some(error.abs() / (MAX_JOINT_ERROR_FRACTION * (high - low)))
            });
            over.fold(0.0, f64::max)
        }
    }
}
