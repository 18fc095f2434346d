/// Working quadrant of a drive: the signs of speed and tension (fig. 2b).
///
/// A cable only pulls, so a muscle works in two of the four quadrants: it shortens and delivers power, or it
/// is lengthened and absorbs power. The motor works in all four, because its own friction reverses the sign
/// of its torque.
///
/// # Source
/// `yuan2023`, fig. 2b.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quadrant {
    /// Torque and speed toward the motor: the active muscle.
    First,
    /// Moving toward the motor while the torque brakes.
    Second,
    /// Torque and speed away from the motor: active paying out.
    Third,
    /// Lengthened under tension: the passive muscle.
    Fourth,
}

impl Quadrant {
    /// The quadrant of a speed and a torque, both + toward the motor; zero speed counts as first or second.
    #[must_use]
    pub fn new(speed: f64, torque: f64) -> Self {
        match (speed >= 0.0, torque >= 0.0) {
            (true, true) => Self::First,
            (true, false) => Self::Second,
            (false, false) => Self::Third,
            (false, true) => Self::Fourth,
        }
    }

    /// Whether the drive delivers power.
    #[must_use]
    pub fn is_active(self) -> bool {
        matches!(self, Self::First | Self::Third)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_is_active_where_its_torque_acts_along_its_motion() {
        for (speed, torque) in [(2.0, 3.0), (2.0, -3.0), (-2.0, -3.0), (-2.0, 3.0)] {
            assert_eq!(Quadrant::new(speed, torque).is_active(), speed * torque > 0.0, "{speed} {torque}");
        }
    }
}
