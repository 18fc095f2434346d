/// That two nodes have one identifier.
pub(super) const TWO_ANSWER: &str = "two nodes answer: expected one of each id";

/// Why a machine on CAN does not start.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CanError {
    /// The adapter or interface cannot be used.
    #[error("{port}: {source}")]
    Port {
        /// Its path or name.
        port: String,
        /// Of the operating system.
        source: std::io::Error,
    },
    /// An adapter that is not said.
    #[error("{device}: its port is not said: expected `port` in its table or --interface")]
    NoPort {
        /// Name of the device.
        device: String,
    },
    /// The machine file describes devices of another bus.
    #[error(
        "the devices of the machine file are not on CAN: expected `node` in each [[device]], or no \
        [[device]]: nodes 1, 2, .. then drive the muscles in their order"
    )]
    OtherBus,
    /// A sensor that no drive on CAN has.
    #[error(
        "{device}: no drive measures it: expected load_cell = \"none\" and none = true in \
        [every_joint_encoder]"
    )]
    Sensor {
        /// Name of the device.
        device: String,
    },
    /// Nodes that cannot be on one bus.
    #[error("{device} and {other} are on one bus: expected {expected}")]
    Bus {
        /// Name of the device.
        device: String,
        /// Of the other one.
        other: String,
        /// What they have to have.
        expected: &'static str,
    },
    /// The bus is too slow for the period.
    #[error("{nodes} drives at {bitrate} bit/s take {:.3} ms of a cycle of {:.3} ms: expected a longer period_s or a \
        higher bitrate", 1e3 * needed, 1e3 * period)]
    Slow {
        /// Drives on the bus.
        nodes: usize,
        /// Its rate.
        bitrate: u32,
        /// What a cycle takes at most, s.
        needed: f64,
        /// The machine's period, s.
        period: f64,
    },
    /// No node answers.
    #[error("{device}: no node answers to id {node} at {bitrate} bit/s")]
    Silent {
        /// Name of the device.
        device: String,
        /// Its identifier.
        node: u8,
        /// Rate of the bus.
        bitrate: u32,
    },
    /// Something is wrong with a node.
    #[error("{device} (id {node}): {problem}")]
    Node {
        /// Name of the device.
        device: String,
        /// Its identifier.
        node: u8,
        /// What it is.
        problem: String,
    },
    /// An object of a node does not take a value.
    #[error("{device}: object {index:#06x}:{subindex:02x} {value:#x}: {reason}")]
    Refused {
        /// Name of the device.
        device: String,
        /// Index of the object.
        index: u16,
        /// Its subindex.
        subindex: u8,
        /// What was written.
        value: u32,
        /// What came of it.
        reason: String,
    },
}
