//! `sinew can`.

mod scan;
mod simulate;

use crate::answer::Answer;
use crate::arguments::{CanArguments, CanVerb, General};
use crate::error::Error;

pub(crate) fn run(arguments: &CanArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        CanVerb::Scan(arguments) => scan::run(arguments, general),
        CanVerb::Simulate(arguments) => simulate::run(arguments, general),
    }
}
