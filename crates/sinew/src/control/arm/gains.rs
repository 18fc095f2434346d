use crate::error::{Error, non_negative, positive, within};
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// Gains, limits and thresholds of a machine's controller.
///
/// Each field names the term of the control law in which it stands. The laws are written in full at the
/// controller ([`ArmController`](super::ArmController), `q''_d`), the joints' observer (`joint_observer.rs`),
/// the winches (`winch.rs`) and fault detection (`fault_detector.rs`, `joint_monitor.rs`).
/// [`synthesize`](super::synthesize) derives all of them from a machine's own numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArmGains {
    /// `zeta` in `q''_d = .. + w^2 (q_r - q^) + 2 zeta w (q'_r - q'^)`, 1, >= 0: damping ratio.
    pub damping: f64,
    /// `w_o` in `w = w_o clip(|e|/e_0, 1, r)`, rad/s, > 0: bandwidth of the joints' observers at small
    /// innovations `e`.
    #[serde(rename = "observer_bandwidth_rad_per_s")]
    pub observer_bandwidth: f64,
    /// `r` of the same, 1, >= 1: largest ratio by which it grows.
    pub max_bandwidth_ratio: f64,
    /// `beta_0` in `beta = beta_0 + beta_c/(1 + (v_r/v_c)^2)`, 1, >= 0: fraction of the dead band that
    /// feedforward leaves to feedback, the uncertainty of friction.
    #[serde(alias = "feedback_share")]
    pub feedback_fraction: f64,
    /// `beta_c` of the same, 1, >= 0: additional fraction at creep speed, where static friction exceeds
    /// sliding friction.
    #[serde(alias = "creep_feedback_share")]
    pub creep_feedback_fraction: f64,
    /// `t_s` in `t_s v_s' = v^ - v_s`, s, > 0: filter of the anchor's speed at which friction is evaluated.
    #[serde(rename = "slip_filter_time_s")]
    pub slip_filter_time: f64,
    /// `t_r` in `s_r' = d_0/(t_r x_t)`, s, > 0: time constant with which errors beyond the dead zone are
    /// corrected at rest.
    #[serde(rename = "rest_time_constant_s")]
    pub rest_time_constant: f64,
    /// Slow integral of the end point's error; none for a machine without an end point.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub end_point: Option<EndPointGains>,
    /// Of every joint: `[joints]`.
    pub joints: Vec<JointGains>,
    /// Of every muscle: `[muscles]`.
    pub muscles: Vec<MuscleGains>,
}

/// Gains of the integral of the end point's error by the joints' encoders.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EndPointGains {
    /// Index of its site.
    pub site: usize,
    /// `k`, 1/s, >= 0: rate with which its error is integrated.
    #[serde(rename = "rate_per_s")]
    pub rate: f64,
    /// `u_max`, m, > 0: largest correction.
    #[serde(rename = "largest_m")]
    pub largest: f64,
}

/// Gains of one joint, and the thresholds beyond which its encoder or its error is a fault; its unit is the
/// radian or the metre.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointGains {
    /// `w` in `q''_d`, rad/s, >= 0: bandwidth.
    #[serde(rename = "bandwidth_rad_per_s")]
    pub bandwidth: f64,
    /// `w_d` in `d_u' = w_d (d^ - d_u)`, rad/s, >= 0: bandwidth of the disturbance compensation `d_u`, 0 for
    /// none.
    #[serde(rename = "disturbance_bandwidth_rad_per_s")]
    pub disturbance_bandwidth: f64,
    /// `e_0` of the joint's observer, > 0: innovation above which its bandwidth grows; larger than the
    /// encoder's quantisation.
    pub innovation_threshold: f64,
    /// Whether it has an encoder; without one its angle follows from its muscles.
    pub encoder: bool,
    /// `D`, resolution of its encoder.
    pub resolution: f64,
    /// `x_j`: innovation of the encoder that is a jump.
    pub jump: f64,
    /// `x_max`: deviation implied by the muscles beyond which an unchanged output is a fault.
    pub implied: f64,
    /// `x_r,max`: travel of the reference beyond which an unchanged output is a fault.
    pub reference_travel: f64,
    /// `theta_G`, >= 0: dead band of its cables, within which it may stand where its reference has turned.
    #[serde(default)]
    pub dead_band: f64,
    /// `e_q`: error that stops the machine, and largest deviation of the first measurement.
    pub tracking_error: f64,
}

