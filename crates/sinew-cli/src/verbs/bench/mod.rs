//! `sinew bench`: one file per verb within it.

mod plan;
mod run;

use crate::answer::Answer;
use crate::arguments::{BenchArguments, BenchVerb, General};
use crate::error::Error;

pub(crate) fn run(arguments: &BenchArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        BenchVerb::Run(arguments) => run::run(arguments, general),
        BenchVerb::Plan(arguments) => plan::run(arguments, general),
    }
}
