//! Whether the near side is still that of the specimen of the training logs.

use super::conditioner::MAX_MAGNITUDE;
use super::model_file_error::{ModelFileError, require};
use alloc::format;
use alloc::vec::Vec;
use serde::{Deserialize, Serialize};

/// The loop of a near effort over a near motion, held against the loops of the training logs.
///
/// Over every two strokes of the motion `q`, between its reversals, of the effort `T`:
///
/// ```text
/// e = int T dq / int dq,   s = slope of T over q in least squares        of each of the two strokes
/// level = (e_+ + e_-)/2,   height = e_+ - e_-,   slope = (s_+ + s_-)/2
/// z = (y - b - w . x) / sqrt(sigma^2 (1 + x . P x) + v / n)              of the means over the last n loops
/// ```
///
/// | symbol | field         | meaning                                                       |
/// |--------|---------------|----------------------------------------------------------------|
/// | y      | `quantity`    | height, slope or level                                         |
/// | x      | `terms`       | what the loop of one specimen depends on, standardised         |
/// | b, w   | `offset`, `weights` | regression over the trials in training                   |
/// | sigma  | `deviation`   | standard deviation of a trial from it                          |
/// | P      | `covariance`  | of the regression: what was not seen in training is uncertain  |
/// | v      | `scatter`     | variance of a loop within its trial                            |
///
/// The height of a loop is the friction, its slope the stiffness, its level the load: the far side takes no
/// part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpecimenMonitor {
    /// Which input is the effort.
    pub effort: usize,
    /// Which input is the motion.
    pub motion: usize,
    /// Motion back from an extreme that counts as a reversal, its unit.
    pub reversal: f64,
    /// What is held against training.
    pub checks: Vec<LoopCheck>,
}

/// One quantity of the loop as it is in training.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoopCheck {
    /// Which quantity.
    pub quantity: LoopQuantity,
    /// What it depends on.
    pub terms: Vec<LoopTerm>,
    /// Mean of every term in training.
    pub mean: Vec<f64>,
    /// One over its standard deviation.
    pub inverse_scale: Vec<f64>,
    /// `b`.
    pub offset: f64,
    /// `w`.
    pub weights: Vec<f64>,
    /// `P`, row by row, with `1/trials` for the offset apart.
    pub covariance: Vec<f64>,
    /// Trials in training.
    pub trials: usize,
    /// `sigma`.
    pub deviation: f64,
    /// `v`.
    pub scatter: f64,
    /// `|z|` above which the specimen is another.
    pub limit: f64,
}

/// A quantity of the loop of effort over motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LoopQuantity {
    /// Mean effort of rising minus that of falling motion: friction.
    Height,
    /// Mean slope of the effort over the motion: stiffness.
    Slope,
    /// Mean effort: pretension or load.
    Level,
}

/// What a quantity of a loop depends on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LoopTerm {
    /// The level of the loop.
    Level,
    /// Its square.
    LevelSquared,
    /// Mean speed of the motion.
    Speed,
    /// Length of the strokes.
    Stroke,
    /// A given input.
    Given(usize),
}

/// How unlike the training logs the loops of a sequence are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SpecimenDeviation {
    /// The quantity that deviates most.
    pub quantity: LoopQuantity,
    /// Its value.
    pub value: f64,
    /// The one expected of the specimen of the training logs.
    pub expected: f64,
    /// `|z|` over its limit: above 1 the specimen is another.
    pub excess: f64,
}

/// Means over the loops of a sequence.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Loops {
    /// Loops so far, at most [`LOOPS`](Self::LOOPS).
    pub count: f64,
    /// Mean effort.
    pub level: f64,
    /// Mean difference between the strokes.
    pub height: f64,
    /// Mean slope.
    pub slope: f64,
    /// Mean speed of the motion, its unit per second.
    pub speed: f64,
    /// Mean length of the strokes, its unit.
    pub stroke: f64,
}

impl Loops {
    /// Loops over which means are taken; older ones are forgotten.
    pub const LOOPS: f64 = 16.0;

