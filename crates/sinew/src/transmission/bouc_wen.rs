use crate::error::{Error, positive, within};

/// Bouc-Wen hysteresis without its parallel spring: a friction force that saturates more or less sharply.
///
/// ```text
/// dz/dx = (1 - |z|^n (beta sign(z dx) + 1 - beta)) / D,    F = F_c z,    z in [-1, 1]
/// step:   z_1 = z_0 + dx/D (1 - |z_1|^n (beta sign(z_1 dx) + 1 - beta))           (implicit Euler)
/// ```
///
/// | symbol | argument             | unit | domain   | meaning                                   |
/// |--------|----------------------|------|----------|-------------------------------------------|
/// | F_c    | `limit_force`        | N    | > 0      | force in steady sliding                    |
/// | D      | `yield_displacement` | m    | > 0      | `F_c/D` is the stiffness at zero force      |
/// | n      | `sharpness`          | 1    | [1, 1000]| 1: gradual as Dahl; large: a corner         |
/// | beta   | `shape`              | 1    | [1/2, 1] | 1/2: unloading along a straight line; 1: softening both ways |
/// | dx     | `slide`              | m    | finite   | displacement of this step                  |
/// | z      | `fraction`           | 1    | [-1, 1]  | state: force as a fraction of its limit     |
///
/// # Assumes
/// Rate-independent. Order 1 in the slide, stable for any slide: the step's equation is monotone in `z_1`,
/// its root lies between `z_0` and +-1 and is found by safeguarded Newton.
///
/// # Departs
/// Normalised (A = 1, beta + gamma = 1), which removes a redundancy. `beta >= 1/2` is
/// `-beta <= gamma <= beta`: outside it closed cycles create energy. The elastic part `alpha k x` is left to
/// the caller.
///
/// # Example
/// ```
/// use sinew::transmission::BoucWen;
/// let law = BoucWen::new(5.0, 1e-3, 2.0, 0.5)?;
/// let fraction = law.step(0.0, 1.0);
/// assert!((law.force(fraction) - 5.0).abs() < 0.01);    // after long sliding: Coulomb
/// let fraction = law.step(0.0, 1e-9);
/// assert!((law.force(fraction) - 5e-6).abs() < 1e-12);  // at first: a spring
/// # Ok::<(), sinew::Error>(())
/// ```
///
/// # Source
/// `bouc1967`, `wen1976`; admissible shapes: `erlicher2004`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoucWen {
    limit_force: f64,
    yield_displacement: f64,
    sharpness: f64,
    shape: f64,
}

impl BoucWen {
    /// A law of checked parameters.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the parameter outside its domain.
    pub fn new(limit_force: f64, yield_displacement: f64, sharpness: f64, shape: f64) -> Result<Self, Error> {
        positive("limit_force", limit_force)?;
        positive("yield_displacement", yield_displacement)?;
        within("sharpness", "a number in [1, 1000]", sharpness, (1.0..=1000.0).contains(&sharpness))?;
        within("shape", "a number in [1/2, 1]", shape, (0.5..=1.0).contains(&shape))?;
        Ok(Self { limit_force, yield_displacement, sharpness, shape })
    }

    /// The force, N, that belongs to a state.
    #[inline]
    #[must_use]
    pub fn force(&self, fraction: f64) -> f64 {
        self.limit_force * fraction
    }

    /// The state after a slide, m, in [-1, 1]; a slide that is not finite leaves it as it is.
    #[must_use]
    pub fn step(&self, fraction: f64, slide: f64) -> f64 {
        let travel = slide.abs() / self.yield_displacement;
        if !travel.is_finite() || travel <= 0.0 {
            return fraction;
        }
        // Seen in the direction of motion the problem is always that of a positive slide.
        let sign = 1.0_f64.copysign(slide);
        sign * self.advance((sign * fraction).clamp(-1.0, 1.0), travel)
    }

    /// Root of `z - z0 - t (1 - |z|^n c(z))` in `[z0, 1]`, `c = 1` for `z > 0` and `1 - 2 beta` below.
    fn advance(&self, start: f64, travel: f64) -> f64 {
        let (mut low, mut high) = (start, 1.0);
        let mut z = (start + travel).min(1.0);
        for _ in 0..80 {
            let c = if z > 0.0 { 1.0 } else { 1.0 - 2.0 * self.shape };
            let power = self.power(z.abs());
            let residual = z - start - travel * (1.0 - power * c);
            if residual > 0.0 {
                high = z;
            } else {
                low = z;
            }
            // d|z|^n/dz = n |z|^n / z; at zero the slope of the residual is that of `z`.
            let slope = if z.abs() > 1e-300 { 1.0 + travel * c * self.sharpness * power / z } else { 1.0 };
            let newton = z - residual / slope;
            if (newton - z).abs() <= 1e-15 {
                return z;
            }
            let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
            if high - low <= 1e-15 {
                return next;
            }
            z = next;
        }
        z
    }

