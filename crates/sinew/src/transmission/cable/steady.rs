//! The stationary solution of a cable that slides at constant speed.

use super::dispatch::LANES;
use super::elementary::{at_least, tanh_series};
use super::lane_group::{LaneGroup, Row};
use super::law::CableLaw;
use crate::dispatch::{Arithmetic, Work};
use crate::error::{Error, finite, non_negative};

/// Tension and stretch of a steadily sliding cable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SteadySliding {
    /// Tension at the drive's outlet, N.
    pub tension_in: f64,
    /// Elongation, m.
    pub stretch: f64,
}

/// Fixed-point iterations per node: its drag depends on the tension behind it and that tension on the drag.
/// Starting from the ratio at the node before, two suffice.
const FIXED_POINT_ITERATIONS: usize = 2;

impl CableLaw {
    /// Near tension and stretch of a cable that slides at `velocity`, m/s, + toward the motor, with this
    /// tension at the anchor, N, and the drag of the law times `drag_factor`.
    ///
    /// ```text
    /// T_(i-1) = T_i (1 + tau_i)/(1 - tau_i),   tau_i = tanh( s h_i(v) + g_i v ),   s = sign v
    /// e = sum_j c_j T_j
    /// ```
    ///
    /// | symbol | argument      | unit | domain | meaning                                                      |
    /// |--------|---------------|------|--------|--------------------------------------------------------------|
    /// | T_out  | `tension_out` | N    | finite | `T_(M-1) + T_0`; below `T_0` it is taken as `T_0`               |
    /// | v      | `velocity`    | m/s  | finite | 0 counts as toward the motor: the edge of sliding that way      |
    /// |        | `drag_factor` | 1    | finite, >= 0 | on every `d_i`: grease that has warmed                    |
    ///
    /// # Assumes
    /// Velocity weakening is evaluated at this speed all along the cable.
    ///
    /// # Example
    /// ```
    /// use sinew::transmission::cable::{CableLaw, CableParameters, CablePath};
    /// let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12)?;
    /// let [pulled, yielded] = [0.06, -0.06].map(|v| law.steady(100.0, v, 1.0));
    /// assert!(pulled?.tension_in > 240.0 && yielded?.tension_in < 30.0);
    /// # Ok::<(), sinew::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where an argument is not finite.
    ///
    /// # Source
    /// Balance of [`cable`](super) at every node.
    pub fn steady(&self, tension_out: f64, velocity: f64, drag_factor: f64) -> Result<SteadySliding, Error> {
        self.sliding(tension_out, velocity, velocity, drag_factor)
    }

    /// The same with the velocity weakening evaluated at another speed, `slip` m/s: for a cable that slips
    /// faster than its mean velocity.
    ///
    /// # Errors
    /// As [`steady`](Self::steady).
    pub fn sliding(
        &self,
        tension_out: f64,
        velocity: f64,
        slip: f64,
        drag_factor: f64,
    ) -> Result<SteadySliding, Error> {
        let (tension_out, velocity) = (finite("tension_out", tension_out)?, finite("velocity", velocity)?);
        let slip = finite("slip", slip)?.abs();
        let drag_factor = non_negative("drag_factor", drag_factor)?;
        let weakened = self.weakened(slip);
        Ok(self.profile(tension_out, drag_factor, |_| (velocity, weakened), |_, _| ()))
    }

    /// Factor on the friction that weakens, at this speed, m/s.
    pub(crate) fn weakened(&self, slip: f64) -> f64 {
        self.weakening.map_or(1.0, |weakening| weakening.factor(slip))
    }

    /// The same with a velocity and a factor on the friction that weakens at every node, from finite numbers;
    /// `beyond` receives the stretch between each node and the anchor, m.
    pub(crate) fn profile(
        &self,
        tension_out: f64,
        drag_factor: f64,
        node: impl Fn(usize) -> (f64, f64),
        mut beyond: impl FnMut(usize, f64),
    ) -> SteadySliding {
        let mut tension = (tension_out - self.pretension).max(0.0);
        let mut cells = self.compliance.iter().rev();
        let mut stretch = cells.next().map_or(0.0, |c| c * tension);
        let mut ratio = 1.0;
        for ((i, law), compliance) in self.nodes.iter().enumerate().rev().zip(cells) {
            beyond(i, stretch);
            let (velocity, weakened) = node(i);
            let s = if velocity < 0.0 { -1.0 } else { 1.0 };
            let half = s * (weakened * law.friction + law.loss) + law.viscous * velocity;
            let drag = law.drag * (drag_factor * velocity);
            tension = before(tension, &mut ratio, half, drag, 2.0 * self.drag_fade);
            stretch += compliance * tension;
        }
        SteadySliding { tension_in: tension, stretch }
    }
}

