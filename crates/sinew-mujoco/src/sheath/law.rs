//! The law of one sheath on a tendon.

use crate::text::number;
use sinew::transmission::SheathLaw;
use sinew::transmission::cable::WeakeningForm;

/// Largest friction angle: at 20 the ratio of the tensions is 5e8, and the far end is locked.
const LARGEST_ANGLE: f64 = 20.0;

/// A sheath between an actuator and its tendon.
///
/// ```text
/// theta = min(20, mu (phi + g psi) (1 + beta/(1 + (v/v_s)^2)) - ln eta)
/// T_out = T e^(-s theta) + T_0 = T cosh theta - s T sinh theta + T_0,      s in [-1, 1], +-1 while it slides
/// ```
///
/// | symbol | field        | unit | domain | meaning                                                       |
/// |--------|--------------|------|--------|---------------------------------------------------------------|
/// | T      |              | N    | any    | sum of the actuators' pulls on the tendon; at or below 0 no friction acts |
/// | mu     | `friction`   | 1    | >= 0   | coefficient of sliding                                         |
/// | phi    | `bend`       | rad  | >= 0   | bend of the sheath, independent of the pose                    |
/// | g      | `turning`    | 1    | >= 0   | fraction of psi that is counted; psi, rad, is the sum of the angles of the tendon's path |
/// | eta    | `efficiency` | 1    | (0, 1] | fraction of the tension left by losses that do not depend on the bend |
/// | T_0    | `pretension` | N    | >= 0   | constant force in parallel                                     |
/// | beta   | `rise`       | 1    | >= 0   | friction at rest is `1 + beta` times that of fast sliding        |
/// | v_s    | `speed`      | m/s  | > 0    | speed at which half of the rise remains                         |
///
/// # Assumes
/// An inextensible cable with one speed along its length. `T cosh theta` is the actuators' force;
/// `s T sinh theta` is a friction constraint of the tendon, for which MuJoCo's constraint solver finds `s`.
///
/// # Source
/// As [`SheathLaw`]; the rational weakening as
/// [`Weakening`](sinew::transmission::cable::Weakening), without its lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sheath {
    friction: f64,
    bend: f64,
    pub(crate) turning: f64,
    loss: f64,
    pub(crate) pretension: f64,
    rise: f64,
    inverse_speed: f64,
}

const KEYS: [&str; 7] = ["mu", "bend", "turning", "efficiency", "pretension", "rise", "speed"];

impl Sheath {
    /// From the pairs of an entry.
    pub(crate) fn read(pairs: &[(&str, &str)]) -> Result<Self, String> {
        let mut values = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.01];
        let mut seen = [false; KEYS.len()];
        for (key, text) in pairs {
            let at = KEYS.iter().position(|known| known == key);
            let at = at.ok_or_else(|| format!("unknown key {key}, expected one of {}", KEYS.join(", ")))?;
            if std::mem::replace(&mut seen[at], true) {
                return Err(format!("{key} is given twice"));
            }
            values[at] = number(key, text)?;
        }
        let [friction, bend, turning, efficiency, pretension, rise, speed] = values;
        SheathLaw::new(efficiency, friction, pretension).map_err(|error| error.to_string())?;
        for (key, value) in [("bend", bend), ("turning", turning), ("rise", rise)] {
            if value < 0.0 {
                return Err(format!("{key} must be a finite number >= 0, but is {value}"));
            }
        }
        if speed <= 0.0 {
            return Err(format!("speed must be a finite number > 0, but is {speed}"));
        }
        let loss = -efficiency.ln();
        let law = Self { friction, bend, turning, loss, pretension, rise, inverse_speed: 1.0 / speed };
        let largest = friction * bend * (1.0 + rise) + loss;
        if largest > LARGEST_ANGLE {
            return Err(format!(
                "the friction angle mu bend (1 + rise) - ln efficiency is {largest:.1}, expected at most \
                    {LARGEST_ANGLE}"
            ));
        }
        Ok(law)
    }

    /// `theta` for a turning of the path `psi`, rad, and a velocity of the tendon, m/s.
    pub(crate) fn angle(&self, psi: f64, velocity: f64) -> f64 {
        let ratio = velocity * self.inverse_speed;
        let weakening = WeakeningForm::Rational.factor(self.rise, ratio);
        let wrap = self.bend + self.turning * psi;
        (self.friction * wrap * weakening + self.loss).min(LARGEST_ANGLE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_but_friction_and_bend_is_there_by_default() {
        let sheath = Sheath::read(&[("mu", "0.2"), ("bend", "3")]).unwrap();
        assert!((sheath.angle(7.0, 0.0) - 0.6).abs() < 1e-15);
        assert!(sheath.pretension == 0.0 && sheath.turning == 0.0);
    }

    #[test]
    fn friction_halves_its_rise_at_the_speed_given() {
        let pairs = [("mu", "0.2"), ("bend", "3"), ("rise", "0.5"), ("speed", "0.02"), ("turning", "1")];
        let sheath = Sheath::read(&pairs).unwrap();
        assert!((sheath.angle(1.0, 0.0) - 0.2 * 4.0 * 1.5).abs() < 1e-15);
        assert!((sheath.angle(1.0, -0.02) - 0.2 * 4.0 * 1.25).abs() < 1e-15);
    }

    #[test]
    fn a_parameter_outside_of_its_domain_is_refused_by_name() {
        for (key, value) in [
            ("mu", "-0.1"),
            ("bend", "-1"),
            ("bend", "nan"),
            ("efficiency", "0"),
            ("efficiency", "1.1"),
            ("rise", "-1"),
            ("speed", "0"),
            ("turning", "-1"),
            ("pretension", "-1"),
            ("friction", "1"),
        ] {
            let error = Sheath::read(&[(key, value)]).unwrap_err();
            let name = if key == "mu" { "friction" } else { key };
            assert!(error.contains(name), "{error}");
        }
        assert!(Sheath::read(&[("mu", "10"), ("bend", "10")]).unwrap_err().contains("friction angle"));
        assert!(Sheath::read(&[("mu", "1"), ("mu", "1")]).unwrap_err().contains("twice"));
    }
}
