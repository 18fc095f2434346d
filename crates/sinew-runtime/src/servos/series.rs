//! What series of servos differ in: protocol, where their registers are, and how they write numbers.

use super::protocol::Protocol;
use super::registers::{BAUD, Registers, eeprom, sts};

/// A series of servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Series {
    /// Dynamixel X.
    X,
    /// Dynamixel P.
    P,
    /// Feetech STS.
    Sts,
}

/// Addresses of registers of one octet.
#[derive(Debug, Clone, Copy)]
pub(super) struct Places {
    pub(super) id: u16,
    pub(super) baud: u16,
    pub(super) return_delay: u16,
    pub(super) torque_enable: u16,
    pub(super) hardware_error: u16,
}

/// What a servo says of itself in a cycle, in its own units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Measured {
    pub(super) torque: bool,
    /// Whether its watchdog has stopped it.
    pub(super) timed_out: bool,
    /// As of a Dynamixel.
    pub(super) error: u8,
    pub(super) temperature: u8,
    pub(super) current: i32,
    pub(super) velocity: i32,
    pub(super) position: i32,
}

/// Bit of [`Measured::error`] that a Dynamixel does not have: too large a current.
pub(super) const OVERCURRENT: u8 = 0x40;
/// Value of a bus watchdog that has stopped its servo: -1.
pub(super) const WATCHDOG_ERROR: u8 = 0xff;
/// Hardware errors: the bits of the STS series, and those of a Dynamixel.
const ERRORS: [(u8, u8); 5] = [(0x01, 0x01), (0x02, 0x08), (0x04, 0x04), (0x08, OVERCURRENT), (0x20, 0x20)];

impl Series {
    /// Its protocol.
    #[must_use]
    pub const fn protocol(self) -> Protocol {
        match self {
            Self::X | Self::P => Protocol::Dynamixel,
            Self::Sts => Protocol::Feetech,
        }
    }

    /// Rates of a line, bit/s, by their number in the control table.
    #[must_use]
    pub const fn baud(self) -> &'static [u32; 8] {
        match self {
            Self::X | Self::P => &BAUD,
            Self::Sts => &sts::BAUD,
        }
    }

    /// Registers of one octet that every series has.
    pub(super) const fn places(self) -> Places {
        let Registers { torque_enable, hardware_error, .. } = self.registers();
        match self {
            Self::X | Self::P => Places {
                id: eeprom::ID,
                baud: eeprom::BAUD,
                return_delay: eeprom::RETURN_DELAY,
                torque_enable,
                hardware_error,
            },
            Self::Sts => Places {
                id: sts::ID,
                baud: sts::BAUD_RATE,
                return_delay: sts::RETURN_DELAY,
                torque_enable: sts::TORQUE_ENABLE,
                hardware_error: sts::STATUS,
            },
        }
    }

    /// The registers of a Dynamixel; those of the X series for another.
    pub(super) const fn registers(self) -> Registers {
        match self {
            Self::X | Self::Sts => Registers::X,
            Self::P => Registers::P,
        }
    }

    /// The largest goal of a position, counts.
    pub(super) const fn largest_position(self) -> f64 {
        match self {
            Self::X => 1_048_575.0,
            Self::P => i32::MAX as f64,
            Self::Sts => i16::MAX as f64,
        }
    }

    /// Address and octets of what a cycle reads.
    pub(super) const fn reading(self) -> [u16; 2] {
        match self {
            Self::X | Self::P => [self.registers().indirect[1], 14],
            Self::Sts => [sts::LOCK, 16],
        }
    }

    /// Registers of one octet that are written when torque comes or goes, each with its value for torque.
    ///
    /// A cycle of the STS series does not read the torque, which lies far from the rest. The lock, which is 1
    /// after power-on, tells a servo that has started anew: it is 0 while there is torque.
    pub(super) const fn power(self) -> &'static [(u16, u8)] {
        match self {
            Self::X => &[(Registers::X.torque_enable, 1)],
            Self::P => &[(Registers::P.torque_enable, 1)],
            Self::Sts => &[(sts::TORQUE_ENABLE, 1), (sts::LOCK, 0)],
        }
    }

    /// Octets of a cycle on a line with so many servos: goals, request and answers.
    pub(super) const fn cycle_octets(self, servos: usize, fast: bool) -> usize {
        match (self, fast) {
            (Self::Sts, _) => 8 + 3 * servos + 8 + servos + 22 * servos,
            (_, true) => 14 + 5 * servos + 14 + servos + 8 + 18 * servos,
            (_, false) => 14 + 5 * servos + 14 + servos + 25 * servos,
        }
    }

    /// What the octets that a cycle reads say.
    pub(super) fn measured(self, data: &[u8]) -> Option<Measured> {
        Some(match (self, data) {
            (
                Self::X | Self::P,
                &[torque, watchdog, error, temperature, c0, c1, v0, v1, v2, v3, p0, p1, p2, p3],
            ) => Measured {
                torque: torque == 1,
                timed_out: watchdog == WATCHDOG_ERROR,
                error,
                temperature,
                current: i32::from(i16::from_le_bytes([c0, c1])),
                velocity: i32::from_le_bytes([v0, v1, v2, v3]),
                position: i32::from_le_bytes([p0, p1, p2, p3]),
            },
            (Self::Sts, &[lock, p0, p1, v0, v1, _, _, _, temperature, _, status, _, _, _, c0, c1]) => {
                Measured {
                    torque: lock == 0,
                    timed_out: false,
                    error: self.errors(status),
                    temperature,
                    current: signed([c0, c1]),
                    velocity: signed([v0, v1]),
                    position: signed([p0, p1]),
                }
            }
            _ => return None,
        })
    }

    /// Hardware errors as bits of a Dynamixel.
    pub(super) fn errors(self, status: u8) -> u8 {
        match self {
            Self::X | Self::P => status,
            Self::Sts => ERRORS.iter().filter(|(bit, _)| status & bit != 0).map(|(_, error)| error).sum(),
        }
    }

    /// The bits of a hardware error of a Dynamixel as its own.
    pub(super) fn status(self, errors: u8) -> u8 {
        match self {
            Self::X | Self::P => errors,
            Self::Sts => ERRORS.iter().filter(|(_, error)| errors & error != 0).map(|(bit, _)| bit).sum(),
        }
    }

    /// A goal as octets, of which as many count as its register has.
    pub(super) fn goal(self, goal: i32) -> [u8; 4] {
        match self {
            Self::X | Self::P => goal.to_le_bytes(),
            Self::Sts => {
                let [low, high] = magnitude(goal);
                [low, high, 0, 0]
            }
        }
    }
}

/// Sign of a number of two octets.
const SIGN: u16 = 0x8000;

/// A number with its sign in bit 15.
pub(super) fn signed(octets: [u8; 2]) -> i32 {
    let number = u16::from_le_bytes(octets);
    let size = i32::from(number & !SIGN);
    if number & SIGN == 0 { size } else { -size }
}

/// The octets of such a number; the largest that there is in place of a larger one.
pub(super) fn magnitude(number: i32) -> [u8; 2] {
    let size = number.unsigned_abs().min(u32::from(!SIGN)) as u16;
    (size | if number < 0 { SIGN } else { 0 }).to_le_bytes()
}