/// `T_(i-1)` from `T_i`, the ratio of the node behind, which becomes that of this one, `s h_i + g_i v`,
/// `d_i v` and `2 T_d`.
#[inline(always)]
fn before(tension: f64, ratio: &mut f64, half: f64, drag: f64, fade: f64) -> f64 {
    let mut ahead = tension * *ratio;
    for _ in 0..FIXED_POINT_ITERATIONS {
        let tau = tanh_series(half + drag / (tension + ahead + fade));
        *ratio = (1.0 + tau) / (1.0 - tau);
        ahead = tension * *ratio;
    }
    ahead
}

/// Steady sliding of one cable in both directions.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BothDirections {
    /// Tension at the anchor, N.
    pub(crate) tension_out: f64,
    /// Speed toward the motor and away from it, m/s: not below and not above zero.
    pub(crate) velocity: [f64; 2],
    /// Speed at which the velocity weakening is evaluated, m/s.
    pub(crate) slip: f64,
    /// Drag as a multiple of the law's.
    pub(crate) drag_factor: f64,
}

impl BothDirections {
    fn check(&self) -> Result<(), Error> {
        finite("tension_out", self.tension_out)?;
        self.velocity.into_iter().try_for_each(|velocity| finite("velocity", velocity).map(|_| ()))?;
        finite("slip", self.slip)?;
        non_negative("drag_factor", self.drag_factor).map(|_| ())
    }
}

/// [`CableLaw::sliding`] in both directions for the lanes of a group.
pub(super) struct SteadyLanes<'a> {
    pub(super) lanes: &'a LaneGroup<LANES>,
    pub(super) sliding: &'a [BothDirections],
    pub(super) stretch: &'a mut [[f64; 2]],
}

impl SteadyLanes<'_> {
    /// # Errors
    /// As [`CableLaw::sliding`].
    pub(super) fn check(&self) -> Result<(), Error> {
        self.sliding.iter().try_for_each(BothDirections::check)
    }
}

