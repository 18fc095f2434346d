//! The numbers in the frames of MIT mode.
//!
//! ```text
//! command: position 16, velocity 12, stiffness 12, damping 12, torque 12 bits
//! answer:  position 16, velocity 12, torque or current 12 bits, behind the identifier
//! ```

/// Whose firmware a motor in MIT mode has: it decides what is answered, and under which identifier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MitFamily {
    /// MIT mini cheetah: 6 octets, without a state, to the master with identifier 0.
    MiniCheetah,
    /// CubeMars AK: 8 octets with temperature and error, under the motor's own identifier.
    Cubemars,
    /// DAMIAO: 8 octets with the state beside the identifier, to a master of its own; registers.
    Damiao,
}

/// Ranges of the numbers in the frames of a motor in MIT mode, all at the shaft that it shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MitRanges {
    /// Whose firmware it has.
    pub family: MitFamily,
    /// Position from minus this to this, rad.
    pub position: f64,
    /// The same of the velocity, rad/s.
    pub velocity: f64,
    /// The same of the torque, N m.
    pub torque: f64,
    /// Stiffness from 0 to this, N m/rad.
    pub stiffness: f64,
    /// Damping from 0 to this, N m s/rad.
    pub damping: f64,
    /// Where the answer carries a current in place of a torque, that from minus this to this, A.
    pub current: Option<f64>,
}

/// What a motor is told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct MitCommand {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Torque per position error, N m/rad.
    pub stiffness: f64,
    /// Torque per velocity error, N m s/rad.
    pub damping: f64,
    /// Torque beside, N m.
    pub torque: f64,
}

/// What the octets of an answer carry beside identifier, state and temperatures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MitReadings {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Torque, N m, or current, A.
    pub torque: f64,
}

/// The number of so many bits for a value between two ends, which is rounded and held between them.
fn coded(value: f64, [low, high]: [f64; 2], bits: u32) -> u64 {
    let most = f64::from((1_u32 << bits) - 1);
    ((value - low) / (high - low) * most).round().max(0.0).min(most) as u64
}

fn decoded(number: u64, [low, high]: [f64; 2], bits: u32) -> f64 {
    low + number as f64 * (high - low) / f64::from((1_u32 << bits) - 1)
}

impl MitRanges {
    /// The octets of a command.
    #[must_use]
    pub fn command(&self, command: &MitCommand) -> [u8; 8] {
        let MitCommand { position, velocity, stiffness, damping, torque } = *command;
        let word = coded(position, [-self.position, self.position], 16) << 48
            | coded(velocity, [-self.velocity, self.velocity], 12) << 36
            | coded(stiffness, [0.0, self.stiffness], 12) << 24
            | coded(damping, [0.0, self.damping], 12) << 12
            | coded(torque, [-self.torque, self.torque], 12);
        word.to_be_bytes()
    }

    /// What the octets of a command say.
    #[must_use]
    pub fn commanded(&self, octets: [u8; 8]) -> MitCommand {
        let word = u64::from_be_bytes(octets);
        let number = |shift: u32| word >> shift & 0xfff;
        MitCommand {
            position: decoded(word >> 48, [-self.position, self.position], 16),
            velocity: decoded(number(36), [-self.velocity, self.velocity], 12),
            stiffness: decoded(number(24), [0.0, self.stiffness], 12),
            damping: decoded(number(12), [0.0, self.damping], 12),
            torque: decoded(number(0), [-self.torque, self.torque], 12),
        }
    }

    /// The five octets of an answer that carry readings. A position beyond its range wraps round, as the
    /// firmware of the mini cheetah lets it.
    #[must_use]
    pub fn answer(&self, readings: &MitReadings) -> [u8; 5] {
        let turn = 2.0 * self.position * 65_536.0 / 65_535.0;
        let position = (readings.position + self.position).rem_euclid(turn) - self.position;
        let word = coded(position, [-self.position, self.position], 16) << 24
            | coded(readings.velocity, [-self.velocity, self.velocity], 12) << 12
            | coded(readings.torque, self.shown(), 12);
        let [_, _, _, octets @ ..] = word.to_be_bytes();
        octets
    }

    /// What the five octets of an answer say.
    #[must_use]
    pub fn readings(&self, octets: [u8; 5]) -> MitReadings {
        let [a, b, c, d, e] = octets;
        let word = u64::from_be_bytes([0, 0, 0, a, b, c, d, e]);
        MitReadings {
            position: decoded(word >> 24, [-self.position, self.position], 16),
            velocity: decoded(word >> 12 & 0xfff, [-self.velocity, self.velocity], 12),
            torque: decoded(word & 0xfff, self.shown(), 12),
        }
    }

    fn shown(&self) -> [f64; 2] {
        let most = self.current.unwrap_or(self.torque);
        [-most, most]
    }
}
