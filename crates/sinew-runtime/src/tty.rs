//! Serial ports, and pseudo-terminals in their place.

use crate::cycle::{Clock, MonotonicClock};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, QueueSelector, tcflush, tcgetattr, tcsetattr};
use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::fd::AsFd;
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

    /// How many are open.
    #[must_use]
    pub fn count(&self) -> usize {
        self.ports.len()
    }

    /// Time of the system's monotonic clock, ns.
    pub fn now(&mut self) -> u64 {
        self.clock.now()
    }

    /// A port once more, for another process.
    ///
    /// # Errors
    /// Of the operating system.
    pub(crate) fn duplicate(&self, line: usize) -> io::Result<Option<File>> {
        self.ports.get(line).map(File::try_clone).transpose()
    }

    /// Sends octets on a port.
    ///
    /// # Errors
    /// Of the operating system, where the adapter is gone.
    pub fn send(&mut self, line: usize, octets: &[u8]) -> io::Result<()> {
        let Some(port) = self.ports.get_mut(line) else { return Ok(()) };
        match port.write(octets) {
            Ok(count) if count == octets.len() => Ok(()),
            // A full queue loses the rest, as the line would.
            Ok(_) => Ok(()),
            Err(error) if error.kind() == ErrorKind::WouldBlock => Ok(()),
            Err(error) => Err(error),
        }
    }

    /// How many octets have come on a port and are now in `buffer`, after waiting for some until a deadline,
    /// ns; 0 where none came.
    ///
    /// # Errors
    /// As [`send`](Self::send).
    pub fn receive(&mut self, line: usize, buffer: &mut [u8], deadline: u64) -> io::Result<usize> {
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
            wait_for_input(&*port, deadline - now)?;
        }
    }

    /// Returns at a time, ns.
    pub fn rest_until(&mut self, time: u64) {
        // Without the clock the exchanges are merely faster.
        let _ = self.clock.wait_until(time);
    }
}

/// Waits until something can be read, or as long, ns.
///
/// # Errors
/// Of the operating system.
pub(crate) fn wait_for_input(from: &impl AsFd, time: u64) -> io::Result<()> {
    let time = Timespec { tv_sec: (time / 1_000_000_000) as i64, tv_nsec: (time % 1_000_000_000) as i64 };
    match poll(&mut [PollFd::new(from, PollFlags::IN)], Some(&time)) {
        Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}

/// A pseudo-terminal: what a master opens under its path is read and written here.
#[derive(Debug)]
pub struct PseudoTerminal {
    ours: File,
    /// Held open, so that a master may come and go.
    _theirs: File,
    path: String,
}

impl PseudoTerminal {
    /// Opens one, without echo and with every octet as it is.
    ///
    /// # Errors
    /// Of the operating system.
    pub fn open() -> io::Result<Self> {
        let ours = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
        grantpt(&ours)?;
        unlockpt(&ours)?;
        let path = ptsname(&ours, Vec::new())?.to_string_lossy().into_owned();
        let theirs = File::options().read(true).write(true).open(&path)?;
        let mut settings = tcgetattr(&theirs)?;
        settings.make_raw();
        tcsetattr(&theirs, OptionalActions::Now, &settings)?;
        let flags = rustix::fs::fcntl_getfl(&ours)?;
        rustix::fs::fcntl_setfl(&ours, flags | OFlags::NONBLOCK)?;
        Ok(Self { ours: File::from(ours), _theirs: theirs, path })
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// Waits until a master has sent something to one of them, at most so long, ns, or 0.1 s.
    ///
    /// # Errors
    /// Of the operating system.
    pub fn wait<'a>(terminals: impl IntoIterator<Item = &'a Self>, most: u64) -> io::Result<()> {
        let waited = terminals.into_iter().map(|terminal| PollFd::new(&terminal.ours, PollFlags::IN));
        let left = Timespec { tv_sec: 0, tv_nsec: most.min(100_000_000) as i64 };
        match poll(&mut waited.collect::<Vec<_>>(), Some(&left)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(error) => Err(error.into()),
        }
    }

    /// Octets that a master has sent, now in `buffer`: 0 where it is gone or none yet.
    ///
    /// # Errors
    /// Of the operating system.
    pub fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        nothing_yet(self.ours.read(buffer))
    }

    /// Sends octets to a master; one that reads nothing loses them, as on a line.
    ///
    /// # Errors
    /// Of the operating system.
    pub fn write(&mut self, octets: &[u8]) -> io::Result<usize> {
        nothing_yet(self.ours.write(octets))
    }
}

/// A master that has closed its end is none yet.
fn nothing_yet(result: io::Result<usize>) -> io::Result<usize> {
    match result {
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
        other => other,
    }
}
