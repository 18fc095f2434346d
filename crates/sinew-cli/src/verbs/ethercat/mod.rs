//! `sinew ethercat`.

mod scan;
mod simulate;

use crate::answer::Answer;
use crate::arguments::{EthercatArguments, EthercatVerb, General};
use crate::error::Error;

pub(crate) fn run(arguments: &EthercatArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        EthercatVerb::Scan(arguments) => scan::run(arguments, general),
        EthercatVerb::Simulate(arguments) => simulate::run(arguments, general),
    }
}
