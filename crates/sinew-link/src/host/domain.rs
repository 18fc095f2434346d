//! What set-points a machine accepts.

use crate::wire::{MAX_JOINTS, MAX_MUSCLES, features};
use crate::{Command, Error, Rejection, SetpointKind};

/// Number of joints and muscles of a machine, and the ranges of its set-points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Domain {
    /// Name of the machine.
    pub name: String,
    /// Range of every independent joint, rad or m.
    pub joint: Vec<[f64; 2]>,
    /// Range of every muscle's length, m.
    pub muscle_length: Vec<[f64; 2]>,
    /// Range of every muscle's tension at the anchor, N; as many as muscles.
    pub tension: Vec<[f64; 2]>,
    /// Box of the end point in the world, m; none where the machine has no end point.
    pub end_point: Option<[[f64; 2]; 3]>,
}

impl Domain {
    /// Checks that the machine fits in the packets.
    ///
    /// # Errors
    /// [`Error::Size`] names what does not.
    pub fn validate(&self) -> Result<(), Error> {
        let size = |name, expected, got, fits: bool| {
            if fits { Ok(()) } else { Err(Error::Size { name, expected, got }) }
        };
        let [joints, muscles] = self.dimensions();
        size("joints", "at most 64", joints, joints <= MAX_JOINTS)?;
        size("muscles", "at most 128", muscles, muscles <= MAX_MUSCLES)?;
        let lengths = self.muscle_length.len();
        size("muscle lengths", "as many as tensions, or none", lengths, lengths == 0 || lengths == muscles)
    }

    /// Number of joints and muscles.
    #[must_use]
    pub fn dimensions(&self) -> [usize; 2] {
        [self.joint.len(), self.tension.len()]
    }

    /// Bits of [`Welcome::features`](crate::wire::Welcome::features) for its set-points.
    #[must_use]
    pub fn features(&self) -> u32 {
        let bit = |present: bool, bit| if present { bit } else { 0 };
        bit(!self.joint.is_empty(), features::JOINT)
            | bit(!self.muscle_length.is_empty(), features::MUSCLE_LENGTH)
            | bit(!self.tension.is_empty(), features::TENSION)
            | bit(self.end_point.is_some(), features::END_POINT)
    }

    /// Ranges of the numbers of a set-point; empty where the machine does not accept its kind.
    fn ranges(&self, kind: SetpointKind) -> &[[f64; 2]] {
        match kind {
            SetpointKind::None => &[],
            SetpointKind::Joint => &self.joint,
            SetpointKind::MuscleLength => &self.muscle_length,
            SetpointKind::Tension => &self.tension,
            SetpointKind::EndPoint => self.end_point.as_ref().map_or(&[], |ranges| ranges),
        }
    }

    /// Checks counts and ranges of a command's set-points.
    ///
    /// # Errors
    /// The first reason that applies.
    pub fn check(&self, command: &Command) -> Result<(), Rejection> {
        let setpoints = &command.setpoints;
        let ranges = self.ranges(setpoints.kind());
        if setpoints.values() != ranges.len() {
            return Err(Rejection::Count);
        }
        let inside = |numbers: &[f64]| {
            numbers.iter().zip(ranges).all(|(x, [low, high])| x.is_finite() && low <= x && x <= high)
        };
        if setpoints.iter().all(|(_, numbers)| inside(numbers)) { Ok(()) } else { Err(Rejection::OutOfRange) }
    }
}