    fn power(&self, magnitude: f64) -> f64 {
        // Whole exponents of common use are cheap; the rest costs a `pow`.
        if self.sharpness <= 1.0 {
            magnitude
        } else if (self.sharpness - 2.0).abs() <= 0.0 {
            magnitude * magnitude
        } else {
            libm::pow(magnitude, self.sharpness)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transmission::Dahl;
    use proptest::prelude::*;
    use std::vec;
    use std::vec::Vec;

    proptest! {
        #[test]
        fn every_step_solves_its_equation_and_stays_within_its_limits(
            fraction in prop_oneof![-1.0..1.0_f64, Just(-1.0), Just(0.0), Just(1.0)],
            travel in prop_oneof![-3.0..3.0_f64, Just(1e-12), Just(-1e6), Just(1e12)],
            sharpness in prop_oneof![1.0..8.0_f64, Just(1.0), Just(2.0), Just(1000.0)],
            shape in prop_oneof![0.5..1.0_f64, Just(0.5), Just(1.0)],
        ) {
            let law = BoucWen::new(1.0, 1.0, sharpness, shape).unwrap();
            let z = law.step(fraction, travel);
            prop_assert!(z.abs() <= 1.0);
            let sign = if z * travel > 0.0 { 1.0 } else { -1.0 };
            let grip = libm::pow(z.abs(), sharpness) * (shape * sign + 1.0 - shape);
            let residual = z - fraction - travel * (1.0 - grip);
            // Near saturation the residual amplifies the rounding of z by the travel.
            prop_assert!(residual.abs() <= 1e-13 * (1.0 + travel.abs() * sharpness), "{residual}");
        }
    }

    #[test]
    fn sharpness_one_and_full_shape_is_dahl() {
        let law = BoucWen::new(4.0, 2e-4, 1.0, 1.0).unwrap();
        let dahl = Dahl::new(2e4, 4.0).unwrap();
        let (mut z, mut force) = (0.0, 0.0);
        for i in 0..20_000 {
            let slide = 1e-7 * libm::cos(f64::from(i) * 1e-3);
            z = law.step(z, slide);
            force = dahl.step(force, slide);
            assert!((law.force(z) - force).abs() < 4e-3);
        }
    }

    #[test]
    fn halving_the_slide_halves_the_error() {
        let law = BoucWen::new(1.0, 1e-3, 1.7, 0.8).unwrap();
        let end = |steps: i32| {
            let position = |i: i32| 2e-3 * libm::sin(1.3 * f64::from(i) / f64::from(steps));
            (0..steps).fold(-0.8, |z, i| law.step(z, position(i + 1) - position(i)))
        };
        let reference = end(1 << 17);
        let errors: Vec<f64> = (6..10).map(|p| (end(1 << p) - reference).abs()).collect();
        assert!(errors[0] > 1e-4, "{errors:?}");
        for pair in errors.windows(2) {
            assert!((libm::log2(pair[0] / pair[1]) - 1.0).abs() < 0.25, "{errors:?}");
        }
    }

    #[test]
    fn the_root_is_found_from_every_state_however_hard_the_step() {
        // The first ones are where an iteration with a wrong slope or a wrong middle ends elsewhere.
        let mut cases = vec![(-1e-9, 1.0, 1.01, 0.5), (-0.1, 1.1, 3.0, 0.5), (0.5, 0.3, 5.0, 0.5)];
        cases.extend([
            (1.0 - 1e-9, 1e-12, 30.0, 0.5),
            (-0.7224281818524843, 0.34583168301636386, 1.78, 0.502),
        ]);
        for start in [-1.0, -0.999, -0.5, -1e-3, 0.0, 1e-9, 0.1, 0.9, 1.0 - 1e-9] {
            for travel in [1e-12, 1e-3, 0.1, 0.9, 1.0, 1.1, 3.0, 100.0, 1e6] {
                for sharpness in [1.0, 1.01, 1.3, 2.0, 3.0, 8.0, 100.0] {
                    cases.extend([0.5, 0.6, 1.0].map(|shape| (start, travel, sharpness, shape)));
                }
            }
        }
        for (start, travel, sharpness, shape) in cases {
            let law = BoucWen::new(1.0, 1.0, sharpness, shape).unwrap();
            let z = law.step(start, travel);
            let mirrored = law.step(-start, -travel);
            assert!((z + mirrored).abs() < 1e-15, "the law knows no direction");
            // Bisection of the same equation, whose left side grows with `z`.
            let (mut low, mut high) = (start, 1.0);
            for _ in 0..60 {
                let middle: f64 = 0.5 * (low + high);
                let grip = libm::pow(middle.abs(), sharpness) * (shape * middle.signum() + 1.0 - shape);
                let beyond = middle - start > travel * (1.0 - grip);
                *(if beyond { &mut high } else { &mut low }) = middle;
            }
            assert!((z - high).abs() < 2e-15, "{start} {travel} {sharpness} {shape}: {z} {high}");
        }
    }

    #[test]
    fn a_slide_that_is_not_finite_leaves_the_state() {
        let law = BoucWen::new(1.0, 1e-3, 2.0, 0.7).unwrap();
        for slide in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, 0.0] {
            assert!((law.step(0.3, slide) - 0.3).abs() < 1e-16, "{slide}");
        }
    }
}
