use super::largest_errors::{LargestError, largest_errors};
use super::outcome::{TrackOutcome, inaccuracy, max_end_point_error, reason, to_milliseconds};
use super::stop_reason::{fault_name, stop_reason};
use crate::experiment::{FaultInterval, ModeChange, Statistics, TrackSummary};
use serde::{Deserialize, Deserializer, Serialize};
use sinew::body::{JointKind, Robot};
use sinew::control::arm::Fault;
use sinew::control::supervisor::{CableHealth, FaultKind};
use sinew::machine::Machine;

/// A number, or NaN where JSON, which has none, says null.
fn number_or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Position error of the end point, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorSpread {
    /// Mean.
    #[serde(deserialize_with = "number_or_nan")]
    pub mean: f64,
    /// Standard deviation.
    #[serde(deserialize_with = "number_or_nan")]
    pub std: f64,
    /// Largest.
    #[serde(deserialize_with = "number_or_nan")]
    pub max: f64,
}

impl From<&Statistics> for ErrorSpread {
    /// NaN, in JSON null, of a run without an end point.
    fn from(statistics: &Statistics) -> Self {
        if statistics.is_empty() {
            return Self { mean: f64::NAN, std: f64::NAN, max: f64::NAN };
        }
        Self { mean: statistics.mean, std: statistics.std, max: statistics.max }
    }
}

/// Mean and largest magnitude of an error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ErrorRange {
    /// Over parts and time.
    #[serde(deserialize_with = "number_or_nan")]
    pub mean: f64,
    /// Of all parts and times.
    #[serde(deserialize_with = "number_or_nan")]
    pub max: f64,
}

impl ErrorRange {
    /// Of some parts; none where there is no part.
    fn over<'a>(parts: impl Iterator<Item = &'a Statistics>) -> Option<Self> {
        let (mut sum, mut count, mut max) = (0.0, 0.0, 0.0_f64);
        for part in parts {
            (sum, count, max) = (sum + part.mean, count + 1.0, max.max(part.max));
        }
        (count > 0.0).then(|| Self { mean: sum / count, max })
    }
}

/// Errors at rest after the motion, after two seconds of settling.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Hold {
    /// Position error of the end point.
    pub end_point_error_m: ErrorSpread,
    /// Its mean fraction by the zeros of the joint encoders, m.
    #[serde(deserialize_with = "number_or_nan")]
    pub unseen_error_m: f64,
    /// Largest standard deviation of a tension at an anchor, N.
    #[serde(deserialize_with = "number_or_nan")]
    pub tension_ripple_n: f64,
}

/// Length errors of the muscles, m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MuscleSpread {
    /// Mean magnitude, over muscles and time.
    #[serde(deserialize_with = "number_or_nan")]
    pub mean: f64,
    /// Its standard deviation: root mean square of the muscles'.
    #[serde(deserialize_with = "number_or_nan")]
    pub std: f64,
}

/// A fault over an interval of time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackIncident {
    /// First report of the controller, s since the start of the run.
    pub from_s: f64,
    /// Last report, s.
    pub until_s: f64,
    /// Kind of the fault: `cable_break`, `sensor_lost` and so on; empty in records of earlier versions.
    #[serde(default)]
    pub kind: String,
    /// The fault, with the name of its muscle or joint.
    pub what: String,
    /// Reaction of the controller: `bridged`, `held` where the motion ended and the machine held its pose, or
    /// `stopped`.
    pub answer: String,
}

impl TrackIncident {
    fn new(interval: &FaultInterval, robot: &Robot) -> Self {
        Self {
            from_s: to_milliseconds(interval.from),
            until_s: to_milliseconds(interval.until),
            kind: interval.kind.name().to_owned(),
            what: fault_name(interval.fault, robot),
            answer: match interval.fault {
                _ if interval.stopped => "stopped",
                Fault::StaleCommand => "held",
                _ => "bridged",
            }
            .to_owned(),
        }
    }
}

/// A mode of the supervisor and when it began.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackMode {
    /// s since the start of the run.
    pub from_s: f64,
    /// `off`, `ready`, `pretension`, `hold`, `run`, `safe_stop` or `fault`.
    pub mode: String,
    /// Kind of the fault that led there.
    pub fault: Option<String>,
}

impl TrackMode {
    /// Of a change of the mode.
    #[must_use]
    pub fn new(change: &ModeChange) -> Self {
        Self {
            from_s: to_milliseconds(change.time),
            mode: change.mode.name().to_owned(),
            fault: change.fault.map(|fault| fault.kind().name().to_owned()),
        }
    }
}

/// A joint of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackJoint {
    /// Its name.
    pub joint: String,
    /// Largest magnitude of the error of a hinge, without the zero of its encoder, rad.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub largest_error_rad: Option<f64>,
    /// Largest of a completed run, rad; none without a range.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub limit_rad: Option<f64>,
    /// As `largest_error_rad`, of a slide, m.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub largest_error_m: Option<f64>,
    /// As `limit_rad`, of a slide, m.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub limit_m: Option<f64>,
}

