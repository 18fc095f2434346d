//! `sinew demo`.

use super::evaluate::scores_table;
use super::identify::{output_files, write_results};
use crate::answer::{Answer, Content};
use crate::arguments::{DemoArguments, General};
use crate::error::Error;
use crate::output::{Folder, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::table::{number, table};
use sinew_identify::evaluate::{evaluate, roles_of};
use sinew_identify::identify::{Options, identify};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_bytes, read_bytes_with_roles};
use sinew_identify::report::Parameter;
use sinew_lab::simulated::{Truth, demo_logs, demo_truth};

pub(crate) fn run(arguments: &DemoArguments, general: &General) -> Result<Answer, Error> {
    let folder = Folder::open(&arguments.out)?;
    let progress = Progress::new();
    progress.show("simulating", 0.0);
    let logs = demo_logs(arguments.write.seed);
    let places: Vec<_> = logs.iter().map(|(name, _)| folder.file(name)).collect();
    let outputs = [places, output_files(&folder, &arguments.write)].concat();
    refuse_overwrite([], &outputs, general.no_clobber)?;
    let bytes: Vec<(&str, &[u8])> =
        logs.iter().map(|(name, text)| (name.as_str(), text.as_bytes())).collect();
    let Some((held_out, training)) = bytes.split_last() else {
        return Err(Error::NoSimulatedLog);
    };
    let reading = ReadOptions { far_required: true, ..ReadOptions::default() };
    let data = read_bytes(training, &RequestedRoles::default(), &reading)?;
    let options = Options { seed: arguments.write.seed, ..Options::default() };
    let identification = identify(&data, &options, &|stage, done| progress.show(stage, done))?;
    drop(progress);
    let files: Vec<_> = bytes.iter().map(|(name, text)| (folder.file(name), *text)).collect();
    let mut written = write_all(&files)?;
    let mut answer = write_results(&folder, &arguments.write, &identification, general.json)?;
    let model = &identification.model;
    let data = read_bytes_with_roles(&[*held_out], &roles_of(model), &reading)?;
    let evaluation = evaluate(model, &data, None)?;
    written.append(&mut answer.written);
    answer.written = written;
    match &mut answer.content {
        Content::Json(keys) => {
            keys.insert("simulated".to_owned(), true.into());
            keys.insert("held_out".to_owned(), serde_json::to_value(&evaluation)?);
            let truth: Vec<_> = demo_truth(arguments.write.seed)
                .map(
                    |truth| serde_json::json!({"name": truth.name, "unit": truth.unit, "value": truth.value}),
                )
                .to_vec();
            keys.insert("truth".to_owned(), truth.into());
        }
        Content::Text(text) => {
            let scores = scores_table(model, &evaluation);
            *text += &format!("On another SIMULATED day, which was not fitted:\n\n{scores}\n");
            *text += &truth_table(arguments.write.seed, &identification.report.chosen.parameters);
        }
    }
    Ok(answer)
}

/// The numbers that the simulation was made from beside those identified; dashes where the chosen model has
/// others.
fn truth_table(seed: u64, parameters: &[Parameter]) -> String {
    let row = |truth: Truth| {
        let found = parameters.iter().find(|parameter| parameter.name == truth.name);
        let identified = found.map(|found| [found.value, found.low, found.high]);
        let verdict = match found {
            Some(found) if (found.low..=found.high).contains(&truth.value) => "inside",
            Some(_) => "outside",
            None => "not a number of the chosen model",
        };
        let numbers =
            identified.map_or_else(|| ["-"; 3].map(str::to_owned), |all| all.map(|x| number(Some(x))));
        let head = [truth.name.to_owned(), truth.unit.to_owned(), number(Some(truth.value))];
        head.into_iter().chain(numbers).chain([verdict.to_owned()]).collect()
    };
    let rows: Vec<Vec<String>> = demo_truth(seed).into_iter().map(row).collect();
    let head = ["made from", "unit", "truth", "identified", "95 % from", "to", "truth is"];
    format!("{}\n", table(&head, &rows, 2))
}

#[cfg(test)]
mod tests {
    use super::truth_table;

    #[test]
    fn the_truth_is_shown_also_where_another_family_of_models_was_chosen() {
        let text = truth_table(1, &[]);
        let rows = text.lines().filter(|line| line.contains("not a number of the chosen model")).count();
        assert!(rows > 0 && rows == sinew_lab::simulated::demo_truth(1).len(), "{text}");
    }
}
