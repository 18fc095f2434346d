//! The server's thread: UDP in, commands to the cycle, state out.

use super::domain::Domain;
use super::port::{Port, ServerEnd, Shared, queues};
use super::sessions::{SessionSettings, Sessions};
use crate::wire::{Datagram, MAX_DATAGRAM};
use crate::{Counters, Error, Key, Snapshot};
use rustix::event::{PollFd, PollFlags, poll};
use rustix::time::Timespec;
use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, UdpSocket};
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

/// Where a server listens and what it serves.
#[derive(Debug, Clone)]
pub struct ServerSettings {
    /// Address and port; port 0 takes a free one.
    pub address: SocketAddr,
    /// The pre-shared key; needed where the address is not a loopback one.
    pub key: Option<Key>,
    /// The machine.
    pub domain: Domain,
    /// Sessions.
    pub sessions: SessionSettings,
}

/// A running server; it stops when dropped.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    thread: Option<JoinHandle<Sessions>>,
    shared: Arc<Shared>,
    wake: UnixStream,
}

/// Most datagrams read before states are sent.
const BATCH: usize = 256;
/// Longest wait while no client commands or watches, ns.
const IDLE: u64 = 50_000_000;

impl Server {
    /// Binds the socket and starts the thread. In lock-step, [`Port::wait`] must be called on the thread that
    /// called this function: it is the one that is woken.
    ///
    /// # Errors
    /// [`Error::KeyNeeded`] for a non-loopback address without a key; [`Error::Socket`]; [`Error::Thread`];
    /// as [`Domain::validate`].
    pub fn start(settings: ServerSettings) -> Result<(Self, Port), Error> {
        let ServerSettings { address, key, domain, sessions } = settings;
        if key.is_none() && !address.ip().is_loopback() {
            return Err(Error::KeyNeeded(address));
        }
        let failed = |what| move |source| Error::Socket { what, address, source };
        let random = Box::new(|nonce: &mut [u8; 16]| getrandom::fill(nonce).is_ok());
        let poll_ns = sessions.state_period_ns / 2;
        let core = Sessions::new(&key.unwrap_or_else(Key::none), domain, sessions, random)?;
        let socket = UdpSocket::bind(address).map_err(failed("listen on"))?;
        socket.set_nonblocking(true).map_err(failed("set up"))?;
        let address = socket.local_addr().map_err(failed("listen on"))?;
        let (wake, woken) = UnixStream::pair().map_err(failed("set up"))?;
        for end in [&wake, &woken] {
            end.set_nonblocking(true).map_err(failed("set up"))?;
        }
        let own_wake = wake.try_clone().map_err(failed("set up"))?;
        let (port, end) = queues(wake, core.shared_counters());
        let shared = end.shared();
        let mut thread = ServerThread {
            socket,
            woken,
            core,
            end,
            start: Instant::now(),
            poll_ns,
            latest: Box::default(),
            buffer: [0; MAX_DATAGRAM + 1],
            datagram: Datagram::default(),
        };
        let thread = std::thread::Builder::new()
            .name("sinew-link".into())
            .spawn(move || {
                thread.serve();
                thread.core
            })
            .map_err(Error::Thread)?;
        Ok((Self { address, thread: Some(thread), shared, wake: own_wake }, port))
    }

    /// Where it listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Stops the thread and returns the counts of received packets; zeros where the thread panicked.
    #[must_use]
    pub fn stop(mut self) -> Counters {
        self.end().unwrap_or_default()
    }

    fn end(&mut self) -> Option<Counters> {
        self.shared.stop();
        let _ = self.wake.write(&[1]);
        self.thread.take()?.join().ok().map(|sessions| sessions.counters())
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.end();
    }
}

struct ServerThread {
    socket: UdpSocket,
    woken: UnixStream,
    core: Sessions,
    end: ServerEnd,
    start: Instant,
    poll_ns: u64,
    latest: Box<Snapshot>,
    /// One byte more than the longest datagram, so that longer ones are seen.
    buffer: [u8; MAX_DATAGRAM + 1],
    datagram: Datagram,
}

impl ServerThread {
    fn now(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    fn serve(&mut self) {
        while !self.end.is_stopped() {
            self.wait();
            self.receive();
            let now = self.now();
            self.core.expire(now);
            self.end.set_session(self.core.generation());
            self.send_state();
        }
    }

    fn wait(&mut self) {
        let used = self.core.client().is_some() || self.core.watchers() > 0;
        let most = if used { self.poll_ns } else { IDLE };
        let most = Timespec {
            tv_sec: (most / 1_000_000_000).cast_signed(),
            tv_nsec: (most % 1_000_000_000).cast_signed(),
        };
        let mut ready = [PollFd::new(&self.socket, PollFlags::IN), PollFd::new(&self.woken, PollFlags::IN)];
        // Interrupted or refused: the sockets are read all the same.
        let _ = poll(&mut ready, Some(&most));
        let _ = self.woken.read(&mut [0; 64]);
    }

    fn receive(&mut self) {
        for _ in 0..BATCH {
            let (size, from) = match self.socket.recv_from(&mut self.buffer) {
                Ok(received) => received,
                // An answer that did not arrive is reported by the next reception.
                Err(error) if error.kind() == ErrorKind::ConnectionRefused => continue,
                Err(_) => return,
            };
            let now = self.now();
            let Self { core, end, buffer, datagram, .. } = self;
            core.receive(&buffer[..size], from, now, datagram, |command, session| end.push(command, session));
            if !datagram.bytes().is_empty() {
                // Where it cannot be sent the client asks again.
                let _ = self.socket.send_to(self.datagram.bytes(), from);
            }
        }
    }

    /// Sends the newest state, if there is a new one.
    fn send_state(&mut self) {
        let mut new = false;
        while let Ok(snapshot) = self.end.snapshots.pop() {
            *self.latest = snapshot;
            new = true;
        }
        if !new {
            return;
        }
        self.send_to(|core, latest, part, now, datagram| core.state(latest, part, now, datagram));
        for k in 0..self.core.watchers() {
            self.send_to(|core, latest, part, now, datagram| {
                core.state_for_watcher(k, latest, part, now, datagram)
            });
        }
    }

    /// Sends all parts of the newest state to one client; `seal` writes the part that begins at the given
    /// `[joint, muscle]` and sets where the next one begins, none after the last.
    fn send_to(
        &mut self,
        mut seal: impl FnMut(
            &mut Sessions,
            &Snapshot,
            &mut Option<[usize; 2]>,
            u64,
            &mut Datagram,
        ) -> Option<SocketAddr>,
    ) {
        let mut part = Some([0, 0]);
        while part.is_some() {
            let now = self.now();
            let Some(to) = seal(&mut self.core, &self.latest, &mut part, now, &mut self.datagram) else {
                return;
            };
            let _ = self.socket.send_to(self.datagram.bytes(), to);
        }
    }
}