/// Gains of one muscle's winch, its limits, and the thresholds beyond which its sensors, its drive or its
/// cable are at fault.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MuscleGains {
    /// `kappa` in `x = e* - e^ + kappa d + t_d (v_r - v^)`, 1, >= 0: fraction of an anchor's position error
    /// `d` in the travel `x` of its winch; oscillates beyond 2.
    pub position_gain: f64,
    /// `t_d` of the same, s, >= 0: gain of the anchor's speed error; damps limit cycles of the dead band.
    #[serde(rename = "rate_gain_s")]
    pub rate_gain: f64,
    /// `t_v` in `v = v_r + clip(x/t_v, +-sqrt(2 a |x|))`, s, > 0: time constant of a winch's travel.
    #[serde(rename = "stretch_time_constant_s")]
    pub stretch_time_constant: f64,
    /// `a` of the same, m/s^2, > 0: deceleration that a winch is assumed capable of.
    #[serde(rename = "winch_deceleration_m_per_s2")]
    pub winch_deceleration: f64,
    /// `v_max` in `|v| <= v_max`, m/s, > 0: largest commanded speed of a winch.
    #[serde(rename = "max_winch_speed_m_per_s")]
    pub max_winch_speed: f64,
    /// `a_max` in `|v'| <= a_max`, m/s^2, > 0: largest commanded acceleration of a winch, at most its
    /// drive's.
    #[serde(rename = "max_winch_acceleration_m_per_s2")]
    pub max_winch_acceleration: f64,
    /// `a_s`, m/s^2, > 0: deceleration when the machine is stopped.
    #[serde(rename = "stop_deceleration_m_per_s2")]
    pub stop_deceleration: f64,
    /// `x_t` in `s_r' = v_r/x_t`, m, > 0: presliding distance, travel of an anchor over which its cable
    /// crosses half of the dead band.
    #[serde(rename = "presliding_distance_m")]
    pub presliding_distance: f64,
    /// `lambda` in `s = .. + lambda d/G`, 1, >= 0: backlash compensation across the dead band `G`,
    /// proportional to the anchor's position error.
    #[serde(alias = "pre_travel_gain")]
    pub backlash_gain: f64,
    /// `lambda_i` in `s_i' = lambda_i d/G`, 1/s, >= 0: the same, integrated.
    #[serde(rename = "backlash_integral_per_s", alias = "pre_travel_integral_per_s")]
    pub backlash_integral: f64,
    /// Fraction of the model's own gain with which the load cell corrects the observer of its cable, 1, >= 0.
    #[serde(default = "whole")]
    pub correction_fraction: f64,
    /// `F_min`, `F_max` of (22), N, >= 0 and rising: desired tension at the anchor.
    #[serde(rename = "tension_limits_n")]
    pub tension: [f64; 2],
    /// `delta_min`, `delta_max` in `d_0 = d - clip(d, +-delta)`, m, >= 0 and rising: dead zone of the
    /// anchor's position error at rest, and its limit.
    #[serde(rename = "rest_tolerance_m")]
    pub rest_tolerance: [f64; 2],
    /// m, rising: position error of the anchor at which the machine comes to rest, and up to which it is at
    /// rest.
    #[serde(rename = "rest_error_m")]
    pub rest_error: [f64; 2],
    /// m/s: largest speed of the anchor at which the machine comes to rest.
    #[serde(rename = "rest_speed_m_per_s")]
    pub rest_speed: f64,
    /// m/s: largest rate of change of the motor encoder.
    #[serde(rename = "max_motor_rate_m_per_s")]
    pub max_motor_rate: f64,
    /// m: commanded travel over which the motor encoder may stand.
    #[serde(rename = "max_unchanged_travel_m")]
    pub max_unchanged_travel: f64,
    /// m/N: commanded travel over which a drive that reverses stands until its speed control has taken back
    /// the friction of its reducer, per tension of its cable.
    #[serde(rename = "reversal_travel_m_per_n", default)]
    pub reversal_travel: f64,
    /// `r_v,max`, m: residual between commanded and measured travel of the winch.
    #[serde(rename = "max_winch_residual_m")]
    pub max_winch_residual: f64,
    /// N/s: largest rate of change of the load cell.
    #[serde(rename = "max_tension_rate_n_per_s")]
    pub max_tension_rate: f64,
    /// Number of equal samples of the load cell that are a fault; large where its noise is below its
    /// resolution.
    pub max_equal_tensions: f64,
    /// `dT`, N: tension below its estimate that is a fault.
    #[serde(rename = "missing_tension_n")]
    pub missing_tension: f64,
    /// `T_f`, N, >= 0: tension at the drive below which a winch winds in cable.
    #[serde(rename = "min_drive_tension_n", alias = "least_drive_tension_n", default)]
    pub min_drive_tension: f64,
    /// N: tension below which a drive may not pay out cable although it is commanded to.
    #[serde(rename = "slack_tension_n")]
    pub slack_tension: f64,
    /// Whether the tension at the drive is measured.
    #[serde(default = "measured", skip_serializing_if = "Clone::clone")]
    pub load_cell: bool,
    /// `s`, N, >= 0: standard deviation of the load cell's noise.
    #[serde(rename = "load_cell_noise_n", default = "usual_noise")]
    pub load_cell_noise: f64,
    /// `eps`, 1, >= 0: relative error of the moment arms.
    #[serde(default = "usual_arm_error")]
    pub moment_arm_error: f64,
}

