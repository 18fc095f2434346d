//! `sinew adapt`.

use super::identify::{finish, places};
use super::read_model;
use crate::arguments::AdaptArguments;
use crate::error::Error;
use crate::output::{Folder, spare};
use crate::progress::Progress;
use sinew_identify::adapt::adapt;
use sinew_identify::evaluate::read_for;
use sinew_identify::identify::Options;
use sinew_identify::log::ReadOptions;

pub(crate) fn run(arguments: &AdaptArguments) -> Result<(), Error> {
    let folder = Folder::open(&arguments.write.out)?;
    spare(arguments.logs.iter().chain([&arguments.model]), &places(&folder, &arguments.write))?;
    let old = read_model(&arguments.model)?;
    let options = ReadOptions { skip_s: arguments.skip, far_required: true, paths: arguments.logs.clone() };
    let data = read_for(&old, &options)?;
    let progress = Progress::new();
    let options = Options { seed: arguments.write.seed, models: Vec::new() };
    let adapted = adapt(&old, &data, &options, &|stage, done| progress.show(stage, done))?;
    drop(progress);
    finish(&folder, &arguments.write, &adapted)
}
