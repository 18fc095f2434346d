use super::limits::JointLimits;
use crate::error::{Error, check_length};
use crate::trajectory::Reference;
use alloc::vec;
use alloc::vec::Vec;

/// Reference of the joints that follows a moving target within limits of range, speed and acceleration.
///
/// ```text
/// f(e) = w e/2                                 |e| <= e_0 = 2 a/w^2
///      = sign(e) sqrt(a (|e| - e_0/2))         else
/// v*   = clip(v_t + f(q_t - q), -v_max, v_max), and not above f(high - q), not below f(low - q)
/// a    = clip(2 w (v* - v), -a_max, a_max),    v <- v + h a,   q <- q + h v + h^2 a/2
/// ```
///
/// | symbol       | meaning                                        | unit         |
/// |--------------|------------------------------------------------|--------------|
/// | q_t, v_t     | target and its velocity                         | rad, rad/s (m, m/s) |
/// | q, v, a      | reference                                       | rad, rad/s, rad/s^2 |
/// | w            | bandwidth with which a target within the limits is followed, at most 1/(2 h) | 1/s |
/// | e_0          | error up to which the reference is a critically damped second-order system | rad |
///
/// `f` is the speed from which the reference comes to rest within `e` at half of the largest acceleration;
/// the other half is left to the following of `f`. A target of constant speed is followed without error, one
/// of constant acceleration `b` with `b/w^2`.
///
/// # Assumes
/// `2 w h <= 1`; otherwise the speed could overshoot its limit.
///
/// # Source
/// Textbook: time-optimal control of a double integrator, with a linear zone around the target; ours in this
/// form.
#[derive(Debug, Clone)]
pub struct JointLimiter {
    limits: JointLimits,
    reference: Reference,
}

/// Whether a target was within the limits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limited {
    /// The reference is at the target or follows it.
    No,
    /// The target is beyond a range, or faster than a limit.
    Yes,
}

/// `w`, 1/s.
const BANDWIDTH: f64 = 100.0;
/// Distance, rad or m, and speed, per s, at which a resting target is reached.
const REACHED: [f64; 2] = [1e-8, 1e-6];

impl JointLimiter {
    /// At rest in a pose, which is moved into the ranges.
    ///
    /// # Errors
    /// As [`JointLimits::validate`]; [`Error::WrongLength`].
    pub fn new(limits: JointLimits, pose: &[f64]) -> Result<Self, Error> {
        limits.validate()?;
        check_length("pose", pose.len(), limits.range.len())?;
        let mut limiter = Self { reference: Reference::new(pose.len()), limits };
        limiter.rest_at(pose);
        Ok(limiter)
    }

    /// The limits.
    #[must_use]
    pub fn limits(&self) -> &JointLimits {
        &self.limits
    }

    /// The reference.
    #[must_use]
    pub fn reference(&self) -> &Reference {
        &self.reference
    }

    /// Begins anew at rest in a pose, which is moved into the ranges: `[joints]`.
    pub fn rest_at(&mut self, pose: &[f64]) {
        let Reference { q, v, a } = &mut self.reference;
        for ((q, pose), [low, high]) in q.iter_mut().zip(pose).zip(&self.limits.range) {
            *q = pose.max(*low).min(*high);
        }
        v.fill(0.0);
        a.fill(0.0);
    }

    /// One step of `h` s toward a target and its velocity: `[joints]` each, finite.
    pub fn step(&mut self, h: f64, target: &[f64], velocity: &[f64]) -> Limited {
        let bandwidth = BANDWIDTH.min(0.5 / h);
        let mut limited = Limited::No;
        for (k, (target, velocity)) in target.iter().zip(velocity).enumerate().take(self.limits.range.len()) {
            let joint = Joint {
                range: self.limits.range[k],
                speed: self.limits.speed[k],
                acceleration: self.limits.acceleration[k],
            };
            let Reference { q, v, a } = &mut self.reference;
            if joint.step(h, bandwidth, [*target, *velocity], [&mut q[k], &mut v[k], &mut a[k]])
                == Limited::Yes
            {
                limited = Limited::Yes;
            }
        }
        limited
    }

    /// One step of `h` s toward rest, each joint as soon as its acceleration allows.
    pub fn brake(&mut self, h: f64) {
        let Reference { q, v, a } = &mut self.reference;
        for (k, ([low, high], most)) in self.limits.range.iter().zip(&self.limits.acceleration).enumerate() {
            a[k] = (-v[k] / h).max(-most).min(*most);
            q[k] = (q[k] + h * v[k] + 0.5 * h * h * a[k]).max(*low).min(*high);
            v[k] += h * a[k];
        }
    }

    /// Whether the reference rests.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.reference.v.iter().chain(&self.reference.a).all(|x| *x == 0.0)
    }

    /// Number of joints.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.limits.range.len()
    }

    /// Zeros for targets: `[joints]`.
    pub(super) fn zeros(&self) -> Vec<f64> {
        vec![0.0; self.joints()]
    }
}

/// Limits of one joint.
struct Joint {
    range: [f64; 2],
    speed: f64,
    acceleration: f64,
}

