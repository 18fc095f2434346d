use super::Stribeck;
use crate::error::{Error, non_negative, positive};

/// LuGre friction under a varying load: elastic bristles with velocity weakening.
///
/// ```text
/// dz/dt = v - sigma_0 |v| z / g,   g = N mu(v)
/// F     = sigma_0 z + sigma_1' dz/dt + D(v),   sigma_1' = min(sigma_1, 4 g/|v|)
/// step:   z_1 = (z_0 + dx) / (1 + sigma_0 |dx| / g)                          (implicit Euler)
/// ```
///
/// | symbol  | argument    | unit  | domain | meaning                                       |
/// |---------|-------------|-------|--------|-----------------------------------------------|
/// | sigma_0 | `stiffness` | N/m   | > 0    | bristle stiffness, the same at every load      |
/// | sigma_1 | `damping`   | N s/m | >= 0   | bristle damping in the stick phase             |
/// | mu(v), D(v) | `friction` |    |        | steady-state curve and drag, [`Stribeck`]      |
/// | N       | `load`      | N     | >= 0   | what friction is proportional to: normal force, or tension times angle |
/// | dx      | `slide`     | m     | finite | displacement of this step, `v = dx/dt`         |
/// | dt      | `interval`  | s     | > 0    | length of this step                            |
/// | z       | `deflection`| m     | finite | state                                          |
///
/// # Assumes
/// Constant velocity within a step. Order 1 in `dt`, stable for every step size and every stiffness:
/// an explicit Runge-Kutta step is silently wrong here at 1 ms.
///
/// # Departs
/// The load scales `g` and not `z`: otherwise a change of load alone would create energy. `sigma_1` is
/// capped at `4 g/|v|`, below which the law, and this step of it, is passive:
/// `F dx >= sigma_0 (z_1^2 - z_0^2)/2` for any load, speed and interval. Steady sliding is unchanged.
///
/// # Example
/// ```
/// use sinew::transmission::{LuGre, Stribeck};
/// let curve = Stribeck::new(0.1, 0.15, 1e-3, 0.0, 2.0)?;
/// let law = LuGre::new(1e5, 300.0, curve)?;
/// let mut z = 0.0;
/// let mut force = 0.0;
/// for _ in 0..2000 {
///     let step = law.step(z, 2e-5, 50.0, 1e-3);
///     (z, force) = (step.deflection, step.force);
/// }
/// // Steady sliding at 0.02 m/s: the Stribeck curve.
/// assert!((force - (50.0 * curve.coefficient(0.02)? + curve.drag_force(0.02)?)).abs() < 1e-9);
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `canudas1995`; that its passivity is a matter of `sigma_1`: `barabanov2000`, the bound here is derived for
/// this step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LuGre {
    stiffness: f64,
    damping: f64,
    friction: Stribeck,
}

/// State and force after a step of [`LuGre`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LuGreStep {
    /// Bristle deflection to hand to the next step, m.
    pub deflection: f64,
    /// Friction force, N, positive where it opposes positive motion.
    pub force: f64,
}

impl LuGre {
    /// A law of checked parameters.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the parameter outside its domain.
    pub fn new(stiffness: f64, damping: f64, friction: Stribeck) -> Result<Self, Error> {
        positive("stiffness", stiffness)?;
        non_negative("damping", damping)?;
        Ok(Self { stiffness, damping, friction })
    }

    /// One step; arguments outside their domain leave the deflection and report its elastic force.
    #[inline]
    #[must_use]
    pub fn step(&self, deflection: f64, slide: f64, load: f64, interval: f64) -> LuGreStep {
        let held = LuGreStep { deflection, force: self.stiffness * deflection };
        let velocity = slide / interval;
        if !(interval > 0.0 && load >= 0.0 && velocity.is_finite()) {
            return held;
        }
        let grip = load * self.friction.coefficient_unchecked(velocity.abs());
        if !grip.is_finite() {
            return held;
        }
        let next =
            if grip > 0.0 { (deflection + slide) / (1.0 + self.stiffness * slide.abs() / grip) } else { 0.0 };
        let damping = self.damping.min(4.0 * grip / velocity.abs());
        let drag = self.friction.drag_unchecked(velocity);
        let force = self.stiffness * next + damping * (next - deflection) / interval + drag;
        if force.is_finite() { LuGreStep { deflection: next, force } } else { held }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve() -> Stribeck {
        Stribeck::new(0.1, 0.15, 2e-3, 0.3, 5.0).unwrap()
    }

    #[test]
    fn steady_sliding_is_the_stribeck_curve_at_every_load_and_step_size() {
        let law = LuGre::new(1e5, 300.0, curve()).unwrap();
        for load in [0.0, 3.0, 80.0] {
            for velocity in [-0.2, -2e-3, 1e-3, 0.05] {
                for interval in [1e-4, 1e-3, 0.1] {
                    let mut last = LuGreStep { deflection: 0.0, force: 0.0 };
                    for _ in 0..40_000 {
                        let next = law.step(last.deflection, velocity * interval, load, interval);
                        let settled = (next.deflection - last.deflection).abs() < 1e-16;
                        last = next;
                        if settled {
                            break;
                        }
                    }
                    let exact = (load * curve().coefficient(velocity).unwrap()).copysign(velocity)
                        + curve().drag_force(velocity).unwrap();
                    assert!(
                        (last.force - exact).abs() < 1e-6 * (1.0 + exact.abs()),
                        "{} {exact}",
                        last.force
                    );
                }
            }
        }
    }

    #[test]
    fn halving_the_step_halves_the_error() {
        let law = LuGre::new(2e4, 20.0, curve()).unwrap();
        let end = |steps: i32| {
            let dt = 0.05 / f64::from(steps);
            let position = |i: i32| 4e-4 * libm::sin(80.0 * dt * f64::from(i));
            (0..steps).fold(0.0, |z, i| law.step(z, position(i + 1) - position(i), 30.0, dt).deflection)
        };
        let reference = end(1 << 18);
        let errors: std::vec::Vec<f64> = (9..13).map(|power| (end(1 << power) - reference).abs()).collect();
        assert!(errors[0] > 1e-9, "the test must have something to converge from: {errors:?}");
        for pair in errors.windows(2) {
            let order = libm::log2(pair[0] / pair[1]);
            assert!((order - 1.0).abs() < 0.2, "{errors:?}");
        }
    }

    #[test]
    fn outside_the_domain_the_state_is_held() {
        let law = LuGre::new(1e5, 300.0, curve()).unwrap();
        for (slide, load, interval) in [
            (f64::NAN, 1.0, 1e-3),
            (1e-6, f64::NAN, 1e-3),
            (1e-6, -1.0, 1e-3),
            (1e-6, 1.0, 0.0),
            (1e-6, 1.0, f64::NAN),
            (f64::MAX, 1.0, 1e-3),
            (1e-6, f64::INFINITY, 1e-3),
        ] {
            let step = law.step(1e-5, slide, load, interval);
            assert!((step.deflection - 1e-5).abs() < 1e-20 && (step.force - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn without_load_the_bristles_spring_back_even_at_rest() {
        let law = LuGre::new(1e5, 300.0, curve()).unwrap();
        for slide in [0.0, 1e-6, -1e-6] {
            assert!(law.step(1e-5, slide, 0.0, 1e-3).deflection == 0.0, "{slide}");
        }
    }
}
