//! Simulated chains in the process: virtual time, the machine's twin behind the servos.

use super::machine::SimulatedMachine;
use crate::servos::line::Lines;
use sinew_session::BusFault;
use std::io;

/// Lines to simulated servos, whose machine moves on by a period with every cycle.
#[derive(Debug, Clone)]
pub struct SimulatedLines {
    machine: SimulatedMachine,
    now: u64,
    /// When the cycle began, ns.
    begin: u64,
    injected: Option<BusFault>,
}

impl SimulatedLines {
    /// The lines of a machine.
    #[must_use]
    pub fn new(machine: SimulatedMachine) -> Self {
        Self { machine, now: 0, begin: 0, injected: None }
    }

    /// The machine, to let its servos fail.
    pub fn machine_mut(&mut self) -> &mut SimulatedMachine {
        &mut self.machine
    }
}

impl Lines for SimulatedLines {
    fn count(&self) -> usize {
        self.machine.chains().len()
    }

    fn now(&mut self) -> u64 {
        self.now
    }

    fn send(&mut self, line: usize, octets: &[u8]) -> io::Result<()> {
        if let Some(chain) = self.machine.chains_mut().get_mut(line)
            && self.injected != Some(BusFault::Lost)
        {
            chain.process(octets, self.now);
        }
        Ok(())
    }

    fn receive(&mut self, line: usize, buffer: &mut [u8], deadline: u64) -> io::Result<usize> {
        let Some(chain) = self.machine.chains_mut().get_mut(line) else { return Ok(0) };
        let due = chain.next_due().unwrap_or(u64::MAX);
        self.now = self.now.max(due.min(deadline));
        Ok(chain.take(buffer, self.now))
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
