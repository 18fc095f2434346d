//! `sinew arm`: one file per verb within it.

mod convert;
mod evaluate;
mod inspect;
pub(super) mod model;
mod poses;
mod report;
mod survey;
pub(super) mod view;

use crate::answer::Answer;
use crate::arguments::{ArmArguments, ArmVerb, General};
use crate::error::Error;

pub(crate) fn run(arguments: &ArmArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        ArmVerb::Inspect(arguments) => inspect::run(arguments, general),
        ArmVerb::Evaluate(arguments) => evaluate::run(arguments, general),
        ArmVerb::Convert(arguments) => convert::run(arguments, general),
    }
}
