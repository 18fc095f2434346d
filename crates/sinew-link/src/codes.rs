//! Codes of modes, requests and kinds of set-points.

use crate::wire::Code;

macro_rules! codes {
    ($(#[$meta:meta])* $name:ident { $($(#[$about:meta])* $code:ident = $value:literal,)* }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[repr(u8)]
        pub enum $name { $($(#[$about])* $code = $value,)* }

        impl $name {
            /// All codes, in the order of their numbers.
            pub const ALL: &'static [Self] = &[$(Self::$code,)*];

            /// The code's number on the wire.
            #[must_use]
            pub fn number(self) -> u8 {
                self as u8
            }

            /// The code of a number; none for a number without meaning.
            #[must_use]
            pub fn from_number(number: u8) -> Option<Self> {
                Self::ALL.iter().copied().find(|code| code.number() == number)
            }

            /// Its name, in English.
            #[must_use]
            pub fn name(self) -> &'static str {
                match self { $(Self::$code => stringify!($code),)* }
            }
        }

        impl $name {
            /// Numbers and names, for the documentation.
            #[must_use]
            pub fn codes() -> Vec<Code> {
                Self::ALL.iter().map(|code| Code { number: code.number(), name: code.name() }).collect()
            }
        }
    };
}

codes! {
    /// Operating mode of the machine.
    Mode {
        /// Drives without power.
        Off = 0,
        /// Drives enabled, cables may be slack.
        Ready = 1,
        /// Slack is removed.
        Pretension = 2,
        /// The joints are held where they are.
        Hold = 3,
        /// The machine follows set-points or its programme.
        Run = 4,
        /// Tensions are released on a ramp.
        SafeStop = 5,
        /// A fault ended the motion.
        Fault = 6,
    }
}

codes! {
    /// What a client asks of the machine.
    Request {
        /// Nothing.
        None = 0,
        /// Power off.
        TurnOff = 1,
        /// Enable the drives.
        GetReady = 2,
        /// Remove slack.
        Pretension = 3,
        /// Hold the joints where they are.
        Hold = 4,
        /// Follow set-points.
        Run = 5,
        /// Let tensions down on a ramp.
        SafeStop = 6,
        /// Leave a fault that is no longer present.
        Reset = 7,
    }
}

codes! {
    /// What the numbers of a set-point are.
    SetpointKind {
        /// No set-point.
        None = 0,
        /// Coordinates of the independent joints, rad or m: `[joints]`.
        Joint = 1,
        /// Lengths of the muscles, m: `[muscles]`.
        MuscleLength = 2,
        /// Tensions at the anchors, N: `[muscles]`.
        Tension = 3,
        /// Coordinates of the end point in the world, m: `[3]`.
        EndPoint = 4,
    }
}

codes! {
    /// What a client wants a session for.
    Role {
        /// To command the machine: one client at a time.
        Commands = 0,
        /// To see its state alone.
        Watches = 1,
    }
}

codes! {
    /// Why a session is refused.
    RefusedBecause {
        /// Another client has the session.
        SecondClient = 1,
        /// As many clients watch as may.
        TooManyWatchers = 2,
    }
}

impl Request {
    /// Whether a machine under tension is released for it.
    #[must_use]
    pub fn is_stop(self) -> bool {
        matches!(self, Self::SafeStop | Self::GetReady | Self::TurnOff)
    }
}

impl Mode {
    /// Whether set-points are followed.
    #[must_use]
    pub fn is_running(self) -> bool {
        self == Self::Run
    }
}
