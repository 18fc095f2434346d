//! `sinew servos`.

mod scan;
mod simulate;

use crate::answer::Answer;
use crate::arguments::{General, ServosArguments, ServosVerb};
use crate::error::Error;

pub(crate) fn run(arguments: &ServosArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        ServosVerb::Scan(arguments) => scan::run(arguments, general),
        ServosVerb::Simulate(arguments) => simulate::run(arguments, general),
    }
}
