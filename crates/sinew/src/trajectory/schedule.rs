use super::motion::Trajectory;
use super::reference::Reference;
use crate::Error;
use crate::error::non_negative;

/// A trajectory that is repeated between two rests.
///
/// ```text
/// rest [0, before)   repeats [before, before + n d)   rest [.., + after]
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Schedule<'a> {
    trajectory: &'a Trajectory,
    repeats: u32,
    before: f64,
    after: f64,
}

/// Where a time lies in a [`Schedule`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Since the start of the schedule, s.
    pub time: f64,
    /// Index of the repeat; none at rest before and after.
    pub repeat: Option<u32>,
    /// Since the present repeat began, s; none at rest.
    pub repeat_time: Option<f64>,
    /// Since the end of the last repeat, s; 0 before.
    pub rested: f64,
}

impl<'a> Schedule<'a> {
    /// `repeats` of a trajectory, after a rest of `before` and followed by a rest of `after`, s.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] where an open trajectory is to be repeated, and for rests below 0.
    pub fn new(trajectory: &'a Trajectory, repeats: u32, before: f64, after: f64) -> Result<Self, Error> {
        if repeats > 1 && !trajectory.is_closed() {
            let (name, expected) = ("repeats", "1 for a trajectory that does not come back");
            return Err(Error::OutOfDomain { name, expected, got: f64::from(repeats) });
        }
        non_negative("rest before a motion", before)?;
        non_negative("rest after a motion", after)?;
        Ok(Self { trajectory, repeats, before, after })
    }

    /// What is repeated.
    #[must_use]
    pub fn trajectory(&self) -> &'a Trajectory {
        self.trajectory
    }

    /// Number of independent joints.
    #[must_use]
    pub fn joints(&self) -> usize {
        self.trajectory.joints()
    }

    /// Duration of all repeats, s.
    #[must_use]
    pub fn motion(&self) -> f64 {
        self.trajectory.duration() * f64::from(self.repeats)
    }

    /// Duration with both rests, s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.before + self.motion() + self.after
    }

    /// Whether the first rest is over at a time, s.
    #[must_use]
    pub fn moves(&self, time: f64) -> bool {
        time >= self.before
    }

    /// The reference at a time, s, with the one `horizon` s later. Nothing is allocated.
    ///
    /// # Errors
    /// As [`Trajectory::sample`].
    pub fn sample(
        &self,
        time: f64,
        horizon: f64,
        current: &mut Reference,
        previewed: &mut Reference,
    ) -> Result<Moment, Error> {
        let since_start = time - self.before;
        self.trajectory.sample(self.time_in_repeat(since_start), current)?;
        self.trajectory.sample(self.time_in_repeat(since_start + horizon), previewed)?;
        let moving = since_start >= 0.0 && since_start < self.motion();
        Ok(Moment {
            time,
            repeat: moving.then(|| (since_start / self.trajectory.duration()) as u32),
            repeat_time: moving.then(|| self.time_in_repeat(since_start)),
            rested: (since_start - self.motion()).max(0.0),
        })
    }

    /// Time within the present repeat, s; its ends at rest before the first and after the last.
    fn time_in_repeat(&self, since_start: f64) -> f64 {
        let duration = self.trajectory.duration();
        if since_start >= self.motion() { duration } else { since_start.max(0.0) % duration }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::MinimumJerk;

    #[test]
    fn a_schedule_rests_at_both_ends_of_its_motion() {
        let motion = Trajectory::PointToPoint(MinimumJerk::new(&[0.0], &[1.0], 2.0).unwrap());
        let schedule = Schedule::new(&motion, 1, 3.0, 1.0).unwrap();
        assert!((schedule.duration() - 6.0).abs() < 1e-12);
        let mut now = Reference::new(1);
        let mut soon = Reference::new(1);
        let mut at = |time| {
            let moment = schedule.sample(time, 0.5, &mut now, &mut soon).unwrap();
            (now.q[0], soon.q[0], moment)
        };
        let (q, next, moment) = at(2.0);
        assert!(q == 0.0 && next == 0.0 && moment.repeat.is_none() && moment.rested == 0.0);
        let (q, next, moment) = at(4.0);
        assert!((q - 0.5).abs() < 1e-12 && next > 0.5 && moment.repeat == Some(0));
        assert_eq!(moment.repeat_time, Some(1.0));
        let (q, _, moment) = at(5.75);
        assert!((q - 1.0).abs() < 1e-12 && moment.repeat.is_none() && (moment.rested - 0.75).abs() < 1e-12);
        assert!(Schedule::new(&motion, 2, 0.0, 0.0).is_err(), "an open motion is not repeated");
    }
}
