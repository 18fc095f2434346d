/// Why a machine with servos does not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServoError {
    /// A serial port cannot be used.
    #[error("{port}: {source}")]
    Port {
        /// Its path.
        port: String,
        /// Of the operating system.
        source: std::io::Error,
    },
    /// A servo whose port is not said.
    #[error("{device}: its port is not said: expected `port` in its table or --interface")]
    NoPort {
        /// Name of the device.
        device: String,
    },
    /// The machine file describes devices of another bus.
    #[error(
        "the devices of the machine file are no servos: expected `id` and `model` in each [[device]], or no \
        [[device]]: servos 1, 2, .. then drive the muscles in their order"
    )]
    OtherBus,
    /// A sensor that no servo has.
    #[error(
        "{device}: no servo measures it: expected load_cell = \"none\" and none = true in \
        [every_joint_encoder]"
    )]
    Sensor {
        /// Name of the device.
        device: String,
    },
    /// Servos of one line that cannot be asked together.
    #[error("{device} and {other} are on one line: expected {expected}")]
    Line {
        /// Name of the device.
        device: String,
        /// Of the other one.
        other: String,
        /// What they have to have.
        expected: &'static str,
    },
    /// No servo answers.
    #[error("{device}: no servo answers to id {id} at {baud} bit/s")]
    Silent {
        /// Name of the device.
        device: String,
        /// Its identifier.
        id: u8,
        /// Rate of the line.
        baud: u32,
    },
    /// A line is too slow for the period.
    #[error("{device} and all {servos} of its line: {baud} bit/s take {:.3} ms of a cycle of {:.3} ms: expected \
        a longer period_s, a higher baud or another port", 1e3 * needed, 1e3 * period)]
    Slow {
        /// Name of the first device.
        device: String,
        /// Servos of the line.
        servos: usize,
        /// Rate of the line.
        baud: u32,
        /// What a cycle takes, s.
        needed: f64,
        /// The machine's period, s.
        period: f64,
    },
    /// Another model answers.
    #[error("{device}: model number {got}: expected {expected}")]
    Model {
        /// Name of the device.
        device: String,
        /// The model number that was read.
        got: u16,
        /// Model of the machine file.
        expected: String,
    },
    /// A servo reports a hardware error.
    #[error("{device}: reports a hardware error: {}", hardware(*.error))]
    Hardware {
        /// Name of the device.
        device: String,
        /// Its hardware error status.
        error: u8,
    },
    /// A servo does not take a value.
    #[error("{device}: {register} {value}: {reason}")]
    Refused {
        /// Name of the device.
        device: String,
        /// What was written.
        register: &'static str,
        /// Its value.
        value: i64,
        /// What came of it.
        reason: String,
    },
}

/// The bits of a hardware error status in words: a Dynamixel's, with one of ours.
pub(super) fn hardware(error: u8) -> String {
    let known = [
        (0, "input voltage"),
        (2, "overheating"),
        (3, "encoder"),
        (4, "electrical shock"),
        (5, "overload"),
        (6, "overcurrent"),
    ];
    let set = known.iter().filter(|(bit, _)| error >> bit & 1 == 1).map(|(_, name)| *name);
    let words = set.collect::<Vec<_>>().join(", ");
    if words.is_empty() { format!("hardware error {error:#04x}") } else { words }
}

/// The error of a status in words.
pub(super) fn status(error: u8) -> String {
    let words = [
        "no error",
        "the servo failed to do so",
        "the servo does not know the instruction",
        "the servo received a damaged packet",
        "outside of the servo's range",
        "the servo expected another length",
        "outside of the servo's limits",
        "the servo does not allow access: EEPROM is locked under torque",
    ];
    words.get(usize::from(error & 0x7f)).map_or_else(|| format!("error {error:#04x}"), ToString::to_string)
}
