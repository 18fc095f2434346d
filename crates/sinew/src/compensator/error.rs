use crate::Error;
use crate::predictor::ModelFileError;

/// A compensator that cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CompensatorError {
    /// The model is invalid, or has no input that can be commanded.
    #[error(transparent)]
    Model(#[from] ModelFileError),
    /// A setting is outside its domain.
    #[error(transparent)]
    Settings(#[from] Error),
}
