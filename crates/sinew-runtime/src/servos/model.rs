//! Models of servos: units and limits.

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
