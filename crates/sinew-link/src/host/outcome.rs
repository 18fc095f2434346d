use crate::Rejection;

/// What happened to a received datagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Rejected and counted; a reply (Refused), if one was written, is to be sent.
    Rejected(Rejection),
    /// A Hello was answered: the reply (Welcome) offers a session and is to be sent.
    Offered,
    /// A command was put into the queue to the control cycle.
    Commanded,
    /// A Watch packet keeps the session of a watching client alive.
    Watched,
    /// A Goodbye ended the session.
    Ended,
}
