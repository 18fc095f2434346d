//! A simulated bus in the process: virtual time, the machine's twin behind the nodes.

use super::Link;
use super::simulated::SimulatedMachine;
use sinew_segment::CanFrame as Frame;
use sinew_session::BusFault;
use std::io;

/// The nodes of a machine in the process, which moves on by a period with every cycle.
#[derive(Debug, Clone)]
pub struct SimulatedLink {
    machine: SimulatedMachine,
    now: u64,
    /// When the cycle began, ns.
    begin: u64,
    injected: Option<BusFault>,
    /// Whether the cable is cut: nothing comes through.
    cut: bool,
}

impl SimulatedLink {
    /// The bus of a machine.
    #[must_use]
    pub fn new(machine: SimulatedMachine) -> Self {
        Self { machine, now: 0, begin: 0, injected: None, cut: false }
    }

    /// The machine, to let its nodes fail.
    pub fn machine_mut(&mut self) -> &mut SimulatedMachine {
        &mut self.machine
    }

    /// Cuts the cable behind the adapter.
    pub fn cut(&mut self) {
        self.cut = true;
    }
}

impl Link for SimulatedLink {
    fn now(&mut self) -> u64 {
        self.now
    }

    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        if !self.cut && self.injected != Some(BusFault::Lost) {
            frames.iter().for_each(|frame| self.machine.process(frame, self.now));
        }
        Ok(())
    }

    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>> {
        let due = self.machine.next_due().filter(|_| !self.cut).unwrap_or(u64::MAX);
        self.now = self.now.max(due.min(deadline));
        Ok(self.machine.take(self.now).filter(|_| !self.cut))
    }

    fn rest_until(&mut self, time: u64) {
        self.now = self.now.max(time);
    }

    fn begin_cycle(&mut self, period: u64) {
        self.begin = (self.begin + period).max(self.now);
        self.now = self.begin;
        self.injected = self.machine.injected(period);
        self.machine.advance(period, self.now);
    }

    fn injected(&self) -> Option<BusFault> {
        self.injected
    }

    fn simulated(&self) -> Option<&SimulatedMachine> {
        Some(&self.machine)
    }
}
