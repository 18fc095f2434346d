//! `sinew adapt`.

use super::columns::account;
use super::identify::{output_files, write_results};
use super::read_model;
use crate::answer::Answer;
use crate::arguments::{AdaptArguments, General};
use crate::error::Error;
use crate::output::{Folder, print, refuse_overwrite};
use crate::progress::Progress;
use sinew_identify::adapt::adapt;
use sinew_identify::evaluate::read_for;
use sinew_identify::identify::Options;
use sinew_identify::log::ReadOptions;

pub(crate) fn run(arguments: &AdaptArguments, general: &General) -> Result<Answer, Error> {
    let folder = Folder::open(&arguments.out)?;
    refuse_overwrite(
        arguments.logs.iter().chain([&arguments.model]),
        &output_files(&folder, &arguments.write),
        general.no_clobber,
    )?;
    let old = read_model(&arguments.model)?;
    let options = ReadOptions {
        skip_s: arguments.skip,
        far_required: true,
        paths: arguments.logs.clone(),
        columns: arguments.columns.options(),
        ..ReadOptions::default()
    };
    let data = read_for(&old, &options)?;
    if !general.json {
        print(&(account(&data) + "\n"))?;
    }
    let progress = Progress::new();
    let options = Options { seed: arguments.write.seed, ..Options::default() };
    let adapted = adapt(&old, &data, &options, &|stage, done| progress.show(stage, done))?;
    drop(progress);
    write_results(&folder, &arguments.write, &adapted, general.json)
}