impl TrackJoint {
    fn new(summary: &TrackSummary, robot: &Robot, limits: &[f64]) -> Vec<Self> {
        let joints = robot.independent_joints().into_iter().zip(&summary.joint_error).zip(limits);
        let joint = |((joint, error), limit): ((usize, &Statistics), &f64)| {
            let part = &robot.parts().joints[joint];
            let (error, limit) = (Some(error.max), limit.is_finite().then_some(*limit));
            let none = Self {
                joint: part.name.clone(),
                largest_error_rad: None,
                limit_rad: None,
                largest_error_m: None,
                limit_m: None,
            };
            match part.kind {
                JointKind::Slide => Self { largest_error_m: error, limit_m: limit, ..none },
                _ => Self { largest_error_rad: error, limit_rad: limit, ..none },
            }
        };
        joints.map(joint).collect()
    }
}

/// A slow change of a cable that was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackHealth {
    /// Name of the muscle.
    pub muscle: String,
    /// `friction_drift`, `stiffness_drift` or `pretension_drift`.
    pub kind: String,
    /// Change since the beginning as a fraction of the model's value.
    pub drift: f64,
    /// Its standard error.
    pub error: f64,
    /// Time until its limit at the present rate, s; none where it does not grow.
    pub remaining_s: Option<f64>,
}

impl TrackHealth {
    /// Of all cables: `[muscles]`.
    #[must_use]
    pub fn new(cables: &[CableHealth], robot: &Robot) -> Vec<Self> {
        let names = robot.parts().tendons.iter().zip(cables);
        let found = names.filter_map(|(tendon, health)| {
            let kind = health.found()?;
            let drift = match kind {
                FaultKind::FrictionDrift => health.friction,
                FaultKind::StiffnessDrift => health.stiffness,
                _ => health.pretension,
            };
            Some(Self {
                muscle: tendon.name.clone(),
                kind: kind.name().to_owned(),
                drift: drift.fraction,
                error: drift.error,
                remaining_s: drift.remaining.is_finite().then_some(drift.remaining),
            })
        });
        found.collect()
    }
}

/// The numbers of a run in reports and files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TrackingNumbers {
    /// How the run ended.
    pub ended: TrackOutcome,
    /// Why it ended otherwise than planned: the fault that was reported first, then what it led to.
    pub reason: Option<String>,
    /// Largest error of every joint, and of a completed run; empty in records of earlier versions.
    #[serde(default)]
    pub joints: Vec<TrackJoint>,
    /// Magnitude of the error of the hinges, over joints and time, without the zeros of their encoders, rad;
    /// none without hinges.
    pub joint_error_rad: Option<ErrorRange>,
    /// The same of the slides, m.
    pub joint_error_m: Option<ErrorRange>,
    /// Of a machine whose cables leave joints to springs: magnitude of the error of the cables' lengths, over
    /// muscles and time, without the zeros of the joint encoders, m.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub closure_error_m: Option<ErrorRange>,
    /// And what of the joints' errors no cable controls, over joints and time, rad.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub off_manifold_rad: Option<ErrorRange>,
    /// Position error of the end point.
    pub end_point_error_m: ErrorSpread,
    /// Its fraction by the zeros of the joint encoders, which no controller without a sensor at the end point
    /// can correct.
    pub unseen_error_m: ErrorSpread,
    /// Of every repeat.
    pub end_point_error_per_repeat_m: Vec<ErrorSpread>,
    /// At rest after the last repeat, where the run was long enough.
    pub hold: Option<Hold>,
    /// Length error over all muscles.
    pub muscle_length_error_m: MuscleSpread,
    /// Mean magnitude of every muscle's error, m.
    #[serde(rename = "length_error_per_muscle_m")]
    pub per_muscle: Vec<f64>,
    /// Its standard deviation over time, m.
    #[serde(rename = "length_error_std_per_muscle_m", default)]
    pub per_muscle_std: Vec<f64>,
    /// Smallest and largest desired tension at every anchor, N: `[muscles]`.
    #[serde(default)]
    pub tension_limits_n: Vec<[f64; 2]>,
    /// Largest end-point error of a completed run, m; none without an end point.
    #[serde(default)]
    pub end_point_limit_m: Option<f64>,
    /// The largest errors with what they consist of, largest first.
    #[serde(default)]
    pub largest_errors: Vec<LargestError>,
    /// Minimum tension at an anchor, N.
    #[serde(deserialize_with = "number_or_nan")]
    pub min_anchor_tension_n: f64,
    /// Longest time for which a cable was slack, less than 1 N above its pretension, of a small machine less
    /// than a fifth of what its minimum tension leaves, s.
    #[serde(deserialize_with = "number_or_nan")]
    pub longest_slack_s: f64,
    /// Greatest tension at a drive, N.
    #[serde(deserialize_with = "number_or_nan")]
    pub max_drive_tension_n: f64,
    /// Time at which the run was stopped, s.
    pub stopped_s: Option<f64>,
    /// The fault that stopped it.
    pub stopped_by: Option<String>,
    /// All faults, in the order of their first reports.
    pub incidents: Vec<TrackIncident>,
    /// Modes of the supervisor in their order; empty in records of earlier versions.
    #[serde(default)]
    pub modes: Vec<TrackMode>,
    /// Slow changes of the cables that were found; empty in records of earlier versions.
    #[serde(default)]
    pub health: Vec<TrackHealth>,
}

