use super::minimum_jerk::MinimumJerk;
use super::motion::Trajectory;
use super::ranges::finite_ranges;
use super::reference::Reference;
use crate::body::Robot;
use crate::error::{Error, check_length};
use alloc::vec::Vec;

/// The way to a motion's first pose, from wherever a machine stands: minimum jerk, slower than the motion.
///
/// ```text
/// |q'_k| <= s r_k,   s = max(f max_k max_t |q'_k(t)|/r_k, s_0)
/// ```
///
/// | symbol  | meaning                                                     | unit    |
/// |---------|-------------------------------------------------------------|---------|
/// | q_k(t)  | motion of joint k                                           | rad, m  |
/// | r_k     | its range                                                   | rad, m  |
/// | f       | 0.25; joints that the motion leaves alone move as slowly as the others | 1 |
/// | s_0     | 0.02, for motions that nearly stand still                      | 1/s     |
///
/// # Source
/// Our own.
#[derive(Debug, Clone)]
pub struct Approach {
    /// Where the machine is taken to stand: `[joints]`.
    standing: Vec<f64>,
    way: MinimumJerk,
    /// Of the joints, rad or m: `[joints]`.
    ranges: Vec<f64>,
    /// `s`, 1/s.
    pace: f64,
}

/// `f`.
const PACE: f64 = 0.25;
/// `s_0`, 1/s.
const SLOWEST: f64 = 0.02;
/// Largest speed of a minimum-jerk motion, as a multiple of its mean speed.
const PEAK: f64 = 1.875;
/// Fraction of a range within which a joint stands where it is taken to: zeros of encoders are not known
/// better.
const THERE: f64 = 0.02;
/// Shortest approach, s.
const SHORTEST: f64 = 1.0;
/// Intervals between the samples of a motion among which its largest speeds are searched.
const SAMPLES: usize = 500;

impl Approach {
    /// To the beginning of a motion, from a pose in which the machine is taken to stand.
    ///
    /// # Shapes
    /// `standing: [joints]`, rad or m.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for another robot; as [`finite_ranges`] and [`Trajectory::sample`].
    pub fn new(robot: &Robot, trajectory: &Trajectory, standing: &[f64]) -> Result<Self, Error> {
        let joints = trajectory.joints();
        check_length("pose before a motion", standing.len(), joints)?;
        let ranges: Vec<f64> = finite_ranges(robot, standing)?.iter().map(|[low, high]| high - low).collect();
        let (mut reference, mut pace) = (Reference::new(joints), 0.0_f64);
        for k in 0..=SAMPLES {
            trajectory.sample(trajectory.duration() * k as f64 / SAMPLES as f64, &mut reference)?;
            let moving = reference.v.iter().zip(&ranges).filter(|(_, range)| **range > 0.0);
            pace = moving.map(|(v, range)| v.abs() / range).fold(pace, f64::max);
        }
        let way = MinimumJerk::new(standing, &trajectory.first()?, SHORTEST)?;
        let pace = (PACE * pace).max(SLOWEST);
        let mut approach = Self { standing: standing.to_vec(), way, ranges, pace };
        approach.begin(standing);
        Ok(approach)
    }

    /// Its duration, s; 0 where it begins in the motion's first pose.
    #[must_use]
    pub fn duration(&self) -> f64 {
        if self.way.from == self.way.to { 0.0 } else { self.way.duration }
    }

    /// From a pose in which the machine is found: `[joints]`; from where it is taken to stand if that is
    /// what it looks like. Nothing is allocated.
    pub fn found_at(&mut self, pose: &[f64]) {
        let mut joints = pose.iter().zip(&self.standing).zip(&self.ranges);
        if joints.any(|((pose, standing), range)| (pose - standing).abs() > THERE * range) {
            self.begin(pose);
        } else {
            self.way.from.copy_from_slice(&self.standing);
            self.set_duration();
        }
    }

    /// From a pose: `[joints]`. Nothing is allocated.
    pub fn begin(&mut self, from: &[f64]) {
        self.way.from.copy_from_slice(from);
        self.set_duration();
    }

    fn set_duration(&mut self) {
        let MinimumJerk { from, to, duration } = &mut self.way;
        let ways = from.iter().zip(to).zip(&self.ranges);
        // A joint without a range is where it has to be.
        let times = ways.map(|((from, to), range)| PEAK * (*to - from).abs() / (self.pace * range));
        *duration = times.filter(|time| time.is_finite()).fold(SHORTEST, f64::max);
    }

    /// The reference at a time since it began, s, and the one `horizon` s later. Nothing is allocated.
    pub fn sample(&self, time: f64, horizon: f64, current: &mut Reference, previewed: &mut Reference) {
        self.way.sample(time, current);
        self.way.sample(time + horizon, previewed);
    }

    /// At rest where it begins. Nothing is allocated.
    pub fn rest(&self, current: &mut Reference, previewed: &mut Reference) {
        for reference in [current, previewed] {
            reference.q.copy_from_slice(&self.way.from);
            reference.v.fill(0.0);
            reference.a.fill(0.0);
        }
    }

    /// As a motion of its own, from where it begins at present; none where there is no way to go.
    #[must_use]
    pub fn motion(&self) -> Option<Trajectory> {
        (self.duration() > 0.0).then(|| Trajectory::PointToPoint(self.way.clone()))
    }
}
