use crate::error::{Error, finite, non_negative};

/// Angle over which a cable wraps a pulley, as a function of the joint the pulley belongs to.
///
/// ```text
/// theta(q) = max(0, theta_0 + c q)
/// ```
///
/// | symbol  | argument       | unit    | domain | meaning                                      |
/// |---------|----------------|---------|--------|----------------------------------------------|
/// | theta_0 | `wrap_at_zero` | rad     | finite | wrap at `q = 0`; whole turns count `2 pi` each |
/// | c       | `wrap_per_joint_angle` | rad/rad | finite | +1 or -1 for a pulley on the joint's axis, 0 for one the joint does not turn |
/// | q       | `angle_joint`  | rad     | finite | joint angle                                  |
///
/// # Assumes
/// The cable leaves the pulley before the wrap turns negative and comes back where it left.
///
/// # Departs
/// The source names a function `H(q, r, n)` without giving it. The radius `r` changes the path, not the
/// wrap, and so does not appear; `n` pulleys are `n` of these, summed by [`total_wrap_angle`].
///
/// # Example
/// ```
/// use sinew::transmission::{Pulley, total_wrap_angle};
/// let idler = Pulley::new(1.2, 0.0)?;
/// let elbow = Pulley::new(0.5, 1.0)?;
/// // Straight sheath, lifted cable: nothing is wrapped but the idler.
/// assert_eq!(elbow.wrap_angle(-2.0)?, 0.0);
/// let wraps = [idler.wrap_angle(-2.0)?, elbow.wrap_angle(-2.0)?];
/// assert_eq!(total_wrap_angle(0.0, &wraps)?, 1.2);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `yuan2023`, eq. 6.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pulley {
    wrap_at_zero: f64,
    wrap_per_joint_angle: f64,
}

impl Pulley {
    /// A pulley of checked parameters.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the parameter that is not finite.
    pub fn new(wrap_at_zero: f64, wrap_per_joint_angle: f64) -> Result<Self, Error> {
        finite("wrap_at_zero", wrap_at_zero)?;
        finite("wrap_per_joint_angle", wrap_per_joint_angle)?;
        Ok(Self { wrap_at_zero, wrap_per_joint_angle })
    }

    /// Wrap angle at a joint angle, rad, never negative.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the joint angle or the result is not finite.
    pub fn wrap_angle(&self, angle_joint: f64) -> Result<f64, Error> {
        finite("angle_joint", angle_joint)?;
        finite("wrap_angle", (self.wrap_at_zero + self.wrap_per_joint_angle * angle_joint).max(0.0))
    }
}

/// Angle that friction sees: the bend of the sheath plus the wrap on every pulley.
///
/// ```text
/// phi(q) = phi_sheath + sum_i theta_i(q)
/// ```
///
/// | symbol     | argument      | unit | domain | meaning                              |
/// |------------|---------------|------|--------|--------------------------------------|
/// | phi_sheath | `sheath_bend` | rad  | >= 0   | integral of curvature along the sheath |
/// | theta_i    | `wraps`       | rad  | >= 0   | wrap on pulley `i`, [`Pulley::wrap_angle`] |
///
/// # Shapes
/// `wraps: [pulleys]`, any number.
///
/// # Assumes
/// The same friction coefficient everywhere; bends add whatever the planes they lie in.
///
/// # Errors
/// [`Error::OutOfDomain`] for a negative or non-finite angle.
///
/// # Source
/// `yuan2023`, eq. 3.
pub fn total_wrap_angle(sheath_bend: f64, wraps: &[f64]) -> Result<f64, Error> {
    let mut total = non_negative("sheath_bend", sheath_bend)?;
    for &wrap in wraps {
        total += non_negative("wraps", wrap)?;
    }
    finite("wrap_angle", total)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wraps_follow_the_joint_and_never_turn_negative() {
        let pulley = Pulley::new(0.3, -1.0).unwrap();
        assert!((pulley.wrap_angle(-1.0).unwrap() - 1.3).abs() < 1e-15);
        assert!(pulley.wrap_angle(1.0).unwrap().abs() < 1e-15);
        assert!(pulley.wrap_angle(f64::NAN).is_err());
    }

    #[test]
    fn a_negative_wrap_is_refused_and_no_pulley_is_no_wrap() {
        assert!(total_wrap_angle(0.1, &[0.2, -0.1]).is_err());
        assert!((total_wrap_angle(0.7, &[]).unwrap() - 0.7).abs() < 1e-15);
    }

    #[test]
    fn a_pulley_that_turns_faster_than_its_joint_wraps_faster_and_wraps_add_to_the_bend() {
        let pulley = Pulley::new(0.3, 1.5).unwrap();
        assert!((pulley.wrap_angle(2.0).unwrap() - 3.3).abs() < 1e-15);
        assert!((total_wrap_angle(0.7, &[0.2, 1.1]).unwrap() - 2.0).abs() < 1e-15);
    }
}
