use super::joint_path::JointPath;
use super::sequence::Sequence;
use super::time_law::{TimeLaw, curvature, quintic, slope};
use crate::error::{Error, finite, positive};
use alloc::vec;
use alloc::vec::Vec;

/// Reference of the joints at a time: `[joints]` each.
#[derive(Debug, Clone, PartialEq)]
pub struct Reference {
    /// Pose, rad or m.
    pub q: Vec<f64>,
    /// Velocity, per s.
    pub v: Vec<f64>,
    /// Acceleration, per s^2.
    pub a: Vec<f64>,
}

impl Reference {
    /// At rest at zero.
    #[must_use]
    pub fn new(joints: usize) -> Self {
        Self { q: vec![0.0; joints], v: vec![0.0; joints], a: vec![0.0; joints] }
    }
}

/// Minimum-jerk motion between two poses along a straight line in joint space.
///
/// ```text
/// q = q_0 + (q_1 - q_0) u(t/T),     u(x) = 10 x^3 - 15 x^4 + 6 x^5
/// ```
///
/// # Source
/// `flash1985`: the motion of least mean square jerk in that time.
#[derive(Debug, Clone, PartialEq)]
pub struct MinimumJerk {
    from: Vec<f64>,
    to: Vec<f64>,
    duration: f64,
}

impl MinimumJerk {
    /// From a pose to a pose in `duration` seconds.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for poses of different robots, [`Error::OutOfDomain`] for a pose that is not
    /// finite or a duration that is not positive.
    pub fn new(from: &[f64], to: &[f64], duration: f64) -> Result<Self, Error> {
        if from.len() != to.len() {
            return Err(Error::WrongLength { name: "to", expected: from.len(), got: to.len() });
        }
        from.iter().chain(to).try_for_each(|&q| finite("pose", q).map(drop))?;
        positive("duration", duration)?;
        Ok(Self { from: from.to_vec(), to: to.to_vec(), duration })
    }

    fn sample(&self, time: f64, out: &mut Reference) {
        let x = if time > 0.0 { (time / self.duration).min(1.0) } else { 0.0 };
        let t = self.duration;
        let [p, v, a] = [quintic(x), slope(x) / t, curvature(x) / (t * t)];
        for (k, (from, to)) in self.from.iter().zip(&self.to).enumerate().take(out.q.len()) {
            let span = to - from;
            (out.q[k], out.v[k], out.a[k]) = (from + span * p, span * v, span * a);
        }
    }
}

/// A reference trajectory of the joints, from rest to rest.
#[derive(Debug, Clone, PartialEq)]
pub enum Trajectory {
    /// Along a joint path, by a time law.
    AlongPath {
        /// The joints over the phase.
        joints: JointPath,
        /// The phase over time.
        law: TimeLaw,
    },
    /// Between two poses.
    PointToPoint(MinimumJerk),
    /// Several motions in sequence.
    Sequence(Sequence),
}

impl Trajectory {
    /// From rest to rest, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        match self {
            Self::AlongPath { law, .. } => law.duration(),
            Self::PointToPoint(motion) => motion.duration,
            Self::Sequence(motions) => motions.duration(),
        }
    }

    /// Number of joints.
    #[must_use]
    pub fn joints(&self) -> usize {
        match self {
            Self::AlongPath { joints, .. } => joints.spline.width(),
            Self::PointToPoint(motion) => motion.from.len(),
            Self::Sequence(motions) => motions.joints(),
        }
    }

    /// Whether it ends in its initial pose, within 1e-6 rad or m: only then it can be repeated without a
    /// jump.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        let [mut first, mut last] = [self.joints(); 2].map(Reference::new);
        let sampled = self.sample(0.0, &mut first).and_then(|()| self.sample(self.duration(), &mut last));
        sampled.is_ok() && first.q.iter().zip(&last.q).all(|(a, b)| (a - b).abs() < 1e-6)
    }

    /// The reference at a time, s; at rest before 0 and after the end. Does not allocate.
    ///
    /// ```text
    /// q' = q_th th',     q'' = q_th th'' + q_thth th'^2
    /// ```
    ///
    /// # Errors
    /// [`Error::WrongLength`] where `out` is another robot's.
    pub fn sample(&self, time: f64, out: &mut Reference) -> Result<(), Error> {
        let expected = self.joints();
        for (name, got) in [("q", out.q.len()), ("v", out.v.len()), ("a", out.a.len())] {
            if got != expected {
                return Err(Error::WrongLength { name, expected, got });
            }
        }
        match self {
            Self::AlongPath { joints, law } => {
                let now = law.at(time);
                joints.spline.at(now.phase, &mut out.q, &mut out.v, &mut out.a);
                for (v, a) in out.v.iter_mut().zip(&mut out.a) {
                    *a = *v * now.acceleration + *a * now.rate * now.rate;
                    *v *= now.rate;
                }
            }
            Self::PointToPoint(motion) => motion.sample(time, out),
            Self::Sequence(motions) => motions.sample(time, out)?,
        }
        Ok(())
    }
}
