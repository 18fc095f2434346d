use std::net::SocketAddr;

/// Why a page cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}")]
    Address {
        /// As given.
        address: SocketAddr,
        /// Of the system.
        source: std::io::Error,
    },
    /// The system refused a thread or random numbers.
    #[error("the server cannot start: {0}")]
    System(String),
    /// The machine cannot be simulated.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
}
