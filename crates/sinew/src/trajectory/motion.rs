//! Trajectories of the joints, and sequences of them, which are trajectories again.

use super::joint_path::JointPath;
use super::minimum_jerk::MinimumJerk;
use super::reference::Reference;
use super::time_law::TimeLaw;
use crate::error::{Error, within};
use alloc::vec::Vec;

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
    /// Duration from rest to rest, s.
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

    /// Its initial pose, rad or m: `[joints]`.
    ///
    /// # Errors
    /// As [`sample`](Self::sample).
    pub fn first(&self) -> Result<Vec<f64>, Error> {
        let mut first = Reference::new(self.joints());
        self.sample(0.0, &mut first)?;
        Ok(first.q)
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
    /// q' = q_th th',     q'' = q_th th'' + q_thth th'^2          along a path: th phase, q_th = dq/dth
    /// ```
    ///
    /// # Errors
    /// [`Error::WrongLength`] where `out` has another number of joints.
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

/// Motions from rest to rest in sequence, with pauses between them.
///
/// ```text
/// t_i <= t < t_i + T_i       q(t) = q_i(t - t_i)
/// t_i + T_i <= t < t_(i+1)   q(t) = q_i(T_i),   q' = 0,   q'' = 0
/// ```
///
/// | symbol | meaning                            | unit |
/// |--------|------------------------------------|------|
/// | t_i    | start of a motion, increasing        | s    |
/// | T_i    | its duration, without the pause      | s    |
/// | q_i    | its joints, at rest at 0 and at T_i  | rad or m |
///
/// Before the first motion the robot rests in its initial pose.
///
/// # Source
/// Textbook.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    starts: Vec<f64>,
    motions: Vec<Trajectory>,
    duration: f64,
}

/// Largest gap between the end of a motion and the start of the next, rad or m.
const GAP_TOLERANCE: f64 = 1e-6;

/// Largest overlap of two motions, s: rounding of times.
const OVERLAP_TOLERANCE: f64 = 1e-9;

impl Sequence {
    /// Motions with their start times, s; `duration`, s, includes all pauses.
    ///
    /// # Errors
    /// [`Error::WrongLength`] without a motion or for different numbers of joints; [`Error::OutOfDomain`] for
    /// a motion that starts before 0, before the one before it ends, or in another pose, and for a duration
    /// that ends before the last motion.
    pub fn new(motions: Vec<(f64, Trajectory)>, duration: f64) -> Result<Self, Error> {
        let (starts, motions): (Vec<f64>, Vec<Trajectory>) = motions.into_iter().unzip();
        let Some(joints) = motions.first().map(Trajectory::joints) else {
            return Err(Error::WrongLength { name: "motions", expected: 1, got: 0 });
        };
        let (mut end, mut initial, mut last) = (0.0, Reference::new(joints), Reference::new(joints));
        for (k, (&start, motion)) in starts.iter().zip(&motions).enumerate() {
            within(
                "start of a motion",
                "not before the one before ends",
                start,
                start >= end - OVERLAP_TOLERANCE,
            )?;
            motion.sample(0.0, &mut initial)?;
            let gap = initial.q.iter().zip(&last.q).fold(0.0_f64, |gap, (a, b)| gap.max((a - b).abs()));
            within(
                "start of a motion",
                "within 1e-6 of where the one before ends",
                gap,
                k == 0 || gap < GAP_TOLERANCE,
            )?;
            motion.sample(motion.duration(), &mut last)?;
            end = start + motion.duration();
        }
        within(
            "duration",
            "not over before the last motion",
            duration,
            duration.is_finite() && duration >= end - OVERLAP_TOLERANCE,
        )?;
        Ok(Self { starts, motions, duration })
    }

    /// Duration with all pauses, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Motions with their start times, s.
    pub fn motions(&self) -> impl Iterator<Item = (f64, &Trajectory)> {
        self.starts.iter().copied().zip(&self.motions)
    }

    /// Number of joints.
    fn joints(&self) -> usize {
        self.motions[0].joints()
    }

    /// Every motion rests after its end, so that the last one that has started determines the reference.
    fn sample(&self, time: f64, out: &mut Reference) -> Result<(), Error> {
        let active = self.starts.partition_point(|start| *start <= time).max(1) - 1;
        self.motions[active].sample(time - self.starts[active], out)
    }
}
