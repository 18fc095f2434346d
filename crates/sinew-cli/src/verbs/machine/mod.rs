//! `sinew machine`: one file per verb within it.

mod body;
mod body_page;
mod choice;
mod convert;
mod design_checks;
mod draft;
mod evaluate;
mod limit_words;
mod map;
mod map_json;
mod names;
mod new;
mod payload;
mod poses;
mod show;
mod survey;
mod tune;
mod view;

use crate::answer::Answer;
use crate::arguments::{General, MachineArguments, MachineVerb};
use crate::error::Error;

pub(crate) fn run(arguments: &MachineArguments, general: &General) -> Result<Answer, Error> {
    match &arguments.verb {
        MachineVerb::Show(arguments) => show::run(arguments, general),
        MachineVerb::Body(arguments) => body::run(arguments, general),
        MachineVerb::New(arguments) => new::run(arguments, general),
        MachineVerb::Tune(arguments) => tune::run(arguments, general),
        MachineVerb::Map(arguments) => map::run(arguments, general),
        MachineVerb::Evaluate(arguments) => evaluate::run(arguments, general),
        MachineVerb::Convert(arguments) => convert::run(arguments, general),
    }
}
