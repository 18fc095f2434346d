//! `sinew log`.

mod command_kinds;
mod export;
mod info;
mod layout;
#[cfg(feature = "parquet")]
mod parquet;
mod plot;
mod replay;
mod rows;
mod table;

use crate::answer::Answer;
use crate::arguments::{General, LogArguments, LogVerb};
use crate::error::Error;
use crate::progress::Progress;

pub(crate) fn run(arguments: &LogArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        LogVerb::Info(arguments) => info::run(arguments, general),
        LogVerb::Export(arguments) => Progress::during("exporting", || export::run(arguments, general)),
        LogVerb::Plot(arguments) => Progress::during("drawing", || plot::run(arguments, general)),
        LogVerb::Replay(arguments) => replay::run(arguments, general),
        LogVerb::Layout(arguments) => layout::run(arguments, general),
    }
}
