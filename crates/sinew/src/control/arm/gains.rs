use crate::Error;
use crate::error::{non_negative, positive, within};
use crate::transmission::cable::CableLaw;
use alloc::vec;
use alloc::vec::Vec;

/// How hard the controller of an arm tries.
///
/// # Source
/// A random search on two arms of the twin, drawn and calibrated; others of the same kind follow as well.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmGains {
    /// `w` of every joint, rad/s: bandwidth of the wanted acceleration. `[joints]`
    pub bandwidth: Vec<f64>,
    /// `zeta`, 1.
    pub damping: f64,
    /// `w_d` of every joint, rad/s: how fast the disturbance that it shows is believed; 0 for never. `[joints]`
    pub disturbance_bandwidth: Vec<f64>,
    /// `w_o`, rad/s: bandwidth of the joints' observers.
    pub observer_bandwidth: f64,
    /// `e_0`, rad: error of an observer from which on it hurries. More than counts of the encoders.
    pub innovation_threshold: f64,
    /// Most times faster that it then is.
    pub max_bandwidth_ratio: f64,
    /// `kappa`, 1: share of the joints' errors that the winches make good as positions. Beyond 2 it swings.
    pub position_gain: f64,
    /// `t_d`, s: beside it, of the speeds at which the anchors fall behind. It damps what the dead bands make swing.
    pub rate_gain: f64,
    /// `t_v`, s: how fast a winch makes good what it is away from where it should be.
    pub stretch_time_constant: f64,
    /// `a`, m/s^2: with which a winch is expected to be braked.
    pub winch_deceleration: f64,
    /// Fastest that a winch is told to turn, m/s.
    pub max_winch_speed: f64,
    /// `x_t`, m: how far an anchor goes while its cable changes the direction of sliding.
    pub presliding_distance: f64,
    /// `lambda`, 1: how far across its dead band a cable is sent by the joints' errors.
    pub pre_travel_gain: f64,
    /// `lambda_i`, 1/s: the same over time.
    pub pre_travel_integral: f64,
    /// `beta`, 1: share of the way across the dead band that is left to the joints' errors, because friction is not known
    /// better.
    pub feedback_share: f64,
    /// `beta_c`, 1: the same beside it where an anchor only creeps, because a cable at rest holds more than it then pulls.
    pub creep_feedback_share: f64,
    /// s: smoothing of the speed at which a cable is believed to slip.
    pub slip_filter_time: f64,
    /// `F_min`, N: least tension wanted at an anchor.
    pub min_tension: f64,
    /// N: but at least so much above its `T_0`, below which no wish can be met.
    pub pretension_margin: f64,
    /// What a drive can hold for ever, N: bounds the tension at its anchor.
    pub max_drive_tension: f64,
    /// Errors of the muscles' lengths, m, below which the arm at rest is held, and above which it is held no more.
    pub rest_tolerance: [f64; 2],
    /// s: at rest, what a muscle is off beyond the first of these is to be made good within this time.
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
            stretch_time_constant: 0.0056,
            rate_gain: 0.15,
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

    /// The same for who knows no tension at the anchors: what is known less must be tried less hard.
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

    /// Lower and upper limit of the tension at the anchor of a cable, N.
    ///
    /// ```text
    /// F_min = max(min_tension, T_0 + pretension_margin)
    /// F_max = max(F_min, max_drive_tension exp(-lambda) + T_0)        lambda the friction angle
    /// ```
    #[must_use]
    pub fn tension_limits(&self, law: &CableLaw) -> [f64; 2] {
        let lower = self.min_tension.max(law.pretension() + self.pretension_margin);
        let upper = self.max_drive_tension * libm::exp(-law.friction_angle()) + law.pretension();
        [lower, upper.max(lower)]
    }

    /// Checks them for a robot of so many joints.
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
            ("rest_time_constant", self.rest_time_constant),
            ("stretch_time_constant", self.stretch_time_constant),
            ("winch_deceleration", self.winch_deceleration),
            ("max_winch_speed", self.max_winch_speed),
            ("presliding_distance", self.presliding_distance),
            ("slip_filter_time", self.slip_filter_time),
            ("max_drive_tension", self.max_drive_tension),
        ] {
            positive(name, value)?;
        }
        for (name, value) in [
            ("damping", self.damping),
            ("position_gain", self.position_gain),
            ("rate_gain", self.rate_gain),
            ("pre_travel_gain", self.pre_travel_gain),
            ("feedback_share", self.feedback_share),
            ("creep_feedback_share", self.creep_feedback_share),
            ("pre_travel_integral", self.pre_travel_integral),
            ("min_tension", self.min_tension),
            ("pretension_margin", self.pretension_margin),
            ("rest_tolerance", self.rest_tolerance[0]),
        ] {
            non_negative(name, value)?;
        }
        within(
            "max_bandwidth_ratio",
            "a number >= 1",
            self.max_bandwidth_ratio,
            self.max_bandwidth_ratio.is_finite() && self.max_bandwidth_ratio >= 1.0,
        )?;
        within(
            "rest_tolerance",
            "two numbers that rise",
            self.rest_tolerance[1],
            self.rest_tolerance[1] >= self.rest_tolerance[0],
        )?;
        Ok(())
    }
}
