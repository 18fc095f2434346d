use crate::Rejection;

/// What happened to a received datagram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Rejected and counted; where a reply was written it is to be sent.
    Rejected(Rejection),
    /// A session is offered: the reply is to be sent.
    Offered,
    /// A command was taken.
    Commanded,
    /// A client that watches goes on.
    Watched,
    /// The session has ended.
    Ended,
}
