//! The process beside a program, seen from within: without a sign of life it tells the motors to leave.
//!
//! A serial port it writes through the program's own descriptor, a CAN interface through a socket of its own.

use super::guard::{NAME, UNREAD, set_nonblocking};
use super::sign::Sign;
use super::slcan;
use super::socketcan::SocketCan;
use super::{Frame, Link as _, mit};
use crate::cycle::{Clock as _, MonotonicClock, RealTime};
use crate::tty::wait_for_input;
use std::fs::File;
use std::io::{self, ErrorKind, Read as _, Write as _};
use std::os::fd::AsFd as _;
use std::process::ExitCode;

/// Times that it tells all motors to leave, and the time between them, ns: a frame may be lost.
const TIMES: usize = 5;
const BETWEEN: u64 = 2_000_000;

/// Where the program was started as the watchdog of another one, is that until it has acted; the first thing
/// that a program does whose machines have motors in MIT mode. None in any other start.
#[must_use]
pub fn watch() -> Option<ExitCode> {
    let mut arguments = std::env::args_os().skip(1);
    if arguments.next()? != NAME {
        return None;
    }
    let arguments: Vec<_> = arguments.map(|argument| argument.to_string_lossy().into_owned()).collect();
    Some(run(&arguments).map_or(ExitCode::FAILURE, |()| ExitCode::SUCCESS))
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
