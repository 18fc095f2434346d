//! A simulated bus in the process: virtual time, the machine's twin behind the nodes.

use super::Link;
use super::sign::Sign;
use super::simulated::SimulatedMachine;
use crate::virtual_time::VirtualTime;
use sinew_segment::CanFrame as Frame;
use sinew_session::BusFault;
use std::io;

/// The nodes of a machine in the process, which moves on by a period with every cycle.
#[derive(Debug, Clone)]
pub struct SimulatedLink {
    time: VirtualTime<SimulatedMachine>,
    /// Whether the cable is cut: nothing comes through.
    cut: bool,
    guard: Option<Guard>,
}

/// The watchdog beside a program, in virtual time.
#[derive(Debug, Clone)]
struct Guard {
    leave: Vec<Frame>,
    time: u64,
    /// The last sign of life, and when it came, ns; whether it has ended.
    last: (Sign, u64),
    ended: bool,
}

impl SimulatedLink {
    /// The bus of a machine.
    #[must_use]
    pub fn new(machine: SimulatedMachine) -> Self {
        Self { time: VirtualTime::new(machine), cut: false, guard: None }
    }

    /// The machine, to let its nodes fail.
    pub fn machine_mut(&mut self) -> &mut SimulatedMachine {
        &mut self.time.machine
    }

    /// Cuts the cable behind the adapter.
    pub fn cut(&mut self) {
        self.cut = true;
    }
}

impl Link for SimulatedLink {
    fn carries_fd(&self) -> bool {
        true
    }

    fn now(&mut self) -> u64 {
        self.time.now
    }

    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        if !self.cut && self.time.injected != Some(BusFault::Lost) {
            frames.iter().for_each(|frame| self.time.machine.process(frame, self.time.now));
        }
        Ok(())
    }

    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>> {
        let due = self.time.machine.next_due().filter(|_| !self.cut);
        let now = self.time.wait(due, deadline);
        Ok(self.time.machine.take(now).filter(|_| !self.cut))
    }

    fn rest_until(&mut self, time: u64) {
        self.time.rest_until(time);
    }

    fn begin_cycle(&mut self, period: u64) {
        self.time.begin_cycle(period);
        let Self { time, cut, guard: Some(guard) } = self else { return };
        let (sign, at) = guard.last;
        if sign != Sign::Rest && time.now.saturating_sub(at) > guard.time {
            (guard.last.0, guard.ended) = (Sign::Rest, sign == Sign::Alive);
            guard.leave.iter().filter(|_| !*cut).for_each(|frame| time.machine.process(frame, time.now));
        }
    }

    fn guard(&mut self, leave: &[Frame], time: u64) -> io::Result<()> {
        let last = (Sign::Rest, self.time.now);
        self.guard = Some(Guard { leave: leave.to_vec(), time, last, ended: false });
        Ok(())
    }

    fn sign(&mut self, sign: Sign) -> io::Result<()> {
        match &mut self.guard {
            Some(guard) if guard.ended => Err(io::ErrorKind::BrokenPipe.into()),
            Some(guard) => {
                guard.last = (sign, self.time.now);
                Ok(())
            }
            None => Ok(()),
        }
    }

    fn injected(&self) -> Option<BusFault> {
        self.time.injected
    }

    fn simulated(&self) -> Option<&SimulatedMachine> {
        Some(&self.time.machine)
    }
}
