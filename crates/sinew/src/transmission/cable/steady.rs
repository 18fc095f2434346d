//! The stationary solution of a cable that slides at constant speed.

use super::elementary::tanh_series;
use super::law::CableLaw;
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
        let drag_speed = non_negative("drag_factor", drag_factor)? * velocity;
        let s = if velocity < 0.0 { -1.0 } else { 1.0 };
        let weakened = self.weakening.map_or(1.0, |weakening| weakening.factor(slip));
        let mut tension = (tension_out - self.pretension).max(0.0);
        let mut cells = self.compliance.iter().rev();
        let mut stretch = cells.next().map_or(0.0, |c| c * tension);
        let mut ratio = 1.0;
        for (node, compliance) in self.nodes.iter().rev().zip(cells) {
            let half = s * (weakened * node.friction + node.loss) + node.viscous * velocity;
            let mut ahead = tension * ratio;
            for _ in 0..FIXED_POINT_ITERATIONS {
                let both = tension + ahead;
                let tau = tanh_series(half + node.drag * drag_speed / (both + 2.0 * self.drag_fade));
                ratio = (1.0 + tau) / (1.0 - tau);
                ahead = tension * ratio;
            }
            tension = ahead;
            stretch += compliance * tension;
        }
        Ok(SteadySliding { tension_in: tension, stretch })
    }
}

#[cfg(test)]
mod tests {
    use crate::transmission::cable::{Cable, CableLaw, CableParameters, CablePath, EndMotion};

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
}
