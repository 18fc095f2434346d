//! A CAN interface of Linux, whose bit rate the system has set.

use super::Link;
use super::guard::Guard;
use super::sign::Sign;
use crate::cycle::{Clock as _, MonotonicClock};
use crate::tty::wait_for_input;
use sinew_segment::CanFrame as Frame;
use socketcan::{
    CanAnyFrame, CanFdFrame, CanFdSocket, CanFrame, EmbeddedFrame as _, ExtendedId, Id, Socket as _,
    StandardId,
};
use std::io::{self, ErrorKind};

/// A socket on a CAN interface.
#[derive(Debug)]
pub struct SocketCan {
    guard: Option<Guard>,
    interface: String,
    socket: CanFdSocket,
    fd: bool,
    clock: MonotonicClock,
}

/// Frames that an interface has to queue, at least: those of a cycle leave at once.
const QUEUE: usize = 128;
/// Errors of the system: it has no such family of addresses; the queue of the interface is full.
const NO_FAMILY: i32 = 97;
const NO_BUFFERS: i32 = 105;

/// What an interface with CAN FD has, and how it gets it: as moteus wants it.
const FD_MTU: &str = "72";
const FD_RATES: &str = " dbitrate 5000000 sjw 10 dsjw 5 sample-point 0.666 dsample-point 0.666 fd on";

impl SocketCan {
    /// Opens an interface that is up; `bitrate`, bit/s, is what it is expected to have, which is not read;
    /// `fd` says whether it has to carry CAN FD.
    ///
    /// # Errors
    /// There is no such interface, it is down, queues too few frames or has no CAN FD, the kernel has no
    /// CAN: what to do about it.
    pub fn open(interface: &str, bitrate: u32, fd: bool) -> io::Result<Self> {
        let (mtu, rates) = if fd { (" mtu 72", FD_RATES) } else { ("", "") };
        let up = if interface.starts_with("vcan") {
            format!("ip link add {interface} type vcan; ip link set {interface} up txqueuelen 1000{mtu}")
        } else {
            format!("ip link set {interface} up txqueuelen 1000 type can bitrate {bitrate}{rates}")
        };
        let refused =
            |problem: &str| io::Error::other(format!("{problem}: expected a CAN interface, as after `{up}`"));
        let of = |file: &str| std::fs::read_to_string(format!("/sys/class/net/{interface}/{file}"));
        let flags = of("flags").map_err(|_| refused("no such network interface"))?;
        let socket = CanFdSocket::open(interface).map_err(|error| match error.raw_os_error() {
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
        if fd && of("mtu")?.trim() != FD_MTU {
            return Err(refused("the interface has no CAN FD"));
        }
        socket.set_nonblocking(true)?;
        Ok(Self { guard: None, interface: interface.to_owned(), socket, fd, clock: MonotonicClock })
    }
}

impl SocketCan {
    fn write(&self, frame: &Frame) -> io::Result<()> {
        let standard = StandardId::new(frame.id()).map(Id::from);
        let Some(id) = standard.or_else(|| ExtendedId::new(u32::from(frame.id())).map(Id::from)) else {
            return Ok(());
        };
        if frame.is_fd() {
            let Some(mut out) = CanFdFrame::new(id, frame.octets()) else { return Ok(()) };
            out.set_brs(true);
            return self.socket.write_frame(&out);
        }
        let out = if frame.is_remote() {
            CanFrame::new_remote(id, frame.length())
        } else {
            CanFrame::new(id, frame.octets())
        };
        out.map_or(Ok(()), |out| self.socket.write_frame(&out))
    }
}

/// A frame that has come. Those with 29 bits of identifier are none of ours but of CAN FD, and reports of
/// errors are none.
fn taken(frame: &CanAnyFrame) -> Option<Frame> {
    let standard = |id: Id| match id {
        Id::Standard(id) => Some(id.as_raw()),
        Id::Extended(_) => None,
    };
    match frame {
        CanAnyFrame::Normal(frame) => Some(Frame::new(standard(frame.id())?, frame.data())),
        CanAnyFrame::Remote(frame) => Some(Frame::remote(standard(frame.id())?, frame.dlc())),
        CanAnyFrame::Fd(frame) => {
            let id = match frame.id() {
                Id::Standard(id) => id.as_raw(),
                Id::Extended(id) => u16::try_from(id.as_raw()).ok()?,
            };
            Some(Frame::fd(id, frame.data()))
        }
        CanAnyFrame::Error(_) => None,
    }
}

impl Link for SocketCan {
    fn carries_fd(&self) -> bool {
        self.fd
    }

    fn now(&mut self) -> u64 {
        self.clock.now()
    }

    fn send(&mut self, frames: &[Frame]) -> io::Result<()> {
        for frame in frames {
            match self.write(frame) {
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
                    if let Some(frame) = taken(&frame) {
                        return Ok(Some(frame));
                    }
                    continue;
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

    fn guard(&mut self, leave: &[Frame], time: u64) -> io::Result<()> {
        self.guard = Some(Guard::start(&self.interface, None, leave, time)?);
        Ok(())
    }

    fn sign(&mut self, sign: Sign) -> io::Result<()> {
        self.guard.as_mut().map_or(Ok(()), |guard| guard.sign(sign))
    }
}
