/// Operating mode of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum Mode {
    /// The amplifiers are off.
    #[default]
    Off = 0,
    /// The drives are on, and the winches stand.
    Ready = 1,
    /// Slack is wound in: the tensions rise on a ramp, the winches are slow.
    Pretension = 2,
    /// The pose is kept.
    Hold = 3,
    /// The reference is followed.
    Run = 4,
    /// The winches brake, hold the pose, and then release the tensions at a bounded speed.
    SafeStop = 5,
    /// A fault has ended in a safe stop: the winches stand until it is reset.
    Fault = 6,
}

/// What a machine is asked for.
///
/// It counts once, when it differs from that of the cycle before, and names a goal: the modes on the way to
/// it are passed. A fault and a stale command end the goal, but for [`TurnOff`](Self::TurnOff); a
/// [`Reset`](Self::Reset) before the fault mode does not take the place of a [stop](Self::is_stop).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum Request {
    /// Nothing new.
    #[default]
    None = 0,
    /// To [`Mode::Off`]; a machine under tension is released first.
    TurnOff = 1,
    /// To [`Mode::Ready`]; a machine under tension is released first.
    GetReady = 2,
    /// To [`Mode::Pretension`], which ends in [`Mode::Hold`].
    Pretension = 3,
    /// To [`Mode::Hold`].
    Hold = 4,
    /// To [`Mode::Run`].
    Run = 5,
    /// To [`Mode::SafeStop`], which ends in [`Mode::Ready`].
    SafeStop = 6,
    /// Ends [`Mode::Fault`].
    Reset = 7,
}

impl Mode {
    /// All modes, by their numbers.
    pub const ALL: [Self; 7] =
        [Self::Off, Self::Ready, Self::Pretension, Self::Hold, Self::Run, Self::SafeStop, Self::Fault];

    /// The mode of a number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// In words of documents and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Ready => "ready",
            Self::Pretension => "pretension",
            Self::Hold => "hold",
            Self::Run => "run",
            Self::SafeStop => "safe_stop",
            Self::Fault => "fault",
        }
    }

    /// Whether the controller commands the winches.
    #[must_use]
    pub const fn is_controlled(self) -> bool {
        matches!(self, Self::Hold | Self::Run)
    }
}

impl Request {
    /// All requests, by their numbers.
    pub const ALL: [Self; 8] = [
        Self::None,
        Self::TurnOff,
        Self::GetReady,
        Self::Pretension,
        Self::Hold,
        Self::Run,
        Self::SafeStop,
        Self::Reset,
    ];

    /// The request of a number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// Whether a machine under tension is released for it.
    #[must_use]
    pub const fn is_stop(self) -> bool {
        matches!(self, Self::SafeStop | Self::GetReady | Self::TurnOff)
    }

    /// Whether it needs tension.
    #[must_use]
    pub const fn is_under_tension(self) -> bool {
        matches!(self, Self::Pretension | Self::Hold | Self::Run)
    }

    /// In words of documents and files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::TurnOff => "turn_off",
            Self::GetReady => "get_ready",
            Self::Pretension => "pretension",
            Self::Hold => "hold",
            Self::Run => "run",
            Self::SafeStop => "safe_stop",
            Self::Reset => "reset",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_the_places_in_the_lists() {
        for (number, mode) in Mode::ALL.into_iter().enumerate() {
            assert_eq!(mode as usize, number);
            assert_eq!(Mode::from_number(number as u8), Some(mode));
        }
        for (number, request) in Request::ALL.into_iter().enumerate() {
            assert_eq!(request as usize, number);
            assert_eq!(Request::from_number(number as u8), Some(request));
        }
        assert_eq!((Mode::from_number(7), Request::from_number(8)), (None, None));
    }
}
