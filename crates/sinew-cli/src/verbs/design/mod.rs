//! `sinew design`: one file per verb within it.

mod drive;
mod study;
mod tension;

use crate::answer::Answer;
use crate::arguments::{DesignArguments, DesignVerb, General};
use crate::error::Error;

pub(crate) fn run(arguments: &DesignArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        DesignVerb::Drive(arguments) => drive::run(arguments, general),
        DesignVerb::Tension(arguments) => tension::run(arguments, general),
        DesignVerb::Study(arguments) => study::run(arguments, general),
    }
}
