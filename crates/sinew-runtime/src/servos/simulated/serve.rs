//! Simulated servos on pseudo-terminals, for other masters.

use super::machine::SimulatedMachine;
use crate::cycle::{Clock, MonotonicClock};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::OFlags;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};

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
}

/// Answers on a terminal for every chain of a machine in real time, with the machine moving on once a period,
/// ns, until `stop` is set; returns the number of octets that came.
///
/// # Errors
/// Of the operating system.
pub fn serve(
    terminals: &mut [PseudoTerminal],
    machine: &mut SimulatedMachine,
    period: u64,
    stop: &AtomicBool,
) -> io::Result<u64> {
    let mut clock = MonotonicClock;
    let (start, mut advanced, mut octets) = (clock.now(), 0, 0);
    let mut buffer = [0; 4096];
    while !stop.load(Ordering::Relaxed) {
        let now = clock.now() - start;
        let answers = machine.chains().iter().filter_map(|chain| chain.next_due()).min();
        let wake = answers.unwrap_or(u64::MAX).min((advanced + 1) * period);
        let mut waited: Vec<PollFd<'_>> =
            terminals.iter().map(|terminal| PollFd::new(&terminal.ours, PollFlags::IN)).collect();
        let left = Timespec { tv_sec: 0, tv_nsec: wake.saturating_sub(now).min(100_000_000) as i64 };
        match poll(&mut waited, Some(&left)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => {}
            Err(error) => return Err(error.into()),
        }
        drop(waited);
        let now = clock.now() - start;
        // Where the system was late, several periods have passed.
        while advanced < now / period {
            advanced += 1;
            machine.advance(period, advanced * period);
        }
        for (terminal, chain) in terminals.iter_mut().zip(machine.chains_mut()) {
            let read = nothing_yet(terminal.ours.read(&mut buffer))?;
            if read > 0 {
                octets += read as u64;
                chain.process(&buffer[..read], now);
            }
            let count = chain.take(&mut buffer, now);
            if count > 0 {
                // A master that reads nothing loses it, as on a line.
                nothing_yet(terminal.ours.write(&buffer[..count]))?;
            }
        }
    }
    Ok(octets)
}

/// A master that has closed its end is none yet.
fn nothing_yet(result: io::Result<usize>) -> io::Result<usize> {
    match result {
        Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => Ok(0),
        other => other,
    }
}
