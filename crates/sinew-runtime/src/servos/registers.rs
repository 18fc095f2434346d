//! Where the registers of servos are.

/// Addresses of a Dynamixel's control table that series differ in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Registers {
    /// Torque enable, 1 octet; the EEPROM lies below it.
    pub torque_enable: u16,
    /// Hardware error status, 1 octet.
    pub hardware_error: u16,
    /// Bus watchdog, 1 octet, in units of 20 ms.
    pub bus_watchdog: u16,
    /// Goal current, 2 octets; goal velocity, 4 octets, follows it.
    pub goal_current: u16,
    /// Goal position, 4 octets.
    pub goal_position: u16,
    /// Present current, velocity and position, 2 + 4 + 4 octets.
    pub present: u16,
    /// Present input voltage, 2 octets; present temperature, 1 octet, follows it.
    pub voltage: u16,
    /// The first of the indirect addresses and the first octet of what they show.
    pub indirect: [u16; 2],
}

impl Registers {
    /// Of the X series.
    pub const X: Self = Self {
        torque_enable: 64,
        hardware_error: 70,
        bus_watchdog: 98,
        goal_current: 102,
        goal_position: 116,
        present: 126,
        voltage: 144,
        indirect: [168, 224],
    };
    /// Of the P series.
    pub const P: Self = Self {
        torque_enable: 512,
        hardware_error: 518,
        bus_watchdog: 546,
        goal_current: 550,
        goal_position: 564,
        present: 574,
        voltage: 592,
        indirect: [168, 634],
    };

    /// Goal velocity.
    #[must_use]
    pub const fn goal_velocity(self) -> u16 {
        self.goal_current + 2
    }

    /// Present temperature.
    #[must_use]
    pub const fn temperature(self) -> u16 {
        self.voltage + 2
    }
}

/// Registers of the EEPROM, at the same addresses in every series.
pub mod eeprom {
    /// Identifier.
    pub const ID: u16 = 7;
    /// Rate of the line, by its place in [`BAUD`](super::BAUD).
    pub const BAUD: u16 = 8;
    /// Return delay time, in units of 2 us.
    pub const RETURN_DELAY: u16 = 9;
    /// Operating mode: 0 current, 1 velocity, 3 position, 4 extended position.
    pub const OPERATING_MODE: u16 = 11;
    /// Homing offset, 4 octets.
    pub const HOMING_OFFSET: u16 = 20;
    /// Temperature limit.
    pub const TEMPERATURE_LIMIT: u16 = 31;
    /// Current limit, 2 octets.
    pub const CURRENT_LIMIT: u16 = 38;
    /// Velocity limit, 4 octets.
    pub const VELOCITY_LIMIT: u16 = 44;
}

/// Rates of a line, bit/s, by their number in the control table.
pub const BAUD: [u32; 8] = [9600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000];

/// Registers of the STS series. Sources: Feetech's memory table of the STS series, with the constants of its
/// `SMS_STS.h` and of LeRobot, which agree where all say something.
pub mod sts {
    /// Version of the firmware, 2 octets; the model number, 2 octets, is at 3.
    pub const FIRMWARE: u16 = 0;
    /// Model number, 2 octets.
    pub const NUMBER: u16 = 3;
    /// Identifier.
    pub const ID: u16 = 5;
    /// Rate of the line, by its place in [`BAUD`].
    pub const BAUD_RATE: u16 = 6;
    /// Return delay time, in units of 2 us.
    pub const RETURN_DELAY: u16 = 7;
    /// What is answered: 0 pings and readings, 1 everything.
    pub const RESPONSE_LEVEL: u16 = 8;
    /// Lower and upper limit of the angle, 2 octets each; where both are 0, positions go beyond one turn.
    pub const ANGLE_LIMITS: u16 = 9;
    /// Bits of its own: see [`FINE_SPEED`] and [`MANY_TURNS`].
    pub const PHASE: u16 = 18;
    /// Bit of the phase: the unit of the speed is a count/s, and not 50.
    pub const FINE_SPEED: u8 = 0x04;
    /// Bit of the phase: positions go beyond one turn.
    pub const MANY_TURNS: u8 = 0x10;
    /// Operating mode: 0 position, 1 speed.
    pub const OPERATING_MODE: u16 = 33;
    /// Torque enable; the EEPROM lies below it.
    pub const TORQUE_ENABLE: u16 = 40;
    /// Acceleration, in units of 100 counts/s^2; 0 is the largest.
    pub const ACCELERATION: u16 = 41;
    /// Goal position, 2 octets.
    pub const GOAL_POSITION: u16 = 42;
    /// Goal speed, 2 octets; after power-on the largest.
    pub const GOAL_SPEED: u16 = 46;
    /// Whether what is written to the EEPROM is not kept; 1 after power-on. What a cycle reads begins here.
    pub const LOCK: u16 = 55;
    /// Present position, speed and load, 2 octets each, voltage and temperature.
    pub const PRESENT: u16 = 56;
    /// Hardware errors.
    pub const STATUS: u16 = 65;
    /// Present current, 2 octets.
    pub const CURRENT: u16 = 69;
    /// Rates of a line, bit/s, by their number in the table.
    pub const BAUD: [u32; 8] = [1_000_000, 500_000, 250_000, 128_000, 115_200, 76_800, 57_600, 38_400];
}
