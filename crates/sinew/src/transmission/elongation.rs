use super::Sliding;
use crate::error::{Error, finite, non_negative, positive, within};

/// Stretch of a cable under the tension that friction leaves along it.
///
/// ```text
/// delta_l = rho integral_0^L (T(x) - T_0) dx,    T(x) = eta^s T_in exp(-s mu x/R),    L = min(l_c, L_1)
///         = rho L (eta^s T_in E(s mu L/R) - T_0),                E(z) = (1 - exp(-z))/z,  E(0) = 1
/// ```
///
/// | symbol | argument     | unit | domain | meaning                                          |
/// |--------|--------------|------|--------|--------------------------------------------------|
/// | rho    | `compliance` | 1/N  | > 0    | strain per tension, `1/(E A)`                     |
/// | eta    | `efficiency` | 1    | (0, 1] | as in [`SheathLaw`](super::SheathLaw)                   |
/// | mu     | `friction`   | 1    | >= 0   | friction coefficient                              |
/// | 1/R    | `curvature`  | 1/m  | >= 0   | mean curvature of the sheath, 0 when straight     |
/// | l_c    | `length`     | m    | >= 0   | length of the cable in the sheath                 |
/// | T_0    | `pretension` | N    | >= 0   | tension at which the stretch counts as zero       |
/// | T_in   | `tension_in` | N    | >= 0   | tension at the drive end                          |
/// | L_1    |              | m    | >= 0   | see [`transmission_length`]                       |
///
/// The bend is `phi = l_c/R`; `mu -> 0`, `1/R -> 0` and `l_c -> 0` are regular.
///
/// # Assumes
/// Linear elastic cable, quasi-static, sliding from the drive end to `L`.
/// For `s = -1` tension grows along the cable and all of it counts; the stretch is then relative to `T_0`
/// and negative where the tension lies below it.
///
/// # Departs
/// Printed (10) lacks the sign in front of `R/mu` and turns negative for `s = -1`; it also divides by `mu`.
///
/// # Example
/// ```
/// use sinew::transmission::{Elongation, Sliding};
/// // Without friction the tension is uniform: rho (T - T_0) l.
/// let cable = Elongation::new(2.4e-4, 1.0, 0.0, 3.0, 0.8, 20.0)?;
/// let stretch = cable.stretch(120.0, Sliding::TowardMotor)?;
/// assert!((stretch - 2.4e-4 * 100.0 * 0.8).abs() < 1e-15);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `yuan2023`, eqs. 10 and 11, corrected. The example's compliance is fitted to its Table III.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Elongation {
    compliance: f64,
    efficiency: f64,
    friction_per_length: f64,
    length: f64,
    pretension: f64,
}

impl Elongation {
    /// A cable of checked parameters, in the order of the table.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the parameter outside its domain.
    pub fn new(
        compliance: f64,
        efficiency: f64,
        friction: f64,
        curvature: f64,
        length: f64,
        pretension: f64,
    ) -> Result<Self, Error> {
        positive("compliance", compliance)?;
        within(
            "efficiency",
            "a finite number in (0, 1]",
            efficiency,
            efficiency.is_finite() && efficiency > 0.0 && efficiency <= 1.0,
        )?;
        non_negative("friction", friction)?;
        non_negative("curvature", curvature)?;
        non_negative("length", length)?;
        non_negative("pretension", pretension)?;
        let friction_per_length = finite("friction * curvature", friction * curvature)?;
        Ok(Self { compliance, efficiency, friction_per_length, length, pretension })
    }

    /// Stretch relative to the cable at its pretension, m: (10).
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for a tension outside its domain or a result beyond `f64`.
    pub fn stretch(&self, tension_in: f64, sliding: Sliding) -> Result<f64, Error> {
        non_negative("tension_in", tension_in)?;
        let near = match sliding {
            Sliding::TowardMotor => self.efficiency * tension_in,
            Sliding::AwayFromMotor => tension_in / self.efficiency,
        };
        let reached = match sliding {
            Sliding::TowardMotor => {
                self.length.min(length_to(near, self.pretension, self.friction_per_length))
            }
            Sliding::AwayFromMotor => self.length,
        };
        let mean = near * one_minus_exp_over(sliding.sign() * self.friction_per_length * reached);
        finite("elongation", self.compliance * reached * (mean - self.pretension))
    }
}

/// Length along the cable at which the tension has fallen to the pretension, m.
///
/// ```text
/// L_1 = (R/mu) ln(eta T_in / T_0),   0 where eta T_in <= T_0,   infinite without friction or pretension
/// ```
///
/// | symbol | argument             | unit | domain | meaning                        |
/// |--------|----------------------|------|--------|--------------------------------|
/// | eta T_in | `tension`          | N    | >= 0   | tension just inside the sheath |
/// | T_0    | `pretension`         | N    | >= 0   | tension of the rest of the cable |
/// | mu/R   | `friction_per_length`| 1/m  | >= 0   | friction times curvature       |
///
/// # Assumes
/// `s = +1`: for `s = -1` tension grows along the cable and there is no such length.
///
/// # Errors
/// [`Error::OutOfDomain`] for an argument outside its domain. Infinity is a valid result.
///
/// # Source
/// `yuan2023`, eq. 11.
pub fn transmission_length(tension: f64, pretension: f64, friction_per_length: f64) -> Result<f64, Error> {
    non_negative("tension", tension)?;
    non_negative("pretension", pretension)?;
    non_negative("friction_per_length", friction_per_length)?;
    Ok(length_to(tension, pretension, friction_per_length))
}

