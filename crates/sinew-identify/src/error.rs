/// What can be wrong between a log and a model.
///
/// Every variant names the place, what was expected there and what stands there.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A value refused by the physics.
    #[error(transparent)]
    Physics(#[from] sinew::Error),
}
