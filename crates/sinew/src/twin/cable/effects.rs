//! What a real cable does that its model does not know: each effect by itself, each can be left out.

use crate::Error;
use crate::error::{non_negative, positive, within};
use crate::transmission::cable::Weakening;
use alloc::vec;
use alloc::vec::Vec;

/// A sheath that bends more here than there.
///
/// Equal parts of every sheath get these relative curvatures. The sum of the bend stays what it is, so steady
/// sliding does not show it; reversals do, because the slip front meets the bends in another order.
///
/// Default: six parts between 0.5 and 1.5. Assumed: a sheath laid by hand along a limb.
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

/// The wall of the sheath carries in compression what the cable carries in tension, and shortens.
///
/// Inside sheaths the compliance grows; a model with one compliance for the whole cable cannot follow.
///
/// Default: a tenth of the calibrated cable's 2.56e-4 1/N. Assumed: a wire-wound wall of some 40 kN per unit
/// strain; the tables of `yuan2023` do not tell it from the cable's own.
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

/// Friction warms the sheath, and warm grease drags less.
///
/// ```text
/// C dT/dt = P - T/R,    drag = d exp(-k T)          T above the surroundings, P the power of friction
/// ```
///
/// Default: `k` = 4 %/K (greases lose half of their viscosity in 15 to 20 K), `R` = 0.5 K/W and `C` = 80 J/K
/// (0.8 m of steel-wound sheath, 150 g, in still air): a time constant of 40 s; 10 W of friction warm it by 5 K and
/// take 18 % of the drag. Assumed: nobody has measured it on this bench.
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

/// A braid goes on stretching under load and comes back when it is gone: a Kelvin-Voigt element in every cell.
///
/// ```text
/// dx_j/dt = (kappa c_j T_j - x_j)/tau         x_j is added to the length of cell j
/// ```
///
/// Default: `kappa` = 4 % of the elastic stretch within `tau` = 30 s. Assumed: the recoverable part of the
/// creep of braided polyethylene is of this order at a tenth of its strength; the permanent part is bedded in.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BraidCreep {
    /// `kappa`, 1, >= 0.
    pub share: f64,
    /// `tau`, s, > 0.
    pub time: f64,
}

impl Default for BraidCreep {
    fn default() -> Self {
        Self { share: 0.04, time: 30.0 }
    }
}

/// Friction is higher at creeping speed: [`Weakening`], at a size the tables cannot exclude.
///
/// Default: a tenth more at rest, half of that gone at 3 mm/s, remembered for 50 ms. At the lowest speed of the
/// tables of `yuan2023`, 0.02 m/s, 2 thousandths of it are left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlowFriction {
    /// How it falls with speed.
    pub weakening: Weakening,
}

impl Default for SlowFriction {
    fn default() -> Self {
        Self { weakening: Weakening { rise: 0.1, speed: 3e-3, lag: 0.05 } }
    }
}

/// The cable breaks, says when, and has no tension from then on.
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

/// All effects together; each may be left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Effects {
    /// Uneven bend.
    pub curvature: Option<UnevenCurvature>,
    /// Soft wall.
    pub sheath: Option<SheathCompliance>,
    /// Warm grease.
    pub heat: Option<DragHeat>,
    /// Creep.
    pub creep: Option<BraidCreep>,
    /// Friction at creeping speed.
    pub slow: Option<SlowFriction>,
    /// Breaking.
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
    /// The bare law; it cannot even break.
    #[must_use]
    pub fn none() -> Self {
        Self { curvature: None, sheath: None, heat: None, creep: None, slow: None, breakage: None }
    }

    /// Checks what the law does not check itself.
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
            let share = creep.share;
            within("creep.share", "a number in [0, 1]", share, (0.0..=1.0).contains(&share))?;
            let time = creep.time;
            within("creep.time", "a finite number >= 0.1 s", time, time.is_finite() && time >= 0.1)?;
        }
        if let Some(breakage) = &self.breakage {
            positive("breakage.tension", breakage.tension)?;
        }
        Ok(())
    }
}
