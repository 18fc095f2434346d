use super::Sliding;
use crate::error::{Error, finite, non_negative, within};

/// A bent sheath in steady sliding: tension at one end from the tension at the other.
///
/// ```text
/// T_out = eta^s T_in exp(-s mu phi) + T_0                 (7)
/// T_in  = (T_out - T_0) eta^(-s) exp(s mu phi)            (8)
/// T_r   = T_in - T_out                                    compensation to add to the desired T_out
/// ```
///
/// | symbol | argument      | unit | domain     | meaning                                   |
/// |--------|---------------|------|------------|-------------------------------------------|
/// | eta    | `efficiency`  | 1    | (0, 1]     | fraction of tension left by losses independent of phi |
/// | mu     | `friction`    | 1    | >= 0       | friction coefficient, see [`Stribeck`](super::Stribeck) |
/// | T_0    | `pretension`  | N    | >= 0       | constant force in parallel at the anchor   |
/// | phi    | `wrap_angle`  | rad  | >= 0       | sheath bend plus wraps, see [`total_wrap_angle`](super::total_wrap_angle) |
/// | T_in   | `tension_in`  | N    | >= 0       | tension at the drive end                   |
/// | T_out  | `tension_out` | N    | >= T_0     | tension at the anchor                      |
/// | s      | `sliding`     | 1    | +-1        | +1 while the cable slides toward the motor |
///
/// # Assumes
/// Quasi-static, sliding everywhere. `T_0` is constant, so it stores no energy over a closed cycle.
///
/// # Departs
/// Printed (7) has `eta^(-s)`: an efficiency below one would then *gain* tension on the active side.
/// Printed (8) is called the inverse of (7) and is not; sign, place of `eta` and of `T_0` are corrected here.
///
/// # Example
/// ```
/// use sinew::transmission::{SheathLaw, Sliding};
/// let sheath = SheathLaw::new(0.93, 0.156, 15.5)?;
/// let desired = 80.0;
/// let needed = sheath.tension_in(desired, 6.28, Sliding::TowardMotor)?;
/// let reached = sheath.tension_out(needed, 6.28, Sliding::TowardMotor)?;
/// assert!((reached - desired).abs() < 1e-10);
/// // Without bend, loss and pretension both tensions are equal.
/// assert_eq!(SheathLaw::new(1.0, 0.2, 0.0)?.tension_out(50.0, 0.0, Sliding::TowardMotor)?, 50.0);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `yuan2023`, eqs. 7 and 8, corrected. The example's numbers are fitted to the tables of `yuan2023`;
/// there only `mu phi - ln(eta)` is identified, not its parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheathLaw {
    efficiency: f64,
    friction: f64,
    pretension: f64,
}

impl SheathLaw {
    /// A sheath of checked parameters.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the parameter outside its domain.
    pub fn new(efficiency: f64, friction: f64, pretension: f64) -> Result<Self, Error> {
        within(
            "efficiency",
            "a finite number in (0, 1]",
            efficiency,
            efficiency.is_finite() && efficiency > 0.0 && efficiency <= 1.0,
        )?;
        non_negative("friction", friction)?;
        non_negative("pretension", pretension)?;
        Ok(Self { efficiency, friction, pretension })
    }

    /// Tension at the anchor, N: (7).
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for an argument outside its domain or a result that is not finite.
    pub fn tension_out(&self, tension_in: f64, wrap_angle: f64, sliding: Sliding) -> Result<f64, Error> {
        non_negative("tension_in", tension_in)?;
        let exponent = self.exponent(wrap_angle)?;
        finite("tension_out", tension_in * libm::exp(-sliding.sign() * exponent) + self.pretension)
    }

    /// Drive-end tension for a desired tension at the anchor, N: (8), the exact inverse of (7).
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for an argument outside its domain or a result that is not finite.
    #[doc(alias = "inverse")]
    pub fn tension_in(&self, tension_out: f64, wrap_angle: f64, sliding: Sliding) -> Result<f64, Error> {
        let above = tension_out - self.pretension;
        within(
            "tension_out",
            "a finite number >= pretension",
            tension_out,
            above.is_finite() && above >= 0.0,
        )?;
        let exponent = self.exponent(wrap_angle)?;
        finite("tension_in", above * libm::exp(sliding.sign() * exponent))
    }

