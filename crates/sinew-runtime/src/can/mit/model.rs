//! Motors that speak MIT mode: the ranges of their numbers.

use sinew::drive::{DriveParameters, VelocityLoop};
use sinew_segment::{MitFamily, MitRanges};

/// A motor in MIT mode, as the machine file says it.
#[derive(Debug, Clone, PartialEq)]
pub struct MitMotor {
    /// Its model.
    pub model: String,
    /// What its frames can say.
    pub ranges: MitRanges,
    /// Torque of its shaft per position error, N m/rad, and per velocity error, N m s/rad.
    pub stiffness: f64,
    /// As stiffness.
    pub damping: f64,
}

/// Ends of stiffness and damping of all models, N m/rad and N m s/rad.
const GAINS: [f64; 2] = [500.0, 5.0];

/// Name and ranges of position, rad, velocity, rad/s, and torque, N m.
type Row = (&'static str, [f64; 3]);

/// With a current in the answer, A. Source: Ben Katz' firmware HKC_MiniCheetah; in the present one every
/// range is a parameter.
const MINI_CHEETAH: [(Row, f64); 1] = [(("mini-cheetah", [12.5, 65.0, 18.0]), 40.0)];
/// Source: CubeMars, manual of the AK series, 1.0.8; AK80-8 of 1.0.15, as other people's programs cite it.
const CUBEMARS: [Row; 7] = [
    ("AK10-9", [12.5, 50.0, 65.0]),
    ("AK60-6", [12.5, 45.0, 15.0]),
    ("AK70-10", [12.5, 50.0, 25.0]),
    ("AK80-6", [12.5, 76.0, 12.0]),
    ("AK80-8", [12.5, 37.5, 32.0]),
    ("AK80-9", [12.5, 50.0, 18.0]),
    ("AK80-64", [12.5, 8.0, 144.0]),
];
/// As from the factory. Source: DAMIAO's tables of its motors, as Seeed's wiki and its Python packages have
/// them.
const DAMIAO: [Row; 11] = [
    ("DM-J3507", [12.566, 50.0, 5.0]),
    ("DM-J4310", [12.5, 30.0, 10.0]),
    ("DM-J4340", [12.5, 8.0, 28.0]),
    ("DM-J6006", [12.5, 45.0, 20.0]),
    ("DM-J8006", [12.5, 45.0, 40.0]),
    ("DM-J8009", [12.5, 45.0, 54.0]),
    ("DM-J10010", [12.5, 20.0, 200.0]),
    ("DM-J10010L", [12.5, 25.0, 200.0]),
    ("DM-H3510", [12.5, 280.0, 1.0]),
    ("DM-H6215", [12.5, 45.0, 10.0]),
    ("DM-G6220", [12.5, 45.0, 10.0]),
];

impl MitMotor {
    /// The model of a simulated machine whose file names none: it says most of itself.
    pub(in crate::can) const USUAL: (&str, MitRanges) = {
        let [stiffness, damping] = GAINS;
        let (family, current) = (MitFamily::Damiao, None);
        (
            "DM-J4310",
            MitRanges { family, position: 12.5, velocity: 30.0, torque: 10.0, stiffness, damping, current },
        )
    };

    /// All models that have a name here.
    pub fn models() -> impl Iterator<Item = (&'static str, MitRanges)> {
        let of = |family, current| {
            move |(name, [position, velocity, torque]): Row| {
                let [stiffness, damping] = GAINS;
                (name, MitRanges { family, position, velocity, torque, stiffness, damping, current })
            }
        };
        let cheetah = MINI_CHEETAH.map(|(row, current)| of(MitFamily::MiniCheetah, Some(current))(row));
        cheetah
            .into_iter()
            .chain(CUBEMARS.map(of(MitFamily::Cubemars, None)))
            .chain(DAMIAO.map(of(MitFamily::Damiao, None)))
    }

    /// Stiffness and damping of the shaft that shows so many turns in one of the motor, with which it answers
    /// as a drive with a velocity loop of its own: critically damped.
    pub(in crate::can) fn gains(drive: &DriveParameters, turn: f64) -> [f64; 2] {
        let inertia = drive.motor.inertia / (turn * turn);
        [VelocityLoop::DRIVE_INTEGRAL * inertia, VelocityLoop::DRIVE_GAIN * inertia]
    }
}
