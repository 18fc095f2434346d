//! Simulated chains in the process: virtual time, the machine's twin behind the servos.

use super::machine::SimulatedMachine;
use crate::servos::line::Lines;
use crate::virtual_time::VirtualTime;
use sinew_session::BusFault;
use std::io;

/// Lines to simulated servos, whose machine moves on by a period with every cycle.
#[derive(Debug, Clone)]
pub struct SimulatedLines(VirtualTime<SimulatedMachine>);

impl SimulatedLines {
    /// The lines of a machine.
    #[must_use]
    pub fn new(machine: SimulatedMachine) -> Self {
        Self(VirtualTime::new(machine))
    }

    /// The machine, to let its servos fail.
    pub fn machine_mut(&mut self) -> &mut SimulatedMachine {
        &mut self.0.machine
    }
}

impl Lines for SimulatedLines {
    fn count(&self) -> usize {
        self.0.machine.chains().len()
    }

    fn now(&mut self) -> u64 {
        self.0.now
    }

    fn send(&mut self, line: usize, octets: &[u8]) -> io::Result<()> {
        if let Some(chain) = self.0.machine.chains_mut().get_mut(line)
            && self.0.injected != Some(BusFault::Lost)
        {
            chain.process(octets, self.0.now);
        }
        Ok(())
    }

    fn receive(&mut self, line: usize, buffer: &mut [u8], deadline: u64) -> io::Result<usize> {
        let Some(chain) = self.0.machine.chains().get(line) else { return Ok(0) };
        let now = self.0.wait(chain.next_due(), deadline);
        Ok(self.0.machine.chains_mut().get_mut(line).map_or(0, |chain| chain.take(buffer, now)))
    }

    fn rest_until(&mut self, time: u64) {
        self.0.rest_until(time);
    }

    fn begin_cycle(&mut self, period: u64) {
        self.0.begin_cycle(period);
    }

    fn injected(&self) -> Option<BusFault> {
        self.0.injected
    }

    fn simulated(&self) -> Option<&SimulatedMachine> {
        Some(&self.0.machine)
    }
}