    /// Compensation to add to the desired tension, N: `T_r = T_in - T_out`.
    ///
    /// # Errors
    /// As [`SheathLaw::tension_in`].
    pub fn compensation(&self, tension_out: f64, wrap_angle: f64, sliding: Sliding) -> Result<f64, Error> {
        Ok(self.tension_in(tension_out, wrap_angle, sliding)? - tension_out)
    }

    /// `mu phi - ln(eta) >= 0`; a pair of tensions identifies only this sum.
    fn exponent(&self, wrap_angle: f64) -> Result<f64, Error> {
        non_negative("wrap_angle", wrap_angle)?;
        let exponent = self.friction * wrap_angle - libm::log(self.efficiency);
        finite("friction * wrap_angle - ln(efficiency)", exponent)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BOTH: [Sliding; 2] = [Sliding::TowardMotor, Sliding::AwayFromMotor];

    fn edge_or(range: core::ops::Range<f64>, edges: &'static [f64]) -> impl Strategy<Value = f64> {
        prop_oneof![3 => range, 1 => proptest::sample::select(edges)]
    }

    proptest! {
        #[test]
        fn the_inverse_inverts_the_law_over_the_whole_domain(
            efficiency in edge_or(1e-3..1.0, &[1e-3, 1.0]),
            friction in edge_or(0.0..1.0, &[0.0, 1e-300, 1.0]),
            pretension in edge_or(0.0..50.0, &[0.0]),
            wrap in edge_or(0.0..12.0, &[0.0, 1e-300]),
            tension in edge_or(0.0..500.0, &[0.0, 1e-9, 500.0]),
        ) {
            let sheath = SheathLaw::new(efficiency, friction, pretension).unwrap();
            for sliding in BOTH {
                let out = sheath.tension_out(tension, wrap, sliding).unwrap();
                let back = sheath.tension_in(out, wrap, sliding).unwrap();
                // Adding T_0 rounds T_out to a part in 2^53, which the inverse then amplifies.
                let gain = libm::exp(sheath.exponent(wrap).unwrap());
                let rounding = 8.0 * f64::EPSILON * (tension + gain * (out + pretension) + 1e-300);
                prop_assert!((back - tension).abs() <= rounding, "{back} {tension} {rounding}");
            }
        }

        #[test]
        fn the_law_is_passive_in_every_closed_cycle(
            efficiency in edge_or(0.05..1.0, &[1.0]),
            friction in edge_or(0.0..0.5, &[0.0]),
            wrap in edge_or(0.0..6.0, &[0.0]),
            pretension in edge_or(0.0..30.0, &[0.0]),
            there in edge_or(0.0..300.0, &[0.0]),
            back in edge_or(0.0..300.0, &[0.0]),
        ) {
            let sheath = SheathLaw::new(efficiency, friction, pretension).unwrap();
            // One metre toward the motor at one tension, one metre back at another.
            let out = sheath.tension_out(there, wrap, BOTH[0]).unwrap();
            prop_assert!(out <= there + pretension);
            let returned = sheath.tension_out(back, wrap, BOTH[1]).unwrap();
            let lost = (there - out) - (back - returned);
            prop_assert!(lost >= -1e-9 * (1.0 + there + returned), "{lost}");
        }
    }

    #[test]
    fn compensation_equals_the_friction_loss() {
        let sheath = SheathLaw::new(0.9, 0.2, 10.0).unwrap();
        let added = sheath.compensation(60.0, 3.0, Sliding::TowardMotor).unwrap();
        let reached = sheath.tension_out(60.0 + added, 3.0, Sliding::TowardMotor).unwrap();
        assert!((reached - 60.0).abs() < 1e-10);
    }

    #[test]
    fn a_tension_below_the_pretension_has_no_inverse() {
        let sheath = SheathLaw::new(0.9, 0.2, 10.0).unwrap();
        assert!(sheath.tension_in(9.9, 3.0, Sliding::TowardMotor).is_err());
        assert!(SheathLaw::new(0.0, 0.2, 0.0).is_err() && SheathLaw::new(1.1, 0.2, 0.0).is_err());
    }

    #[test]
    fn friction_angle_and_loss_act_together_as_one_exponent() {
        let sheath = SheathLaw::new(0.9, 0.2, 10.0).unwrap();
        for (sliding, factor) in BOTH.into_iter().zip([0.9 * libm::exp(-0.6), libm::exp(0.6) / 0.9]) {
            assert!((sheath.tension_out(50.0, 3.0, sliding).unwrap() - 50.0 * factor - 10.0).abs() < 3e-14);
        }
    }
}
