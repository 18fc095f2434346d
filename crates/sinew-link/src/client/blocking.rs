//! A client with a socket.

use super::session::{Arrived, ClientSession, Greeting};
use crate::wire::{Datagram, MAX_DATAGRAM};
use crate::{Command, Error, Key, RefusedBecause, Snapshot};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

/// A client that waits for its answers; for programs that test, watch and demonstrate.
///
/// # Example
/// ```
/// use sinew_link::client::Client;
/// use sinew_link::host::{Domain, Server, ServerSettings, SessionSettings};
/// use sinew_link::{Command, Request, Snapshot};
/// use std::time::Duration;
///
/// let domain = Domain { joint: vec![[-1.0, 1.0]], tension: vec![[0.0, 100.0]; 2], ..Domain::default() };
/// let address = "127.0.0.1:0".parse()?;
/// let sessions = SessionSettings::default();
/// let (server, mut port) = Server::start(ServerSettings { address, key: None, domain, sessions })?;
///
/// let mut client = Client::connect(server.address(), None, Duration::from_secs(5))?;
/// client.send(&Command::from_request(Request::GetReady))?;
/// let command = loop {
///     if let Some(command) = port.next_command() { break command } // in the control cycle
/// };
/// port.publish(&Snapshot::new(1, 2));
/// assert_eq!(command.request, Request::GetReady);
/// assert_eq!(client.receive(Duration::from_secs(5))?.joints().len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Client {
    socket: UdpSocket,
    address: SocketAddr,
    start: Instant,
    session: ClientSession,
    datagram: Datagram,
}

/// Between two Hellos.
const RETRY: Duration = Duration::from_millis(100);
/// Longest wait for the acknowledgement of a stop.
const ACKNOWLEDGEMENT: Duration = Duration::from_secs(1);

impl Client {
    /// A session with a host, asked for until it answers or the time is over; a host whose session another
    /// client has is asked again, because the session of a client that has gone ends soon.
    ///
    /// # Errors
    /// [`Error::Socket`], [`Error::Random`], [`Error::NoAnswer`], [`Error::Refused`].
    pub fn connect(address: SocketAddr, key: Option<&Key>, most: Duration) -> Result<Self, Error> {
        Self::greet(address, most, |nonce| Greeting::new(key.unwrap_or(&Key::none()), nonce))
    }

    /// The same with a session that watches, beside the client that commands; [`watch`](Self::watch) keeps
    /// it.
    ///
    /// # Errors
    /// As [`connect`](Self::connect).
    pub fn connect_to_watch(address: SocketAddr, key: Option<&Key>, most: Duration) -> Result<Self, Error> {
        Self::greet(address, most, |nonce| Greeting::new(key.unwrap_or(&Key::none()), nonce).watching())
    }

    fn greet(
        address: SocketAddr,
        most: Duration,
        greeting: impl FnOnce([u8; 16]) -> Greeting,
    ) -> Result<Self, Error> {
        let failed = |source| Error::Socket { what: "connect to", address, source };
        let any: SocketAddr = if address.is_ipv4() {
            (Ipv4Addr::UNSPECIFIED, 0).into()
        } else {
            (Ipv6Addr::UNSPECIFIED, 0).into()
        };
        let socket = UdpSocket::bind(any).map_err(failed)?;
        socket.connect(address).map_err(failed)?;
        let mut nonce = [0; 16];
        getrandom::fill(&mut nonce).map_err(Error::Random)?;
        let greeting = greeting(nonce);
        let (start, mut datagram) = (Instant::now(), Datagram::default());
        let mut refused = None;
        let mut buffer = [0; MAX_DATAGRAM + 1];
        while start.elapsed() < most {
            // Nobody there yet: asked again.
            let _ = socket.send(greeting.hello(nanoseconds(start), &mut datagram));
            let sent = Instant::now();
            while let Some(left) = RETRY.checked_sub(sent.elapsed()).filter(|left| !left.is_zero()) {
                socket.set_read_timeout(Some(left)).map_err(failed)?;
                let Ok(size) = socket.recv(&mut buffer) else {
                    std::thread::sleep(RETRY.saturating_sub(sent.elapsed()));
                    break;
                };
                match greeting.answer(&buffer[..size]) {
                    Ok(Ok(session)) => return Ok(Self { socket, address, start, session, datagram }),
                    Ok(Err(RefusedBecause::SecondClient)) => {
                        refused = Some("another client has it");
                    }
                    Ok(Err(RefusedBecause::TooManyWatchers)) => {
                        refused = Some("as many clients watch as may");
                    }
                    Err(_) => {}
                }
            }
        }
        Err(match refused {
            Some(because) => Error::Refused { address, because },
            None => Error::NoAnswer { address, seconds: most.as_secs_f64() },
        })
    }

