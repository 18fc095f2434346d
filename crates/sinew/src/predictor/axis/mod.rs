//! A moving mass between the two sides: the force that a motion takes, or the motion that a force makes.
//!
//! Both laws are those of an axis with inertia, viscous and dry friction and a spring. Which one a model
//! holds follows from what it reads: [`AxisForce`] from motions, [`AxisMotion`] from forces.

mod differentiator;
mod force;
mod motion;
mod output;

pub use differentiator::Differentiator;
pub use force::{AxisForce, AxisSlip};
pub use motion::AxisMotion;

use super::model_file_error::ModelFileError;
use force::ForceState;
use motion::MotionState;
pub(super) use output::AxisOutput;
use serde::{Deserialize, Serialize};

/// The law of an axis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Axis {
    /// The far side is a force, the near side moves.
    Force(AxisForce),
    /// The far side moves, the near side is a force.
    Motion(AxisMotion),
}

impl Axis {
    /// The same axis with `gain y + offset` in place of its output `y`.
    #[must_use]
    pub fn rescaled(&self, gain: f64, offset: f64) -> Self {
        match self {
            Self::Force(law) => Self::Force(law.rescaled(gain, offset)),
            Self::Motion(law) => Self::Motion(law.rescaled(gain, offset)),
        }
    }

    pub(super) fn validate(&self, signals: usize) -> Result<(), ModelFileError> {
        match self {
            Self::Force(law) => law.validate(signals),
            Self::Motion(law) => law.validate(signals),
        }
    }
}

/// The state of an [`Axis`] along one sequence; no allocation after construction.
#[derive(Debug, Clone, Default)]
pub(super) struct AxisState {
    force: ForceState,
    motion: MotionState,
}

impl AxisState {
    /// Advances by one sample, `dt_s` after the one before; the first one starts the state, at the far side
    /// where that is measured.
    #[inline]
    pub(super) fn step(
        &mut self,
        law: &Axis,
        started: bool,
        dt_s: f64,
        signals: &[f64],
        far: Option<f64>,
    ) -> AxisOutput {
        match (law, started) {
            (Axis::Force(law), false) => self.force.start(law, signals),
            (Axis::Force(law), true) => self.force.step(law, dt_s, signals),
            (Axis::Motion(law), false) => self.motion.start(law, signals, far),
            (Axis::Motion(law), true) => self.motion.step(law, dt_s, signals),
        }
    }
}
