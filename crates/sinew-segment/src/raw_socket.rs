//! EtherCAT frames on one Ethernet interface of Linux, through a packet socket.

#![expect(
    unsafe_code,
    reason = "packet sockets have no interface in the standard library; each call says why it is sound"
)]

use core::mem::size_of;
use core::time::Duration;
use libc::{c_int, c_void, socklen_t};
use std::ffi::CString;
use std::io;
use std::os::fd::{AsRawFd, FromRawFd, OwnedFd};

/// EtherType of EtherCAT, in the order of the network.
const PROTOCOL: u16 = 0x88a4_u16.to_be();

/// Why frames cannot be exchanged on an interface.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RawSocketError {
    /// There is no interface of this name.
    #[error("no network interface `{interface}`; there are: {}", known.join(", "))]
    NoInterface {
        /// The name.
        interface: String,
        /// Names of the interfaces that there are.
        known: Vec<String>,
    },
    /// The process may not open packet sockets.
    #[error(
        "no permission for raw frames on `{interface}`: the program needs the capability CAP_NET_RAW; \
         grant it with `sudo setcap cap_net_raw+ep {program}`"
    )]
    NoPermission {
        /// Name of the interface.
        interface: String,
        /// Path of this program.
        program: String,
    },
    /// The interface is switched off, or was while frames were exchanged.
    #[error("network interface `{interface}` is down; switch it on with `sudo ip link set {interface} up`")]
    Down {
        /// Name of the interface.
        interface: String,
    },
    /// The system refused a call.
    #[error("network interface `{interface}`: {call}: {source}")]
    System {
        /// Name of the interface.
        interface: String,
        /// What was called.
        call: &'static str,
        /// The system's reason.
        source: io::Error,
    },
}

/// A packet socket that sends and receives frames of EtherType 0x88A4 on one interface, whomever they are
/// addressed to.
#[derive(Debug)]
pub struct RawSocket {
    socket: OwnedFd,
    interface: String,
}

impl RawSocket {
    /// Opens a socket on an interface and makes the interface receive every frame.
    ///
    /// # Errors
    ///
    /// [`RawSocketError`]: no such interface, no permission, the interface is down, or another reason of the
    /// system.
    pub fn open(interface: &str) -> Result<Self, RawSocketError> {
        let index = index_of(interface)?;
        let kind = libc::SOCK_RAW | libc::SOCK_CLOEXEC | libc::SOCK_NONBLOCK;
        // SAFETY: takes numbers and returns a descriptor or -1.
        let descriptor = unsafe { libc::socket(libc::AF_PACKET, kind, c_int::from(PROTOCOL)) };
        if descriptor < 0 {
            return Err(failed(interface, "socket"));
        }
        // SAFETY: the descriptor was just returned and belongs to nobody else.
        let socket = unsafe { OwnedFd::from_raw_fd(descriptor) };
        let opened = Self { socket, interface: interface.to_owned() };
        opened.bind(index)?;
        opened.receive_all(index)?;
        Ok(opened)
    }

    /// Name of the interface.
    #[must_use]
    pub fn interface(&self) -> &str {
        &self.interface
    }

    fn bind(&self, index: c_int) -> Result<(), RawSocketError> {
        let address = libc::sockaddr_ll {
            sll_family: libc::AF_PACKET as u16,
            sll_protocol: PROTOCOL,
            sll_ifindex: index,
            sll_hatype: 0,
            sll_pkttype: 0,
            sll_halen: 0,
            sll_addr: [0; 8],
        };
        let length = size_of::<libc::sockaddr_ll>() as socklen_t;
        let pointer = (&raw const address).cast::<libc::sockaddr>();
        // SAFETY: the pointer and the length are those of a complete address that lives through the call.
        let result = unsafe { libc::bind(self.socket.as_raw_fd(), pointer, length) };
        if result < 0 { Err(failed(&self.interface, "bind")) } else { Ok(()) }
    }

    fn receive_all(&self, index: c_int) -> Result<(), RawSocketError> {
        let membership = libc::packet_mreq {
            mr_ifindex: index,
            mr_type: libc::PACKET_MR_PROMISC as u16,
            mr_alen: 0,
            mr_address: [0; 8],
        };
        let length = size_of::<libc::packet_mreq>() as socklen_t;
        let pointer = (&raw const membership).cast::<c_void>();
        let (level, option) = (libc::SOL_PACKET, libc::PACKET_ADD_MEMBERSHIP);
        // SAFETY: the pointer and the length are those of a complete request that lives through the call.
        let result = unsafe { libc::setsockopt(self.socket.as_raw_fd(), level, option, pointer, length) };
        if result < 0 { Err(failed(&self.interface, "PACKET_ADD_MEMBERSHIP")) } else { Ok(()) }
    }