    fn add(&mut self, new: &Self) {
        self.count = (self.count + 1.0).min(Self::LOOPS);
        let pairs = [
            (&mut self.level, new.level),
            (&mut self.height, new.height),
            (&mut self.slope, new.slope),
            (&mut self.speed, new.speed),
            (&mut self.stroke, new.stroke),
        ];
        for (mean, value) in pairs {
            *mean += (value - *mean) / self.count;
        }
    }

    /// The value of a quantity.
    #[must_use]
    pub fn quantity(&self, quantity: LoopQuantity) -> f64 {
        match quantity {
            LoopQuantity::Height => self.height,
            LoopQuantity::Slope => self.slope,
            LoopQuantity::Level => self.level,
        }
    }

    /// The value of a term; `inputs`: those of the present sample.
    #[must_use]
    pub fn term(&self, term: LoopTerm, inputs: &[f64]) -> f64 {
        match term {
            LoopTerm::Level => self.level,
            LoopTerm::LevelSquared => self.level * self.level,
            LoopTerm::Speed => self.speed,
            LoopTerm::Stroke => self.stroke,
            LoopTerm::Given(input) => inputs[input],
        }
    }
}

impl LoopCheck {
    /// The value expected of the specimen of the training logs, and `z`; `inputs`: those of the present
    /// sample.
    #[must_use]
    pub fn deviation(&self, loops: &Loops, inputs: &[f64]) -> (f64, f64) {
        let term = |i: usize| (loops.term(self.terms[i], inputs) - self.mean[i]) * self.inverse_scale[i];
        let (mut expected, mut uncertain) = (self.offset, 1.0 + 1.0 / self.trials as f64);
        for i in 0..self.terms.len() {
            expected += self.weights[i] * term(i);
            for j in 0..self.terms.len() {
                uncertain += term(i) * self.covariance[i * self.terms.len() + j] * term(j);
            }
        }
        let variance = self.deviation * self.deviation * uncertain + self.scatter / loops.count;
        (expected, (loops.quantity(self.quantity) - expected) / libm::sqrt(variance))
    }
}

impl SpecimenMonitor {
    /// The largest deviation; `None` before the first loop.
    #[must_use]
    pub fn deviation(&self, loops: &Loops, inputs: &[f64]) -> Option<SpecimenDeviation> {
        let one = |check: &LoopCheck| {
            let (expected, z) = check.deviation(loops, inputs);
            let quantity = check.quantity;
            SpecimenDeviation {
                quantity,
                value: loops.quantity(quantity),
                expected,
                excess: z.abs() / check.limit,
            }
        };
        let all = self.checks.iter().filter(|_| loops.count > 0.0).map(one);
        all.max_by(|a, b| a.excess.total_cmp(&b.excess))
    }

    pub(super) fn validate(&self, inputs: usize) -> Result<(), ModelFileError> {
        let below = |name: &str, input: usize| {
            require(name, &format!("an input below {inputs}"), input < inputs, input)
        };
        let positive = |name: &str, value: f64| {
            let holds = value > 0.0 && value <= MAX_MAGNITUDE;
            require(name, "> 0 and <= 1e30", holds, value)
        };
        below("specimen.effort", self.effort)?;
        below("specimen.motion", self.motion)?;
        positive("specimen.reversal", self.reversal)?;
        for check in &self.checks {
            let count = check.terms.len();
            for term in &check.terms {
                if let LoopTerm::Given(input) = *term {
                    below("specimen.terms", input)?;
                }
            }
            let lists = [
                ("specimen.mean", &check.mean, count),
                ("specimen.inverse_scale", &check.inverse_scale, count),
                ("specimen.weights", &check.weights, count),
                ("specimen.covariance", &check.covariance, count * count),
            ];
            for (name, list, expected) in lists {
                require(name, &format!("{expected} numbers"), list.len() == expected, list.len())?;
                for value in list {
                    require(name, "numbers within +-1e30", value.abs() <= MAX_MAGNITUDE, value)?;
                }
            }
            let offset = check.offset.abs() <= MAX_MAGNITUDE;
            require("specimen.offset", "a number within +-1e30", offset, check.offset)?;
            require("specimen.trials", "at least 1", check.trials > 0, check.trials)?;
            positive("specimen.deviation", check.deviation)?;
            positive("specimen.limit", check.limit)?;
            let scatter = (0.0..=MAX_MAGNITUDE).contains(&check.scatter);
            require("specimen.scatter", ">= 0 and <= 1e30", scatter, check.scatter)?;
        }
        Ok(())
    }
}

