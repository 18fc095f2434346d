use crate::Error;
use crate::body::JointKind;
use crate::control::arm::{ArmGains, MuscleGains};
use crate::drive::DriveParameters;
use crate::machine::{Machine, SafetyLimits};
use crate::muscle::MuscleDynamics;
use alloc::vec::Vec;

/// Limits and times of a supervisor, from a machine's file or from gains alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Of every muscle: `[muscles]`.
    pub muscles: Vec<MuscleLimits>,
    /// Range of every joint with its margin, rad or m; none where it has none: `[joints]`.
    pub ranges: Vec<Option<[f64; 2]>>,
    /// The numbers of the whole machine.
    pub safety: SafetyLimits,
}

/// Limits of one muscle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MuscleLimits {
    /// Largest tension at the drive, N.
    pub tension: f64,
    /// Largest rate of change of it, N/s.
    pub tension_rate: f64,
    /// Largest speed of the cable at the winch, m/s.
    pub speed: f64,
    /// Cable on the drum by the motor's encoder, m; none where its origin is not known.
    pub travel: Option<[f64; 2]>,
    /// Its drive, for the thermal model, and the limit of its winding, degrees Celsius.
    pub motor: Option<(DriveParameters, f64)>,
    /// Tension at the drive below which its cable is slack, N.
    pub slack_tension: f64,
    /// Speed at which slack is wound in, m/s.
    pub wind_in_speed: f64,
    /// Slack above which a cable is not taken up, m.
    pub largest_slack: f64,
    /// Speed at which the cable is paid out when the machine is released, m/s.
    pub lowering_speed: f64,
}

impl Limits {
    /// What gains alone tell: no limits of tension, speed, travel, range and heat.
    #[must_use]
    pub fn of_gains(gains: &ArmGains) -> Self {
        let safety = SafetyLimits::default();
        let muscle = |gains: &MuscleGains| {
            // The speed below which an anchor is at rest is 0.05 rad/s at its largest moment arm.
            let arm = gains.rest_speed / 0.05;
            MuscleLimits {
                tension: f64::INFINITY,
                tension_rate: f64::INFINITY,
                speed: f64::INFINITY,
                travel: None,
                motor: None,
                slack_tension: 0.0,
                wind_in_speed: (safety.wind_in_speed * arm).min(gains.max_winch_speed),
                largest_slack: safety.largest_slack * arm,
                lowering_speed: (safety.lowering_speed * arm).min(gains.max_winch_speed),
            }
        };
        Self {
            muscles: gains.muscles.iter().map(muscle).collect(),
            ranges: gains.joints.iter().map(|_| None).collect(),
            safety,
        }
    }

    /// Of a machine with these gains.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for gains of another machine; as [`MuscleDynamics::new`].
    pub fn from_machine(machine: &Machine, gains: &ArmGains) -> Result<Self, Error> {
        let mut limits = Self::of_gains(gains);
        let safety = machine.safety;
        crate::error::check_length("gains of muscles", gains.muscles.len(), machine.muscles.len())?;
        crate::error::check_length("gains of joints", gains.joints.len(), machine.start.len())?;
        let mut body = MuscleDynamics::new(&machine.robot)?;
        body.evaluate(&machine.start)?;
        let joints = machine.robot.independent_joints();
        let kinds: Vec<JointKind> =
            joints.iter().map(|joint| machine.robot.parts().joints[*joint].kind).collect();
        let arms = body.moment_arms().chunks_exact(joints.len().max(1));
        for (((limit, gains), design), arms) in
            limits.muscles.iter_mut().zip(&gains.muscles).zip(&machine.muscles).zip(arms)
        {
            // Speed of the anchor at the allowed speed of the joint on which it acts most.
            let anchor = |hinge: f64, slide: f64| {
                let speed = arms.iter().zip(&kinds).map(|(arm, kind)| match kind {
                    JointKind::Slide => slide * arm.abs(),
                    _ => hinge * arm.abs(),
                });
                speed.fold(0.0, f64::max)
            };
            let drive = &design.drive;
            let own = safety.of_drive(drive);
            *limit = MuscleLimits {
                tension: own.tension,
                tension_rate: own.tension_rate,
                speed: own.cable_speed,
                travel: Some([0.0, drive.winch.capacity()]),
                motor: Some((*drive, own.winding)),
                slack_tension: (SLACK_FRACTION * drive.min_tension).max(drive.load_cell.noise),
                wind_in_speed: anchor(safety.wind_in_speed, safety.wind_in_speed * SLIDE)
                    .clamp(MIN_SPEED, gains.max_winch_speed.max(MIN_SPEED)),
                largest_slack: anchor(safety.largest_slack, safety.largest_slack * SLIDE).max(MIN_SLACK),
                lowering_speed: anchor(safety.lowering_speed, safety.lowering_speed * SLIDE)
                    .clamp(MIN_SPEED, gains.max_winch_speed.max(MIN_SPEED)),
            };
        }
        for (range, joint) in limits.ranges.iter_mut().zip(&joints) {
            *range = machine.robot.parts().joints[*joint].range.map(|[low, high]| {
                let margin = safety.joint_margin * (high - low);
                [low - margin, high + margin]
            });
        }
        limits.safety = safety;
        Ok(limits)
    }
}

/// Fraction of the tension that a drive itself keeps below which its cable is slack.
const SLACK_FRACTION: f64 = 0.5;
/// Metres of a slide for a radian of a hinge.
const SLIDE: f64 = 0.25;
/// Smallest limit of slack, m.
const MIN_SLACK: f64 = 1e-3;
/// Smallest limit of a speed, m/s.
const MIN_SPEED: f64 = 1e-4;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_alone_tell_the_slow_speeds_of_the_winches_by_their_moment_arms_and_nothing_else() {
        let mut gains = ArmGains::for_tests(2, 1);
        // 0.05 rad/s at 40 and at 20 mm; the second winch is slower than what its joint is allowed.
        gains.muscles[0].rest_speed = 2e-3;
        gains.muscles[1].max_winch_speed = 3e-3;
        let limits = Limits::of_gains(&gains);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        for (limit, [take_up, slack, lowering]) in
            limits.muscles.iter().zip([[0.3 * 0.04, 4.0 * 0.04, 0.2 * 0.04], [3e-3, 4.0 * 0.02, 3e-3]])
        {
            near(limit.wind_in_speed, take_up);
            near(limit.largest_slack, slack);
            near(limit.lowering_speed, lowering);
            assert!([limit.tension, limit.tension_rate, limit.speed].iter().all(|limit| limit.is_infinite()));
            assert!(limit.travel.is_none() && limit.motor.is_none());
        }
        assert_eq!((limits.ranges, limits.safety), (alloc::vec![None], SafetyLimits::default()));
    }
}
