//! Devices on a network interface.

use super::link::Link;
use crate::cycle::{Clock, MonotonicClock};
use sinew_segment::{RawSocket, RawSocketError};
use std::io;

/// Frames through a packet socket of one interface.
#[derive(Debug)]
pub struct RawSocketLink {
    socket: RawSocket,
    clock: MonotonicClock,
}

impl RawSocketLink {
    /// Opens an interface.
    ///
    /// # Errors
    /// [`RawSocketError`] with the remedy: no such interface, no permission, interface down.
    pub fn open(interface: &str) -> Result<Self, RawSocketError> {
        Ok(Self { socket: RawSocket::open(interface)?, clock: MonotonicClock })
    }
}

impl Link for RawSocketLink {
    fn now(&mut self) -> u64 {
        self.clock.now()
    }

    fn send(&mut self, frame: &[u8]) -> io::Result<()> {
        // A full queue loses the frame, as the wire would.
        self.socket.send(frame).map(drop).map_err(io::Error::other)
    }

    fn receive(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        self.socket.try_receive(buffer).map_err(io::Error::other)
    }

    fn idle(&mut self) {
        // An answer takes some ten microseconds: shorter than a sleep. Whoever is to give it, a driver's
        // thread or a simulated device, may need this processor.
        std::thread::yield_now();
    }

    fn rest_until(&mut self, time: u64) {
        // Without the clock the exchanges are merely faster.
        let _ = self.clock.wait_until(time);
    }

    fn begin_cycle(&mut self, _period: u64) {}
}
