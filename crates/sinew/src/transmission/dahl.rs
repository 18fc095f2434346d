use crate::error::{Error, non_negative, positive};

/// Dahl friction: a force that saturates along the path, with elastic presliding and no speed dependence.
///
/// ```text
/// dF/dx = sigma (1 - sign(dx) F/F_c)
/// F_1   = F_0 exp(-a) + sign(dx) F_c (1 - exp(-a)),   a = sigma |dx| / F_c      (exact within a step)
/// ```
///
/// | symbol | argument        | unit | domain | meaning                                |
/// |--------|-----------------|------|--------|----------------------------------------|
/// | sigma  | `stiffness`     | N/m  | > 0    | slope of the force where it is zero     |
/// | F_c    | `coulomb_force` | N    | >= 0   | force in steady sliding                 |
/// | dx     | `slide`         | m    | finite | displacement of this step               |
/// | F      | `force`         | N    | finite | state and result; opposes the motion where positive with `dx` |
///
/// # Assumes
/// Monotone motion within a step. Passive: `F dx = d(F^2/(2 sigma)) + F^2 |dx|/F_c`.
///
/// # Departs
/// Dahl's shape exponent is fixed at 1, the value for which the step has a closed form.
///
/// # Example
/// ```
/// use sinew::transmission::Dahl;
/// let law = Dahl::new(1e4, 5.0)?;
/// assert_eq!(law.step(0.0, 1.0), 5.0);              // after long sliding: Coulomb
/// let small = law.step(0.0, 1e-9);
/// assert!((small - 1e-5).abs() < 1e-10);            // at first: a spring
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `dahl1968`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dahl {
    stiffness: f64,
    coulomb_force: f64,
}

impl Dahl {
    /// A law of checked parameters.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the parameter outside its domain.
    pub fn new(stiffness: f64, coulomb_force: f64) -> Result<Self, Error> {
        positive("stiffness", stiffness)?;
        non_negative("coulomb_force", coulomb_force)?;
        Ok(Self { stiffness, coulomb_force })
    }

    /// The force, N, after a slide, m; a slide that is not finite leaves it as it is.
    #[inline]
    #[must_use]
    pub fn step(&self, force: f64, slide: f64) -> f64 {
        if !slide.is_finite() || slide.abs() <= 0.0 {
            return force;
        }
        // Coulomb force zero gives an infinite `a` and hence no force.
        let a = self.stiffness * slide.abs() / self.coulomb_force;
        let kept = libm::exp(-a);
        force * kept - self.coulomb_force.copysign(slide) * libm::expm1(-a)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_long_step_equals_many_short_ones() {
        let law = Dahl::new(2e4, 3.0).unwrap();
        let whole = law.step(-2.0, 5e-4);
        let parts = (0..1000).fold(-2.0, |force, _| law.step(force, 5e-7));
        assert!((whole - parts).abs() < 1e-12);
    }

    #[test]
    fn no_coulomb_force_is_no_force_and_nan_is_held() {
        let frictionless = Dahl::new(2e4, 0.0).unwrap();
        assert!(frictionless.step(0.0, 1e-3).abs() < 1e-300);
        let law = Dahl::new(2e4, 3.0).unwrap();
        for slide in [f64::NAN, f64::INFINITY, 0.0] {
            assert!((law.step(1.5, slide) - 1.5).abs() < 1e-15);
        }
        assert!(Dahl::new(0.0, 1.0).is_err() && Dahl::new(1.0, -1.0).is_err());
    }
}
