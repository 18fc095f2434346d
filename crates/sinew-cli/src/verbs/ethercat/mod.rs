//! `sinew ethercat`.

mod scan;
mod simulate;

use crate::arguments::{EthercatArguments, EthercatVerb};
use crate::error::Error;
use crate::verbs::Outcome;

pub(crate) fn run(arguments: &EthercatArguments) -> Result<Outcome, Error> {
    match &arguments.verb {
        EthercatVerb::Scan(arguments) => scan::run(arguments),
        EthercatVerb::Simulate(arguments) => simulate::run(arguments),
    }
}
