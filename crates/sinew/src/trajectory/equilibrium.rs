use super::check::first_unreachable;
use super::controllable::ControllableMotion;
use super::joint_path::JointPath;
use super::motion::{Sequence, Trajectory};
use super::ranges::independent_ranges;
use super::reference::Reference;
use super::spline::Spline;
use super::time_law::TimeLaw;
use super::unreached::{UnreachedCause, UnreachedPoint};
use crate::body::Robot;
use crate::error::{Error, check_length};
use alloc::vec;
use alloc::vec::Vec;

/// Poses and motions of a machine with fewer motors than joints: where its joints stand when its cables have
/// given lengths.
///
/// ```text
/// q(s) = argmin V(q)   subject to   l(q) = y(s),   low <= q <= high        V: springs and gravity
/// dV/dq = R^T F at the joints that are not at a stop
/// ```
///
/// Solved by Newton's method with the joints at stops as active set, from pose to neighbouring pose. By
/// length, never by tension: a finger that snaps at a given tension may stand at every length of its cable.
///
/// # Assumes
/// As [`ControllableMotion`]. Where muscles share a direction, their tensions of least norm.
///
/// # Source
/// Equilibrium of elastic mechanisms under constraints; the active set is textbook.
#[derive(Debug, Clone)]
pub struct Equilibrium {
    motion: ControllableMotion,
    ranges: Vec<[f64; 2]>,
    stopped: Vec<bool>,
    tension: Vec<f64>,
    step: Vec<f64>,
    names: Vec<alloc::string::String>,
}

/// Steps of Newton's method and of changes of the active set; where it has converged, rad or m.
const ITERATIONS: usize = 80;
const CONVERGED: f64 = 1e-10;
/// Longest step of a joint, rad or m.
const LONGEST_STEP: f64 = 0.2;
/// Length of a cable by which a pose may miss it, m.
const LENGTH_TOLERANCE: f64 = 1e-8;
/// Torque by which a stop may pull, Nm or N.
const STOP_TOLERANCE: f64 = 1e-9;
/// Knots of a motion.
const KNOTS: usize = 360;

impl Equilibrium {
    /// Of a robot whose cables leave joints to its springs; none where they hold all joints.
    ///
    /// # Errors
    /// As [`ControllableMotion::new`] and [`independent_ranges`].
    pub fn new(robot: &Robot) -> Result<Option<Self>, Error> {
        let Some(motion) = ControllableMotion::new(robot)? else { return Ok(None) };
        let joints = robot.independent_joints();
        Ok(Some(Self {
            motion,
            ranges: independent_ranges(robot)?,
            stopped: vec![false; joints.len()],
            tension: vec![0.0; robot.parts().tendons.len()],
            step: vec![0.0; joints.len()],
            names: joints.into_iter().map(|joint| robot.parts().joints[joint].name.clone()).collect(),
        }))
    }

    /// Moves a pose, rad or m, `[joints]`, to the equilibrium with the lengths that the cables have in it;
    /// the reason where there is none nearby.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for the pose of another robot; [`Error::EntryOutOfDomain`] where it is not
    /// finite.
    pub fn settle(&mut self, q: &mut [f64]) -> Result<Option<UnreachedCause>, Error> {
        check_length("pose", q.len(), self.ranges.len())?;
        self.stopped.fill(false);
        self.tension.fill(0.0);
        self.motion.set_stopped(self.stopped.iter().copied());
        self.motion.evaluate(q, &self.tension)?;
        let lengths = self.motion.lengths().to_vec();
        self.follow(&lengths, q)
    }

    /// The controllable motion in the pose found last.
    #[must_use]
    pub fn motion(&self) -> &ControllableMotion {
        &self.motion
    }

    /// Tensions at the anchors in it, N: `[muscles]`.
    #[must_use]
    pub fn tension(&self) -> &[f64] {
        &self.tension
    }

    /// From a neighbouring pose to the equilibrium with these lengths, m: `[muscles]`.
    fn follow(&mut self, lengths: &[f64], q: &mut [f64]) -> Result<Option<UnreachedCause>, Error> {
        for _ in 0..ITERATIONS {
            self.motion.set_stopped(self.stopped.iter().copied());
            self.motion.evaluate(q, &self.tension)?;
            self.motion.balance(&mut self.tension);
            self.motion.step_to(lengths, &mut self.step);
            let size = self.step.iter().fold(0.0_f64, |most, step| most.max(step.abs()));
            let fraction = (LONGEST_STEP / size.max(1e-30)).min(1.0);
            let mut reached_stop = false;
            let moved = q.iter_mut().zip(&mut self.stopped).zip(self.step.iter().zip(&self.ranges));
            for ((q, stopped), (step, [low, high])) in moved.filter(|((_, stopped), _)| !**stopped) {
                let next = *q + fraction * step;
                *q = next.max(*low).min(*high);
                *stopped = (next - *q).abs() > CONVERGED;
                reached_stop |= *stopped;
            }
            if reached_stop || size > CONVERGED {
                continue;
            }
            if let Some(joint) = self.leaves_stop(q) {
                self.stopped[joint] = false;
                continue;
            }
            return Ok(self.fault(lengths));
        }
        Ok(Some(self.snaps()))
    }

