use crate::Error;
use crate::error::{non_negative, positive, within};
use crate::transmission::cable::CableLaw;
use alloc::vec;
use alloc::vec::Vec;

/// Gains and limits of the arm's controller.
///
/// Each field names the term of the control law in which it stands. The laws are written in full at the
/// controller ([`ArmController`](super::ArmController), `q''_d`), the joints' observer (`joint_observer.rs`)
/// and the winches (`winch.rs`).
///
/// # Source
/// A random search on two arms of the twin, drawn and calibrated; checked on other arms of the same kind.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmGains {
    /// `w` of every joint in `q''_d = .. + w^2 (q_r - q^) + 2 zeta w (q'_r - q'^)`, rad/s, >= 0: bandwidth.
    /// `[joints]`
    pub bandwidth: Vec<f64>,
    /// `zeta` of the same, 1, >= 0: damping ratio.
    pub damping: f64,
    /// `w_d` of every joint in `d_u' = w_d (d^ - d_u)`, rad/s, >= 0: bandwidth of the disturbance
    /// compensation `d_u`, 0 for none. `[joints]`
    pub disturbance_bandwidth: Vec<f64>,
    /// `w_o` in `w = w_o clip(|e|/e_0, 1, r)`, rad/s, > 0: bandwidth of the joints' observers at small
    /// innovations `e`.
    pub observer_bandwidth: f64,
    /// `e_0` of the same, rad, > 0: innovation above which the bandwidth grows; larger than the encoders'
    /// quantisation.
    pub innovation_threshold: f64,
    /// `r` of the same, 1, >= 1: largest ratio by which it grows.
    pub max_bandwidth_ratio: f64,
    /// `kappa` in `x = e* - e^ + kappa d + t_d (v_r - v^)`, 1, >= 0: share of an anchor's position error `d`
    /// in the travel `x` of its winch; oscillates beyond 2.
    pub position_gain: f64,
    /// `t_d` of the same, s, >= 0: gain of the anchor's speed error; damps limit cycles of the dead band.
    pub rate_gain: f64,
    /// `t_v` in `v = v_r + clip(x/t_v, +-sqrt(2 a |x|))`, s, > 0: time constant of a winch's travel.
    pub stretch_time_constant: f64,
    /// `a` of the same, m/s^2, > 0: deceleration that a winch is assumed capable of.
    pub winch_deceleration: f64,
    /// `v_max` in `|v| <= v_max`, m/s, > 0: largest commanded speed of a winch.
    pub max_winch_speed: f64,
    /// `x_t` in `s_r' = v_r/x_t`, m, > 0: presliding distance, travel of an anchor over which its cable
    /// crosses half of the dead band.
    pub presliding_distance: f64,
    /// `lambda` in `s = .. + lambda d/G`, 1, >= 0: pre-travel across the dead band `G`, proportional to the
    /// anchor's position error.
    pub pre_travel_gain: f64,
    /// `lambda_i` in `s_i' = lambda_i d/G`, 1/s, >= 0: the same, integrated.
    pub pre_travel_integral: f64,
    /// `beta_0` in `beta = beta_0 + beta_c/(1 + (v_r/v_c)^2)`, 1, >= 0: share of the dead band that
    /// feedforward leaves to feedback, the uncertainty of friction.
    pub feedback_share: f64,
    /// `beta_c` of the same, 1, >= 0: additional share at creep speed, where static friction exceeds sliding
    /// friction.
    pub creep_feedback_share: f64,
    /// `t_s` in `t_s v_s' = v^ - v_s`, s, > 0: filter of the anchor's speed at which friction is evaluated.
    pub slip_filter_time: f64,
    /// `F_min` of (22), N, >= 0: least desired tension at an anchor.
    pub min_tension: f64,
    /// N, >= 0: least difference of `F_min` to the cable's `T_0`, below which no tension can be reached.
    pub pretension_margin: f64,
    /// N, > 0: continuous tension of a drive; with the friction of its cable it gives `F_max` of (22).
    pub max_drive_tension: f64,
    /// `delta_min`, `delta_max` in `d_0 = d - clip(d, +-delta)`, m, >= 0 and rising: dead zone of the
    /// anchors' position errors at rest, and its limit.
    pub rest_tolerance: [f64; 2],
    /// `t_r` in `s_r' = d_0/(t_r x_t)`, s, > 0: time constant with which errors beyond the dead zone are
    /// corrected at rest.
    pub rest_time_constant: f64,
}

