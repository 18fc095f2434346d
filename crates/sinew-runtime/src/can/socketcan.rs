//! A CAN interface of Linux, whose bit rate the system has set.

use super::Link;
use crate::cycle::{Clock as _, MonotonicClock};
use crate::tty::wait_for_input;
use sinew_segment::CanFrame as Frame;
use socketcan::{CanFrame, CanSocket, EmbeddedFrame as _, Id, Socket as _, StandardId};
use std::io::{self, ErrorKind};

/// A socket on a CAN interface.
#[derive(Debug)]
pub struct SocketCan {
    socket: CanSocket,
    clock: MonotonicClock,
}

/// Frames that an interface has to queue, at least: those of a cycle leave at once.
const QUEUE: usize = 128;
/// Errors of the system: it has no such family of addresses; the queue of the interface is full.
const NO_FAMILY: i32 = 97;
const NO_BUFFERS: i32 = 105;

impl SocketCan {
    /// Opens an interface that is up; `bitrate`, bit/s, is what it is expected to have, which is not read.
    ///
    /// # Errors
    /// There is no such interface, it is down or queues too few frames, the kernel has no CAN: what to do
    /// about it.
    pub fn open(interface: &str, bitrate: u32) -> io::Result<Self> {
        let up = if interface.starts_with("vcan") {
            format!("ip link add {interface} type vcan; ip link set {interface} up")
        } else {
            format!("ip link set {interface} up txqueuelen 1000 type can bitrate {bitrate}")
        };
        let refused =
            |problem: &str| io::Error::other(format!("{problem}: expected a CAN interface, as after `{up}`"));
        let of = |file: &str| std::fs::read_to_string(format!("/sys/class/net/{interface}/{file}"));
        let flags = of("flags").map_err(|_| refused("no such network interface"))?;
        let socket = CanSocket::open(interface).map_err(|error| match error.raw_os_error() {
            Some(NO_FAMILY) => refused("this kernel has no CAN (can_raw)"),
            _ => refused(&error.to_string()),
        })?;
        let is_up =
            u32::from_str_radix(flags.trim().trim_start_matches("0x"), 16).is_ok_and(|flags| flags & 1 == 1);
        if !is_up {
            return Err(refused("the interface is down"));
        }
        let queue = of("tx_queue_len")?;
        if queue.trim().parse::<usize>().is_ok_and(|queue| queue < QUEUE) {
            return Err(refused(&format!("the interface queues {} frames", queue.trim())));
        }
        socket.set_nonblocking(true)?;
        Ok(Self { socket, clock: MonotonicClock })
    }
}

impl Link for SocketCan {
    fn now(&mut self) -> u64 {
        self.clock.now()
    }

    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        for frame in frames {
            let Some(id) = StandardId::new(frame.id()) else { continue };
            let out = if frame.is_remote() {
                CanFrame::new_remote(id, frame.length())
            } else {
                CanFrame::new(id, frame.octets())
            };
            match out.map_or(Ok(()), |out| self.socket.write_frame(&out)) {
                Ok(()) => {}
                // A full queue loses a frame, as the bus would.
                Err(error) if error.kind() == ErrorKind::WouldBlock => {}
                Err(error) if error.raw_os_error() == Some(NO_BUFFERS) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    fn receive(&mut self, deadline: u64) -> io::Result<Option<Frame>> {
        loop {
            let now = self.clock.now();
            match self.socket.read_frame() {
                Ok(frame) => {
                    // Frames with 29 bits of identifier are none of ours, nor are reports of errors.
                    let Id::Standard(id) = frame.id() else { continue };
                    match frame {
                        CanFrame::Data(_) => return Ok(Some(Frame::new(id.as_raw(), frame.data()))),
                        CanFrame::Remote(_) => return Ok(Some(Frame::remote(id.as_raw(), frame.dlc()))),
                        CanFrame::Error(_) => continue,
                    }
                }
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::Interrupted) => {}
                Err(error) => return Err(error),
            }
            if now >= deadline {
                return Ok(None);
            }
            wait_for_input(&self.socket, deadline - now)?;
        }
    }

    fn rest_until(&mut self, time: u64) {
        // Without the clock the exchanges are merely faster.
        let _ = self.clock.wait_until(time);
    }

    fn begin_cycle(&mut self, _period: u64) {}
}
