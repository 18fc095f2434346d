use super::domain::Domain;
use super::port::{Port, ServerEnd, queues};
use crate::rejection::SharedCounters;
use crate::{Command, Error, Rejection, Snapshot};
use std::os::unix::net::UnixStream;
use std::sync::Arc;

/// The host of a client in this process: the queue to the control cycle, the checks of set-points and the
/// sessions of a [`Server`](super::Server), without packets.
///
/// Use it for another protocol beside this one; what it asks for goes the same way to the machine.
#[derive(Debug)]
pub struct Local {
    end: ServerEnd,
    domain: Domain,
    counters: Arc<SharedCounters>,
    /// Number of the newest session, from 1; 0 before the first.
    session: u64,
    attached: bool,
    latest: Box<Snapshot>,
    /// The other end of what wakes a server.
    _wake: UnixStream,
}

impl Local {
    /// Without a session, and the control cycle's port.
    ///
    /// # Errors
    /// As [`Domain::validate`]; [`Error::Thread`] where the system has no more sockets.
    pub fn new(domain: Domain) -> Result<(Self, Port), Error> {
        domain.validate()?;
        let (wake, woken) = UnixStream::pair().map_err(Error::Thread)?;
        wake.set_nonblocking(true).map_err(Error::Thread)?;
        let counters = Arc::<SharedCounters>::default();
        let (port, end) = queues(wake, Arc::clone(&counters));
        let (session, attached, latest) = (0, false, Box::default());
        Ok((Self { end, domain, counters, session, attached, latest, _wake: woken }, port))
    }

    /// What set-points are accepted.
    #[must_use]
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Whether there is a session.
    #[must_use]
    pub fn is_attached(&self) -> bool {
        self.attached
    }

    /// Gives a command to the cycle; a session begins with it where there is none.
    ///
    /// # Errors
    /// The first reason that applies, as of a packet: [`Rejection::Count`], [`Rejection::OutOfRange`],
    /// [`Rejection::QueueFull`].
    pub fn command(&mut self, command: &Command) -> Result<(), Rejection> {
        let result = self.domain.check(command).and_then(|()| {
            let session = self.session + u64::from(!self.attached);
            let taken = self.end.push(command, session);
            (self.session, self.attached) = (session, true);
            if taken { Ok(()) } else { Err(Rejection::QueueFull) }
        });
        match result {
            Ok(()) => self.counters.accept(),
            Err(reason) => self.counters.reject(reason),
        }
        result
    }

    /// Ends the session, as a Goodbye does.
    pub fn end(&mut self) {
        self.attached = false;
        self.end.set_session(0);
    }

    /// The newest state of the machine; all zeros before the first.
    pub fn state(&mut self) -> &Snapshot {
        while let Ok(snapshot) = self.end.snapshots.pop() {
            *self.latest = snapshot;
        }
        &self.latest
    }
}

impl Drop for Local {
    fn drop(&mut self) {
        self.end();
    }
}
