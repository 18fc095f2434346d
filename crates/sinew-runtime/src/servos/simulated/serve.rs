//! Simulated servos on pseudo-terminals, for other masters.

use super::machine::SimulatedMachine;
use crate::cycle::{Clock, MonotonicClock};
use crate::tty::PseudoTerminal;
use sinew::twin::arm::ArmTwin;
use std::io;
use std::sync::atomic::{AtomicBool, Ordering};

/// Answers on a terminal for every chain of a machine in real time, with the machine moving on once a period,
/// ns, until `stop` is set; `seen` is shown the machine after each. Returns the number of octets that came.
///
/// # Errors
/// Of the operating system.
pub fn serve(
    terminals: &mut [PseudoTerminal],
    machine: &mut SimulatedMachine,
    period: u64,
    stop: &AtomicBool,
    seen: &mut dyn FnMut(&ArmTwin),
) -> io::Result<u64> {
    let mut clock = MonotonicClock;
    let (start, mut advanced, mut octets) = (clock.now(), 0, 0);
    let mut buffer = [0; 4096];
    while !stop.load(Ordering::Relaxed) {
        let now = clock.now() - start;
        let answers = machine.chains().iter().filter_map(|chain| chain.next_due()).min();
        let wake = answers.unwrap_or(u64::MAX).min((advanced + 1) * period);
        PseudoTerminal::wait(&*terminals, wake.saturating_sub(now))?;
        let now = clock.now() - start;
        // Where the system was late, several periods have passed.
        while advanced < now / period {
            advanced += 1;
            machine.advance(period, advanced * period);
            seen(machine.arm());
        }
        for (terminal, chain) in terminals.iter_mut().zip(machine.chains_mut()) {
            let read = terminal.read(&mut buffer)?;
            if read > 0 {
                octets += read as u64;
                chain.process(&buffer[..read], now);
            }
            let count = chain.take(&mut buffer, now);
            if count > 0 {
                terminal.write(&buffer[..count])?;
            }
        }
    }
    Ok(octets)
}