/// Of a load cell of 1 kN, N: of gains that were written without it.
fn usual_noise() -> f64 {
    0.4
}

/// Of gains that were written without it, or with a load cell.
fn measured() -> bool {
    true
}

/// Of gains that were written without it.
fn usual_arm_error() -> f64 {
    0.02
}

/// Of gains written before there was one.
fn whole() -> f64 {
    1.0
}

impl ArmGains {
    /// The same with lower gains, for [`CableStateSource::Encoders`](super::CableStateSource::Encoders):
    /// without estimated tensions the phase margin is smaller.
    #[must_use]
    pub fn without_tension_estimates(mut self) -> Self {
        self.joints.iter_mut().for_each(|joint| joint.bandwidth *= 0.7);
        for muscle in &mut self.muscles {
            muscle.position_gain *= 0.53;
            muscle.rate_gain *= 0.4;
            muscle.backlash_gain *= 0.45;
        }
        self
    }

    /// The same without compensation of disturbances and without any other integral action.
    #[must_use]
    pub fn without_integral_action(mut self) -> Self {
        self.joints.iter_mut().for_each(|joint| joint.disturbance_bandwidth = 0.0);
        self.muscles.iter_mut().for_each(|muscle| muscle.backlash_integral = 0.0);
        self
    }

    /// `F_min` and `F_max` of every muscle, N: `[muscles]`.
    #[must_use]
    pub fn tension_limits(&self) -> Vec<[f64; 2]> {
        self.muscles.iter().map(|muscle| muscle.tension).collect()
    }

