//! Nodes behind an adapter or an interface, in the list of buses; simulated ones for other masters.

use super::bus::CanBus;
use super::device::CanDevice;
use super::error::CanError;
use super::slcan::{Decoder, Line, RATES, encode};
use super::socketcan::SocketCan;
use super::{Link, SimulatedMachine};
use crate::bus::{BusError, Devices, Wire};
use crate::tty::{PseudoTerminal, Ttys};
use sinew::machine::Machine;
use sinew_segment::CanFrame as Frame;
use sinew_session::Plant;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

/// Rate of the adapter's serial line, bit/s; those with a USB of their own have none.
const LINE_RATE: u32 = 115_200;
/// Octets that are sent or come at once, at most.
const OCTETS: usize = 4096;

/// The adapter or interface of nodes whose machine file names none.
struct Adapter(String);

pub(super) fn open(interface: &str) -> Result<Box<dyn Wire>, BusError> {
    Ok(Box::new(Adapter(interface.to_owned())))
}

impl Wire for Adapter {
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
        let Some((port, rate)) =
            nodes.first().map(|node| (node.port.clone().unwrap_or_default(), node.bitrate))
        else {
            return Err(CanError::OtherBus.into());
        };
        let link = connect(&port, rate).map_err(|source| CanError::Port { port, source })?;
        Ok(Box::new(CanBus::start(link, machine, &nodes)?))
    }
}

/// Opens a bus at a rate, bit/s: a path, which has a slash, is the serial port of an adapter with slcan, any
/// other name that of a CAN interface.
///
/// # Errors
/// Of the operating system, as [`Slcan::open`] and [`SocketCan::open`].
pub fn connect(port: &str, bitrate: u32) -> io::Result<Box<dyn Link>> {
    Ok(if port.contains('/') {
        Box::new(Slcan::open(port, bitrate)?)
    } else {
        Box::new(SocketCan::open(port, bitrate)?)
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

/// An adapter that carries frames as text over a serial line.
#[derive(Debug)]
pub struct Slcan {
    port: Ttys,
    decoder: Decoder,
    out: Vec<u8>,
    /// Octets that have come, and how many of them have been looked at.
    buffer: [u8; OCTETS],
    came: usize,
    seen: usize,
}

impl Slcan {
    /// Opens the adapter on a serial port and its bus at a rate, bit/s.
    ///
    /// # Errors
    /// Of the operating system: there is no such port, it is none, or may not be opened; a rate that slcan
    /// does not have.
    pub fn open(path: &str, bitrate: u32) -> io::Result<Self> {
        let rate = RATES.iter().position(|rate| *rate == bitrate);
        let rate = rate.ok_or_else(|| io::Error::other(format!("slcan has no rate of {bitrate} bit/s")))?;
        let mut port = Ttys::default();
        port.open(path, LINE_RATE)?;
        // What was begun before ends; a bus that was open is closed.
        port.send(0, format!("\r\r\rC\rS{rate}\rO\r").as_bytes())?;
        let (decoder, out) = (Decoder::default(), Vec::with_capacity(OCTETS));
        Ok(Self { port, decoder, out, buffer: [0; OCTETS], came: 0, seen: 0 })
    }
}

impl Drop for Slcan {
    fn drop(&mut self) {
        // Where the adapter is gone, there is no bus to close.
        let _ = self.port.send(0, b"C\r");
    }
}

impl Link for Slcan {
    fn now(&mut self) -> u64 {
        self.port.now()
    }

    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        self.out.clear();
        frames.iter().for_each(|frame| encode(&mut self.out, frame));
        self.port.send(0, &self.out)
    }

    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>> {
        loop {
            while self.seen < self.came {
                self.seen += 1;
                if let Some(Line::Frame(frame)) = self.decoder.feed(self.buffer[self.seen - 1]) {
                    return Ok(Some(frame));
                }
            }
            (self.came, self.seen) = (self.port.receive(0, &mut self.buffer, deadline)?, 0);
            if self.came == 0 {
                return Ok(None);
            }
        }
    }

    fn rest_until(&mut self, time: u64) {
        self.port.rest_until(time);
    }

    fn begin_cycle(&mut self, _period: u64) {}
}

/// Answers on a terminal, as an adapter on a bus of a rate, bit/s, with the nodes of a machine in real time,
/// which moves on once a period, ns, until `stop` is set; returns the number of frames that came.
///
/// # Errors
/// Of the operating system.
pub fn serve(
    terminal: &mut PseudoTerminal,
    machine: &mut SimulatedMachine,
    (bitrate, period): (u32, u64),
    stop: &AtomicBool,
) -> io::Result<u64> {
    let (mut decoder, mut out, mut buffer) = (Decoder::default(), Vec::with_capacity(OCTETS), [0; OCTETS]);
    let (mut clock, mut rate, mut open) = (Ttys::default(), 0, false);
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
        for line in buffer[..count].iter().filter_map(|octet| decoder.feed(*octet)) {
            match line {
                // Nodes hear nothing at another rate than theirs.
                Line::Frame(frame) if open && rate == bitrate => {
                    frames += 1;
                    machine.process(&frame, now);
                }
                Line::Command(b'S', digit) => {
                    rate = RATES.get(usize::from(digit.wrapping_sub(b'0'))).copied().unwrap_or(0);
                    out.push(b'\r');
                }
                Line::Command(command @ (b'O' | b'C'), _) => {
                    open = command == b'O';
                    out.push(b'\r');
                }
                Line::Command(b'V', _) => out.extend(b"V0000\r"),
                Line::Command(b'N', _) => out.extend(b"N0000\r"),
                Line::Command(..) | Line::Frame(_) => {}
            }
        }
        while let Some(frame) = machine.take(u64::MAX) {
            if open && rate == bitrate {
                encode(&mut out, &frame);
            }
        }
        if !out.is_empty() {
            // A master that reads nothing loses it, as an adapter's buffer does.
            terminal.write(&out)?;
            out.clear();
        }
    }
    Ok(frames)
}
