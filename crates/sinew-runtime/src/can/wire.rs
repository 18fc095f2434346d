//! Nodes behind an adapter or an interface, in the list of buses.

use super::Link;
use super::adapter::Adapter;
use super::bus::CanBus;
use super::device::{CanDevice, Protocol};
use super::error::CanError;
use super::fdcanusb::Fdcanusb;
use super::slcan::Slcan;
use super::socketcan::SocketCan;
use crate::bus::{BusError, Devices, Wire};
use sinew::machine::Machine;
use sinew_session::Plant;
use std::io;

/// The adapter or interface of nodes whose machine file names none.
struct Named(String);

pub(super) fn open(interface: &str) -> Result<Box<dyn Wire>, BusError> {
    Ok(Box::new(Named(interface.to_owned())))
}

impl Wire for Named {
    fn operate<'a>(
        &'a mut self,
        machine: &Machine,
        devices: &Devices,
    ) -> Result<Box<dyn Plant + 'a>, BusError> {
        let mut nodes = devices.of::<CanDevice>().to_vec();
        for node in &mut nodes {
            if node.port.is_none() && self.0.is_empty() {
                return Err(CanError::NoPort { device: node.name.clone() }.into());
            }
            node.port.get_or_insert_with(|| self.0.clone());
        }
        let Some(CanDevice { port, bitrate, protocol, .. }) = nodes.first() else {
            return Err(CanError::OtherBus.into());
        };
        let port = port.clone().unwrap_or_default();
        let link = connect(&port, *bitrate, *protocol == Protocol::Moteus)
            .map_err(|source| CanError::Port { port, source })?;
        Ok(Box::new(CanBus::start(link, machine, &nodes)?))
    }
}

/// Opens a bus at a rate, bit/s: a path, which has a slash, is the serial port of an adapter with slcan, or
/// with CAN FD of an fdcanusb; any other name is that of a CAN interface.
///
/// # Errors
/// Of the operating system, as [`Adapter::open`] and [`SocketCan::open`].
pub fn connect(port: &str, bitrate: u32, fd: bool) -> io::Result<Box<dyn Link>> {
    Ok(match (port.contains('/'), fd) {
        (true, false) => Box::new(Adapter::<Slcan>::open(port, bitrate)?),
        (true, true) => Box::new(Adapter::<Fdcanusb>::open(port, bitrate)?),
        (false, _) => Box::new(SocketCan::open(port, bitrate, fd)?),
    })
}

impl From<CanError> for BusError {
    fn from(error: CanError) -> Self {
        match error {
            CanError::Port { .. } => Self::System(Box::new(error)),
            _ => Self::Unexpected(Box::new(error)),
        }
    }
}
