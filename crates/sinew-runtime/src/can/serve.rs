//! Simulated nodes in real time, for other masters.

use super::adapter::{Host, OCTETS};
use super::device::{CanDevice, Protocol};
use super::fdcanusb::FdcanusbHost;
use super::slcan::SlcanHost;
use super::{Link, SimulatedMachine};
use crate::cycle::{Clock as _, MonotonicClock};
use crate::tty::PseudoTerminal;
use sinew::twin::arm::ArmTwin;
use sinew_segment::CanFrame as Frame;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

/// The bus behind an adapter on a pseudo-terminal: frames of its host come, what is sent is shown to it.
#[derive(Debug)]
pub struct HostedAdapter {
    terminal: PseudoTerminal,
    host: Box<dyn Host>,
    out: Vec<u8>,
    /// Octets that have come, and how many of them have been looked at.
    buffer: [u8; OCTETS],
    came: usize,
    seen: usize,
    clock: MonotonicClock,
}

impl HostedAdapter {
    /// Opens a terminal with the adapter of a device's bus: an fdcanusb for moteus, slcan for others.
    ///
    /// # Errors
    /// Of the operating system.
    pub fn open(device: &CanDevice) -> io::Result<Self> {
        let host: Box<dyn Host> = match device.protocol {
            Protocol::Moteus => Box::new(FdcanusbHost::default()),
            Protocol::Canopen | Protocol::Cansimple | Protocol::Mit => {
                Box::new(SlcanHost::new(device.bitrate))
            }
        };
        let (terminal, out) = (PseudoTerminal::open()?, Vec::with_capacity(OCTETS));
        Ok(Self { terminal, host, out, buffer: [0; OCTETS], came: 0, seen: 0, clock: MonotonicClock })
    }

    /// Path of the terminal.
    #[must_use]
    pub fn path(&self) -> &str {
        self.terminal.path()
    }

    /// A host that reads nothing loses what it is shown, as an adapter's buffer does.
    fn show(&mut self) -> io::Result<()> {
        if !self.out.is_empty() {
            self.terminal.write(&self.out)?;
            self.out.clear();
        }
        Ok(())
    }
}

impl Link for HostedAdapter {
    fn now(&mut self) -> u64 {
        self.clock.now()
    }

    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        frames.iter().for_each(|frame| self.host.show(frame, &mut self.out));
        self.show()
    }

    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>> {
        loop {
            while self.seen < self.came {
                self.seen += 1;
                if let Some(frame) = self.host.take(self.buffer[self.seen - 1], &mut self.out) {
                    return Ok(Some(frame));
                }
            }
            self.show()?;
            (self.came, self.seen) = (self.terminal.read(&mut self.buffer)?, 0);
            if self.came == 0 {
                let now = self.clock.now();
                if now >= deadline {
                    return Ok(None);
                }
                PseudoTerminal::wait([&self.terminal], deadline - now)?;
            }
        }
    }

    fn rest_until(&mut self, time: u64) {
        // Without the clock the exchanges are merely faster.
        let _ = self.clock.wait_until(time);
    }

    fn begin_cycle(&mut self, _period: u64) {}
}

/// Answers on a bus with the nodes of a machine in real time, which moves on once a period, ns, until `stop`
/// is set; `seen` is shown the machine after each. Returns the number of frames that came.
///
/// # Errors
/// Of the operating system.
pub fn serve(
    bus: &mut dyn Link,
    machine: &mut SimulatedMachine,
    period: u64,
    stop: &AtomicBool,
    seen: &mut dyn FnMut(&ArmTwin),
) -> io::Result<u64> {
    let (start, mut advanced, mut frames, mut answers) = (bus.now(), 0, 0, Vec::new());
    while !stop.load(Ordering::Relaxed) {
        let frame = bus.receive(start + (advanced + 1) * period)?;
        let now = bus.now() - start;
        // Where the system was late, several periods have passed.
        while advanced < now / period {
            advanced += 1;
            machine.advance(period, advanced * period);
            seen(machine.arm());
        }
        if let Some(frame) = frame {
            frames += 1;
            machine.process(&frame, now);
        }
        answers.extend(std::iter::from_fn(|| machine.take(u64::MAX)));
        if !answers.is_empty() {
            bus.send(&answers)?;
            answers.clear();
        }
    }
    Ok(frames)
}
