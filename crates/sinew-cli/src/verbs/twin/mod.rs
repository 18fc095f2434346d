//! `sinew twin`: one file per verb within it.

mod bench;
mod cable;
mod plan;
mod scenario;

use crate::answer::Answer;
use crate::arguments::{General, TwinArguments, TwinVerb};
use crate::error::Error;

pub(super) use cable::two_strokes;

pub(crate) fn run(arguments: &TwinArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        TwinVerb::Cable(arguments) => cable::run(arguments, general),
        TwinVerb::Bench(arguments) => bench::run(arguments, general),
        TwinVerb::Plan(arguments) => plan::run(arguments, general),
    }
}
