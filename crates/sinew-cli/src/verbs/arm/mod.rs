//! `sinew arm`: one file per verb within it.

mod convert;
mod evaluate;
mod inspect;
pub(super) mod model;
mod poses;
mod report;
mod survey;
mod view;

use crate::arguments::{ArmArguments, ArmVerb};
use crate::error::Error;

pub(crate) fn run(arguments: &ArmArguments) -> Result<(), Error> {
    match &arguments.verb {
        ArmVerb::Inspect(arguments) => inspect::run(arguments),
        ArmVerb::Evaluate(arguments) => evaluate::run(arguments),
        ArmVerb::Convert(arguments) => convert::run(arguments),
    }
}
