use super::drift::Estimate;
use crate::body::cholesky;

/// Friction and compliance of a cable from the travel that its model does not explain, over one window.
///
/// ```text
/// e = C T_in E(s A),   E(z) = (1 - exp(-z))/z                        stretch of a cable that slides everywhere
/// x' = x + R_k e_q + C E(s A) i + s C (f - 1) D |v|/2  T_m/(T_m + T_d),   T_m = T_in E(s A)
/// -x' = c + g p + C T_in E(s A) d_C + C T_in s E'(s A) A d_A         least squares over a window; g, d_C, d_A with priors
/// ```
///
/// | symbol | meaning                                                             | unit |
/// |--------|---------------------------------------------------------------------|------|
/// | x      | travel of the winch in addition to its encoder's with which the observer explains the tension | m |
/// | R_k e_q | way of the anchor in addition to the estimated joints': moment arms by measured less estimated coordinates | m |
/// | i      | tension at the drive that it does not explain yet                     | N    |
/// | T_in, s | tension at the drive as the observer estimates it, direction of sliding | N, 1 |
/// | p, g   | position of the anchor; error of the muscle's moment arm as a fraction of it | m, 1 |
/// | C, A   | compliance and friction angle of the model                            | m/N, 1 |
/// | D, T_d | drag of the model and the tension below which it fades                | N s/m, N |
/// | f, v   | drag that the observer has learned, over the model's; speed of the anchor | 1, m/s |
/// | d_C, d_A | relative differences of the cable from its model                     | 1    |
///
/// Sliding toward the motor the stretch shrinks with friction, away it grows: the hysteresis tells friction
/// from compliance. A joint's estimate lags its encoder where friction changes its sign, which at the anchor
/// of a short cable is as much as its stretch changes: without `e_q` friction of one muscle shows in all
/// muscles of its joints. The observer corrects `x` more slowly than a cable reverses: `i` is what is left.
/// It takes friction that grows for drag, which `f` takes back. Noise of the load cell is in `x'` by `i`:
/// were it in `T_in` too, it would look like a stiffness.
///
/// # Assumes
/// Friction evenly along the cable. What else is wrong with the geometry, and creep, enter both numbers alike
/// as long as the motion is the same: only their change counts.
///
/// # Source
/// (10) of `yuan2023`, linearised.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct SlidingFit {
    /// Normal equations of `(1, p, r_C, r_A)`, and their right side.
    normal: [[f64; COLUMNS]; COLUMNS],
    right: [f64; COLUMNS],
    count: [f64; 2],
    /// Position of the anchor in the first sample, m.
    origin: Option<f64>,
}

const COLUMNS: usize = 4;

/// What is seen of a cable at one time.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlidingSample {
    /// Of the anchor, m.
    pub(super) position: f64,
    /// Of the anchor, m/s, + toward the motor.
    pub(super) speed: f64,
    /// At the drive, estimated, N, >= 0.
    pub(super) tension: f64,
    /// `x`, m.
    pub(super) unexplained: f64,
    /// `R_k e_q`, m.
    pub(super) anchor_error: f64,
    /// `i`, N.
    pub(super) innovation: f64,
    /// `f`.
    pub(super) drag_factor: f64,
}

/// What its model says.
#[derive(Debug, Clone, Copy)]
pub(super) struct SlidingModel {
    /// `A`.
    pub(super) angle: f64,
    /// `C`, m/N.
    pub(super) compliance: f64,
    /// `D`, N s/m.
    pub(super) drag: f64,
    /// `T_d`, N, > 0.
    pub(super) drag_fade: f64,
}

/// Samples of each direction that a window needs.
const ENOUGH: f64 = 40.0;
/// Fraction of the samples in which a cable has to slide everywhere: one that slides less only breaks away
/// again and again, and what it shows depends on how far it comes.
const MIN_SLIDING: f64 = 0.15;
/// Standard deviations before a window: of `d_C` and `d_A`, and of `g`.
const WEAR: f64 = 0.5;
const MOMENT_ARM: f64 = 0.02;
/// Standard deviation of a sample as a fraction of the cable's stretch.
const NOISE: f64 = 0.003;
/// Angle below which the series of `E` is taken.
const SMALL: f64 = 1e-3;

/// `E(z)` and `z E'(z)`.
fn mean_tension(z: f64) -> [f64; 2] {
    if z.abs() < SMALL {
        return [1.0 - 0.5 * z, -0.5 * z];
    }
    let decay = libm::exp(-z);
    let mean = (1.0 - decay) / z;
    [mean, decay - mean]
}

