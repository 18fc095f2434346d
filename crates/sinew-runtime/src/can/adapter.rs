//! Adapters that carry frames as text over a serial line.

use sinew_segment::CanFrame as Frame;
use std::fmt::Debug;
use std::io;

#[cfg(target_os = "linux")]
use {super::Link, super::guard::Guard, super::sign::Sign, crate::tty::Ttys};

/// How an adapter writes frames.
pub trait Dialect: Debug + Default {
    /// Whether it has frames of CAN FD.
    const CARRIES_FD: bool;
    /// What closes its bus.
    const CLOSE: &[u8];

    /// What opens its bus at a rate, bit/s.
    ///
    /// # Errors
    /// It has no such rate.
    fn open(bitrate: u32) -> io::Result<String>;

    /// Appends a frame to be sent, within the capacity of `out` without an allocation.
    fn encode(out: &mut Vec<u8>, frame: &Frame);

    /// Takes an octet of the adapter; the frame that it ends.
    fn feed(&mut self, octet: u8) -> Option<Frame>;
}

/// A simulated adapter, as its host sees it.
pub(super) trait Host: Debug {
    /// Takes an octet of the host, and appends what it is answered; the frame that goes on the bus.
    fn take(&mut self, octet: u8, out: &mut Vec<u8>) -> Option<Frame>;

    /// Appends a frame that comes from the bus.
    fn show(&self, frame: &Frame, out: &mut Vec<u8>);
}

/// Rate of the adapter's serial line, bit/s; those with a USB of their own have none.
#[cfg(target_os = "linux")]
const LINE_RATE: u32 = 115_200;
/// Octets that are sent or come at once, at most.
pub(super) const OCTETS: usize = 4096;

/// An adapter on a serial port.
#[cfg(target_os = "linux")]
#[derive(Debug)]
pub struct Adapter<D: Dialect> {
    guard: Option<Guard>,
    path: String,
    port: Ttys,
    dialect: D,
    out: Vec<u8>,
    /// Octets that have come, and how many of them have been looked at.
    buffer: [u8; OCTETS],
    came: usize,
    seen: usize,
}

#[cfg(target_os = "linux")]
impl<D: Dialect> Adapter<D> {
    /// Opens the adapter on a serial port and its bus at a rate, bit/s.
    ///
    /// # Errors
    /// Of the operating system: there is no such port, it is none, or may not be opened; a rate that the
    /// adapter does not have.
    pub fn open(path: &str, bitrate: u32) -> io::Result<Self> {
        let begin = D::open(bitrate)?;
        let mut port = Ttys::default();
        port.open(path, LINE_RATE)?;
        port.send(0, begin.as_bytes())?;
        let (dialect, out) = (D::default(), Vec::with_capacity(OCTETS));
        let path = path.to_owned();
        Ok(Self { guard: None, path, port, dialect, out, buffer: [0; OCTETS], came: 0, seen: 0 })
    }
}

#[cfg(target_os = "linux")]
impl<D: Dialect> Drop for Adapter<D> {
    fn drop(&mut self) {
        // It says its last through the open bus.
        self.guard = None;
        // Where the adapter is gone, there is no bus to close.
        let _ = self.port.send(0, D::CLOSE);
    }
}

#[cfg(target_os = "linux")]
impl<D: Dialect> Link for Adapter<D> {
    fn carries_fd(&self) -> bool {
        D::CARRIES_FD
    }

    fn now(&mut self) -> u64 {
        self.port.now()
    }

    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        self.out.clear();
        frames.iter().for_each(|frame| D::encode(&mut self.out, frame));
        self.port.send(0, &self.out)
    }

    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>> {
        loop {
            while self.seen < self.came {
                self.seen += 1;
                if let Some(frame) = self.dialect.feed(self.buffer[self.seen - 1]) {
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

    fn guard(&mut self, leave: &[Frame], time: u64) -> io::Result<()> {
        if D::CARRIES_FD {
            return Err(io::ErrorKind::Unsupported.into());
        }
        self.guard = Some(Guard::start(&self.path, self.port.duplicate(0)?, leave, time)?);
        Ok(())
    }

    fn sign(&mut self, sign: Sign) -> io::Result<()> {
        self.guard.as_mut().map_or(Ok(()), |guard| guard.sign(sign))
    }
}
