//! `sinew demo`.

use super::evaluate::scores_table;
use super::identify::write_results;
use crate::arguments::DemoArguments;
use crate::error::Error;
use crate::output::{Folder, print, write_all};
use crate::progress::Progress;
use sinew_identify::evaluate::{evaluate, roles_of};
use sinew_identify::identify::{Options, identify};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_bytes, read_bytes_with_roles};
use sinew_lab::simulated::demo_logs;

pub(crate) fn run(arguments: &DemoArguments) -> Result<(), Error> {
    let folder = Folder::open(&arguments.write.out)?;
    let progress = Progress::new();
    progress.show("simulating", 0.0);
    let logs = demo_logs(arguments.write.seed);
    let bytes: Vec<(&str, &[u8])> =
        logs.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect();
    let Some((held_out, training)) = bytes.split_last() else {
        return Err(Error::NoSimulatedLog);
    };
    let reading = ReadOptions { skip_s: 0.0, far_required: true, paths: Vec::new() };
    let data = read_bytes(training, &RequestedRoles::default(), &reading)?;
    let options = Options { seed: arguments.write.seed, models: Vec::new() };
    let identification = identify(&data, &options, &|stage, done| progress.show(stage, done))?;
    drop(progress);
    let files: Vec<_> = bytes.iter().map(|(name, text)| (folder.file(name), *text)).collect();
    write_all(&files)?;
    write_results(&folder, &arguments.write, &identification)?;
    if arguments.write.json {
        return Ok(());
    }
    let model = &identification.model;
    let data = read_bytes_with_roles(&[*held_out], &roles_of(model), &reading)?;
    let evaluation = evaluate(model, &data)?;
    print(&format!(
        "\nOn a third SIMULATED day, which was not fitted:\n\n{}",
        scores_table(model, &evaluation)
    ))
}
