//! Effects of the plant's cable that the identified models lack or know only in part; each can be left out.

use crate::Error;
use crate::error::{non_negative, positive, within};
use crate::transmission::cable::Weakening;
use alloc::vec;
use alloc::vec::Vec;

/// Curvature that varies along the sheath.
///
/// Equal parts of every sheath have these relative curvatures. The total bend is unchanged, so that steady
/// sliding is not affected; reversals are, because the slip front passes the bends in another order.
///
/// Default: six parts between 0.5 and 1.5; assumed for a sheath routed by hand along a limb.
#[derive(Debug, Clone, PartialEq)]
pub struct UnevenCurvature {
    /// Relative curvature of equal parts, each >= 0, not all zero.
    pub parts: Vec<f64>,
}

impl Default for UnevenCurvature {
    fn default() -> Self {
        Self { parts: vec![1.4, 0.7, 1.2, 0.5, 1.5, 0.7] }
    }
}

/// The wall of the sheath is compressed by the tension of the cable, and shortens.
///
/// The compliance is larger inside sheaths; a model with one compliance for the whole cable cannot represent
/// this.
///
/// Default: a tenth of the calibrated cable's 2.56e-4 1/N. Assumed: a wire-wound wall of some 40 kN per unit
/// strain; the tables of `yuan2023` do not distinguish it from the cable's own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SheathCompliance {
    /// Strain per tension, 1/N, >= 0.
    pub compliance: f64,
}

impl Default for SheathCompliance {
    fn default() -> Self {
        Self { compliance: 2.56e-5 }
    }
}

/// Friction warms the sheath, which lowers the viscosity of the grease.
///
/// ```text
/// C dT/dt = P - T/R,    drag = d exp(-k T)          T above the surroundings, P the power of friction
/// ```
///
/// Default: `k` = 4 %/K (greases lose half of their viscosity in 15 to 20 K), `R` = 0.5 K/W and `C` = 80 J/K
/// (0.8 m of steel-wound sheath, 150 g, in still air): a time constant of 40 s; 10 W of friction warm it by 5
/// K and lower the drag by 18 %. Assumed; not measured on this bench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DragHeat {
    /// `k`, 1/K, >= 0.
    pub softening: f64,
    /// `R`, K/W, >= 0.
    pub resistance: f64,
    /// `C`, J/K, > 0.
    pub capacity: f64,
}

impl Default for DragHeat {
    fn default() -> Self {
        Self { softening: 0.04, resistance: 0.5, capacity: 80.0 }
    }
}

/// Recoverable creep of a braid: a Kelvin-Voigt element in every cell.
///
/// ```text
/// dx_j/dt = (kappa c_j T_j - x_j)/tau         x_j is added to the length of cell j
/// ```
///
/// Default: `kappa` = 4 % of the elastic stretch within `tau` = 30 s. Assumed: the recoverable part of the
/// creep of braided polyethylene is of this order at a tenth of its strength; the permanent part has been
/// removed by bedding in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BraidCreep {
    /// `kappa`, 1, >= 0.
    pub fraction: f64,
    /// `tau`, s, > 0.
    pub time: f64,
}

impl Default for BraidCreep {
    fn default() -> Self {
        Self { fraction: 0.04, time: 30.0 }
    }
}

/// Friction is higher at low speed: [`Weakening`], of a size that the tables do not exclude.
///
/// Default: a tenth more at rest, half of that at 3 mm/s, with a lag of 50 ms. At the lowest speed of the
/// tables of `yuan2023`, 0.02 m/s, 2 thousandths of friction are left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowFriction {
    /// How it falls with speed.
    pub weakening: Weakening,
}

impl Default for SlowFriction {
    fn default() -> Self {
        Self { weakening: Weakening::rational(0.1, 3e-3, 0.05) }
    }
}

/// The cable breaks above a tension and carries none from then on.
///
/// Default: above 800 N, the limit that the drive of `yuan2023` is built for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breakage {
    /// Tension at either end, N, > 0.
    pub tension: f64,
}

impl Default for Breakage {
    fn default() -> Self {
        Self { tension: 800.0 }
    }
}

/// The effects of one cable; each may be left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Effects {
    /// Uneven curvature.
    pub curvature: Option<UnevenCurvature>,
    /// Compliance of the sheath.
    pub sheath: Option<SheathCompliance>,
    /// Heating of the grease.
    pub heat: Option<DragHeat>,
    /// Creep.
    pub creep: Option<BraidCreep>,
    /// Friction at low speed.
    pub slow: Option<SlowFriction>,
    /// Breakage.
    pub breakage: Option<Breakage>,
}

impl Default for Effects {
    /// Every effect at its default size.
    fn default() -> Self {
        Self {
            curvature: Some(UnevenCurvature::default()),
            sheath: Some(SheathCompliance::default()),
            heat: Some(DragHeat::default()),
            creep: Some(BraidCreep::default()),
            slow: Some(SlowFriction::default()),
            breakage: Some(Breakage::default()),
        }
    }
}

impl Effects {
    /// The law alone, without breaking.
    #[must_use]
    pub fn none() -> Self {
        Self { curvature: None, sheath: None, heat: None, creep: None, slow: None, breakage: None }
    }

    /// Checks the numbers that the law does not check.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the number outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        if let Some(heat) = &self.heat {
            non_negative("heat.softening", heat.softening)?;
            non_negative("heat.resistance", heat.resistance)?;
            positive("heat.capacity", heat.capacity)?;
        }
        if let Some(creep) = &self.creep {
            let fraction = creep.fraction;
            within("creep.fraction", "a number in [0, 1]", fraction, (0.0..=1.0).contains(&fraction))?;
            let time = creep.time;
            within("creep.time", "a finite number >= 0.1 s", time, time.is_finite() && time >= 0.1)?;
        }
        if let Some(breakage) = &self.breakage {
            positive("breakage.tension", breakage.tension)?;
        }
        Ok(())
    }
}
