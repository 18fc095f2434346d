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

use super::Outcome;
use crate::arguments::{MachineArguments, MachineVerb};
use crate::error::Error;

pub(crate) fn run(arguments: &MachineArguments) -> Result<Outcome, Error> {
    match &arguments.verb {
        MachineVerb::Show(arguments) => show::run(arguments).map(|()| Outcome::AsAsked),
        MachineVerb::New(arguments) => new::run(arguments),
        MachineVerb::Tune(arguments) => tune::run(arguments).map(|()| Outcome::AsAsked),
        MachineVerb::Map(arguments) => map::run(arguments).map(|()| Outcome::AsAsked),
    }
}
