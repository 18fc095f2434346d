//! Servos in the list of buses.

use super::bus::ServoBus;
use super::device::ServoDevice;
use super::error::ServoError;
use super::line::Lines;
use crate::bus::{BusError, Devices, Wire};
use crate::tty::Ttys;
use sinew::machine::Machine;
use sinew_session::Plant;
use std::io;

/// The port of servos whose machine file names none.
struct Ports(String);

pub(super) fn open(interface: &str) -> Result<Box<dyn Wire>, BusError> {
    Ok(Box::new(Ports(interface.to_owned())))
}

impl Wire for Ports {
    fn operate<'a>(
        &'a mut self,
        machine: &Machine,
        devices: &Devices,
    ) -> Result<Box<dyn Plant + 'a>, BusError> {
        let mut servos = devices.of::<ServoDevice>().to_vec();
        if servos.is_empty() {
            return Err(ServoError::OtherBus.into());
        }
        for servo in &mut servos {
            if servo.port.is_none() && self.0.is_empty() {
                return Err(ServoError::NoPort { device: servo.name.clone() }.into());
            }
            servo.port.get_or_insert_with(|| self.0.clone());
        }
        let mut lines = Ttys::default();
        for port in ServoDevice::ports(&servos).into_iter().flatten() {
            let of_port = servos.iter().find(|servo| servo.port.as_ref() == Some(&port));
            let opened = lines.open(&port, of_port.map_or(0, |servo| servo.baud));
            opened.map_err(|source| ServoError::Port { port, source })?;
        }
        Ok(Box::new(ServoBus::start(lines, machine, &servos)?))
    }
}

impl From<ServoError> for BusError {
    fn from(error: ServoError) -> Self {
        match error {
            ServoError::Port { .. } => Self::System(Box::new(error)),
            _ => Self::Unexpected(Box::new(error)),
        }
    }
}

impl Lines for Ttys {
    fn count(&self) -> usize {
        Self::count(self)
    }

    fn now(&mut self) -> u64 {
        Self::now(self)
    }

    fn send(&mut self, line: usize, octets: &[u8]) -> io::Result<()> {
        Self::send(self, line, octets)
    }

    fn receive(&mut self, line: usize, buffer: &mut [u8], deadline: u64) -> io::Result<usize> {
        Self::receive(self, line, buffer, deadline)
    }

    fn rest_until(&mut self, time: u64) {
        Self::rest_until(self, time);
    }

    fn begin_cycle(&mut self, _period: u64) {}
}
