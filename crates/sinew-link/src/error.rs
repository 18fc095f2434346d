//! Errors of sockets, keys and sessions.

use std::net::SocketAddr;

/// What ends a link or prevents it. No variant contains key material.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A socket operation failed.
    #[error("{what} {address}: {source}")]
    Socket {
        /// What was attempted.
        what: &'static str,
        /// With which address.
        address: SocketAddr,
        /// Why it failed.
        source: std::io::Error,
    },
    /// An address other than loopback without a key.
    #[error("link address {0}: expected a loopback address, or a key")]
    KeyNeeded(SocketAddr),
    /// The operating system gave no random numbers.
    #[error("random numbers of the operating system: {0}")]
    Random(getrandom::Error),
    /// The server's thread did not start.
    #[error("the link's thread: {0}")]
    Thread(std::io::Error),
    /// Nothing answered in time.
    #[error("{address}: expected an answer within {seconds} s, got none; is the key the same on both ends?")]
    NoAnswer {
        /// Who did not answer.
        address: SocketAddr,
        /// How long was waited, s.
        seconds: f64,
    },
    /// A session ended while the host had not yet said that the machine has taken the client's stop.
    #[error(
        "{address}: expected the machine to take {request} within {seconds} s, got no acknowledgement; it is \
            stopped if the request has arrived"
    )]
    StopNotAcknowledged {
        /// Whose machine.
        address: SocketAddr,
        /// What was asked for.
        request: &'static str,
        /// How long was waited, s.
        seconds: f64,
    },
    /// The host refused the session.
    #[error("{address}: expected a free session, got: {because}")]
    Refused {
        /// Who refused.
        address: SocketAddr,
        /// Why.
        because: &'static str,
    },
    /// A number of joints, muscles, values or points beyond what a link carries.
    #[error("{name}: expected {expected}, got {got}")]
    Size {
        /// What is counted.
        name: &'static str,
        /// The domain.
        expected: &'static str,
        /// The number.
        got: usize,
    },
    /// A key file.
    #[error(transparent)]
    KeyFile(#[from] KeyFileError),
}

/// What is wrong with a key file. Its content is never part of the message.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum KeyFileError {
    /// It cannot be opened, read or written.
    #[error("key file {file}: {source}")]
    File {
        /// Its path.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// Others may read it.
    #[error("key file {file}: expected permissions 0600 (no access for group and others), got {mode:04o}")]
    Permissions {
        /// Its path.
        file: String,
        /// Its permissions.
        mode: u32,
    },
    /// It is not a key.
    #[error("key file {file}: expected 64 hexadecimal digits in one line, got {got}")]
    Content {
        /// Its path.
        file: String,
        /// What it is instead, without its content.
        got: String,
    },
    /// There were no random numbers for it.
    #[error("key file {file}: random numbers of the operating system: {source}")]
    Random {
        /// Its path.
        file: String,
        /// Why.
        source: getrandom::Error,
    },
}