/// The integrals of one stroke, or of a part of one.
#[derive(Debug, Clone, Copy, Default)]
struct Stroke {
    /// Motion at its start and at its end, from that at the start of the sequence.
    from: f64,
    to: f64,
    /// `int T dq` and `int T q dq`.
    effort: f64,
    moment: f64,
    seconds: f64,
}

impl Stroke {
    fn join(&mut self, part: &Self) {
        self.to = part.to;
        self.effort += part.effort;
        self.moment += part.moment;
        self.seconds += part.seconds;
    }

    fn length(&self) -> f64 {
        self.to - self.from
    }

    fn mean(&self) -> f64 {
        self.effort / self.length()
    }

    fn slope(&self) -> f64 {
        let (length, middle) = (self.length(), 0.5 * (self.from + self.to));
        12.0 * (self.moment - middle * self.effort) / (length * length * length)
    }
}

/// The loops of one sequence as they arrive; no allocation.
#[derive(Debug, Clone, Copy, Default)]
pub struct LoopState {
    /// Motion, and effort, at the sample before; motion at the first.
    last: Option<(f64, f64)>,
    origin: f64,
    /// 1 while the motion rises, -1 while it falls, 0 before the first reversal.
    direction: f64,
    /// Extremes of the motion while it has no direction.
    low: f64,
    high: f64,
    /// The present stroke up to its extreme, and what came after that.
    stroke: Stroke,
    since: Stroke,
    /// Whether the present stroke began at a reversal.
    whole: bool,
    /// The whole stroke before it.
    before: Option<Stroke>,
    loops: Loops,
    latest: Loops,
}

impl LoopState {
    /// Clears the state: the next sample starts a new sequence.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// Means over the loops so far.
    #[must_use]
    pub fn loops(&self) -> &Loops {
        &self.loops
    }

    /// The latest loop alone.
    #[must_use]
    pub fn latest(&self) -> &Loops {
        &self.latest
    }

    /// Advances by one sample, `dt_s` after the one before; whether it completed a loop.
    pub fn step(&mut self, reversal: f64, dt_s: f64, motion: f64, effort: f64) -> bool {
        let Some((q_before, effort_before)) = self.last else {
            self.origin = motion;
            self.last = Some((0.0, effort));
            return false;
        };
        let q = motion - self.origin;
        self.last = Some((q, effort));
        let (change, mean, middle) = (q - q_before, 0.5 * (effort + effort_before), 0.5 * (q + q_before));
        self.since.join(&Stroke {
            to: q,
            effort: mean * change,
            moment: mean * middle * change,
            seconds: dt_s,
            ..Stroke::default()
        });
        if self.direction == 0.0 {
            (self.low, self.high) = (self.low.min(q), self.high.max(q));
            let (up, down) = (q > self.low + reversal, q < self.high - reversal);
            self.direction = if up { 1.0 } else { -f64::from(u8::from(down)) };
            let here = Stroke { from: q, to: q, ..Stroke::default() };
            (self.stroke, self.since) = (here, here);
            return false;
        }
        if (q - self.stroke.to) * self.direction >= 0.0 {
            self.stroke.join(&self.since);
            self.since = Stroke { from: q, to: q, ..Stroke::default() };
            return false;
        }
        if (self.stroke.to - q) * self.direction <= reversal {
            return false;
        }
        let finished = core::mem::replace(&mut self.stroke, self.since);
        self.since = Stroke { from: q, to: q, ..Stroke::default() };
        self.direction = -self.direction;
        if !core::mem::replace(&mut self.whole, true) {
            return false;
        }
        let before = self.before.replace(finished);
        before.is_some_and(|before| self.conclude(&before, &finished))
    }

