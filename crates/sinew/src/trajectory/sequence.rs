use super::motion::{Reference, Trajectory};
use crate::error::{Error, within};
use alloc::vec::Vec;

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
/// | q_i    | its joints, at rest at 0 and at T_i  |      |
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
    /// [`Error::WrongLength`] for none, or motions of different robots; [`Error::OutOfDomain`] for motions
    /// that overlap or do not join, and for a duration shorter than the last motion needs.
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
    pub(super) fn joints(&self) -> usize {
        self.motions[0].joints()
    }

    /// Every motion rests after its end, so that the last one that has started determines the reference.
    pub(super) fn sample(&self, time: f64, out: &mut Reference) -> Result<(), Error> {
        let active = self.starts.partition_point(|start| *start <= time).max(1) - 1;
        self.motions[active].sample(time - self.starts[active], out)
    }
}
