use sinew::Error;
use sinew::twin::cable::Resolution;

/// What an action commands of every drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Actuation {
    /// Speed of the cable at the winch: -1 and 1 are the speed at which the drive winds in cable at half of
    /// its working tension, away from and toward the motor.
    Speed,
    /// Tension at the drive's outlet: -1 is the least that keeps the cable from going slack, 1 the drive's
    /// working tension.
    Tension,
    /// Torque of the motor: -1 and 1 are the torque that it can give continuously.
    Torque,
}

/// Conditions of an environment beside machine and task.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// What an action commands.
    pub actuation: Actuation,
    /// Milliseconds for which an action holds, 1 to 1000; a whole number of the machine's periods.
    pub interval_ms: u32,
    /// Actions of an episode, at least 1: it is truncated then.
    pub steps: u32,
    /// Cells of the cables, and least substeps of a millisecond; more are taken where the machine needs them.
    pub resolution: Resolution,
    /// Largest distance of the initial pose, and of the pose to be reached, from the machine's start, as a
    /// fraction of the way to the ends of the joints' ranges, 0 to 1.
    pub spread: f64,
    /// Weight of the mean square action in the reward, >= 0.
    pub effort: f64,
}

impl Default for Settings {
    /// Speeds every 10 ms for 5 s; half of the ranges. Twelve cells, whose end tensions differ from those of
    /// a fine cable by less than specimens do (`sinew::transmission::cable`), and as few substeps as the
    /// machine allows.
    fn default() -> Self {
        Self {
            actuation: Actuation::Speed,
            interval_ms: 10,
            steps: 500,
            resolution: Resolution { cells: 12, substeps: 1 },
            spread: 0.5,
            effort: 0.01,
        }
    }
}

impl Settings {
    /// Milliseconds that an action holds on a machine with this period, s, where nothing else is said: 10, or
    /// the next that are a whole number of its periods.
    #[must_use]
    pub fn interval_for(period: f64) -> u32 {
        let ten = Self::default().interval_ms;
        (ten..=1000).find(|&milliseconds| periods_in(milliseconds, period).is_some()).unwrap_or(ten)
    }

    /// Checks every number.
    ///
    /// # Errors
    /// [`Error::OutOfDomain`] names the one outside its domain.
    pub fn validate(&self) -> Result<(), Error> {
        let milliseconds = f64::from(self.interval_ms);
        within(
            "interval_ms",
            "a number of milliseconds from 1 to 1000",
            milliseconds,
            (1..=1000).contains(&self.interval_ms),
        )?;
        within("steps", "at least 1", f64::from(self.steps), self.steps >= 1)?;
        within("spread", "a number from 0 to 1", self.spread, (0.0..=1.0).contains(&self.spread))?;
        within("effort", "a finite number >= 0", self.effort, self.effort >= 0.0 && self.effort.is_finite())
    }
}

/// The number of periods, s, in an interval that is a whole number of them.
pub(crate) fn periods_in(milliseconds: u32, period: f64) -> Option<u32> {
    let exact = 1e-3 * f64::from(milliseconds) / period;
    let whole = exact.round();
    ((exact - whole).abs() < 1e-6 && whole >= 1.0).then_some(whole as u32)
}

/// Refuses a value for which the condition, which `expected` states in words, does not hold.
pub(crate) fn within(name: &'static str, expected: &'static str, got: f64, holds: bool) -> Result<(), Error> {
    if holds { Ok(()) } else { Err(Error::OutOfDomain { name, expected, got }) }
}

#[cfg(test)]
mod tests {
    use super::{Settings, periods_in};

    #[test]
    fn an_action_holds_for_ten_milliseconds_or_the_next_whole_number_of_periods() {
        let periods = [0.5e-3, 1e-3, 2e-3, 2.5e-3, 3e-3, 4e-3, 7e-3, 12.5e-3, 0.02];
        let expected = [10, 10, 10, 10, 12, 12, 14, 25, 20];
        for (period, expected) in periods.into_iter().zip(expected) {
            assert_eq!(Settings::interval_for(period), expected, "{period}");
            assert!(periods_in(expected, period).is_some());
        }
    }
}
