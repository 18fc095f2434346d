use crate::error::{Error, check_length, non_negative, within};
use crate::trajectory::{Reference, Trajectory};
use alloc::vec;
use alloc::vec::Vec;

/// Limits of references of the joints: `[joints]` each.
#[derive(Debug, Clone, PartialEq)]
pub struct JointLimits {
    /// Range, rad or m: lower and upper bound, finite.
    pub range: Vec<[f64; 2]>,
    /// Largest speed, rad/s or m/s, >= 0.
    pub speed: Vec<f64>,
    /// Largest acceleration, rad/s^2 or m/s^2, >= 0.
    pub acceleration: Vec<f64>,
}

/// Intervals between the samples of a motion among which its largest speeds and accelerations are searched.
const SAMPLES: usize = 2000;

impl JointLimits {
    /// Checks lengths and numbers.
    ///
    /// # Errors
    /// [`Error::WrongLength`], [`Error::OutOfDomain`] name the field.
    pub fn validate(&self) -> Result<(), Error> {
        let joints = self.range.len();
        check_length("speed limits", self.speed.len(), joints)?;
        check_length("acceleration limits", self.acceleration.len(), joints)?;
        for [low, high] in &self.range {
            within(
                "joint range",
                "finite, from low to high",
                high - low,
                (high - low).is_finite() && low <= high,
            )?;
        }
        self.speed.iter().try_for_each(|v| non_negative("speed limit", *v).map(drop))?;
        self.acceleration.iter().try_for_each(|a| non_negative("acceleration limit", *a).map(drop))
    }

    /// Limits from a motion that the machine is known to track: the largest speed and acceleration of every
    /// joint in it, with the given ranges.
    ///
    /// # Shapes
    /// `range: [joints]`, rad or m.
    ///
    /// # Errors
    /// As [`Trajectory::sample`] and [`validate`](Self::validate).
    pub fn of_motion(trajectory: &Trajectory, range: Vec<[f64; 2]>) -> Result<Self, Error> {
        let joints = trajectory.joints();
        let mut limits = Self { range, speed: vec![0.0; joints], acceleration: vec![0.0; joints] };
        let mut reference = Reference::new(joints);
        for k in 0..=SAMPLES {
            trajectory.sample(trajectory.duration() * k as f64 / SAMPLES as f64, &mut reference)?;
            for (most, v) in limits.speed.iter_mut().zip(&reference.v) {
                *most = most.max(v.abs());
            }
            for (most, a) in limits.acceleration.iter_mut().zip(&reference.a) {
                *most = most.max(a.abs());
            }
        }
        limits.validate()?;
        Ok(limits)
    }
}
