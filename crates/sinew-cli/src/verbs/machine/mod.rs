//! `sinew machine`: one file per verb within it.

mod choice;
mod design_checks;
mod draft;
mod limit_words;
mod map;
mod map_json;
mod new;
mod payload;
mod show;
mod tune;

use crate::answer::Answer;
use crate::arguments::{General, MachineArguments, MachineVerb};
use crate::error::Error;

pub(crate) fn run(arguments: &MachineArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        MachineVerb::Show(arguments) => show::run(arguments, general),
        MachineVerb::New(arguments) => new::run(arguments, general),
        MachineVerb::Tune(arguments) => tune::run(arguments, general),
        MachineVerb::Map(arguments) => map::run(arguments, general),
    }
}