    /// The loop of two strokes.
    fn conclude(&mut self, before: &Stroke, finished: &Stroke) -> bool {
        let (up, down) = if before.length() > 0.0 { (before, finished) } else { (finished, before) };
        let length = up.length() - down.length();
        let new = Loops {
            count: 1.0,
            level: 0.5 * (up.mean() + down.mean()),
            height: up.mean() - down.mean(),
            slope: 0.5 * (up.slope() + down.slope()),
            speed: length / (up.seconds + down.seconds),
            stroke: 0.5 * length,
        };
        let numbers = [new.level, new.height, new.slope, new.speed, new.stroke];
        if numbers.iter().all(|number| number.abs() <= MAX_MAGNITUDE) {
            self.latest = new;
            self.loops.add(&new);
            return true;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A loop of height 2 h and slope k around a level, in strokes of +-1.
    fn run(state: &mut LoopState, level: f64, k: f64, h: f64, offset: f64) -> usize {
        let mut before = 0.0;
        let one = |i: u32| {
            let q = libm::sin(f64::from(i) * 0.01);
            let effort = level + k * q + if q > before { h } else { -h };
            before = q;
            state.step(0.2, 0.002, q + offset, effort)
        };
        (0..6000_u32).map(one).filter(|finished| *finished).count()
    }

    #[test]
    fn level_height_slope_speed_and_stroke_of_a_loop_come_back() {
        for offset in [0.0, 1e4] {
            let mut state = LoopState::default();
            let loops = run(&mut state, 7.0, 3.0, 0.5, offset);
            assert!((17..=18).contains(&loops), "{loops}");
            let found = state.loops();
            let expected = [(found.level, 7.0), (found.height, 1.0), (found.slope, 3.0), (found.stroke, 2.0)];
            for (value, expected) in expected {
                assert!((value - expected).abs() < 5e-3 * expected, "{found:?}");
            }
            assert!((found.speed - 2.0 / (0.002 * 314.16)).abs() < 0.01, "{found:?}");
            state.reset();
            assert!(state.loops().count < 0.5);
        }
    }

    #[test]
    fn a_deviation_is_counted_in_the_uncertainty_of_what_is_expected() {
        let check = LoopCheck {
            quantity: LoopQuantity::Height,
            terms: alloc::vec![LoopTerm::Level],
            mean: alloc::vec![7.0],
            inverse_scale: alloc::vec![0.5],
            offset: 1.0,
            weights: alloc::vec![0.2],
            covariance: alloc::vec![0.25],
            trials: 4,
            deviation: 0.1,
            scatter: 0.0,
            limit: 4.0,
        };
        let monitor = SpecimenMonitor { effort: 1, motion: 0, reversal: 0.2, checks: alloc::vec![check] };
        let at = |level: f64, height: f64| Loops { count: 1.0, level, height, ..Loops::default() };
        let near = monitor.deviation(&at(7.0, 2.0), &[]).unwrap();
        assert!(
            (near.excess - 10.0 / 1.25_f64.sqrt() / 4.0).abs() < 1e-12
                && near.quantity == LoopQuantity::Height
        );
        // Four standard deviations of the level away: 1.4 expected, variance 0.01 (1.25 + 0.25 4^2).
        let far = monitor.deviation(&at(15.0, 2.8), &[]).unwrap();
        assert!((far.expected - 1.8).abs() < 1e-12, "{far:?}");
        assert!((far.excess - 10.0 / 5.25_f64.sqrt() / 4.0).abs() < 1e-12, "{far:?}");
        assert!(monitor.deviation(&Loops::default(), &[]).is_none());
    }
}