    /// The joint that springs and cables pull away from its stop most.
    fn leaves_stop(&mut self, q: &[f64]) -> Option<usize> {
        self.motion.unbalanced(&self.tension, &mut self.step);
        let away = |j: usize| if q[j] <= self.ranges[j][0] { -self.step[j] } else { self.step[j] };
        let pulled = (0..q.len()).filter(|&j| self.stopped[j] && away(j) > STOP_TOLERANCE);
        pulled.max_by(|a, b| away(*a).total_cmp(&away(*b)))
    }

    fn fault(&self, lengths: &[f64]) -> Option<UnreachedCause> {
        if !self.motion.is_followable() {
            return Some(self.snaps());
        }
        let missed = self.motion.lengths().iter().zip(lengths).any(|(a, b)| (a - b).abs() > LENGTH_TOLERANCE);
        let stopped = || self.names.iter().zip(&self.stopped).filter(|(_, stopped)| **stopped);
        missed.then(|| UnreachedCause::OtherPose(stopped().map(|(name, _)| name.clone()).collect()))
    }

    fn snaps(&self) -> UnreachedCause {
        let (stiffness, joint) = self.motion.least_stiffness().unwrap_or((0.0, 0));
        UnreachedCause::Snaps { joint: self.names[joint].clone(), stiffness }
    }

    /// The motion in which the cables have the lengths that they have in another one of the joints.
    ///
    /// # Errors
    /// As [`settle`](Self::settle) and [`Spline::natural`].
    pub fn along(&mut self, motion: &Trajectory) -> Result<Trajectory, Error> {
        let n = self.ranges.len();
        match motion {
            Trajectory::AlongPath { joints, law } => {
                let spline = &joints.spline;
                let joints = self.path(spline.end(), spline.is_closed(), |s| joints.pose(s))?;
                Ok(Trajectory::AlongPath { joints, law: *law })
            }
            Trajectory::PointToPoint(straight) => {
                let [from, to] = [0.0, straight.duration].map(|time| {
                    let mut reference = Reference::new(n);
                    straight.sample(time, &mut reference);
                    reference.q
                });
                let at = |s: f64| from.iter().zip(&to).map(|(from, to)| from + s * (to - from)).collect();
                let joints = self.path(1.0, false, at)?;
                Ok(Trajectory::AlongPath { joints, law: TimeLaw::minimum_jerk(1.0, straight.duration)? })
            }
            Trajectory::Sequence(motions) => {
                let mut found = Vec::new();
                for (start, motion) in motions.motions() {
                    let motion = self.along(motion)?;
                    let (lost, end) = (first_unreachable(&motion).is_some(), start + motion.duration());
                    found.push((start, motion));
                    if lost {
                        return Ok(Trajectory::Sequence(Sequence::new(found, end)?));
                    }
                }
                Ok(Trajectory::Sequence(Sequence::new(found, motions.duration())?))
            }
        }
    }

    /// The path with the lengths of the cables along poses over `[0, end]`.
    fn path(&mut self, end: f64, closed: bool, given: impl Fn(f64) -> Vec<f64>) -> Result<JointPath, Error> {
        let n = self.ranges.len();
        let pieces = if closed { KNOTS } else { KNOTS - 1 };
        let phases: Vec<f64> = (0..KNOTS).map(|k| end * k as f64 / pieces as f64).collect();
        let (mut poses, mut q, mut lost) = (vec![0.0; KNOTS * n], given(0.0), None);
        for (k, (&phase, row)) in phases.iter().zip(poses.chunks_exact_mut(n)).enumerate() {
            if lost.is_none() {
                let cause = if k == 0 {
                    self.settle(&mut q)?
                } else {
                    self.motion.evaluate(&given(phase), &self.tension)?;
                    let lengths = self.motion.lengths().to_vec();
                    self.follow(&lengths, &mut q)?
                };
                lost = cause.map(|cause| UnreachedPoint { phase, distance: 0.0, cause });
            }
            row.copy_from_slice(&q);
        }
        let spline =
            if closed { Spline::periodic(&phases, &poses, end)? } else { Spline::natural(&phases, &poses)? };
        Ok(JointPath { first_unreached: lost, ..JointPath::along(spline) })
    }
}