fn length_to(tension: f64, pretension: f64, friction_per_length: f64) -> f64 {
    if tension <= pretension {
        0.0
    } else if friction_per_length > 0.0 && pretension > 0.0 {
        (libm::log(tension) - libm::log(pretension)) / friction_per_length
    } else {
        f64::INFINITY
    }
}

/// `E(z) = (1 - exp(-z))/z`, 1 at zero. `expm1` keeps every digit of the numerator, so no series is needed.
fn one_minus_exp_over(z: f64) -> f64 {
    if z.abs() < f64::MIN_POSITIVE { 1.0 } else { -libm::expm1(-z) / z }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const BOTH: [Sliding; 2] = [Sliding::TowardMotor, Sliding::AwayFromMotor];

    fn stretch(mu: f64, curvature: f64, length: f64, t0: f64, t: f64, sliding: Sliding) -> f64 {
        Elongation::new(2.4e-4, 0.9, mu, curvature, length, t0).unwrap().stretch(t, sliding).unwrap()
    }

    proptest! {
        #[test]
        fn the_closed_form_is_the_integral(
            mu in 0.0..0.5, curvature in 0.0..10.0, length in 0.01..2.0, t0 in 0.0..30.0, t in 0.0..200.0,
        ) {
            for sliding in BOTH {
                let near = t * libm::pow(0.9, sliding.sign());
                let n = 4000;
                let h = length / f64::from(n);
                // Midpoint sum over the part that still feels the drive.
                let sum: f64 = (0..n)
                    .map(|i| near * libm::exp(-sliding.sign() * mu * curvature * h * (f64::from(i) + 0.5)) - t0)
                    .take_while(|above| sliding == Sliding::AwayFromMotor || *above > 0.0)
                    .sum();
                let closed = stretch(mu, curvature, length, t0, t, sliding);
                let tolerance = 1e-4 * closed.abs() + 2.4e-4 * h * (near + t0);
                prop_assert!((closed - 2.4e-4 * h * sum).abs() <= tolerance, "{closed}");
            }
        }
    }

    #[test]
    fn no_friction_and_no_bend_are_limits_not_exceptions() {
        for sliding in BOTH {
            let limit = 2.4e-4 * 0.8 * (100.0 * libm::pow(0.9, sliding.sign()) - 20.0);
            assert!((stretch(0.0, 4.0, 0.8, 20.0, 100.0, sliding) - limit).abs() < 1e-15);
            assert!((stretch(0.2, 0.0, 0.8, 20.0, 100.0, sliding) - limit).abs() < 1e-15);
            let mut last = f64::INFINITY;
            for exponent in (-320..0).rev() {
                let small = libm::pow(10.0, f64::from(exponent));
                let off_mu = (stretch(small, 4.0, 0.8, 20.0, 100.0, sliding) - limit).abs();
                let off_bend = (stretch(0.2, small, 0.8, 20.0, 100.0, sliding) - limit).abs();
                assert!(off_mu <= last + 1e-16, "{exponent}");
                assert!(off_mu < small + 1e-15 && off_bend < small + 1e-15, "{exponent}");
                last = off_mu;
            }
            assert!(stretch(0.2, 4.0, 0.0, 20.0, 100.0, sliding).abs() < 1e-15);
        }
    }

    #[test]
    fn stretch_is_continuous_where_the_tension_no_longer_arrives() {
        let l1 = transmission_length(90.0, 20.0, 0.8).unwrap();
        let at = |length: f64| stretch(0.2, 4.0, length, 20.0, 100.0, Sliding::TowardMotor);
        assert!((at(l1 * (1.0 + 1e-9)) - at(l1 * (1.0 - 1e-9))).abs() < 1e-12);
        assert!((at(l1 * 3.0) - at(l1)).abs() < 1e-15, "beyond L_1 nothing more is stretched");
        // Just inside L_1 the tension equals T_0, so the slope is zero there.
        assert!((90.0 * libm::exp(-0.8 * l1) - 20.0).abs() < 1e-12);
    }

    #[test]
    fn both_directions_stretch_a_taut_cable() {
        // The printed equation is negative for s = -1.
        for sliding in BOTH {
            assert!(stretch(0.2, 4.0, 0.8, 20.0, 100.0, sliding) > 0.0);
        }
        assert!(stretch(0.2, 4.0, 0.8, 20.0, 15.0, Sliding::TowardMotor).abs() < 1e-15);
    }

    #[test]
    fn without_friction_any_tension_above_the_pretension_reaches_the_whole_cable() {
        // Even the next number, whose logarithm is rounded to the same.
        let just_above = f64::from_bits(1e6_f64.to_bits() + 1);
        assert!(libm::log(just_above) - libm::log(1e6) == 0.0);
        for (tension, pretension, friction) in [(just_above, 1e6, 0.0), (30.0, 0.0, 0.8), (30.0, 0.0, 0.0)] {
            let length = transmission_length(tension, pretension, friction).unwrap();
            assert!(length == f64::INFINITY, "{tension} {pretension} {friction}: {length}");
        }
        assert!(transmission_length(20.0, 20.0, 0.0).unwrap() == 0.0);
    }
}
