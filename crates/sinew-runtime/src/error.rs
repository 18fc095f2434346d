/// What keeps a machine from being run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A value outside the domain of the physics, or a machine of other dimensions.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
    /// The link to a client.
    #[error(transparent)]
    Link(#[from] sinew_link::Error),
    /// The operating system refused the clock.
    #[error("the monotonic clock: {0}")]
    Clock(#[source] std::io::Error),
}
