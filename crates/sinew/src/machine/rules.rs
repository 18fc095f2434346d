use crate::Error;
use crate::error::positive;
use serde::{Deserialize, Serialize};

/// Constants of the rules by which the gains of a machine's controller follow from its numbers.
///
/// The rules are written in full at [`synthesize`](crate::control::arm::synthesize).
///
/// # Source
/// A study on random machines of one to eight joints, and the LM-Arm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ControlRules {
    /// `w`, bandwidth of every joint, rad/s.
    #[serde(rename = "bandwidth_rad_per_s")]
    pub bandwidth: f64,
    /// `w_o`, bandwidth of the joints' observers, rad/s.
    #[serde(rename = "observer_bandwidth_rad_per_s")]
    pub observer_bandwidth: f64,
    /// `kappa`, fraction of an anchor's position error in the travel of its winch, 1.
    pub position_gain: f64,
    /// `lambda`, backlash compensation across the dead band, 1.
    #[serde(alias = "pre_travel_gain")]
    pub backlash_gain: f64,
    /// `lambda_i`, the same integrated, 1/s.
    #[serde(rename = "backlash_integral_per_s", alias = "pre_travel_integral_per_s")]
    pub backlash_integral: f64,
    /// `k`, rate with which the error of the end point is integrated, 1/s; 0 for none.
    #[serde(rename = "end_point_integral_per_s")]
    pub end_point_integral: f64,
    /// `c`, largest crossover of the damping of a cable's mode, rad/s.
    #[serde(rename = "damping_crossover_rad_per_s")]
    pub damping_crossover: f64,
    /// Largest rate at which all muscles together damp the motion of one, over `c`, 1.
    pub shared_damping: f64,
    /// Fraction of torque and drive limits that a planned motion may use, 1.
    pub margin: f64,
}

impl Default for ControlRules {
    fn default() -> Self {
        Self {
            bandwidth: 9.5,
            observer_bandwidth: 58.0,
            position_gain: 0.94,
            backlash_gain: 5.5,
            backlash_integral: 4.4,
            end_point_integral: 0.0,
            damping_crossover: 60.0,
            shared_damping: 2.0,
            margin: 0.8,
        }
    }
}

impl ControlRules {
    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        for (name, value) in [
            ("bandwidth", self.bandwidth),
            ("observer_bandwidth", self.observer_bandwidth),
            ("position_gain", self.position_gain),
            ("backlash_gain", self.backlash_gain),
            ("backlash_integral", self.backlash_integral),
            ("damping_crossover", self.damping_crossover),
            ("shared_damping", self.shared_damping),
            ("margin", self.margin),
        ] {
            positive(name, value)?;
        }
        crate::error::non_negative("end_point_integral", self.end_point_integral)?;
        crate::error::within("margin", "a number in (0, 1]", self.margin, self.margin <= 1.0).map(drop)
    }
}