impl SlidingModel {
    /// `s (f - 1) D |v| T_m/(T_m + T_d)`, N: what the observer has added to the model's friction.
    pub(super) fn learned_drag(&self, sample: &SlidingSample) -> f64 {
        let [mean, _] = mean_tension(sample.speed.signum() * self.angle);
        let tension = sample.tension * mean;
        let faded = if tension > 0.0 { tension / (tension + self.drag_fade) } else { 0.0 };
        (sample.drag_factor - 1.0) * self.drag * sample.speed * faded
    }
}

impl SlidingFit {
    /// Takes one sample.
    pub(super) fn add(&mut self, sample: &SlidingSample, model: &SlidingModel) {
        let SlidingSample { position, speed, tension, unexplained, innovation, .. } = *sample;
        let SlidingModel { angle, compliance, .. } = *model;
        let sign = speed.signum();
        let [mean, slope] = mean_tension(sign * angle);
        let stretch = compliance * tension;
        let learned = 0.5 * compliance * model.learned_drag(sample);
        let travel = unexplained + sample.anchor_error + compliance * mean * innovation + learned;
        let position = position - *self.origin.get_or_insert(position);
        let row = [1.0, position, stretch * mean, stretch * slope];
        for ((normal, right), own) in self.normal.iter_mut().zip(&mut self.right).zip(row) {
            for (sum, other) in normal.iter_mut().zip(row) {
                *sum += own * other;
            }
            *right -= own * travel;
        }
        self.count[usize::from(sign > 0.0)] += 1.0;
    }