    /// The session.
    #[must_use]
    pub fn session(&self) -> &ClientSession {
        &self.session
    }

    /// Time of this client, ns since it began to connect.
    #[must_use]
    pub fn now(&self) -> u64 {
        nanoseconds(self.start)
    }

    /// Sends a command.
    ///
    /// # Errors
    /// [`Error::Socket`].
    pub fn send(&mut self, command: &Command) -> Result<(), Error> {
        let now = self.now();
        let bytes = self.session.command(command, now, &mut self.datagram);
        let sent = self.socket.send(bytes);
        sent.map(|_| ()).map_err(|source| Error::Socket { what: "send to", address: self.address, source })
    }

    /// Begins and keeps a session that watches.
    ///
    /// # Errors
    /// [`Error::Socket`].
    pub fn watch(&mut self) -> Result<(), Error> {
        let now = self.now();
        let bytes = self.session.watch(now, &mut self.datagram);
        let sent = self.socket.send(bytes);
        sent.map(|_| ()).map_err(|source| Error::Socket { what: "send to", address: self.address, source })
    }

    /// The next complete state; packets that are rejected are skipped.
    ///
    /// # Errors
    /// [`Error::NoAnswer`] where none comes in time: where no packet of this client has reached the host for
    /// half a second, the session has ended, and the client connects anew. [`Error::Socket`].
    pub fn receive(&mut self, most: Duration) -> Result<&Snapshot, Error> {
        let begin = Instant::now();
        let mut buffer = [0; MAX_DATAGRAM + 1];
        loop {
            let left = most.saturating_sub(begin.elapsed());
            let failed = |source| Error::Socket { what: "receive from", address: self.address, source };
            if left.is_zero() {
                return Err(Error::NoAnswer { address: self.address, seconds: most.as_secs_f64() });
            }
            self.socket.set_read_timeout(Some(left)).map_err(failed)?;
            match self.socket.recv(&mut buffer) {
                Ok(size) => {
                    let now = self.now();
                    if self.session.receive(&buffer[..size], now) == Ok(Arrived::Complete) {
                        return Ok(self.session.state());
                    }
                }
                Err(error) if is_time_out(&error) => {}
                Err(error) => return Err(failed(error)),
            }
        }
    }

    /// Ends the session. Where a stop was asked for (SafeStop, GetReady, TurnOff), first waits until the
    /// machine has taken it, at most a second, and asks again meanwhile.
    ///
    /// # Errors
    /// [`Error::StopNotAcknowledged`]: the session has ended, and the machine has perhaps not been told to
    /// stop. [`Error::Socket`].
    pub fn close(mut self) -> Result<(), Error> {
        let begin = Instant::now();
        while let Some(stop) = self.session.unacknowledged_stop().copied()
            && begin.elapsed() < ACKNOWLEDGEMENT
        {
            let asked = Instant::now();
            // Where the host has gone there is nobody who could answer: the time runs out.
            if self.send(&stop).and_then(|()| self.receive(RETRY / 5)).is_err() {
                std::thread::sleep((RETRY / 5).saturating_sub(asked.elapsed()));
            }
        }
        let unacknowledged = self.session.unacknowledged_stop().map(|stop| stop.request.name());
        let (address, seconds) = (self.address, ACKNOWLEDGEMENT.as_secs_f64());
        let sent = self.close_at_once();
        unacknowledged.map_or(sent, |request| Err(Error::StopNotAcknowledged { address, request, seconds }))
    }

    /// Ends the session without waiting for anything.
    ///
    /// # Errors
    /// [`Error::Socket`].
    pub fn close_at_once(mut self) -> Result<(), Error> {
        let now = self.now();
        let bytes = self.session.goodbye(now, &mut self.datagram);
        let sent = self.socket.send(bytes);
        sent.map(|_| ()).map_err(|source| Error::Socket { what: "send to", address: self.address, source })
    }
}

fn is_time_out(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), TimedOut | WouldBlock | Interrupted)
}

fn nanoseconds(start: Instant) -> u64 {
    start.elapsed().as_nanos() as u64
}
