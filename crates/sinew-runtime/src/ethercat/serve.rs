//! The simulated segment on a real interface, for other masters.

use super::pump::MAX_FRAME;
use super::simulated_machine::SimulatedMachine;
use crate::cycle::{Clock, MonotonicClock};
use sinew::twin::arm::ArmTwin;
use sinew_segment::{Passed, RawSocket, RawSocketError, Segment};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// Answers every EtherCAT frame on an interface in real time, with the machine behind the devices advancing
/// once a period, ns, until `stop` is set; `seen` is shown the machine after each. Returns the number of
/// answered frames.
///
/// # Errors
/// [`RawSocketError`] where the interface goes down.
pub fn serve(
    socket: &RawSocket,
    (segment, machine): (&mut Segment, &mut SimulatedMachine),
    period: u64,
    stop: &AtomicBool,
    seen: &mut dyn FnMut(&ArmTwin),
) -> Result<u64, RawSocketError> {
    let mut clock = MonotonicClock;
    let (start, offset) = (clock.now(), segment.now());
    let (mut frame, mut answered, mut advanced) = ([0; MAX_FRAME], 0, 0);
    while !stop.load(Ordering::Relaxed) {
        let now = clock.now() - start;
        let left = period - now % period;
        let received = socket.receive(&mut frame, Duration::from_nanos(left))?;
        let now = clock.now() - start;
        segment.advance((offset + now).saturating_sub(segment.now()));
        // Where the system was late, several periods have passed.
        while advanced < now / period {
            machine.advance(segment, period);
            seen(machine.arm());
            advanced += 1;
        }
        let Some(length) = received else { continue };
        if let Some(Passed::Returned { .. }) = frame.get_mut(..length).map(|frame| segment.process(frame)) {
            socket.send(&frame[..length])?;
            answered += 1;
        }
    }
    Ok(answered)
}
