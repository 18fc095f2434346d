use super::motion::{Reference, Trajectory};
use crate::error::{Error, within};
use alloc::vec::Vec;

/// Motions from rest to rest one after the other, with waits between.
///
/// ```text
/// t_i <= t < t_i + T_i       q(t) = q_i(t - t_i)
/// t_i + T_i <= t < t_(i+1)   q(t) = q_i(T_i),   q' = 0,   q'' = 0
/// ```
///
/// | symbol | meaning                            | unit |
/// |--------|------------------------------------|------|
/// | t_i    | start of a motion, rising            | s    |
/// | q_i    | its joints, at rest at 0 and at T_i  |      |
///
/// Before the first motion the robot waits where it begins.
///
/// # Source
/// Textbook.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    starts: Vec<f64>,
    motions: Vec<Trajectory>,
    duration: f64,
}

/// What a motion may begin away from where the one before ended, rad or m.
const TOGETHER: f64 = 1e-6;

/// What a motion may begin before the one before ended, s: rounding of times.
const OVERLAP: f64 = 1e-9;

impl Sequence {
    /// Motions with their starts, s, of `duration` seconds with all waits.
    ///
    /// # Errors
    /// [`Error::WrongLength`] for none, or motions of different robots; [`Error::OutOfDomain`] for one that begins before
    /// the one before it ends, or elsewhere, and for a duration that is over before the last.
    pub fn new(motions: Vec<(f64, Trajectory)>, duration: f64) -> Result<Self, Error> {
        let (starts, motions): (Vec<f64>, Vec<Trajectory>) = motions.into_iter().unzip();
        let Some(joints) = motions.first().map(Trajectory::joints) else {
            return Err(Error::WrongLength { name: "motions", expected: 1, got: 0 });
        };
        let (mut end, mut here, mut there) = (0.0, Reference::new(joints), Reference::new(joints));
        for (k, (&start, motion)) in starts.iter().zip(&motions).enumerate() {
            within("start of a motion", "not before the one before ends", start, start >= end - OVERLAP)?;
            motion.sample(0.0, &mut here)?;
            let gap = here.q.iter().zip(&there.q).fold(0.0_f64, |gap, (a, b)| gap.max((a - b).abs()));
            within(
                "start of a motion",
                "within 1e-6 of where the one before ends",
                gap,
                k == 0 || gap < TOGETHER,
            )?;
            motion.sample(motion.duration(), &mut there)?;
            end = start + motion.duration();
        }
        within(
            "duration",
            "not over before the last motion",
            duration,
            duration.is_finite() && duration >= end - OVERLAP,
        )?;
        Ok(Self { starts, motions, duration })
    }

    /// From the first rest to the last, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Motions and their starts, s.
    pub fn motions(&self) -> impl Iterator<Item = (f64, &Trajectory)> {
        self.starts.iter().copied().zip(&self.motions)
    }

    /// Number of joints.
    pub(super) fn joints(&self) -> usize {
        self.motions[0].joints()
    }

    /// Every motion rests after its end, so that the last that has begun says where the joints are.
    pub(super) fn sample(&self, time: f64, out: &mut Reference) -> Result<(), Error> {
        let begun = self.starts.partition_point(|start| *start <= time).max(1) - 1;
        self.motions[begun].sample(time - self.starts[begun], out)
    }
}
