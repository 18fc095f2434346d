//! A process beside the program that takes the power of motors whose firmware does not watch for its master.
//!
//! ```text
//! program --sign of life, every cycle--> pipe --> `watch` --none for the time, or the pipe is closed--> leave
//! ```
//!
//! It is the program's own executable with [`NAME`] as its first argument, in a process group of its own, so
//! that neither the keys that stop the program nor its end stop it.

use super::sign::Sign;
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::io::ioctl_fionread;
use rustix::pipe::fcntl_setpipe_size;
use sinew_segment::CanFrame as Frame;
use std::fs::File;
use std::io::{self, ErrorKind, Write as _};
use std::os::fd::AsFd;
use std::os::unix::process::CommandExt as _;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

/// First argument and variable of the environment of such a process.
pub(super) const NAME: &str = "SINEW_CAN_WATCHDOG";
/// Octets of a sign, of which a cycle gives two, and of all signs that wait to be read, at most: a watchdog
/// that does not read for so many cycles is none.
const SIGN: usize = 64;
pub(super) const UNREAD: usize = 4096;
/// Times that it is looked at whether it has begun or ended, and the time between them.
const PATIENCE: u32 = 500;
const BETWEEN: Duration = Duration::from_millis(2);

/// The process, as the program has it. Dropped, it tells the motors to leave, and ends.
#[derive(Debug)]
pub(super) struct Guard(Child);

impl Guard {
    /// Starts it for motors that leave by these frames after a time, ns, without a sign of life; `line` is
    /// the serial port of an adapter with slcan, none a CAN interface.
    pub(super) fn start(port: &str, line: Option<File>, leave: &[Frame], time: u64) -> io::Result<Self> {
        if std::env::var_os(NAME).is_some() {
            return Err(io::Error::other("this program does not know that it is a watchdog"));
        }
        let mut command = Command::new("/proc/self/exe");
        command
            .arg(NAME)
            .arg(port)
            .arg(time.to_string())
            .args(leave.iter().map(|frame| frame.id().to_string()));
        command.env(NAME, "1").process_group(0);
        command
            .stdin(Stdio::piped())
            .stderr(Stdio::null())
            .stdout(line.map_or_else(Stdio::null, Stdio::from));
        let mut guard = Self(command.spawn()?);
        if let Some(signs) = &guard.0.stdin {
            set_nonblocking(signs)?;
            fcntl_setpipe_size(signs, UNREAD)?;
        }
        guard.sign(Sign::Rest)?;
        // Once it has read that, it is there.
        for _ in 0..PATIENCE {
            let unread = guard.0.stdin.as_ref().map_or(Ok(0), ioctl_fionread)?;
            if unread == 0 {
                return Ok(guard);
            }
            if guard.0.try_wait()?.is_some() {
                return Err(ErrorKind::BrokenPipe.into());
            }
            std::thread::sleep(BETWEEN);
        }
        Err(ErrorKind::TimedOut.into())
    }

    /// A sign of life.
    pub(super) fn sign(&mut self, sign: Sign) -> io::Result<()> {
        let Some(signs) = &mut self.0.stdin else { return Err(ErrorKind::BrokenPipe.into()) };
        let octet = Sign::ALL.iter().find(|(of, _)| *of == sign).map_or(0, |(_, octet)| *octet);
        signs.write(&[octet; SIGN]).map(drop)
    }
}

impl Drop for Guard {
    fn drop(&mut self) {
        drop(self.0.stdin.take());
        for _ in 0..PATIENCE {
            if !matches!(self.0.try_wait(), Ok(None)) {
                return;
            }
            std::thread::sleep(BETWEEN);
        }
        // One that was stopped says nothing any more.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

pub(super) fn set_nonblocking(file: &impl AsFd) -> io::Result<()> {
    let flags = fcntl_getfl(file)?;
    Ok(fcntl_setfl(file, flags | OFlags::NONBLOCK)?)
}
