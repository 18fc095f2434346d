//! Control of a cable by the true state of the plant, which no controller has: what a compensation can be
//! compared with.

use sinew::Error;
use sinew::control::stretch::{FarEndReference, StretchController};
use sinew::transmission::cable::CableLaw;

/// Time constant of the law's correction, s.
const CORRECTION_TIME: f64 = 0.3;

/// The plant's own law with its true stretch and drag, corrected by its true far tension.
///
/// ```text
/// e^ = e - b,   db/dt = (e - e*(T_out) - b)/t_b   while the whole cable slides
/// db/dt = -b/t_b after the next reversal, until the whole cable slides again
/// ```
///
/// The law alone lacks what the plant adds to it, creep and warming among others: its stretch of steady
/// sliding `e*` is then biased, and an identified law, whose parameters absorb a part of these effects, could
/// be better than it. The true far tension `T_out` shows the bias `b`; a bias that outlived the sliding would
/// disturb the next reversal.
#[derive(Debug, Clone)]
pub(super) struct Oracle {
    controller: StretchController,
    law: CableLaw,
    /// Constant error of the stretch, m.
    bias: f64,
    /// Direction in which the whole cable slid last.
    direction: f64,
}

/// What the plant is in.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrueState {
    /// Stretch of the cable, m.
    pub(super) stretch: f64,
    /// Tension at the anchor, N.
    pub(super) tension_out: f64,
    /// As a multiple of the law's.
    pub(super) drag_factor: f64,
    /// Whether the whole cable slides.
    pub(super) sliding: bool,
}

impl Oracle {
    pub(super) fn new(law: CableLaw) -> Self {
        Self { controller: StretchController::new(law.clone()), law, bias: 0.0, direction: 0.0 }
    }

    /// Speed of the winch, m/s, for the `interval` seconds to come.
    pub(super) fn winch_speed(
        &mut self,
        interval: f64,
        reference: &FarEndReference,
        state: TrueState,
    ) -> Result<f64, Error> {
        let target = if state.sliding {
            self.direction = reference.velocity.signum();
            let steady = self.law.steady(state.tension_out, reference.velocity, state.drag_factor)?;
            state.stretch - steady.stretch
        } else if reference.velocity * self.direction > 0.0 {
            self.bias
        } else {
            0.0
        };
        self.bias += interval / CORRECTION_TIME * (target - self.bias);
        let stretch = state.stretch - self.bias;
        self.controller.winch_speed(interval, reference, stretch, state.drag_factor)
    }
}