impl ArmGains {
    /// For the LM-Arm with the drives of the bench.
    #[must_use]
    pub fn lm_arm() -> Self {
        Self {
            bandwidth: vec![11.5, 11.5, 11.5, 10.4, 8.8, 8.8, 8.8],
            damping: 0.53,
            disturbance_bandwidth: vec![14.9, 14.9, 14.9, 11.5, 12.4, 12.4, 12.4],
            observer_bandwidth: 58.0,
            innovation_threshold: 3.8e-3,
            max_bandwidth_ratio: 5.4,
            position_gain: 0.94,
            rate_gain: 0.15,
            stretch_time_constant: 0.0056,
            winch_deceleration: 1.77,
            max_winch_speed: 0.13,
            presliding_distance: 1.14e-4,
            pre_travel_gain: 7.3,
            pre_travel_integral: 4.4,
            feedback_share: 0.05,
            creep_feedback_share: 0.16,
            slip_filter_time: 0.009,
            min_tension: 21.0,
            pretension_margin: 4.0,
            max_drive_tension: 445.0,
            rest_tolerance: [9e-5, 1.4e-4],
            rest_time_constant: 0.38,
        }
    }

    /// The same with lower gains, for [`CableStateSource::Encoders`](super::CableStateSource::Encoders):
    /// without estimated tensions the phase margin is smaller.
    #[must_use]
    pub fn without_tension_estimates(self) -> Self {
        Self {
            bandwidth: self.bandwidth.iter().map(|w| 0.7 * w).collect(),
            position_gain: 0.5,
            rate_gain: 0.06,
            pre_travel_gain: 3.3,
            ..self
        }
    }

    /// `F_min` and `F_max` of (22), N, at the anchor of a cable; the first is never above the second.
    ///
    /// ```text
    /// F_min = max(F_min,0, T_0 + margin),     F_max = F_drive exp(-A) + T_0,   A the friction angle
    /// ```
    #[must_use]
    pub fn tension_limits(&self, cable: &CableLaw) -> [f64; 2] {
        let least = self.min_tension.max(cable.pretension() + self.pretension_margin);
        let most = self.max_drive_tension * libm::exp(-cable.friction_angle()) + cable.pretension();
        [least, most.max(least)]
    }

    /// Checks them for a robot with this number of joints.
    ///
    /// # Errors
    /// [`Error::WrongLength`] and [`Error::OutOfDomain`] name the field.
    pub fn validate(&self, joints: usize) -> Result<(), Error> {
        for (name, list) in
            [("bandwidth", &self.bandwidth), ("disturbance_bandwidth", &self.disturbance_bandwidth)]
        {
            if list.len() != joints {
                return Err(Error::WrongLength { name, expected: joints, got: list.len() });
            }
            list.iter().try_for_each(|w| non_negative(name, *w).map(drop))?;
        }
        for (name, value) in [
            ("observer_bandwidth", self.observer_bandwidth),
            ("innovation_threshold", self.innovation_threshold),
            ("stretch_time_constant", self.stretch_time_constant),
            ("winch_deceleration", self.winch_deceleration),
            ("max_winch_speed", self.max_winch_speed),
            ("presliding_distance", self.presliding_distance),
            ("slip_filter_time", self.slip_filter_time),
            ("max_drive_tension", self.max_drive_tension),
            ("rest_time_constant", self.rest_time_constant),
        ] {
            positive(name, value)?;
        }
        for (name, value) in [
            ("damping", self.damping),
            ("position_gain", self.position_gain),
            ("rate_gain", self.rate_gain),
            ("pre_travel_gain", self.pre_travel_gain),
            ("pre_travel_integral", self.pre_travel_integral),
            ("feedback_share", self.feedback_share),
            ("creep_feedback_share", self.creep_feedback_share),
            ("min_tension", self.min_tension),
            ("pretension_margin", self.pretension_margin),
            ("rest_tolerance", self.rest_tolerance[0]),
        ] {
            non_negative(name, value)?;
        }
        let ratio = self.max_bandwidth_ratio;
        within("max_bandwidth_ratio", "a number >= 1", ratio, ratio.is_finite() && ratio >= 1.0)?;
        let [least, most] = self.rest_tolerance;
        within("rest_tolerance", "two numbers that rise", most, most >= least)?;
        Ok(())
    }
}
