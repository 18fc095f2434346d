//! The master before operation: what is on the wire.

use super::bring_up::{self, PreOpGroup};
use super::device::EthercatDevice;
use super::error::EthercatError;
use super::found::{FoundDevice, positions};
use super::link::Link;
use super::pump::{FrameStorage, Pump};
use ethercrab::{MainDevice, MainDeviceConfig, RetryBehaviour, Timeouts};
use std::time::Duration;

/// A master whose devices are not known yet.
pub struct Master<'a, L> {
    pub(super) main: MainDevice<'a>,
    pub(super) pump: Pump<'a, L>,
}

/// Before operation a lost frame is sent again.
const RETRIES: usize = 3;
/// Rounds of the static compensation of the clocks' drift.
const CLOCK_ROUNDS: u32 = 500;

impl<'a, L: Link> Master<'a, L> {
    /// A master that sends its frames over a link.
    ///
    /// # Errors
    /// [`EthercatError::StorageInUse`] where another master has the memory.
    pub fn new(storage: &'a FrameStorage, link: L) -> Result<Self, EthercatError> {
        let (tx, rx, frames) = storage.split().ok_or(EthercatError::StorageInUse)?;
        let timeouts = Timeouts {
            pdu: Duration::from_millis(20),
            state_transition: Duration::from_secs(5),
            mailbox_echo: Duration::from_millis(500),
            // Devices answer within 10 ms, a host with other work looks later.
            eeprom: Duration::from_millis(500),
            ..Timeouts::default()
        };
        let config = MainDeviceConfig {
            dc_static_sync_iterations: CLOCK_ROUNDS,
            retry_behaviour: RetryBehaviour::Count(RETRIES),
        };
        Ok(Self { main: MainDevice::new(frames, timeouts, config), pump: Pump::new(tx, rx, link) })
    }

    /// The link.
    pub fn link_mut(&mut self) -> &mut L {
        self.pump.link_mut()
    }

    /// Brings all devices to PRE-OP and lists them in the order on the wire.
    ///
    /// # Errors
    /// [`EthercatError::NoAnswer`] where no frame comes back, [`EthercatError::Link`] and
    /// [`EthercatError::Protocol`] where they do not answer as they should.
    pub fn scan(&mut self) -> Result<Vec<FoundDevice>, EthercatError> {
        pre_op(&self.main, &mut self.pump).map(|(_, found)| found)
    }
}

fn pre_op<L: Link>(
    main: &MainDevice<'_>,
    pump: &mut Pump<'_, L>,
) -> Result<(PreOpGroup, Vec<FoundDevice>), EthercatError> {
    let outcome = pump.complete(bring_up::pre_op(main));
    outcome.map_err(|error| match pump.take_error() {
        Some(source) => EthercatError::Link { during: "looking for devices", source },
        None if !pump.answered() => EthercatError::NoAnswer,
        None => error,
    })
}

/// Brings all devices to PRE-OP and finds those of a machine among them: the position of each on the wire.
pub(super) fn matching<L: Link>(
    main: &MainDevice<'_>,
    pump: &mut Pump<'_, L>,
    expected: &[EthercatDevice],
) -> Result<(PreOpGroup, Vec<usize>), EthercatError> {
    let (group, found) = pre_op(main, pump)?;
    if found.is_empty() {
        return Err(EthercatError::NoDevices { expected: expected.len() });
    }
    let positions = positions(expected, &found).map_err(EthercatError::Mismatch)?;
    Ok((group, positions))
}