impl Joint {
    fn step(&self, h: f64, w: f64, [target, velocity]: [f64; 2], [q, v, a]: [&mut f64; 3]) -> Limited {
        let [low, high] = self.range;
        let inside = target.max(low).min(high);
        let reachable = (low..=high).contains(&target);
        let drift = if reachable { velocity.max(-self.speed).min(self.speed) } else { 0.0 };
        let limited = if reachable && velocity.abs() <= self.speed { Limited::No } else { Limited::Yes };
        if drift == 0.0 && (inside - *q).abs() <= REACHED[0] && v.abs() <= REACHED[1] {
            (*q, *v, *a) = (inside, 0.0, 0.0);
            return limited;
        }
        let desired = (drift + self.approach(inside - *q, w)).max(-self.speed).min(self.speed);
        let desired = desired.min(self.approach(high - *q, w)).max(self.approach(low - *q, w));
        *a = (2.0 * w * (desired - *v)).max(-self.acceleration).min(self.acceleration);
        *q = (*q + h * *v + 0.5 * h * h * *a).max(low).min(high);
        *v += h * *a;
        limited
    }

    /// `f(e)`.
    fn approach(&self, error: f64, w: f64) -> f64 {
        let linear = 2.0 * self.acceleration / (w * w);
        let distance = error.abs();
        let speed = if distance <= linear {
            0.5 * w * distance
        } else {
            libm::sqrt(self.acceleration * (distance - 0.5 * linear))
        };
        libm::copysign(speed, error)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const H: f64 = 1e-3;

    fn limiter(speed: f64, acceleration: f64) -> JointLimiter {
        let limits =
            JointLimits { range: vec![[-1.0, 1.0]], speed: vec![speed], acceleration: vec![acceleration] };
        JointLimiter::new(limits, &[0.0]).unwrap()
    }

    #[test]
    fn no_target_makes_the_reference_leave_its_limits() {
        for seed in 0..200 {
            let mut random = Random::new(seed);
            let mut draw = || [random.unit(), random.unit(), random.unit()];
            let scale = draw();
            let (speed, acceleration) = (0.05 + 3.0 * scale[0], 0.1 + 30.0 * scale[1]);
            let mut limiter = limiter(speed, acceleration);
            let (mut target, mut velocity, mut last) = (0.0, 0.0, 0.0);
            for step in 0..5000 {
                if step % 97 == 0 {
                    let next = draw();
                    (target, velocity) = (6.0 * next[0] - 3.0, (next[1] - 0.5) * 20.0 * next[2]);
                }
                limiter.step(H, &[target], &[velocity]);
                let Reference { q, v, a } = limiter.reference();
                assert!((-1.0..=1.0).contains(&q[0]), "{q:?}");
                assert!(v[0].abs() <= speed * (1.0 + 1e-12) && a[0].abs() <= acceleration, "{v:?} {a:?}");
                assert!((v[0] - last).abs() <= H * acceleration * (1.0 + 1e-9), "the velocity jumps");
                last = v[0];
            }
        }
    }

    #[test]
    fn the_ends_of_the_range_are_reached_without_a_stop_of_the_position() {
        // The range is a bound that is never needed: the reference would keep it by its deceleration alone.
        for (speed, acceleration) in [(0.1, 0.5), (1.0, 5.0), (3.0, 10.0), (3.0, 100.0)] {
            let mut limiter = limiter(speed, acceleration);
            for step in 0..20_000 {
                let before = (limiter.reference().q[0], limiter.reference().v[0]);
                limiter.step(H, &[if step / 5000 % 2 == 0 { 9.0 } else { -9.0 }], &[5.0]);
                let Reference { q, v, a } = limiter.reference();
                let moved = before.0 + H * before.1 + 0.5 * H * H * a[0];
                assert!((q[0] - moved).abs() < 2e-8, "{q:?} {v:?}: stopped by the range");
            }
        }
    }

    #[test]
    fn a_resting_target_is_reached_exactly_and_without_overshoot() {
        for (speed, acceleration) in [(0.2, 1.0), (2.0, 5.0), (5.0, 50.0)] {
            let mut limiter = limiter(speed, acceleration);
            let mut largest = 0.0_f64;
            for _ in 0..10_000 {
                limiter.step(H, &[0.7], &[0.0]);
                largest = largest.max(limiter.reference().q[0]);
            }
            assert!(largest <= 0.7 + 1e-7, "{largest}");
            assert!(limiter.is_at_rest());
            assert_eq!(limiter.reference().q[0].to_bits(), 0.7_f64.to_bits());
        }
    }

    #[test]
    fn a_smooth_target_within_the_limits_is_followed_with_the_error_of_its_acceleration() {
        let mut limiter = limiter(2.0, 10.0);
        let (mut worst, rate) = (0.0_f64, 3.0);
        for step in 0..10_000 {
            let t = f64::from(step) * H;
            let (target, velocity) = (0.5 * libm::sin(rate * t), 0.5 * rate * libm::cos(rate * t));
            limiter.step(H, &[target], &[velocity]);
            if t > 1.0 {
                worst = worst.max((limiter.reference().q[0] - target - H * velocity).abs());
            }
        }
        let expected = 0.5 * rate * rate / (BANDWIDTH * BANDWIDTH);
        assert!(worst < 2.0 * expected, "{worst} {expected}");
    }

    #[test]
    fn braking_ends_at_rest_in_the_shortest_time() {
        let mut limiter = limiter(2.0, 10.0);
        while limiter.reference().v[0] < 1.0 {
            limiter.step(H, &[5.0], &[2.0]);
        }
        let steps = (0..).take_while(|_| {
            limiter.brake(H);
            !limiter.is_at_rest()
        });
        assert!(steps.count().abs_diff(100) <= 2);
    }
}