impl Work for SteadyLanes<'_> {
    #[inline(always)]
    fn run<A: Arithmetic>(self, _: A) {
        let Self { lanes, sliding, stretch } = self;
        let zero = [Row::<LANES>::ZERO; 2];
        let (mut tension, mut velocity, mut drag_speed, mut sum) = (zero, zero, zero, zero);
        let (mut ratio, mut weakened) = ([Row([1.0; LANES]); 2], Row([1.0; LANES]));
        for (k, (one, law)) in sliding.iter().zip(&lanes.laws).enumerate() {
            weakened.0[k] = law.weakening.map_or(1.0, |weakening| weakening.factor(one.slip.abs()));
            for d in 0..2 {
                tension[d].0[k] = at_least(one.tension_out - law.pretension, 0.0);
                velocity[d].0[k] = one.velocity[d];
                drag_speed[d].0[k] = one.drag_factor * one.velocity[d];
            }
        }
        let last = lanes.nodes.len();
        for d in 0..2 {
            for k in 0..LANES {
                sum[d].0[k] = lanes.compliance[last].0[k] * tension[d].0[k];
            }
        }
        for (i, (node, compliance)) in lanes.nodes.iter().zip(&lanes.compliance).enumerate().rev() {
            let mut half_angle = node.half_angle;
            if let Some(memory) = lanes.memory.get(i) {
                for k in 0..LANES {
                    half_angle.0[k] = weakened.0[k] * memory.friction.0[k] + memory.loss.0[k];
                }
            }
            for (d, s) in [1.0, -1.0].into_iter().enumerate() {
                for k in 0..LANES {
                    let half = s * half_angle.0[k] + node.viscous.0[k] * velocity[d].0[k];
                    let drag = node.drag.0[k] * drag_speed[d].0[k];
                    tension[d].0[k] =
                        before(tension[d].0[k], &mut ratio[d].0[k], half, drag, lanes.fade.0[k]);
                    sum[d].0[k] += compliance.0[k] * tension[d].0[k];
                }
            }
        }
        for (k, stretch) in stretch.iter_mut().enumerate() {
            *stretch = [sum[0].0[k], sum[1].0[k]];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::BothDirections;
    use crate::transmission::cable::{
        Cable, CableBatch, CableLaw, CableParameters, CablePath, EndMotion, Weakening,
    };
    use alloc::vec::Vec;

    #[test]
    fn long_sliding_converges_to_the_steady_solution() {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
        for velocity in [0.12, 0.02, -0.02, -0.12] {
            let mut cable = Cable::new(law.clone());
            cable.settle(100.0, crate::transmission::Sliding::TowardMotor).unwrap();
            let mut ends = cable.ends();
            for _ in 0..20_000 {
                // The winch at the far end regulates 100 N.
                let yielding = velocity + 0.02 * (ends.tension_out - 100.0) / 100.0;
                ends =
                    cable.step(1e-3, EndMotion { motor: 1e-3 * velocity, anchor: 1e-3 * yielding }).unwrap();
            }
            let steady = law.steady(ends.tension_out, velocity, 1.0).unwrap();
            assert!((ends.tension_out - 100.0).abs() < 0.1, "{velocity} {ends:?}");
            assert!(
                (steady.tension_in / ends.tension_in - 1.0).abs() < 1e-3,
                "{velocity} {steady:?} {ends:?}"
            );
            assert!((steady.stretch - cable.stretch()).abs() < 1e-5, "{velocity}");
        }
    }

    #[test]
    fn below_the_pretension_the_drive_tension_is_zero() {
        let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
        let steady = law.steady(3.0, 0.1, 1.0).unwrap();
        assert!(steady.tension_in == 0.0 && steady.stretch == 0.0);
        assert!(law.steady(f64::NAN, 0.1, 1.0).is_err() && law.steady(3.0, 0.1, -1.0).is_err());
    }

    #[test]
    fn every_node_is_in_balance_at_its_own_speed_direction_and_drag() {
        let parameters = CableParameters { viscous: 0.2, ..CableParameters::bench() };
        let law = CableLaw::new(&CablePath::bench(), &parameters, 12).unwrap();
        // What two iterations of the drag at every node leave.
        for (velocity, tolerance) in [(0.12, 1.2e-5), (0.03, 1e-6), (0.0, 2e-9), (-0.03, 4e-6), (-0.12, 4e-5)]
        {
            let steady = law.steady(60.0, velocity, 1.3).unwrap();
            // At rest the cable is at the edge of sliding toward the motor.
            let s = if velocity < 0.0 { -1.0 } else { 1.0 };
            let mut tension = 60.0 - parameters.pretension;
            let mut stretch = law.compliance[11] * tension;
            for (node, compliance) in law.nodes.iter().zip(&law.compliance).rev() {
                let (behind, mut ahead) = (tension, tension);
                for _ in 0..100 {
                    let drag = 1.3 * node.drag * velocity / (behind + ahead + 2.0 * parameters.drag_fade);
                    let half = s * (node.friction + node.loss) + node.viscous * velocity + drag;
                    ahead = behind * libm::exp(2.0 * half);
                }
                tension = ahead;
                stretch += compliance * tension;
            }
            let off =
                f64::max((steady.tension_in / tension - 1.0).abs(), (steady.stretch / stretch - 1.0).abs());
            assert!(off < tolerance, "{velocity} {off:e}");
        }
    }

    #[test]
    fn in_lanes_cables_slide_to_the_bit_as_each_alone() {
        for weakening in [None, Some(Weakening::rational(0.4, 4e-3, 0.04))] {
            let law = |k: i32| {
                let friction = 0.1 + 0.01 * f64::from(k);
                // Friction weakens in every other cable.
                let weakening = weakening.filter(|_| k % 2 == 0);
                let parameters =
                    CableParameters { friction, viscous: 0.02, weakening, ..CableParameters::bench() };
                CableLaw::new(&CablePath::bench(), &parameters, 9).unwrap()
            };
            let laws: Vec<_> = (0..11).map(law).collect();
            let conditions = |k: i32| BothDirections {
                tension_out: 10.0 + 9.0 * f64::from(k),
                velocity: [0.01 * f64::from(k), -0.02 * f64::from(k) - 1e-9],
                slip: 3e-3 * f64::from(k - 5),
                drag_factor: 0.5 + 0.1 * f64::from(k),
            };
            let sliding: Vec<_> = (0..11).map(conditions).collect();
            let mut stretch = [[0.0; 2]; 11];
            let batch = CableBatch::new(&laws).unwrap();
            batch.stretch_in_both_directions(&sliding, &mut stretch).unwrap();
            for ((law, one), stretch) in laws.iter().zip(&sliding).zip(stretch) {
                let alone = one.velocity.map(|velocity| {
                    law.sliding(one.tension_out, velocity, one.slip, one.drag_factor).unwrap().stretch
                });
                assert_eq!(alone.map(f64::to_bits), stretch.map(f64::to_bits), "{one:?}");
            }
            assert!(stretch[10][0] > stretch[10][1] && stretch[10][1] > stretch[0][1]);
            let wrong = BothDirections { slip: f64::NAN, ..sliding[0] };
            assert!(batch.stretch_in_both_directions(&[wrong; 11], &mut stretch).is_err());
        }
    }
}
