/// Direction in which the cable slides through its sheath: the sign `s` of every law of this module.
///
/// ```text
/// s = sign(v),   v > 0 toward the motor
/// ```
///
/// | symbol | argument   | unit | domain | meaning                                        |
/// |--------|------------|------|--------|------------------------------------------------|
/// | v      | `velocity` | m/s  | finite | cable velocity along the sheath, + toward motor |
///
/// # Assumes
/// The whole cable slides in one direction. At `v = 0` there is none: the tension then depends on history and
/// a law with memory is needed.
///
/// # Departs
/// The source sets `v = dT_in/dt`. Here the sign comes from the measured velocity where there is one;
/// `dT_in/dt` is a valid substitute only while the far end yields to tension.
///
/// # Example
/// ```
/// use sinew::transmission::Sliding;
/// assert_eq!(Sliding::from_velocity(0.02), Some(Sliding::TowardMotor));
/// assert_eq!(Sliding::from_velocity(0.0), None);
/// assert_eq!(Sliding::AwayFromMotor.sign(), -1.0);
/// ```
///
/// # Source
/// `yuan2023`, eq. 4, corrected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Sliding {
    /// `s = +1`: contraction, the active muscle, first quadrant.
    TowardMotor,
    /// `s = -1`: lengthening, the passive muscle, fourth quadrant.
    AwayFromMotor,
}

impl Sliding {
    /// The direction of a velocity; `None` at rest or where it is NaN.
    #[must_use]
    pub fn from_velocity(velocity: f64) -> Option<Self> {
        if velocity > 0.0 {
            Some(Self::TowardMotor)
        } else if velocity < 0.0 {
            Some(Self::AwayFromMotor)
        } else {
            None
        }
    }

    /// `s`, +1 or -1.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::TowardMotor => 1.0,
            Self::AwayFromMotor => -1.0,
        }
    }
}
