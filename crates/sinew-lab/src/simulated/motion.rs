//! What winch and anchor do during a simulated log: strokes between random targets, with rests.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Random numbers, the same on every machine.
pub(super) struct Sampler(ChaCha8Rng);

impl Sampler {
    /// One stream of draws for every seed and stream number.
    pub(super) fn new(seed: u64, stream: u32) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(u64::from(stream));
        Self(rng)
    }

    /// Uniform in `[low, high)`.
    pub(super) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        let fraction: f64 = self.0.random();
        low + (high - low) * fraction
    }

    /// Normal to three digits, variance 1: the sum of twelve uniform numbers, which needs no logarithm.
    pub(super) fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform(-0.5, 0.5)).sum()
    }
}

/// Positions of both ends of the cable, m, positive toward the motor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) winch_m: f64,
    pub(super) anchor_m: f64,
}

/// A stroke between two positions; a rest where both are equal.
#[derive(Debug, Clone, Copy)]
struct Stroke {
    start_s: f64,
    end_s: f64,
    from: f64,
    to: f64,
}

/// The motion of a log: stretch between the ends and position of the anchor, sampled independently.
pub(super) struct Motion {
    stretch: Vec<Stroke>,
    anchor: Vec<Stroke>,
}

impl Motion {
    /// Draws a motion of the given length, s.
    pub(super) fn sampled(sampler: &mut Sampler, duration_s: f64) -> Self {
        // Large strokes and, equally often, small ones about the last position: inner hysteresis loops.
        let stretch = strokes(sampler, duration_s, 0.04, |sampler, at| {
            let small = sampler.uniform(0.0, 1.0) < 0.5;
            let target =
                if small { at + sampler.uniform(-0.012, 0.012) } else { sampler.uniform(0.015, 0.075) };
            (target.clamp(0.015, 0.075), sampler.uniform(0.3, 2.2), sampler.uniform(0.0, 1.0) < 0.2)
        });
        let anchor = strokes(sampler, duration_s, 0.0, |sampler, _| {
            (sampler.uniform(-0.012, 0.012), sampler.uniform(1.5, 6.0), sampler.uniform(0.0, 1.0) < 0.3)
        });
        Self { stretch, anchor }
    }

    /// Positions of the ends at a time, s.
    pub(super) fn at(&self, time_s: f64) -> Place {
        let anchor_m = value(&self.anchor, time_s);
        Place { winch_m: anchor_m + value(&self.stretch, time_s), anchor_m }
    }
}

/// Strokes that fill a duration; `next` draws target, duration and whether a rest follows.
fn strokes(
    sampler: &mut Sampler,
    duration_s: f64,
    start: f64,
    next: impl Fn(&mut Sampler, f64) -> (f64, f64, bool),
) -> Vec<Stroke> {
    let (mut found, mut at, mut time) = (Vec::new(), start, 0.0);
    while time < duration_s {
        let (to, seconds, rests) = next(sampler, at);
        found.push(Stroke { start_s: time, end_s: time + seconds, from: at, to });
        (at, time) = (to, time + seconds);
        if rests {
            let until = time + sampler.uniform(0.3, 2.0);
            found.push(Stroke { start_s: time, end_s: until, from: at, to: at });
            time = until;
        }
    }
    found
}

fn value(strokes: &[Stroke], time_s: f64) -> f64 {
    let next = strokes.partition_point(|stroke| stroke.end_s < time_s);
    let Some(stroke) = strokes.get(next).or(strokes.last()) else { return 0.0 };
    let fraction = ((time_s - stroke.start_s) / (stroke.end_s - stroke.start_s)).clamp(0.0, 1.0);
    // Continuous speed at both ends.
    stroke.from + (stroke.to - stroke.from) * fraction * fraction * (3.0 - 2.0 * fraction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_move_continuously_and_within_their_range() {
        let motion = Motion::sampled(&mut Sampler::new(5, 1), 30.0);
        let mut last = motion.at(0.0);
        for k in 1..=30_000 {
            let place = motion.at(f64::from(k) * 1e-3);
            assert!(
                (place.winch_m - last.winch_m).abs() < 5e-4 && (place.anchor_m - last.anchor_m).abs() < 5e-5
            );
            assert!((0.0149..0.0751).contains(&(place.winch_m - place.anchor_m)));
            last = place;
        }
    }

    #[test]
    fn normal_draws_have_mean_zero_and_variance_one() {
        let mut sampler = Sampler::new(9, 3);
        let draws: Vec<f64> = (0..20_000).map(|_| sampler.normal()).collect();
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        let variance = draws.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / draws.len() as f64;
        assert!(mean.abs() < 0.03 && (variance - 1.0).abs() < 0.04, "{mean} {variance}");
    }
}
