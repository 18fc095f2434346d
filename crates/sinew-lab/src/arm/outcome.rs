//! How a run ended, judged by its result as well, and why.

use super::stop_reason::fault_name;
use crate::experiment::{FaultInterval, TrackSummary};
use serde::{Deserialize, Serialize};
use sinew::body::Robot;
use sinew::control::arm::Fault;
use sinew::machine::Machine;

/// Largest end-point error of a run that counts as completed, m, of a large machine: fault-free runs of the
/// LM-Arm without a payload stay below 20 mm.
pub const MAX_END_POINT_ERROR_M: f64 = 0.025;
/// The same as a fraction of the machine's reach, the sum of the distances between its bodies: 3.5 mm of a
/// finger.
const MAX_ERROR_FRACTION: f64 = 0.035;
/// Largest joint error of a run that counts as completed, as a fraction of the joint's range.
pub const MAX_JOINT_ERROR_FRACTION: f64 = 0.1;

/// Largest end-point error of a completed run, m.
#[must_use]
pub fn max_end_point_error(machine: &Machine) -> f64 {
    let parts = machine.robot.parts();
    let length = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>().sqrt();
    let tip = machine.task.site().map_or(0.0, |site| length(parts.sites[site].position));
    let reach = tip + parts.bodies.iter().map(|body| length(body.position)).sum::<f64>();
    (MAX_ERROR_FRACTION * reach).min(MAX_END_POINT_ERROR_M)
}

/// The same of a motion that was verified, as a multiple of the largest error of the sampled machines, and at
/// least as a fraction of the range; never more than [`MAX_JOINT_ERROR_FRACTION`].
const NORMAL: f64 = 3.0;
const MIN_JOINT_ERROR_FRACTION: f64 = 0.035;

/// Largest error of every joint of a completed run, rad or m: `[joints]`; infinite for a joint without a
/// range. `normal`: as [`VerifiedMotion::joint_errors`](super::VerifiedMotion::joint_errors).
pub(super) fn joint_error_limits(machine: &Machine, normal: &[f64]) -> Vec<f64> {
    let limit = |(k, joint): (usize, usize)| {
        let Some([low, high]) = machine.robot.parts().joints[joint].range else { return f64::INFINITY };
        let most = MAX_JOINT_ERROR_FRACTION * (high - low);
        let least = MIN_JOINT_ERROR_FRACTION * (high - low);
        normal.get(k).map_or(most, |normal| (NORMAL * normal).max(least).min(most))
    };
    machine.robot.independent_joints().into_iter().enumerate().map(limit).collect()
}

/// An error of a run beside the largest one of a completed run.
pub(super) struct BoundedError {
    /// m, or rad or m of a joint.
    pub(super) error: f64,
    /// Largest of a completed run.
    pub(super) bound: f64,
    /// The joint and its unit; none for the end point.
    pub(super) joint: Option<(String, &'static str)>,
}

impl BoundedError {
    /// Above one in a run that does not count as completed.
    pub(super) fn fraction(&self) -> f64 {
        self.error / self.bound
    }
}

/// The error of the end point, or of a machine without one of the joint with the largest fraction of its
/// bound; none where no joint has a range.
pub(super) fn largest_bounded_error(summary: &TrackSummary, machine: &Machine) -> Option<BoundedError> {
    if machine.task.site().is_some() {
        let error = summary.end_point_error.max.max(summary.hold_error.max);
        return Some(BoundedError { error, bound: max_end_point_error(machine), joint: None });
    }
    let rigid = vec![0.0; summary.joint_error.len()];
    joint_errors(summary, machine, &rigid).max_by(|a, b| a.fraction().total_cmp(&b.fraction()))
}

/// Fraction of its dead band by which a joint may miss its reference when it breaks away from the friction of
/// its cables.
const BREAK_AWAY_FRACTION: f64 = 0.25;

/// The error of every joint with a range, beside the largest of a completed run or what the joint's dead
/// band, rad or m, explains, where that is more.
pub(super) fn joint_errors(
    summary: &TrackSummary,
    machine: &Machine,
    dead_bands: &[f64],
) -> impl Iterator<Item = BoundedError> {
    let joints = machine.robot.independent_joints().into_iter().zip(&summary.joint_error).zip(dead_bands);
    joints.filter_map(|((joint, error), dead_band)| {
        let joint = &machine.robot.parts().joints[joint];
        let [low, high] = joint.range?;
        let bound = (MAX_JOINT_ERROR_FRACTION * (high - low)).max(BREAK_AWAY_FRACTION * dead_band);
        Some(BoundedError { error: error.max, bound, joint: Some((joint.name.clone(), joint.kind.unit())) })
    })
}

/// What was larger than in a completed run: the error of the end point, else that of the joint with the
/// largest fraction of its limit.
pub(super) fn inaccuracy(summary: &TrackSummary, machine: &Machine, limits: &[f64]) -> Option<String> {
    let at_end = machine.task.site().and_then(|_| largest_bounded_error(summary, machine));
    if let Some(error) = at_end.filter(|error| error.fraction() > 1.0) {
        return Some(format!("the end point exceeded {:.2} mm tracking error", 1e3 * error.bound));
    }
    let joints = machine.robot.independent_joints().into_iter().zip(&summary.joint_error).zip(limits);
    let fractions = joints.map(|((joint, error), limit)| (error.max / limit, joint, *limit));
    let (_, joint, limit) =
        fractions.filter(|(fraction, ..)| *fraction > 1.0).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let joint = &machine.robot.parts().joints[joint];
    let (milli, range) = (1e3 * limit, joint.range.map_or(f64::INFINITY, |[low, high]| high - low));
    Some(format!(
        "{} exceeded {milli:.1} m{} tracking error, {:.1} % of its range",
        joint.name,
        joint.kind.unit(),
        100.0 * limit / range
    ))
}

/// Time after the last report of a fault within which what happens may be its consequence, s.
const LED_TO: f64 = 5.0;

/// Why a run did not end as planned: first the fault, then what it led to. `consequence` happened at a time,
/// s, and is `of` a fault if it is one itself.
pub(super) fn reason(
    summary: &TrackSummary,
    robot: &Robot,
    consequence: &str,
    (time, of): (f64, Option<Fault>),
) -> String {
    let may_have_led =
        |one: &&FaultInterval| one.from <= time && time <= one.until + LED_TO && Some(one.fault) != of;
    match summary.faults.iter().find(may_have_led) {
        Some(first) => {
            let name = fault_name(first.fault, robot);
            format!("{name} at {:.3} s, then {consequence}", to_milliseconds(first.from))
        }
        None if summary.faults.is_empty() => format!("{consequence}; no fault was reported"),
        None => consequence.to_owned(),
    }
}

/// How a run ended, judged by its result as well.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrackOutcome {
    /// To its end, with an end-point error of at most [`max_end_point_error`] and joint errors within their
    /// limits throughout: three times the largest in the verification, at least 3.5 % and at most a tenth of
    /// the ranges.
    #[serde(rename = "as_planned")]
    Completed,
    /// To its end, but at times with a larger error.
    Inaccurate,
    /// The controller stopped the arm.
    Stopped,
    /// The integration of the plant failed.
    Diverged,
}

