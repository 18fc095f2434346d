//! Input and output of a step, with the domains of the input.

use super::lane_group::{Ends, LaneGroup};
use super::law::CableLaw;
use crate::Error;
use crate::error::{finite, non_negative, within};

/// Displacements of both ends of a cable in one step, m, positive toward the motor; each at most 0.1 m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EndMotion {
    /// Of the winch's surface.
    pub motor: f64,
    /// Of the anchor.
    pub anchor: f64,
}

/// Tensions at the ends of a cable after a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EndTensions {
    /// At the drive's outlet, N, >= 0.
    pub tension_in: f64,
    /// At the anchor, N, >= `T_0`.
    pub tension_out: f64,
    /// Energy dissipated by friction in the step, J, >= -1e-12.
    pub dissipated: f64,
}

/// Longest step, s.
const LONGEST_STEP: f64 = 0.02;
/// Largest displacement of an end in one step, m.
pub(super) const LARGEST_MOTION: f64 = 0.1;

pub(super) fn check_interval(interval: f64) -> Result<(), Error> {
    let sane = (1e-7..=LONGEST_STEP).contains(&interval);
    within("interval", "a number of seconds in [1e-7, 0.02]", interval, sane)?;
    Ok(())
}

pub(super) fn check_motion(motion: &EndMotion) -> Result<(), Error> {
    for (name, slide) in
        [("motion of the motor's end", motion.motor), ("motion of the anchor", motion.anchor)]
    {
        within(name, "within +-0.1 m in one step", slide, slide.abs() <= LARGEST_MOTION)?;
    }
    Ok(())
}

impl<const N: usize> Ends<N> {
    pub(super) fn of(&self, k: usize, pretension: f64) -> EndTensions {
        EndTensions {
            tension_in: self.near.0[k],
            tension_out: self.far.0[k] + pretension,
            dissipated: self.dissipated.0[k],
        }
    }
}

impl<const N: usize> LaneGroup<N> {
    /// Tensions at the ends while nothing moves.
    pub(super) fn ends_at_rest(&self, k: usize) -> EndTensions {
        let last = self.tension.len() - 1;
        let tension_out = self.tension[last].0[k] + self.laws[k].pretension();
        EndTensions { tension_in: self.tension[0].0[k], tension_out, dissipated: 0.0 }
    }
}

pub(super) fn above_pretension(law: &CableLaw, tension_out: f64) -> Result<f64, Error> {
    let far = finite("tension_out", tension_out)? - law.pretension();
    non_negative("tension_out - pretension", far)
}