    /// Sends a whole Ethernet frame, without checksum. False where the queue is full and nothing was sent.
    ///
    /// # Errors
    ///
    /// The interface is down or gone, or the frame is longer than it carries.
    pub fn send(&self, frame: &[u8]) -> Result<bool, RawSocketError> {
        let pointer = frame.as_ptr().cast::<c_void>();
        // SAFETY: the pointer and the length are those of a slice that lives through the call.
        let sent = unsafe { libc::send(self.socket.as_raw_fd(), pointer, frame.len(), 0) };
        if sent >= 0 {
            return Ok(true);
        }
        let reason = io::Error::last_os_error();
        match reason.raw_os_error() {
            Some(libc::ENOBUFS | libc::EAGAIN | libc::EINTR) => Ok(false),
            _ => Err(failed(&self.interface, "send")),
        }
    }

    /// Takes a frame that has arrived, without waiting; its length, or none. A frame that is longer than the
    /// buffer is cut. Own frames are not seen.
    ///
    /// # Errors
    ///
    /// The interface is down or gone.
    pub fn try_receive(&self, frame: &mut [u8]) -> Result<Option<usize>, RawSocketError> {
        // SAFETY: an address of zeros is valid.
        let mut from: libc::sockaddr_ll = unsafe { core::mem::zeroed() };
        loop {
            let mut length = size_of::<libc::sockaddr_ll>() as socklen_t;
            let pointer = frame.as_mut_ptr().cast::<c_void>();
            let address = (&raw mut from).cast::<libc::sockaddr>();
            // SAFETY: the pointers and lengths are those of a slice and an address that live through the
            // call.
            let received = unsafe {
                libc::recvfrom(self.socket.as_raw_fd(), pointer, frame.len(), 0, address, &raw mut length)
            };
            if let Ok(received) = usize::try_from(received) {
                if from.sll_pkttype == libc::PACKET_OUTGOING {
                    continue;
                }
                return Ok(Some(received));
            }
            let reason = io::Error::last_os_error();
            return match reason.raw_os_error() {
                Some(libc::EAGAIN) => Ok(None),
                Some(libc::EINTR) => continue,
                _ => Err(failed(&self.interface, "recv")),
            };
        }
    }

    /// Waits for a frame, at most for `timeout`; its length, or none.
    ///
    /// # Errors
    ///
    /// The interface is down or gone.
    pub fn receive(&self, frame: &mut [u8], timeout: Duration) -> Result<Option<usize>, RawSocketError> {
        if let Some(length) = self.try_receive(frame)? {
            return Ok(Some(length));
        }
        let mut poll = libc::pollfd { fd: self.socket.as_raw_fd(), events: libc::POLLIN, revents: 0 };
        let limit = libc::timespec {
            tv_sec: libc::time_t::try_from(timeout.as_secs()).unwrap_or(libc::time_t::MAX),
            tv_nsec: timeout.subsec_nanos().into(),
        };
        // SAFETY: one entry and one time that live through the call; no signal mask.
        let ready = unsafe { libc::ppoll(&raw mut poll, 1, &raw const limit, core::ptr::null()) };
        if ready > 0 { self.try_receive(frame) } else { Ok(None) }
    }
}

fn index_of(interface: &str) -> Result<c_int, RawSocketError> {
    let unknown =
        || RawSocketError::NoInterface { interface: interface.to_owned(), known: known_interfaces() };
    let name = CString::new(interface).map_err(|_| unknown())?;
    // SAFETY: the pointer is that of a text with a final zero that lives through the call.
    let index = unsafe { libc::if_nametoindex(name.as_ptr()) };
    c_int::try_from(index).ok().filter(|index| *index > 0).ok_or_else(unknown)
}

fn known_interfaces() -> Vec<String> {
    let entries = std::fs::read_dir("/sys/class/net").into_iter().flatten().flatten();
    let mut names: Vec<String> =
        entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// The error of the call that has just failed.
fn failed(interface: &str, call: &'static str) -> RawSocketError {
    let source = io::Error::last_os_error();
    let interface = interface.to_owned();
    match source.raw_os_error() {
        Some(libc::EPERM | libc::EACCES) => {
            let program = std::env::current_exe().map(|path| path.display().to_string());
            RawSocketError::NoPermission {
                interface,
                program: program.unwrap_or_else(|_| "PROGRAM".to_owned()),
            }
        }
        Some(libc::ENETDOWN) => RawSocketError::Down { interface },
        _ => RawSocketError::System { interface, call, source },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interface_that_is_not_there_is_named_with_those_that_are() {
        let error = RawSocket::open("no-such-if0").unwrap_err().to_string();
        assert!(error.contains("no-such-if0") && error.contains("lo"), "{error}");
    }
}
