//! Campaigns of single faults at random parts, times and durations on calibrated arms.

use super::lm_machine;
use sinew::control::arm::{ArmStatus, Fault};
use sinew::random::Random;
use sinew::twin::arm::{Failure, InjectedFault, Sensor, SensorFailure};
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, DesiredMotion, MAX_END_POINT_ERROR_M, plan};
use sinew_lab::experiment::arm::{TrackRun, TrackSession};
use sinew_lab::experiment::{FaultInterval, TrackRow};

/// Rest before and after the motion, s, and the motion.
const REST: [f64; 2] = [3.0, 2.0];
const MOTION: f64 = 11.5;
/// Time after the end of a fault until which a run is observed, s.
const AFTER: f64 = 2.5;
/// Longest fault, s; a broken cable stays broken.
const LONGEST: f64 = 0.2;

/// A run with one fault.
#[derive(Debug)]
pub(crate) struct Case {
    pub(crate) seed: u64,
    pub(crate) fault: InjectedFault,
    /// Largest end-point error until the arm was stopped, m.
    pub(crate) error: f64,
    /// The same without a fault, up to the time of the fault.
    pub(crate) error_before: f64,
    pub(crate) stopped: bool,
    pub(crate) reported: Vec<FaultInterval>,
}

impl Case {
    /// The part that the controller names: where it stopped the arm, else in its first report.
    pub(crate) fn named(&self) -> Option<Fault> {
        let stop = self.reported.iter().find(|report| report.stopped);
        stop.or(self.reported.first()).map(|report| report.fault)
    }

    pub(crate) fn is_named_rightly(&self) -> bool {
        self.named() == Some(part_of(self.fault.failure))
    }

    /// Whether the run counts as completed without a report.
    pub(crate) fn is_as_planned(&self) -> bool {
        !self.stopped && self.reported.is_empty() && self.error <= MAX_END_POINT_ERROR_M
    }
}

fn part_of(failure: Failure) -> Fault {
    match failure {
        Failure::Sensor(Sensor::Joint(k), _) => Fault::JointSensor(k),
        Failure::Sensor(Sensor::Motor(k), _) => Fault::MotorSensor(k),
        Failure::Sensor(Sensor::Tension(k), _) => Fault::TensionSensor(k),
        Failure::Amplifier(k) | Failure::Winch(k) => Fault::Drive(k),
        Failure::Cable(k) => Fault::Cable(k),
    }
}

/// Every kind of fault with the same probability, durations uniform in their logarithm.
fn drawn(random: &mut Random) -> InjectedFault {
    use SensorFailure::{Lost, NotANumber, Stuck};
    let mut below = |n: usize| (random.unit() * n as f64) as usize % n;
    let (kind, muscle, joint) = (below(12), below(15), below(7));
    let mode = [Lost, Stuck, NotANumber][kind % 3];
    let failure = match kind {
        0..=2 => Failure::Sensor(Sensor::Joint(joint), mode),
        3..=5 => Failure::Sensor(Sensor::Motor(muscle), mode),
        6..=8 => Failure::Sensor(Sensor::Tension(muscle), mode),
        9 => Failure::Cable(muscle),
        10 => Failure::Amplifier(muscle),
        _ => Failure::Winch(muscle),
    };
    let start = (random.unit() * (REST[0] + MOTION + REST[1] - LONGEST) * 1e3).floor() * 1e-3;
    let milliseconds = (1e3 * LONGEST).powf(random.unit()).round();
    let duration = if kind == 9 { f64::INFINITY } else { 1e-3 * milliseconds };
    InjectedFault { start, duration, failure }
}

/// Runs `count` single faults on the arm of a seed: each branches off one fault-free run, which is continued
/// to its end and has to be free of reports.
pub(crate) fn campaign(seed: u64, count: usize) -> Vec<Case> {
    let machine = lm_machine();
    let arm = CalibratedArm::new(&machine, seed).unwrap();
    let path = machine.paths[(seed % 2) as usize].path.clone();
    let trajectory = plan(&machine, &DesiredMotion::ClosedPath(path), Some(MOTION)).unwrap();
    let controller = arm.controller(CompensationVariant::Observer, &trajectory).unwrap();
    let limits = arm.gains(&trajectory).unwrap().0.tension_limits();
    let run = TrackRun {
        specimen: &arm.specimen,
        robot: &machine.robot,
        site: machine.task.site(),
        tension_limits: &limits,
        trajectory: &trajectory,
        repeats: 1,
        before: REST[0],
        after: REST[1],
        faults: &[],
        seed,
    };
    let mut random = Random::new(seed ^ 0x5eed);
    let mut faults: Vec<InjectedFault> = (0..count).map(|_| drawn(&mut random)).collect();
    faults.sort_by(|a, b| a.start.total_cmp(&b.start));
    let mut healthy = TrackSession::new(&run, controller).unwrap();
    let mut error_before = 0.0_f64;
    let mut cases = Vec::new();
    for fault in faults {
        while healthy.time() < fault.start - 5e-4 {
            healthy.step(|row| error_before = error_before.max(error(row))).unwrap();
        }
        cases.push(case(&healthy, seed, fault, error_before));
    }
    while healthy.step(|_| {}).unwrap() {}
    let reports = healthy.finish().faults;
    assert!(reports.is_empty(), "seed {seed}: reported without a fault: {reports:?}");
    cases
}

fn case(healthy: &TrackSession<'_>, seed: u64, fault: InjectedFault, error_before: f64) -> Case {
    let mut session = healthy.clone().with_faults(&[fault]).unwrap();
    let end = fault.start + fault.duration.min(LONGEST) + AFTER;
    let (mut largest, mut running, mut going) = (0.0_f64, true, true);
    while going && session.time() < end {
        going = session
            .step(|row| {
                running &= !matches!(row.command.status, ArmStatus::Stopped(_));
                largest = if running { largest.max(error(row)) } else { largest };
            })
            .unwrap();
    }
    let summary = session.finish();
    assert!(summary.plant_failed.is_none(), "seed {seed}: {fault:?}");
    let stopped = summary.stopped.is_some();
    Case { seed, fault, error: largest, error_before, stopped, reported: summary.faults }
}

/// Distance of the end point from its reference, m.
fn error(row: &TrackRow<'_>) -> f64 {
    (0..3).map(|i| (row.end_point[i] - row.reference_point[i]).powi(2)).sum::<f64>().sqrt()
}
