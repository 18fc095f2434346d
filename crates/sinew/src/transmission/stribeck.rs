use super::Sliding;
use crate::error::{Error, finite, non_negative, positive, within};

/// Friction coefficient as a function of sliding speed, with a drag that does not depend on tension.
///
/// ```text
/// mu(v)  = mu_c + (mu_s - mu_c) exp(-(v/v_s)^2) + mu_v |v|
/// D(v)   = d v
/// T_out  = max(0, eta^s T_in exp(-s mu(v) phi) - D(v)) + T_0,    s = sign(v)
/// ```
///
/// | symbol | argument         | unit  | domain  | meaning                                     |
/// |--------|------------------|-------|---------|---------------------------------------------|
/// | mu_c   | `coulomb`        | 1     | >= 0    | coefficient once sliding is established      |
/// | mu_s   | `breakaway`      | 1     | >= mu_c | coefficient in the limit of zero speed       |
/// | v_s    | `stribeck_speed` | m/s   | > 0     | speed of the transition between the two      |
/// | mu_v   | `viscous`        | s/m   | >= 0    | growth with speed, proportional to tension   |
/// | d      | `drag`           | N s/m | >= 0    | grease drag over the sheath, whatever the tension |
/// | v      | `velocity`       | m/s   | finite  | cable velocity, + toward the motor           |
///
/// # Assumes
/// Quasi-static; one speed along the whole sheath. A cable cannot push: drag ends where tension does.
///
/// # Departs
/// Printed (5) is `mu = delta(v)`, but delta is already a sign; the text beside it calls mu a viscosity.
/// The drag `d` is an addition: it explains the speed dependence of the published tables better
/// (7.4 % rms) than `mu_v` does (8.8 %).
///
/// # Example
/// ```
/// use sinew::transmission::Stribeck;
/// let friction = Stribeck::new(0.15, 0.2, 3e-3, 0.0, 95.0)?;
/// assert_eq!(friction.coefficient(0.0)?, 0.2);
/// assert!((friction.coefficient(1.0)? - 0.15).abs() < 1e-15);
/// assert_eq!(friction.drag_force(0.1)?, 9.5);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `yuan2023`, eq. 5, read according to its text; `stribeck1902`; drag: own fit to the tables of `yuan2023`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stribeck {
    coulomb: f64,
    breakaway: f64,
    stribeck_speed: f64,
    viscous: f64,
    drag: f64,
}

impl Stribeck {
    /// A friction law of checked parameters.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the parameter outside its domain.
    pub fn new(
        coulomb: f64,
        breakaway: f64,
        stribeck_speed: f64,
        viscous: f64,
        drag: f64,
    ) -> Result<Self, Error> {
        non_negative("coulomb", coulomb)?;
        within(
            "breakaway",
            "a finite number >= coulomb",
            breakaway,
            breakaway.is_finite() && breakaway >= coulomb,
        )?;
        positive("stribeck_speed", stribeck_speed)?;
        non_negative("viscous", viscous)?;
        non_negative("drag", drag)?;
        Ok(Self { coulomb, breakaway, stribeck_speed, viscous, drag })
    }

    /// A constant coefficient without drag: plain Coulomb friction.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where `coulomb` is negative or not finite.
    pub fn coulomb(coulomb: f64) -> Result<Self, Error> {
        Self::new(coulomb, coulomb, 1.0, 0.0, 0.0)
    }

    /// `mu(v)`, even in the velocity.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the velocity or the result is not finite.
    pub fn coefficient(&self, velocity: f64) -> Result<f64, Error> {
        finite("velocity", velocity)?;
        finite("mu(velocity)", self.coefficient_unchecked(velocity.abs()))
    }

    /// `D(v)`, N, odd in the velocity.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where the velocity or the result is not finite.
    pub fn drag_force(&self, velocity: f64) -> Result<f64, Error> {
        finite("velocity", velocity)?;
        finite("drag", self.drag * velocity)
    }

    /// Tension at the anchor, N, of a sheath of the given efficiency and pretension.
    ///
    /// `efficiency` in (0, 1], `wrap_angle` >= 0 rad, `pretension` >= 0 N as in
    /// [`SheathLaw`](super::SheathLaw).
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] for an argument outside its domain, or a velocity of exactly zero,
    /// at which a law without memory is not defined.
    pub fn tension_out(
        &self,
        tension_in: f64,
        velocity: f64,
        wrap_angle: f64,
        efficiency: f64,
        pretension: f64,
    ) -> Result<f64, Error> {
        let Some(sliding) = Sliding::from_velocity(velocity) else {
            return Err(Error::OutOfDomain {
                name: "velocity",
                expected: "a number other than zero",
                got: velocity,
            });
        };
        let sheath = super::SheathLaw::new(efficiency, self.coefficient(velocity)?, 0.0)?;
        let sliding_only = sheath.tension_out(tension_in, wrap_angle, sliding)?;
        let dragged = (sliding_only - self.drag_force(velocity)?).max(0.0);
        finite("tension_out", dragged + non_negative("pretension", pretension)?)
    }

    /// `D` of a velocity already known to be finite.
    pub(super) fn drag_unchecked(&self, velocity: f64) -> f64 {
        self.drag * velocity
    }

    /// `mu` of a speed already known to be finite and >= 0; used at every step of the laws with memory.
    pub(super) fn coefficient_unchecked(&self, speed: f64) -> f64 {
        let ratio = speed / self.stribeck_speed;
        self.coulomb + (self.breakaway - self.coulomb) * libm::exp(-ratio * ratio) + self.viscous * speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_and_drag_always_oppose_the_motion() {
        let law = Stribeck::new(0.1, 0.3, 0.01, 0.5, 40.0).unwrap();
        for i in 1..=200 {
            let speed = f64::from(i) * 1e-3;
            let there = law.tension_out(50.0, speed, 3.0, 0.9, 0.0).unwrap();
            let back = law.tension_out(50.0, -speed, 3.0, 0.9, 0.0).unwrap();
            assert!(there < 50.0 && back > 50.0 && there >= 0.0);
        }
    }

    #[test]
    fn without_speed_terms_it_is_the_plain_sheath() {
        let law = Stribeck::coulomb(0.2).unwrap();
        let sheath = super::super::SheathLaw::new(0.9, 0.2, 12.0).unwrap();
        for velocity in [-0.3, -1e-9, 1e-9, 0.3] {
            let sliding = Sliding::from_velocity(velocity).unwrap();
            let difference = law.tension_out(70.0, velocity, 2.0, 0.9, 12.0).unwrap()
                - sheath.tension_out(70.0, 2.0, sliding).unwrap();
            assert!(difference.abs() < 1e-12);
        }
        assert!(law.tension_out(70.0, 0.0, 2.0, 0.9, 12.0).is_err());
    }

    #[test]
    fn a_breakaway_below_coulomb_is_refused() {
        assert!(Stribeck::new(0.2, 0.1, 0.01, 0.0, 0.0).is_err());
        assert!(Stribeck::new(0.2, 0.2, 0.0, 0.0, 0.0).is_err());
    }

    #[test]
    fn at_the_stribeck_speed_a_share_of_one_over_e_is_left_of_the_rise() {
        let law = Stribeck::new(0.1, 0.3, 0.01, 0.5, 40.0).unwrap();
        for (velocity, left) in [(0.0, 1.0), (0.01, libm::exp(-1.0)), (-0.02, libm::exp(-4.0))] {
            let exact = 0.1 + 0.2 * left + 0.5 * f64::abs(velocity);
            assert!((law.coefficient(velocity).unwrap() - exact).abs() < 1e-16, "{velocity}");
        }
    }
}
