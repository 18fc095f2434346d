//! Parameters of friction and elasticity of a cable.

use super::weakening::Weakening;
use crate::error::{Error, non_negative, positive, within};
use serde::{Deserialize, Serialize};

/// Friction, drag and elasticity of a cable on its [`CablePath`](super::CablePath).
///
/// | symbol | field               | unit  | domain | meaning                                              |
/// |--------|---------------------|-------|--------|------------------------------------------------------|
/// | mu     | `friction`          | 1     | >= 0   | coefficient of sliding                                |
/// | mu_v   | `viscous`           | s/m   | >= 0   | growth of it with speed                               |
/// | eta    | `efficiency`        | 1     | (0, 1] | fraction of tension left by losses independent of the bend, at the first node |
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
            weakening.validate()?;
        }
        Ok(())
    }
}
