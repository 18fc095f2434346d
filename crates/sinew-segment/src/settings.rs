//! What differs between two devices of the same description, and how fast a simulated device is.

/// Settings of one device on the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviceSettings {
    /// Station alias in the EEPROM; 0 is none.
    pub alias: u16,
    /// Serial number; none takes the description's.
    pub serial: Option<u32>,
    /// How fast the local clock runs beside virtual time, in parts per billion; within +-1 000 000.
    pub drift_ppb: i32,
    /// Local time at the start of virtual time, ns.
    pub clock_at_start_ns: u64,
    /// From the previous device to this one and through it, ns.
    pub forward_delay_ns: u32,
    /// Time the firmware takes from the request of a state to its confirmation, ns.
    pub transition_ns: u64,
    /// Time the firmware takes to answer a mailbox message, ns.
    pub mailbox_ns: u64,
    /// Time one access to the EEPROM takes, ns.
    pub eeprom_ns: u64,
    /// Identification value for "device identification" (ETG.1020, explicit device ID); none answers no
    /// request.
    pub identification: Option<u16>,
}

impl Default for DeviceSettings {
    /// No alias, the serial number of the description, a perfect clock and the delays of common devices.
    fn default() -> Self {
        Self {
            alias: 0,
            serial: None,
            drift_ppb: 0,
            clock_at_start_ns: 0,
            forward_delay_ns: 500,
            transition_ns: 200_000,
            mailbox_ns: 50_000,
            eeprom_ns: 20_000,
            identification: None,
        }
    }
}