impl TrackOutcome {
    /// The outcome of a run, with the largest error of every joint of a completed one, rad or m: `[joints]`.
    #[must_use]
    pub fn new(summary: &TrackSummary, machine: &Machine, joint_error_limits: &[f64]) -> Self {
        if summary.stopped.is_some() {
            Self::Stopped
        } else if summary.plant_failed.is_some() {
            Self::Diverged
        } else if inaccuracy(summary, machine, joint_error_limits).is_some() {
            Self::Inaccurate
        } else {
            Self::Completed
        }
    }
}

/// Rounds a time, s, to milliseconds.
pub(super) fn to_milliseconds(time: f64) -> f64 {
    (1e3 * time).round() / 1e3
}

#[cfg(test)]
mod tests {
    use super::super::testing::{bench_joint, lm_arm};
    use super::*;
    use sinew::control::supervisor::FaultKind;

    /// A run with these largest errors of the joints, rad, and an end point that followed.
    fn run(machine: &Machine, errors: &[f64]) -> TrackSummary {
        let mut summary =
            TrackSummary::new(vec![1.0; machine.muscles.len()], vec![1.0; errors.len()], machine.period);
        for (statistics, error) in summary.joint_error.iter_mut().zip(errors) {
            statistics.record(*error);
        }
        summary.end_point_error.record(1e-3);
        summary
    }

    #[test]
    fn an_error_far_beyond_the_normal_one_is_not_as_planned_also_where_the_end_point_follows() {
        for machine in [bench_joint(), lm_arm()] {
            let joints = machine.robot.independent_joints().len();
            let ended = |errors: &[f64], normal: &[f64]| {
                let limits = joint_error_limits(&machine, normal);
                TrackOutcome::new(&run(&machine, errors), &machine, &limits)
            };
            let normal = vec![9e-3; joints];
            assert_eq!(ended(&normal, &normal), TrackOutcome::Completed);
            for joint in 0..joints {
                let mut thrown = normal.clone();
                thrown[joint] = 0.107;
                assert_eq!(ended(&thrown, &normal), TrackOutcome::Inaccurate, "joint {joint}");
                let limits = joint_error_limits(&machine, &normal);
                let why = inaccuracy(&run(&machine, &thrown), &machine, &limits).unwrap_or_default();
                let name = &machine.robot.parts().joints[machine.robot.independent_joints()[joint]].name;
                assert!(why.starts_with(name.as_str()) && why.contains("mrad"), "{why}");
            }
        }
    }

    #[test]
    fn limits_are_three_times_the_normal_error_between_two_shares_of_the_range() {
        let machine = bench_joint();
        let limit = |normal: &[f64]| joint_error_limits(&machine, normal)[0] / 2.4;
        assert!((limit(&[0.05]) - 0.15 / 2.4).abs() < 1e-12, "{}", limit(&[0.05]));
        for (normal, fraction) in [(&[0.001][..], 0.035), (&[0.2], 0.1), (&[], 0.1)] {
            assert!((limit(normal) - fraction).abs() < 1e-12, "{normal:?}: {}", limit(normal));
        }
    }

    #[test]
    fn a_reason_begins_with_the_fault_that_may_have_led_to_the_end() {
        let machine = bench_joint();
        let mut summary = run(&machine, &[0.0]);
        let say = |summary: &TrackSummary, at| reason(summary, &machine.robot, "drive of front", at);
        let drive = (9.0, Some(Fault::Drive(0)));
        assert_eq!(say(&summary, drive), "drive of front; no fault was reported");
        let fault = |fault, from, until, stopped| FaultInterval {
            from,
            until,
            fault,
            kind: FaultKind::SensorLost,
            stopped,
        };
        summary.faults = vec![fault(Fault::Drive(0), 9.0, 12.0, true)];
        assert_eq!(say(&summary, drive), "drive of front", "the fault itself");
        summary.faults.insert(0, fault(Fault::TensionSensor(0), 8.0, 8.001, false));
        assert_eq!(say(&summary, drive), "load cell of front at 8.000 s, then drive of front");
        summary.faults[0] = fault(Fault::TensionSensor(0), 1.0, 2.0, false);
        assert_eq!(say(&summary, drive), "drive of front", "long over");
    }
}
