use std::net::SocketAddr;

/// Why a page cannot be served.
#[derive(Debug, thiserror::Error)]
pub enum LiveError {
    /// The address cannot be listened on.
    #[error("cannot listen on {address}: {source}")]
    Address {
        /// The address as given.
        address: SocketAddr,
        /// Of the system.
        source: std::io::Error,
    },
    /// Foxglove's protocol cannot be served.
    #[error("--foxglove {address}: {reason}")]
    Foxglove {
        /// The address as given.
        address: SocketAddr,
        /// Why.
        reason: String,
    },
    /// The system refused a thread, a runtime or random numbers.
    #[error("the server cannot start: {0}")]
    System(String),
    /// A recording that cannot be read.
    #[error(transparent)]
    Recording(#[from] sinew_record::Error),
    /// A recording that cannot be laid over another.
    #[error("{name}: {reason}")]
    Overlay {
        /// The name as given.
        name: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The machine cannot be simulated.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
}
