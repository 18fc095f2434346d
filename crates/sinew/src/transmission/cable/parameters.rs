//! Parameters of friction and elasticity of a cable.

use crate::error::{Error, non_negative, positive, within};
use serde::{Deserialize, Serialize};

/// Velocity weakening of friction (Stribeck effect), with a lag that keeps the problem well posed.
///
/// ```text
/// mu(z) = mu (1 + beta/(1 + (z/v_s)^2)),      dz = dt/(tau + dt) (|v| - z)      at every node
/// ```
///
/// | symbol | field   | unit | domain | meaning                                           |
/// |--------|---------|------|--------|---------------------------------------------------|
/// | beta   | `rise`  | 1    | >= 0   | breakaway friction is `1 + beta` times sliding friction |
/// | v_s    | `speed` | m/s  | > 0    | speed at which half of the rise remains            |
/// | tau    | `lag`   | s    | >= 0.005 | time constant of the speed estimate of a node    |
///
/// # Assumes
/// Without the lag the law is ill posed along a cable: the smaller the step, the larger the jitter.
///
/// # Source
/// `stribeck1902`; the rational form and the lag are ours. The tables of `yuan2023`, at 0.02 m/s and above,
/// show no such rise and do not identify its size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Weakening {
    /// `beta`, 1.
    pub rise: f64,
    /// `v_s`, m/s.
    #[serde(rename = "speed_m_per_s")]
    pub speed: f64,
    /// `tau`, s.
    #[serde(rename = "lag_s")]
    pub lag: f64,
}

impl Weakening {
    /// The factor on the friction coefficient at a lagged speed `z >= 0`, m/s.
    #[inline]
    #[must_use]
    pub fn factor(&self, speed: f64) -> f64 {
        let ratio = speed / self.speed;
        1.0 + self.rise / (1.0 + ratio * ratio)
    }
}

/// Friction, drag and elasticity of a cable on its [`CablePath`](super::CablePath).
///
/// | symbol | field               | unit  | domain | meaning                                              |
/// |--------|---------------------|-------|--------|------------------------------------------------------|
/// | mu     | `friction`          | 1     | >= 0   | coefficient of sliding                                |
/// | mu_v   | `viscous`           | s/m   | >= 0   | growth of it with speed                               |
/// | eta    | `efficiency`        | 1     | (0, 1] | share of tension left by losses independent of the bend, at the first node |
/// | d      | `drag`              | N s/m | >= 0   | grease drag over all sheaths, whatever the tension     |
/// | T_d    | `drag_fade`         | N     | > 0    | the drag fades below about this tension, which keeps tension >= 0   |
/// | T_0    | `pretension`        | N     | >= 0   | constant force in parallel at the anchor              |
/// | rho    | `compliance`        | 1/N   | > 0    | strain per tension, `1/(E A)`                          |
/// | rho_s  | `sheath_compliance` | 1/N   | >= 0   | shortening of the sheath's wall per tension, added inside sheaths |
///
/// # Source
/// [`bench`](Self::bench) for the values; equations in [`cable`](super).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CableParameters {
    /// `mu`, 1.
    pub friction: f64,
    /// `mu_v`, s/m.
    #[serde(rename = "viscous_s_per_m")]
    pub viscous: f64,
    /// `eta`, 1.
    pub efficiency: f64,
    /// `d`, N s/m.
    #[serde(rename = "drag_n_s_per_m")]
    pub drag: f64,
    /// `T_d`, N.
    #[serde(rename = "drag_fade_n")]
    pub drag_fade: f64,
    /// `T_0`, N.
    #[serde(rename = "pretension_n")]
    pub pretension: f64,
    /// `rho`, 1/N.
    #[serde(rename = "compliance_per_n")]
    pub compliance: f64,
    /// `rho_s`, 1/N; zero for a rigid sheath.
    #[serde(rename = "sheath_compliance_per_n")]
    pub sheath_compliance: f64,
    /// Velocity weakening; none by default.
    pub weakening: Option<Weakening>,
}

impl CableParameters {
    /// The cable of the bench of `yuan2023`, fitted to its Tables II and III (24 means, 7.4 % rms).
    ///
    /// | value                | uncertainty                                                           |
    /// |----------------------|----------------------------------------------------------------------|
    /// | mu = 0.156           | +- 0.006; only `mu phi - ln eta` = 1.054 is identified                 |
    /// | eta = 0.928          | a choice, see above                                                   |
    /// | mu_v = 0             | with drag present the fit gains less than 0.3 % rms from it             |
    /// | d = 95 N s/m         | +- 21                                                                 |
    /// | T_d = 5 N            | a choice; 1 to 15 N fit equally well                                   |
    /// | T_0 = 15.5 N         | +- 1.8                                                                |
    /// | rho = 2.56e-4 1/N    | from the elongation of Table III: effective modulus 0.55 GPa           |
    /// | rho_s = 0, no weakening | not identified by the tables                                       |
    #[must_use]
    pub const fn bench() -> Self {
        Self {
            friction: 0.156,
            viscous: 0.0,
            efficiency: 0.928,
            drag: 95.0,
            drag_fade: 5.0,
            pretension: 15.5,
            compliance: 2.56e-4,
            sheath_compliance: 0.0,
            weakening: None,
        }
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the parameter outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        non_negative("friction", self.friction)?;
        non_negative("viscous", self.viscous)?;
        let efficient = self.efficiency > 0.0 && self.efficiency <= 1.0;
        within("efficiency", "a number in (0, 1]", self.efficiency, efficient)?;
        non_negative("drag", self.drag)?;
        positive("drag_fade", self.drag_fade)?;
        non_negative("pretension", self.pretension)?;
        positive("compliance", self.compliance)?;
        non_negative("sheath_compliance", self.sheath_compliance)?;
        if let Some(weakening) = &self.weakening {
            non_negative("weakening.rise", weakening.rise)?;
            positive("weakening.speed", weakening.speed)?;
            let lag = weakening.lag;
            within("weakening.lag", "a finite number >= 0.005 s", lag, lag.is_finite() && lag >= 0.005)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_is_highest_at_rest_and_half_of_the_rise_remains_at_the_given_speed() {
        let weakening = Weakening { rise: 0.6, speed: 4e-3, lag: 0.02 };
        for (speed, factor) in [(0.0, 1.6), (4e-3, 1.3), (8e-3, 1.12), (4.0, 1.0)] {
            assert!((weakening.factor(speed) - factor).abs() < 1e-6, "{speed}");
        }
    }
}