    /// `d_C` and `d_A` of a window of so many samples; none where a direction is missing or the cable hardly
    /// slides.
    pub(super) fn solve(&self, samples: f64) -> Option<[Estimate; 2]> {
        let slides = self.count.iter().sum::<f64>() >= MIN_SLIDING * samples;
        if !slides || self.count.iter().any(|count| *count < ENOUGH) {
            return None;
        }
        let mut normal = self.normal;
        let mean_square = normal[2][2] / normal[0][0];
        // The samples are not independent: one in `ENOUGH` counts.
        let noise = ENOUGH * NOISE * NOISE * mean_square;
        for (k, prior) in [(1, MOMENT_ARM), (2, WEAR), (3, WEAR)] {
            normal[k][k] += noise / (prior * prior);
        }
        cholesky::factor(normal.as_flattened_mut(), COLUMNS).ok()?;
        let mut solution = self.right;
        cholesky::solve(normal.as_flattened(), &mut solution);
        let estimate = |k: usize| {
            let mut variance = [0.0; COLUMNS];
            variance[k] = noise;
            cholesky::solve(normal.as_flattened(), &mut variance);
            Estimate { value: solution[k], deviation: libm::sqrt(variance[k]) }
        };
        Some([estimate(2), estimate(3)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_derivative_is_that_of_the_mean_tension() {
        for z in [-1.5, -0.3, 1e-4, 0.4, 2.0] {
            let h = 1e-6;
            let slope = (mean_tension(z + h)[0] - mean_tension(z - h)[0]) / (2.0 * h);
            assert!((mean_tension(z)[1] - z * slope).abs() < 1e-5, "{z}");
        }
    }

    #[test]
    fn differences_of_friction_and_compliance_are_told_apart_at_any_scale_and_in_a_geometry_that_errs() {
        // All of it is left to the innovation where the observer has corrected nothing.
        for [softer, rougher, slow, arm] in
            [[0.1, 0.0, 0.0, 0.0], [0.0, 0.15, 0.5, 0.01], [-0.05, 0.08, 1.0, -0.02]]
        {
            // From the stretch of an arm's cable to that of a finger's.
            for compliance in [2e-4, 2e-6] {
                let angle = 0.9;
                let mut fit = SlidingFit::default();
                for k in 0..400 {
                    let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
                    let tension = 40.0 + 20.0 * libm::sin(0.1 * f64::from(k));
                    let stretch = |c: f64, a: f64| c * tension * mean_tension(sign * a)[0];
                    let own = stretch(compliance * (1.0 + softer), angle * (1.0 + rougher));
                    let position = 300.0 * compliance * libm::sin(0.037 * f64::from(k));
                    let unexplained = stretch(compliance, angle) - own + arm * position + 3.5 * compliance;
                    let lag = -0.3 * compliance * tension * sign;
                    let sample = SlidingSample {
                        position,
                        speed: 0.05 * sign,
                        tension,
                        unexplained: unexplained * (1.0 - slow) - lag,
                        anchor_error: lag,
                        innovation: slow * unexplained / (compliance * mean_tension(sign * angle)[0]),
                        drag_factor: 1.0,
                    };
                    fit.add(&sample, &SlidingModel { angle, compliance, drag: 80.0, drag_fade: 5.0 });
                }
                let [c, a] = fit.solve(400.0).unwrap().map(|estimate| estimate.value);
                assert!(
                    (c - softer).abs() < 0.02 && (a - rougher).abs() < 0.02,
                    "{softer} {rougher}: {c} {a}"
                );
            }
        }
    }

    #[test]
    fn friction_that_the_observer_has_learned_as_drag_is_found() {
        let model = SlidingModel { angle: 0.9, compliance: 2e-4, drag: 80.0, drag_fade: 5.0 };
        let friction = |drag_factor: f64| {
            let mut fit = SlidingFit::default();
            for k in 0..400 {
                let speed = if k % 2 == 0 { 0.05 } else { -0.05 };
                let tension = 40.0 + 20.0 * libm::sin(0.1 * f64::from(k));
                fit.add(
                    &SlidingSample {
                        position: 0.0,
                        speed,
                        tension,
                        unexplained: 0.0,
                        anchor_error: 0.0,
                        innovation: 0.0,
                        drag_factor,
                    },
                    &model,
                );
            }
            fit.solve(400.0).unwrap()[1].value
        };
        assert!(friction(1.0).abs() < 1e-9);
        // 4 N of drag more, of about 45 N at 0.9 rad in the mean of both directions.
        assert!((0.03..0.3).contains(&friction(2.0)), "{}", friction(2.0));
        assert!(friction(0.5) < -0.015);
    }

    #[test]
    fn without_friction_the_mean_tension_is_that_of_the_drive() {
        for z in [0.0, 1e-12, -1e-12] {
            let [mean, slope] = mean_tension(z);
            assert!((mean - 1.0).abs() < 1e-11 && slope.abs() < 1e-11, "{z}: {mean} {slope}");
        }
    }

    #[test]
    fn learned_drag_has_the_sign_of_the_motion_and_fades_with_the_tension_along_the_cable() {
        let model = SlidingModel { angle: 0.8, compliance: 1e-4, drag: 80.0, drag_fade: 5.0 };
        let sample = SlidingSample {
            position: 0.0,
            speed: 0.05,
            tension: 40.0,
            unexplained: 0.0,
            anchor_error: 0.0,
            innovation: 0.0,
            drag_factor: 1.5,
        };
        for sign in [1.0, -1.0] {
            // Mean tension of a cable that slides everywhere, by quadrature of T exp(-s A x).
            let mean = (0..1000).map(|k| libm::exp(-sign * 0.8 * (f64::from(k) + 0.5) / 1000.0)).sum::<f64>()
                / 1000.0;
            let tension = 40.0 * mean;
            let expected = sign * 0.5 * 80.0 * 0.05 * tension / (tension + 5.0);
            let drag = model.learned_drag(&SlidingSample { speed: sign * 0.05, ..sample });
            assert!((drag / expected - 1.0).abs() < 1e-6, "{drag} {expected}");
        }
        let slack = model.learned_drag(&SlidingSample { tension: 0.0, ..sample });
        assert!(slack.abs() < 1e-300);
    }

    /// A fit of a cable that slides to and fro, with so many samples of each direction.
    fn slid(toward: u32, away: u32) -> SlidingFit {
        let model = SlidingModel { angle: 0.9, compliance: 2e-4, drag: 80.0, drag_fade: 5.0 };
        let mut fit = SlidingFit::default();
        for (count, speed) in [(toward, 0.05), (away, -0.05)] {
            for k in 0..count {
                let sample = SlidingSample {
                    position: 0.01 * libm::sin(0.3 * f64::from(k)),
                    speed,
                    tension: 40.0 + 20.0 * libm::sin(0.1 * f64::from(k)),
                    unexplained: 0.0,
                    anchor_error: 0.0,
                    innovation: 0.0,
                    drag_factor: 1.0,
                };
                fit.add(&sample, &model);
            }
        }
        fit
    }

    #[test]
    fn a_window_needs_forty_samples_of_each_direction_and_a_cable_that_slides_for_a_seventh_of_it() {
        assert!(slid(40, 40).solve(80.0).is_some());
        assert!(slid(39, 400).solve(439.0).is_none());
        assert!(slid(400, 39).solve(439.0).is_none());
        assert!(slid(100, 100).solve(200.0 / 0.151).is_some());
        assert!(slid(100, 100).solve(200.0 / 0.149).is_none());
    }

    #[test]
    fn the_stated_deviation_falls_with_the_root_of_the_number_of_samples() {
        let [few, many] = [slid(100, 100), slid(1600, 1600)].map(|fit| fit.solve(100.0).unwrap());
        for k in 0..2 {
            assert!(few[k].deviation > 0.0 && few[k].deviation < 0.7 * WEAR);
            // Sixteen times as many: the root is four but for how the positions are spread and for the prior.
            let ratio = few[k].deviation / many[k].deviation;
            assert!((3.5..5.0).contains(&ratio), "{ratio}");
        }
    }
}
