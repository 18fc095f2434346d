//! Adaptation of a model to another specimen.

use crate::Error;
use crate::identify::{Identification, Options, Progress};
use crate::log::Dataset;
use sinew::predictor::Model;

/// Adapts.
///
/// # Errors
/// None yet.
pub fn adapt(
    _old: &Model,
    data: &Dataset,
    options: &Options,
    progress: &Progress<'_>,
) -> Result<Identification, Error> {
    crate::identify::identify(data, options, progress)
}