    /// Checks them for a machine with these numbers of muscles and joints.
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::OutOfDomain`] name the field.
    pub fn validate(&self, muscles: usize, joints: usize) -> Result<(), Error> {
        for (name, expected, got) in [
            ("gains of joints", joints, self.joints.len()),
            ("gains of muscles", muscles, self.muscles.len()),
        ] {
            if expected != got {
                return Err(Error::WrongLength { name, expected, got });
            }
        }
        positive("observer_bandwidth", self.observer_bandwidth)?;
        positive("slip_filter_time", self.slip_filter_time)?;
        positive("rest_time_constant", self.rest_time_constant)?;
        non_negative("damping", self.damping)?;
        let fraction = self.feedback_fraction;
        within("feedback_fraction", "from 0 to 1", fraction, (0.0..=1.0).contains(&fraction))?;
        non_negative("creep_feedback_fraction", self.creep_feedback_fraction)?;
        let ratio = self.max_bandwidth_ratio;
        within("max_bandwidth_ratio", "at least 1", ratio, ratio >= 1.0 && ratio.is_finite())?;
        if let Some(EndPointGains { rate, largest, .. }) = self.end_point {
            non_negative("rate of the end point's integral", rate)?;
            positive("largest correction of the end point", largest)?;
        }
        self.joints.iter().try_for_each(JointGains::validate)?;
        self.muscles.iter().try_for_each(MuscleGains::validate)
    }
}

impl JointGains {
    fn validate(&self) -> Result<(), Error> {
        non_negative("bandwidth", self.bandwidth)?;
        non_negative("disturbance_bandwidth", self.disturbance_bandwidth)?;
        for (name, value) in [
            ("innovation_threshold", self.innovation_threshold),
            ("resolution", self.resolution),
            ("jump", self.jump),
            ("implied", self.implied),
            ("reference_travel", self.reference_travel),
            ("tracking_error", self.tracking_error),
        ] {
            positive(name, value)?;
        }
        non_negative("dead_band", self.dead_band)?;
        Ok(())
    }
}

impl MuscleGains {
    /// Change of a load cell's reading, N, between two cycles, to a tension, N, that no winch at the speeds
    /// of pretension and of lowering makes.
    #[must_use]
    pub(in crate::control) fn implausible_step(&self, tension: f64) -> f64 {
        8.0 * self.load_cell_noise + 0.3 * tension.max(0.0) + self.missing_tension
    }

    fn validate(&self) -> Result<(), Error> {
        for (name, value) in [
            ("stretch_time_constant", self.stretch_time_constant),
            ("winch_deceleration", self.winch_deceleration),
            ("max_winch_speed", self.max_winch_speed),
            ("max_winch_acceleration", self.max_winch_acceleration),
            ("stop_deceleration", self.stop_deceleration),
            ("presliding_distance", self.presliding_distance),
            ("rest_speed", self.rest_speed),
            ("max_motor_rate", self.max_motor_rate),
            ("max_unchanged_travel", self.max_unchanged_travel),
            ("max_winch_residual", self.max_winch_residual),
            ("max_tension_rate", self.max_tension_rate),
            ("max_equal_tensions", self.max_equal_tensions),
            ("missing_tension", self.missing_tension),
        ] {
            positive(name, value)?;
        }
        for (name, value) in [
            ("position_gain", self.position_gain),
            ("rate_gain", self.rate_gain),
            ("backlash_gain", self.backlash_gain),
            ("backlash_integral", self.backlash_integral),
            ("correction_fraction", self.correction_fraction),
            ("reversal_travel", self.reversal_travel),
            ("min_drive_tension", self.min_drive_tension),
            ("slack_tension", self.slack_tension),
            ("load_cell_noise", self.load_cell_noise),
            ("moment_arm_error", self.moment_arm_error),
        ] {
            non_negative(name, value)?;
        }
        for (name, [least, most]) in [
            ("tension limits", self.tension),
            ("rest_tolerance", self.rest_tolerance),
            ("rest_error", self.rest_error),
        ] {
            let least = non_negative(name, least)?;
            within(name, "finite and rising", most, most >= least && most.is_finite())?;
        }
        Ok(())
    }
}

#[cfg(test)]
impl ArmGains {
    /// Those of an arm with the paper's drives.
    pub(in crate::control) fn for_tests(muscles: usize, joints: usize) -> Self {
        let joint = JointGains {
            bandwidth: 10.5,
            disturbance_bandwidth: 13.65,
            innovation_threshold: 3.8e-3,
            encoder: true,
            resolution: 3.8e-4,
            jump: 7.5e-3,
            implied: 0.016,
            reference_travel: 0.06,
            dead_band: 0.15,
            tracking_error: 0.5,
        };
        let muscle = MuscleGains {
            position_gain: 0.94,
            rate_gain: 0.15,
            stretch_time_constant: 0.0056,
            winch_deceleration: 1.75,
            max_winch_speed: 0.19,
            max_winch_acceleration: 5.0,
            stop_deceleration: 2.0,
            presliding_distance: 1.14e-4,
            backlash_gain: 7.3,
            backlash_integral: 4.4,
            correction_fraction: 1.0,
            tension: [21.0, 200.0],
            rest_tolerance: [9e-5, 1.4e-4],
            rest_error: [5e-4, 1e-3],
            rest_speed: 1e-3,
            max_motor_rate: 2.0,
            max_unchanged_travel: 8e-4,
            reversal_travel: 1.8e-6,
            max_winch_residual: 0.006,
            max_tension_rate: 4e4,
            max_equal_tensions: 8.0,
            missing_tension: 8.0,
            min_drive_tension: 1.0,
            slack_tension: 4.0,
            load_cell: true,
            load_cell_noise: 0.4,
            moment_arm_error: 0.01,
        };
        Self {
            damping: 0.53,
            observer_bandwidth: 58.0,
            max_bandwidth_ratio: 5.4,
            feedback_fraction: 0.05,
            creep_feedback_fraction: 0.16,
            slip_filter_time: 0.009,
            rest_time_constant: 0.38,
            end_point: None,
            joints: alloc::vec![joint; joints],
            muscles: alloc::vec![muscle; muscles],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;

    type Set = fn(&mut ArmGains, f64);
    type SetPair = fn(&mut ArmGains, [f64; 2]);

    /// The field that is refused with this value.
    fn refused(set: Set, value: f64) -> Option<&'static str> {
        let mut gains = ArmGains::for_tests(2, 2);
        assert_eq!(gains.validate(2, 2), Ok(()));
        set(&mut gains, value);
        match gains.validate(2, 2) {
            Ok(()) => None,
            Err(Error::OutOfDomain { name, .. }) => Some(name),
            Err(other) => panic!("{other}"),
        }
    }

    #[test]
    fn gains_that_have_to_be_positive_are_refused_by_name_at_zero_and_below() {
        let positive: [(&str, Set); 22] = [
            ("observer_bandwidth", |gains, x| gains.observer_bandwidth = x),
            ("slip_filter_time", |gains, x| gains.slip_filter_time = x),
            ("rest_time_constant", |gains, x| gains.rest_time_constant = x),
            ("innovation_threshold", |gains, x| gains.joints[1].innovation_threshold = x),
            ("resolution", |gains, x| gains.joints[1].resolution = x),
            ("jump", |gains, x| gains.joints[1].jump = x),
            ("implied", |gains, x| gains.joints[1].implied = x),
            ("reference_travel", |gains, x| gains.joints[1].reference_travel = x),
            ("tracking_error", |gains, x| gains.joints[1].tracking_error = x),
            ("stretch_time_constant", |gains, x| gains.muscles[1].stretch_time_constant = x),
            ("winch_deceleration", |gains, x| gains.muscles[1].winch_deceleration = x),
            ("max_winch_speed", |gains, x| gains.muscles[1].max_winch_speed = x),
            ("max_winch_acceleration", |gains, x| gains.muscles[1].max_winch_acceleration = x),
            ("stop_deceleration", |gains, x| gains.muscles[1].stop_deceleration = x),
            ("presliding_distance", |gains, x| gains.muscles[1].presliding_distance = x),
            ("rest_speed", |gains, x| gains.muscles[1].rest_speed = x),
            ("max_motor_rate", |gains, x| gains.muscles[1].max_motor_rate = x),
            ("max_unchanged_travel", |gains, x| gains.muscles[1].max_unchanged_travel = x),
            ("max_winch_residual", |gains, x| gains.muscles[1].max_winch_residual = x),
            ("max_tension_rate", |gains, x| gains.muscles[1].max_tension_rate = x),
            ("max_equal_tensions", |gains, x| gains.muscles[1].max_equal_tensions = x),
            ("missing_tension", |gains, x| gains.muscles[1].missing_tension = x),
        ];
        for (name, set) in positive {
            for value in [0.0, -1.0, f64::NAN, f64::INFINITY] {
                assert_eq!(refused(set, value), Some(name), "{value}");
            }
            assert_eq!(refused(set, 1e-3), None, "{name}");
        }
    }

    #[test]
    fn gains_that_may_vanish_are_refused_by_name_below_zero() {
        let non_negative: [(&str, Set); 12] = [
            ("damping", |gains, x| gains.damping = x),
            ("creep_feedback_fraction", |gains, x| gains.creep_feedback_fraction = x),
            ("bandwidth", |gains, x| gains.joints[1].bandwidth = x),
            ("disturbance_bandwidth", |gains, x| gains.joints[1].disturbance_bandwidth = x),
            ("position_gain", |gains, x| gains.muscles[1].position_gain = x),
            ("rate_gain", |gains, x| gains.muscles[1].rate_gain = x),
            ("backlash_gain", |gains, x| gains.muscles[1].backlash_gain = x),
            ("backlash_integral", |gains, x| gains.muscles[1].backlash_integral = x),
            ("correction_fraction", |gains, x| gains.muscles[1].correction_fraction = x),
            ("reversal_travel", |gains, x| gains.muscles[1].reversal_travel = x),
            ("min_drive_tension", |gains, x| gains.muscles[1].min_drive_tension = x),
            ("slack_tension", |gains, x| gains.muscles[1].slack_tension = x),
        ];
        for (name, set) in non_negative {
            for value in [-1.0, f64::NAN, f64::INFINITY] {
                assert_eq!(refused(set, value), Some(name), "{value}");
            }
            assert_eq!(refused(set, 0.0), None, "{name}");
        }
    }

    #[test]
    fn pairs_of_limits_have_to_be_finite_and_rising() {
        let pairs: [(&str, SetPair); 3] = [
            ("tension limits", |gains, x| gains.muscles[1].tension = x),
            ("rest_tolerance", |gains, x| gains.muscles[1].rest_tolerance = x),
            ("rest_error", |gains, x| gains.muscles[1].rest_error = x),
        ];
        for (field, set) in pairs {
            let refused = |pair: [f64; 2]| {
                let mut gains = ArmGains::for_tests(2, 2);
                set(&mut gains, pair);
                gains
                    .validate(2, 2)
                    .is_err_and(|error| matches!(error, Error::OutOfDomain { name, .. } if name == field))
            };
            let wrong = [[2.0, 1.0], [-1.0, 1.0], [1.0, f64::INFINITY], [f64::NAN, 1.0], [1.0, f64::NAN]];
            assert!(wrong.into_iter().all(refused), "{field}");
            assert!(!refused([0.0, 1.0]) && !refused([1.0, 1.0]), "{field}");
        }
    }

    #[test]
    fn a_share_is_at_most_one_and_a_bandwidth_does_not_shrink() {
        let fraction: Set = |gains, x| gains.feedback_fraction = x;
        assert!([-0.1, 1.1, f64::NAN].into_iter().all(|x| refused(fraction, x) == Some("feedback_fraction")));
        assert!([0.0, 1.0].into_iter().all(|x| refused(fraction, x).is_none()));
        let ratio: Set = |gains, x| gains.max_bandwidth_ratio = x;
        let wrong = [0.9, f64::INFINITY, f64::NAN];
        assert!(wrong.into_iter().all(|x| refused(ratio, x) == Some("max_bandwidth_ratio")));
        assert!(refused(ratio, 1.0).is_none());
    }

    #[test]
    fn gains_of_another_machine_are_refused() {
        let gains = ArmGains::for_tests(3, 2);
        assert_eq!(gains.validate(3, 2), Ok(()));
        let expected = |name, expected, got| Err(Error::WrongLength { name, expected, got });
        assert_eq!(gains.validate(2, 2), expected("gains of muscles", 2, 3));
        assert_eq!(gains.validate(3, 1), expected("gains of joints", 1, 2));
    }

    #[test]
    fn without_tension_estimates_the_gains_of_feedback_are_fixed_shares_of_those_with_them() {
        let of = |factor: f64| {
            let mut gains = ArmGains::for_tests(1, 1);
            gains.joints[0].bandwidth *= factor;
            let muscle = &mut gains.muscles[0];
            muscle.position_gain *= factor;
            muscle.rate_gain *= factor;
            muscle.backlash_gain *= factor;
            gains
        };
        let feedback = |gains: &ArmGains| {
            let muscle = &gains.muscles[0];
            vec![gains.joints[0].bandwidth, muscle.position_gain, muscle.rate_gain, muscle.backlash_gain]
        };
        let fractions = |factor: f64| -> Vec<f64> {
            let [with, without] = [of(factor), of(factor).without_tension_estimates()];
            feedback(&without).iter().zip(feedback(&with)).map(|(without, with)| without / with).collect()
        };
        for (fraction, of_tenfold) in fractions(1.0).into_iter().zip(fractions(10.0)) {
            assert!(
                fraction > 0.3 && fraction < 0.8 && (of_tenfold - fraction).abs() < 1e-12,
                "{fraction} {of_tenfold}"
            );
        }
        // All others stay.
        let mut restored = of(1.0).without_tension_estimates();
        restored.joints[0].bandwidth = of(1.0).joints[0].bandwidth;
        let MuscleGains { position_gain, rate_gain, backlash_gain, .. } = of(1.0).muscles[0];
        restored.muscles[0] = MuscleGains { position_gain, rate_gain, backlash_gain, ..restored.muscles[0] };
        assert_eq!(restored, of(1.0));
    }
}
