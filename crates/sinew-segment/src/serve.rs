//! A simulated segment on a real interface, in real time, for masters of others.

use crate::raw_socket::{RawSocket, RawSocketError};
use crate::segment::{Passed, Segment};
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use std::time::Instant;

/// Without frames the devices run at least this often.
const IDLE: Duration = Duration::from_micros(500);
/// A shorter delay of a frame is less than what waking up takes.
const NOTICEABLE: Duration = Duration::from_micros(50);
/// The longest frame with a VLAN tag.
const LONGEST: usize = 1518;

/// What was served.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Served {
    /// Frames of masters.
    pub frames: u64,
    /// Frames that went back.
    pub answers: u64,
    /// Frames that were not EtherCAT, damaged or lost by injected faults.
    pub dropped: u64,
    /// Answers that the interface had no room for.
    pub overruns: u64,
}

/// Answers frames on an interface until `stop` is set. Virtual time follows the clock. `application` is
/// called after virtual time has passed, with the nanoseconds that did: there motors and loads are simulated.
///
/// # Errors
///
/// The interface is down or gone.
pub fn serve(
    socket: &RawSocket,
    segment: &mut Segment,
    stop: &AtomicBool,
    mut application: impl FnMut(&mut Segment, u64),
) -> Result<Served, RawSocketError> {
    let mut served = Served::default();
    let mut frame = [0; LONGEST];
    // Frames that a fault holds back, with the time at which they are due.
    let mut late: Vec<(Instant, Vec<u8>)> = Vec::new();
    let mut last = Instant::now();
    while !stop.load(Ordering::Relaxed) {
        let due = late.iter().map(|(due, _)| due.saturating_duration_since(last)).min();
        let received = socket.receive(&mut frame, due.unwrap_or(IDLE).min(IDLE))?;
        let now = Instant::now();
        let elapsed = u64::try_from((now - last).as_nanos()).unwrap_or(u64::MAX);
        last = now;
        segment.advance(elapsed);
        application(segment, elapsed);
        if let Some(length) = received {
            served.frames += 1;
            let frame = &mut frame[..length.min(LONGEST)];
            match segment.process(frame) {
                Passed::Returned { delay_ns } if Duration::from_nanos(delay_ns) >= NOTICEABLE => {
                    late.push((now + Duration::from_nanos(delay_ns), frame.to_vec()));
                }
                Passed::Returned { .. } | Passed::Malformed => answer(socket, frame, &mut served)?,
                _ => served.dropped += 1,
            }
        }
        while let Some(at) = late.iter().position(|(due, _)| *due <= now) {
            answer(socket, &late.remove(at).1, &mut served)?;
        }
    }
    Ok(served)
}

fn answer(socket: &RawSocket, frame: &[u8], served: &mut Served) -> Result<(), RawSocketError> {
    if socket.send(frame)? {
        served.answers += 1;
    } else {
        served.overruns += 1;
    }
    Ok(())
}
