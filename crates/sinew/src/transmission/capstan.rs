use super::Sliding;
use crate::error::{Error, finite, non_negative};

/// Tension behind a bend over which a cable slides.
///
/// ```text
/// T_out = T_in exp(-s mu phi)
/// ```
///
/// | symbol | argument     | unit | domain | meaning                                  |
/// |--------|--------------|------|--------|------------------------------------------|
/// | T_in   | `tension_in` | N    | >= 0   | tension at the drive end                 |
/// | mu     | `friction`   | 1    | >= 0   | Coulomb coefficient, cable on sheath     |
/// | phi    | `wrap_angle` | rad  | >= 0   | sum of all bends, whatever their planes  |
/// | s      | `sliding`    | 1    | +-1    | +1 while the cable slides toward the motor |
///
/// # Assumes
/// Quasi-static, flexible and massless cable, sliding everywhere, no adhesion.
///
/// # Errors
/// [`Error::OutOfDomain`] names the argument outside its domain, or `tension_out` where the
/// exponential leaves the range of `f64`.
///
/// # Example
/// ```
/// use sinew::transmission::{Sliding, capstan_tension_out};
/// // A straight cable loses no tension.
/// assert_eq!(capstan_tension_out(50.0, 0.2, 0.0, Sliding::TowardMotor)?, 50.0);
/// // The loss in one direction is the gain needed in the other.
/// let there = capstan_tension_out(50.0, 0.2, 3.0, Sliding::TowardMotor)?;
/// let back = capstan_tension_out(there, 0.2, 3.0, Sliding::AwayFromMotor)?;
/// assert!((back - 50.0).abs() < 1e-12);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `yuan2023`, eqs. 1 and 2; `euler1769`, `eytelwein1808`.
#[doc(alias = "euler_eytelwein")]
pub fn capstan_tension_out(
    tension_in: f64,
    friction: f64,
    wrap_angle: f64,
    sliding: Sliding,
) -> Result<f64, Error> {
    non_negative("tension_in", tension_in)?;
    non_negative("friction", friction)?;
    non_negative("wrap_angle", wrap_angle)?;
    let friction_angle = finite("friction * wrap_angle", friction * wrap_angle)?;
    finite("tension_out", tension_in * libm::exp(-sliding.sign() * friction_angle))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_lies_outside_the_domain_is_refused_by_name() {
        let refused = |t, mu, phi| match capstan_tension_out(t, mu, phi, Sliding::AwayFromMotor) {
            Err(Error::OutOfDomain { name, .. }) => name,
            other => panic!("{other:?}"),
        };
        assert_eq!(refused(-1.0, 0.1, 1.0), "tension_in");
        assert_eq!(refused(1.0, f64::NAN, 1.0), "friction");
        assert_eq!(refused(1.0, 0.1, f64::INFINITY), "wrap_angle");
        assert_eq!(refused(1.0, 1e200, 1e200), "friction * wrap_angle");
        assert_eq!(refused(1.0, 1.0, 1e4), "tension_out");
    }

    #[test]
    fn the_tension_falls_by_the_exponential_toward_the_motor_and_grows_by_it_away() {
        for (sliding, exact) in
            [(Sliding::TowardMotor, 50.0 * libm::exp(-0.6)), (Sliding::AwayFromMotor, 50.0 * libm::exp(0.6))]
        {
            assert!((capstan_tension_out(50.0, 0.2, 3.0, sliding).unwrap() - exact).abs() < 3e-14);
        }
    }
}