impl TrackingNumbers {
    /// The numbers of a run of this machine within these limits of the desired tensions, N: `[muscles]`, and
    /// of the joint errors of a completed run, rad or m: `[joints]`, see
    /// [`CalibratedArm::joint_error_limits`](super::CalibratedArm::joint_error_limits).
    ///
    /// # Errors
    /// As [`MuscleDynamics::new`](sinew::muscle::MuscleDynamics::new).
    pub fn new(
        summary: &TrackSummary,
        machine: &Machine,
        tension_limits: &[[f64; 2]],
        joint_error_limits: &[f64],
    ) -> Result<Self, sinew::Error> {
        let (robot, limits) = (&machine.robot, joint_error_limits);
        let hold = Hold {
            end_point_error_m: (&summary.hold_error).into(),
            unseen_error_m: summary.hold_encoder_zero_error.mean,
            tension_ripple_n: summary.max_hold_tension_std(),
        };
        let muscles = summary.length_error.len().max(1) as f64;
        let squares: f64 =
            summary.length_error.iter().map(|statistics| statistics.std * statistics.std).sum();
        let joints = robot.independent_joints().into_iter().zip(&summary.joint_error);
        let of_kind = |kind: JointKind| {
            let of_kind = joints.clone().filter(move |(joint, _)| robot.parts().joints[*joint].kind == kind);
            ErrorRange::over(of_kind.map(|(_, statistics)| statistics))
        };
        let ended = TrackOutcome::new(summary, machine, limits);
        let stopped_by = summary.stopped.map(|(_, fault)| stop_reason(fault, summary.threshold, robot));
        let worst = summary.peaks().first().map_or(0.0, |peak| peak.time);
        let why = |consequence: &str, at| reason(summary, robot, consequence, at);
        Ok(Self {
            ended,
            reason: match ended {
                TrackOutcome::Completed => None,
                TrackOutcome::Inaccurate => {
                    inaccuracy(summary, machine, limits).map(|error| why(&error, (worst, None)))
                }
                TrackOutcome::Stopped => {
                    let at = summary.stopped.map_or((worst, None), |(time, fault)| (time, Some(fault)));
                    stopped_by.as_deref().map(|stopped| why(stopped, at))
                }
                TrackOutcome::Diverged => {
                    let at = (summary.plant_failed.unwrap_or(worst), None);
                    Some(why("the simulated machine moved faster than its cables allow", at))
                }
            },
            joints: TrackJoint::new(summary, robot, limits),
            joint_error_rad: of_kind(JointKind::Hinge),
            joint_error_m: of_kind(JointKind::Slide),
            closure_error_m: ErrorRange::over(summary.closure_error.iter()),
            off_manifold_rad: ErrorRange::over(
                robot
                    .independent_joints()
                    .into_iter()
                    .zip(&summary.off_manifold)
                    .filter(|(joint, _)| robot.parts().joints[*joint].kind == JointKind::Hinge)
                    .map(|(_, statistics)| statistics),
            ),
            longest_slack_s: summary.longest_slack(|_| true).duration,
            end_point_error_m: (&summary.end_point_error).into(),
            unseen_error_m: (&summary.encoder_zero_error).into(),
            end_point_error_per_repeat_m: summary.repeat_error.iter().map(ErrorSpread::from).collect(),
            hold: (!summary.hold_tension.iter().all(Statistics::is_empty)).then_some(hold),
            muscle_length_error_m: MuscleSpread {
                mean: summary.mean_length_error(),
                std: (squares / muscles).sqrt(),
            },
            per_muscle: summary.length_error.iter().map(|statistics| statistics.mean).collect(),
            per_muscle_std: summary.length_error.iter().map(|statistics| statistics.std).collect(),
            tension_limits_n: tension_limits.to_vec(),
            end_point_limit_m: machine.task.site().map(|_| max_end_point_error(machine)),
            largest_errors: largest_errors(&summary.peaks(), machine)?,
            min_anchor_tension_n: summary.min_anchor_tension.0,
            max_drive_tension_n: summary.max_drive_tension.0,
            stopped_s: summary.stopped.map(|(time, _)| time).or(summary.plant_failed).map(to_milliseconds),
            stopped_by,
            incidents: summary.faults.iter().map(|one| TrackIncident::new(one, robot)).collect(),
            modes: summary.modes.iter().map(TrackMode::new).collect(),
            health: TrackHealth::new(&summary.health, robot),
        })
    }
}
