/// Working quadrant of a drive: the signs of speed and tension (fig. 2b).
///
/// A cable only pulls, so a muscle lives in two of the four: it shortens and gives power, or it is lengthened and
/// takes power. The motor still knows all four, when it turns against its own friction.
///
/// # Source
/// `yuan2023`, fig. 2b.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quadrant {
    /// Torque and speed toward the motor: the active muscle.
    First,
    /// Turning toward the motor while the torque brakes.
    Second,
    /// Torque and speed away from the motor: paying out by force.
    Third,
    /// Lengthened under tension: the passive muscle.
    Fourth,
}

impl Quadrant {
    /// The quadrant of a speed and a torque, both + toward the motor; standing still counts as first or second.
    #[must_use]
    pub fn of(speed: f64, torque: f64) -> Self {
        match (speed >= 0.0, torque >= 0.0) {
            (true, true) => Self::First,
            (true, false) => Self::Second,
            (false, false) => Self::Third,
            (false, true) => Self::Fourth,
        }
    }

    /// Whether the drive gives power.
    #[must_use]
    pub fn is_active(self) -> bool {
        matches!(self, Self::First | Self::Third)
    }
}
