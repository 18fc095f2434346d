//! Models of servos: units, limits and where their registers are.

use super::series::Series;

/// A model of a servo.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// As in the machine file.
    pub name: String,
    /// Model number that it answers with; none is any.
    pub number: Option<u16>,
    /// Counts of the position in a turn of the horn.
    pub counts: f64,
    /// Unit of the velocity, revolutions per minute.
    pub velocity_rpm: f64,
    /// Unit of the current, A; 0 where it measures none.
    pub current_a: f64,
    /// The largest limit of its velocity, in its unit.
    pub max_velocity: u32,
    /// Its series.
    pub series: Series,
}

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

/// Names and model numbers.
type Names = &'static [(&'static str, u16)];

/// Name and model number of those of the X series, by the unit of their current, A, 0 for none.
const X: [(f64, u32, Names); 4] = [
    (
        0.0,
        1023,
        &[
            ("XL430-W250", 1060),
            ("2XL430-W250", 1090),
            ("XC430-W150", 1070),
            ("XC430-W240", 1080),
            ("2XC430-W250", 1160),
        ],
    ),
    (
        2.69e-3,
        1023,
        &[
            ("XM430-W210", 1030),
            ("XM430-W350", 1020),
            ("XH430-W210", 1010),
            ("XH430-W350", 1000),
            ("XD430-T210", 1011),
            ("XD430-T350", 1001),
            ("XM540-W150", 1130),
            ("XM540-W270", 1120),
            ("XH540-W150", 1110),
            ("XH540-W270", 1100),
            ("XW540-T140", 1180),
            ("XW540-T260", 1170),
            ("XD540-T150", 1111),
            ("XD540-T270", 1101),
        ],
    ),
    (1.34e-3, 1023, &[("XH430-V210", 1050), ("XH430-V350", 1040)]),
    (
        1e-3,
        2047,
        &[
            ("XL330-M077", 1190),
            ("XL330-M288", 1200),
            ("XC330-T181", 1210),
            ("XC330-T288", 1220),
            ("XC330-M181", 1230),
            ("XC330-M288", 1240),
        ],
    ),
];

/// Name, model number and counts of a turn of those of the P series.
const P: [(&str, u16, f64); 6] = [
    ("PH42-020", 2000, 607_500.0),
    ("PH54-100", 2010, 1_003_846.0),
    ("PH54-200", 2020, 1_003_846.0),
    ("PM42-010", 2100, 526_374.0),
    ("PM54-040", 2110, 502_834.0),
    ("PM54-060", 2120, 502_834.0),
];

/// Name, model number and top speed at 12 V, counts/s, of those of the STS series. Sources: LeRobot,
/// `motors/feetech/tables.py`; Feetech's data of STS3215-C018 (0.222 s for 60 degrees) and STS3250 (0.133 s),
/// as others cite them.
const STS: [(&str, u16, u32); 2] = [("STS3215", 777, 3073), ("STS3250", 2825, 5133)];

impl Model {
    /// All models that have a name here. Source: ROBOTIS e-Manual, their control tables; see also `STS`.
    pub fn all() -> impl Iterator<Item = Self> {
        let x = X.iter().flat_map(|&(current_a, max_velocity, models)| {
            models.iter().map(move |&(name, number)| Self {
                name: name.to_owned(),
                number: Some(number),
                current_a,
                max_velocity,
                ..Self::any()
            })
        });
        let sts = STS.iter().map(|&(name, number, max_velocity)| Self {
            name: name.to_owned(),
            number: Some(number),
            counts: 4096.0,
            velocity_rpm: 60.0 / 4096.0,
            current_a: 6.5e-3,
            max_velocity,
            series: Series::Sts,
        });
        let p = P.iter().map(|&(name, number, counts)| Self {
            name: name.to_owned(),
            number: Some(number),
            counts,
            velocity_rpm: 0.01,
            current_a: 1e-3,
            max_velocity: 2900,
            series: Series::P,
        });
        x.chain(p).chain(sts)
    }

    /// A servo of the X series without limits of its own, for machines whose file names no devices.
    #[must_use]
    pub fn any() -> Self {
        Self {
            name: "any".to_owned(),
            number: None,
            counts: 4096.0,
            velocity_rpm: 0.229,
            current_a: 2.69e-3,
            max_velocity: 32_767,
            series: Series::X,
        }
    }

    /// Whether it can be commanded a current.
    #[must_use]
    pub fn has_current_loop(&self) -> bool {
        self.current_a > 0.0 && self.series != Series::Sts
    }

    /// Velocity of the horn of one count, rad/s.
    #[must_use]
    pub fn velocity_unit(&self) -> f64 {
        self.velocity_rpm * core::f64::consts::TAU / 60.0
    }
}
