//! Nodes behind an adapter or an interface, in the list of buses; simulated ones for other masters.

use super::adapter::{Adapter, Host, OCTETS};
use super::bus::CanBus;
use super::device::{CanDevice, Protocol};
use super::error::CanError;
use super::fdcanusb::{Fdcanusb, FdcanusbHost};
use super::slcan::{Slcan, SlcanHost};
use super::socketcan::SocketCan;
use super::{Link, SimulatedMachine};
use crate::bus::{BusError, Devices, Wire};
use crate::tty::{PseudoTerminal, Ttys};
use sinew::machine::Machine;
use sinew_session::Plant;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

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

/// Answers on a terminal, as an adapter on the bus of some devices with the nodes of a machine in real time,
/// which moves on once a period, ns, until `stop` is set; returns the number of frames that came. The adapter
/// of moteus is an fdcanusb, any other one speaks slcan.
///
/// # Errors
/// Of the operating system.
pub fn serve(
    terminal: &mut PseudoTerminal,
    machine: &mut SimulatedMachine,
    (device, period): (&CanDevice, u64),
    stop: &AtomicBool,
) -> io::Result<u64> {
    let mut host: Box<dyn Host> = match device.protocol {
        Protocol::Moteus => Box::new(FdcanusbHost::default()),
        Protocol::Canopen | Protocol::Cansimple | Protocol::Mit => Box::new(SlcanHost::new(device.bitrate)),
    };
    let (mut out, mut buffer, mut clock) = (Vec::with_capacity(OCTETS), [0; OCTETS], Ttys::default());
    let (start, mut advanced, mut frames) = (clock.now(), 0, 0);
    while !stop.load(Ordering::Relaxed) {
        let now = clock.now() - start;
        PseudoTerminal::wait([&*terminal], ((advanced + 1) * period).saturating_sub(now))?;
        let now = clock.now() - start;
        // Where the system was late, several periods have passed.
        while advanced < now / period {
            advanced += 1;
            machine.advance(period, advanced * period);
        }
        let count = terminal.read(&mut buffer)?;
        for octet in &buffer[..count] {
            if let Some(frame) = host.take(*octet, &mut out) {
                frames += 1;
                machine.process(&frame, now);
            }
        }
        while let Some(frame) = machine.take(u64::MAX) {
            host.show(&frame, &mut out);
        }
        if !out.is_empty() {
            // A master that reads nothing loses it, as an adapter's buffer does.
            terminal.write(&out)?;
            out.clear();
        }
    }
    Ok(frames)
}
