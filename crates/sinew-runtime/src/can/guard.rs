//! A process beside the program that takes the power of motors whose firmware does not watch for its master.
//!
//! ```text
//! program --sign of life, every cycle--> pipe --> `watch` --none for the time, or the pipe is closed--> leave
//! ```
//!
//! It is the program's own executable with [`NAME`] as its first argument, in a process group of its own, so
//! that neither the keys that stop the program nor its end stop it. A serial port it writes through the
//! program's own descriptor, a CAN interface through a socket of its own.

use super::sign::Sign;
use super::slcan;
use super::socketcan::SocketCan;
use super::{Frame, Link, mit};
use crate::cycle::{Clock as _, MonotonicClock, RealTime};
use crate::tty::wait_for_input;
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use rustix::pipe::fcntl_setpipe_size;
use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::fd::AsFd;
use std::os::unix::process::CommandExt as _;
use std::process::{Child, Command, ExitCode, Stdio};
use std::time::Duration;

/// First argument and variable of the environment of such a process.
const NAME: &str = "SINEW_CAN_WATCHDOG";
/// Octets of a sign, and of all signs that wait to be read, at most: a watchdog that does not read for so
/// many cycles is none.
const SIGN: usize = 128;
const UNREAD: usize = 4096;
/// Times that it tells all motors to leave, and the time between them, ns: a frame may be lost.
const TIMES: usize = 5;
const BETWEEN: u64 = 2_000_000;
/// Times 2 ms, for which its end is waited for.
const PATIENCE: u32 = 100;

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
        command.arg(NAME).arg(port).arg(time.to_string()).args(leave.iter().map(|frame| frame.id().to_string()));
        command.env(NAME, "1").process_group(0);
        command.stdin(Stdio::piped()).stderr(Stdio::null()).stdout(line.map_or_else(Stdio::null, Stdio::from));
        let guard = Self(command.spawn()?);
        if let Some(signs) = &guard.0.stdin {
            set_nonblocking(signs)?;
            fcntl_setpipe_size(signs, UNREAD)?;
        }
        Ok(guard)
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
            std::thread::sleep(Duration::from_millis(2));
        }
        // One that was stopped says nothing any more.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

fn set_nonblocking(file: &impl AsFd) -> io::Result<()> {
    let flags = fcntl_getfl(file)?;
    Ok(fcntl_setfl(file, flags | OFlags::NONBLOCK)?)
}

/// Where the program was started as the watchdog of another one, is that until it has acted; the first thing
/// that a program does whose machines have motors in MIT mode. None in any other start.
#[must_use]
pub fn watch() -> Option<ExitCode> {
    let mut arguments = std::env::args().skip(1);
    if arguments.next()? != NAME {
        return None;
    }
    Some(run(&arguments.collect::<Vec<_>>()).map_or(ExitCode::FAILURE, |()| ExitCode::SUCCESS))
}

fn run(arguments: &[String]) -> io::Result<()> {
    // Without it the watchdog is later where the computer is busy.
    let _ = RealTime::request();
    let number = |text: &String| text.parse::<u64>().map_err(io::Error::other);
    let [port, time, nodes @ ..] = arguments else { return Err(ErrorKind::InvalidInput.into()) };
    let (time, nodes) = (number(time)?, nodes.iter().map(number).collect::<io::Result<Vec<_>>>()?);
    let leave: Vec<Frame> = nodes.into_iter().map(|node| mit::leave(node as u8)).collect();
    let mut out = Way::open(port, &leave)?;
    let mut signs = File::from(io::stdin().as_fd().try_clone_to_owned()?);
    set_nonblocking(&signs)?;
    let (mut clock, mut buffer) = (MonotonicClock, [0; UNREAD]);
    // The last sign, and until when the next one has to come.
    let (mut last, mut deadline) = (Sign::Rest, u64::MAX);
    loop {
        match signs.read(&mut buffer) {
            Ok(0) => return out.leave(&leave),
            Ok(count) => {
                let sign = Sign::ALL.iter().find(|(_, octet)| *octet == buffer[count - 1]);
                last = sign.map_or(Sign::Rest, |(sign, _)| *sign);
                deadline = if last == Sign::Rest { u64::MAX } else { clock.now() + time };
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
            Err(error) => return out.leave(&leave).and(Err(error)),
        }
        let now = clock.now();
        if now >= deadline {
            out.leave(&leave)?;
            if last == Sign::Alive {
                return Ok(());
            }
            deadline = u64::MAX;
            continue;
        }
        wait_for_input(&signs, (deadline - now).min(1_000_000_000))?;
    }
}

/// How frames leave the computer.
enum Way {
    Serial(File, Vec<u8>),
    Interface(SocketCan),
}

impl Way {
    fn open(port: &str, leave: &[Frame]) -> io::Result<Self> {
        if !port.contains('/') {
            return Ok(Self::Interface(SocketCan::open(port, 0, false)?));
        }
        // What was begun ends.
        let mut text = b"\r".to_vec();
        leave.iter().for_each(|frame| slcan::encode(&mut text, frame));
        Ok(Self::Serial(File::from(io::stdout().as_fd().try_clone_to_owned()?), text))
    }

    /// Tells all to leave, some times. What the port does not take now it takes the next time.
    fn leave(&mut self, leave: &[Frame]) -> io::Result<()> {
        let mut clock = MonotonicClock;
        for _ in 0..TIMES {
            match self {
                Self::Serial(port, text) => drop(port.write(text)),
                Self::Interface(socket) => drop(socket.send(leave)),
            }
            let next = clock.now() + BETWEEN;
            clock.wait_until(next)?;
        }
        Ok(())
    }
}
