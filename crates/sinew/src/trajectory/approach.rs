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
/// | f       | [`PACE`]; joints that the motion leaves alone move as slowly as the others | 1 |
/// | s_0     | [`SLOWEST`], for motions that nearly stand still               | 1/s     |
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
        let ranges: Vec<f64> =
            finite_ranges(robot, standing)?.iter().map(|[low, high]| high - low).collect();
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::{JointWaypoint, through_joint_waypoints};
    use alloc::vec;

    /// Two hinges with ranges of 2 rad and of 0.5 rad.
    fn robot() -> Robot {
        let text = include_str!("../../../../models/planar_leg.toml");
        let mut parts = crate::description::from_toml("planar_leg.toml", text).unwrap().parts;
        parts.joints[0].range = Some([-1.0, 1.0]);
        parts.joints[1].range = Some([0.0, 0.5]);
        Robot::new(parts).unwrap()
    }

    fn motion() -> Trajectory {
        Trajectory::PointToPoint(MinimumJerk::new(&[0.2, 0.1], &[0.8, 0.1], 1.5).unwrap())
    }

    #[test]
    fn a_joint_takes_a_quarter_of_the_pace_of_the_motion_whether_it_moves_in_it_or_not() {
        // 1.875 x 0.6 rad/1.5 s in a range of 2 rad.
        let pace = 0.25 * 0.375;
        for (standing, moved, range) in [([-0.8, 0.1], 1.0, 2.0), ([0.2, 0.5], 0.4, 0.5)] {
            let approach = Approach::new(&robot(), &motion(), &standing).unwrap();
            let expected = 1.875 * moved / (pace * range);
            assert!((approach.duration() / expected - 1.0).abs() < 1e-4, "{} {expected}", approach.duration());
            let (mut now, mut soon) = (Reference::new(2), Reference::new(2));
            approach.sample(0.5 * expected, 0.1, &mut now, &mut soon);
            let fastest = now.v.iter().map(|v| v.abs()).fold(0.0, f64::max);
            assert!((fastest / (pace * range) - 1.0).abs() < 1e-3, "{fastest}");
            approach.sample(expected, 0.1, &mut now, &mut soon);
            assert!(now.q.iter().zip([0.2, 0.1]).all(|(q, first)| (q - first).abs() < 1e-12));
        }
    }

    #[test]
    fn it_begins_anew_wherever_the_machine_is_and_is_over_at_once_in_the_first_pose() {
        let mut approach = Approach::new(&robot(), &motion(), &[0.2, 0.1]).unwrap();
        assert!(approach.duration().abs() < 1e-18 && approach.motion().is_none());
        approach.begin(&[0.2, 0.1 + 1e-3]);
        assert!((approach.duration() - SHORTEST).abs() < 1e-12, "not shorter than that");
        approach.begin(&[-0.7, 0.3]);
        let (mut now, mut soon) = (Reference::new(2), Reference::new(2));
        approach.sample(0.0, approach.duration(), &mut now, &mut soon);
        assert_eq!((&now.q[..], &now.v[..]), (&[-0.7, 0.3][..], &[0.0; 2][..]));
        assert!(soon.q.iter().zip([0.2, 0.1]).all(|(q, first)| (q - first).abs() < 1e-12));
        approach.rest(&mut now, &mut soon);
        assert_eq!((&now.q[..], &soon.q[..]), (&[-0.7, 0.3][..], &[-0.7, 0.3][..]));
    }

    #[test]
    fn a_machine_that_is_found_nearly_where_it_is_taken_to_stand_is_taken_to_stand_there() {
        let mut approach = Approach::new(&robot(), &motion(), &[0.2, 0.1]).unwrap();
        let (mut now, mut soon) = (Reference::new(2), Reference::new(2));
        // 2 % of ranges of 2 rad and 0.5 rad.
        for (found, at) in [
            ([0.239, 0.109], [0.2, 0.1]),
            ([0.241, 0.1], [0.241, 0.1]),
            ([0.2, 0.111], [0.2, 0.111]),
            ([0.161, 0.091], [0.2, 0.1]),
        ] {
            approach.found_at(&found);
            approach.rest(&mut now, &mut soon);
            assert_eq!(now.q, at, "{found:?}");
            assert_eq!(approach.motion().is_none(), at == [0.2, 0.1]);
        }
    }

    #[test]
    fn a_motion_that_stands_still_is_approached_too() {
        let still = |time| JointWaypoint { time, q: vec![0.2, 0.1] };
        let motion = through_joint_waypoints(&[still(0.0), still(1.0)]).unwrap();
        let approach = Approach::new(&robot(), &motion, &[0.5, 0.1]).unwrap();
        assert!((approach.duration() - 1.875 * 0.3 / (0.02 * 2.0)).abs() < 1e-9, "{}", approach.duration());
    }
}
