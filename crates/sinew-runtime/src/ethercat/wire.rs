//! EtherCAT in the list of buses.

use super::device::EthercatDevice;
use super::error::EthercatError;
use super::master::Master;
use super::pump::FrameStorage;
use super::raw_link::RawSocketLink;
use crate::bus::{BusError, Devices, Wire};
use sinew::machine::Machine;
use sinew_segment::RawSocketError;
use sinew_session::Plant;

/// An interface, until its master takes it, and the memory of that master.
struct Interface {
    storage: FrameStorage,
    link: Option<RawSocketLink>,
    name: String,
}

pub(super) fn open(interface: &str) -> Result<Box<dyn Wire>, BusError> {
    let link = Some(RawSocketLink::open(interface)?);
    Ok(Box::new(Interface { storage: FrameStorage::new(), link, name: interface.to_owned() }))
}

impl Wire for Interface {
    fn operate<'a>(
        &'a mut self,
        machine: &Machine,
        devices: &Devices,
    ) -> Result<Box<dyn Plant + 'a>, BusError> {
        let link = match self.link.take() {
            Some(link) => link,
            None => RawSocketLink::open(&self.name)?,
        };
        let matched = Master::new(&self.storage, link)?
            .match_devices(devices.of::<EthercatDevice>())
            .map_err(EthercatError::from)?;
        Ok(Box::new(matched.operate(machine)?))
    }
}

impl From<EthercatError> for BusError {
    fn from(error: EthercatError) -> Self {
        match error {
            EthercatError::Link { .. } => Self::System(Box::new(error)),
            _ => Self::Unexpected(Box::new(error)),
        }
    }
}

impl From<RawSocketError> for BusError {
    fn from(error: RawSocketError) -> Self {
        match error {
            RawSocketError::NoInterface { .. } => Self::Unexpected(Box::new(error)),
            _ => Self::System(Box::new(error)),
        }
    }
}
