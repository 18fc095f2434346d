//! Servos on serial ports.

use super::line::Lines;
use crate::cycle::{Clock, MonotonicClock};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::termios::{OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr};
use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::unix::fs::OpenOptionsExt as _;

/// Serial ports.
#[derive(Debug, Default)]
pub struct Ttys {
    ports: Vec<File>,
    clock: MonotonicClock,
}

impl Ttys {
    /// Opens one more port at a rate, bit/s: 8 data bits, no parity, one stop bit.
    ///
    /// # Errors
    /// Of the operating system: there is no such port, it is none, or may not be opened.
    pub fn open(&mut self, path: &str, baud: u32) -> io::Result<()> {
        let flags = (OFlags::NOCTTY | OFlags::NONBLOCK).bits().cast_signed();
        let port = File::options().read(true).write(true).custom_flags(flags).open(path)?;
        self.ports.push(port);
        let set = self.set_baud(self.ports.len() - 1, baud);
        if set.is_err() {
            self.ports.pop();
        }
        set
    }

    /// Changes the rate of a port, bit/s; what has come before is left out.
    ///
    /// # Errors
    /// Of the operating system: the adapter has no such rate.
    pub fn set_baud(&mut self, line: usize, baud: u32) -> io::Result<()> {
        let Some(port) = self.ports.get(line) else { return Ok(()) };
        let mut settings = tcgetattr(port)?;
        settings.make_raw();
        settings.set_speed(baud)?;
        tcsetattr(port, OptionalActions::Flush, &settings)?;
        Ok(tcflush(port, QueueSelector::IOFlush)?)
    }
}

impl Lines for Ttys {
    fn count(&self) -> usize {
        self.ports.len()
    }

    fn now(&mut self) -> u64 {
        self.clock.now()
    }

    fn send(&mut self, line: usize, octets: &[u8]) -> io::Result<()> {
        let Some(port) = self.ports.get_mut(line) else { return Ok(()) };
        match port.write(octets) {
            Ok(count) if count == octets.len() => Ok(()),
            // A full queue loses the rest, as the line would.
            Ok(_) => Ok(()),
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(()),
            Err(error) => Err(error),
        }
    }

    fn receive(&mut self, line: usize, buffer: &mut [u8], deadline: u64) -> io::Result<usize> {
        loop {
            let now = self.clock.now();
            let Some(port) = self.ports.get_mut(line) else { return Ok(0) };
            match port.read(buffer) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => return Ok(count),
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
                Err(error) => return Err(error),
            }
            if now >= deadline {
                return Ok(0);
            }
            let left = Timespec {
                tv_sec: ((deadline - now) / 1_000_000_000) as i64,
                tv_nsec: ((deadline - now) % 1_000_000_000) as i64,
            };
            match poll(&mut [PollFd::new(port, PollFlags::IN)], Some(&left)) {
                Ok(_) | Err(rustix::io::Errno::INTR) => {}
                Err(error) => return Err(error.into()),
            }
        }
    }

    fn rest_until(&mut self, time: u64) {
        // Without the clock the exchanges are merely faster.
        let _ = self.clock.wait_until(time);
    }

    fn begin_cycle(&mut self, _period: u64) {}
}
