//! `sinew identify`.

use crate::arguments::{IdentifyArguments, RoleArguments, WriteArguments};
use crate::error::Error;
use crate::output::{Folder, bold, print, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::report::{picture_svg, render};
use crate::table::{number, percent, table};
use sinew_identify::identify::{Identification, Options, identify};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_dataset};
use sinew_identify::report::IdentificationReport;
use std::fmt::Write;
use std::path::PathBuf;

pub(crate) fn run(arguments: &IdentifyArguments) -> Result<(), Error> {
    let folder = Folder::open(&arguments.write.out)?;
    refuse_overwrite(&arguments.logs, &output_files(&folder, &arguments.write))?;
    let progress = Progress::new();
    progress.show("reading logs", 0.0);
    let options = ReadOptions { skip_s: arguments.skip, far_required: true, paths: arguments.logs.clone() };
    let data = read_dataset(&role_flags(&arguments.roles), &options)?;
    let models =
        if arguments.model.iter().any(|m| m == "auto") { Vec::new() } else { arguments.model.clone() };
    let options = Options { seed: arguments.write.seed, models };
    let identification = identify(&data, &options, &|stage, done| progress.show(stage, done))?;
    drop(progress);
    write_results(&folder, &arguments.write, &identification)
}

fn role_flags(roles: &RoleArguments) -> RequestedRoles {
    RequestedRoles {
        far: roles.far.clone(),
        effort: roles.effort.clone(),
        motion: roles.motion.clone(),
        anchor: roles.anchor.clone(),
        given: roles.given.clone(),
        time: roles.time.clone(),
        trial: roles.trial.clone(),
        group: roles.group.clone(),
    }
}

/// Every file that [`write_results`] writes.
pub(crate) fn output_files(folder: &Folder, write: &WriteArguments) -> Vec<PathBuf> {
    let files = [folder.file("model.json"), folder.file("report.html")];
    files.into_iter().chain(write.picture.clone()).collect()
}

/// Writes model, report and picture, all or none, and says what came out.
pub(crate) fn write_results(
    folder: &Folder,
    write: &WriteArguments,
    identification: &Identification,
) -> Result<(), Error> {
    let account = &identification.report;
    let model = identification.model.to_json().map_err(sinew_identify::Error::from)?;
    let report = render(account)?;
    let picture =
        write.picture.as_ref().map(|path| Ok::<_, Error>((path, picture_svg(account)?))).transpose()?;
    let mut files =
        vec![(folder.file("model.json"), model.as_bytes()), (folder.file("report.html"), report.as_bytes())];
    if let Some((path, picture)) = &picture {
        files.push(((*path).clone(), picture.as_bytes()));
    }
    write_all(&files)?;
    if write.json {
        return print(&(serde_json::to_string(&summary(account, &files[0].0))? + "\n"));
    }
    print(&summary_text(account, &files[0].0, &files[1].0))
}

/// The account without its traces, for programs.
fn summary(account: &IdentificationReport, model: &std::path::Path) -> serde_json::Value {
    serde_json::json!({
        "model": model.display().to_string(),
        "chosen": account.chosen,
        "candidates": account.candidates,
        "influence": account.influence,
        "classical": account.classical,
        "logs": account.logs,
        "question": account.question,
        "warnings": account.warnings,
        "advice": account.recommendations,
        "seed": account.seed,
    })
}

/// What a person wants to know at once.
fn summary_text(account: &IdentificationReport, model: &std::path::Path, report: &std::path::Path) -> String {
    let mut text = String::new();
    for log in &account.logs {
        for finding in &log.findings {
            let _ = writeln!(text, "{}: {finding}", log.name);
        }
    }
    for row in account.influence.iter().filter(|row| row.dropped) {
        let _ = writeln!(text, "{}: {}", row.log, row.remark);
    }
    if !text.is_empty() {
        text.push('\n');
    }
    let _ = writeln!(
        text,
        "Predicting {} on data that the models had not seen. {}\n",
        bold(&account.far),
        account.question
    );
    let rows: Vec<Vec<String>> = account
        .candidates
        .iter()
        .map(|c| {
            vec![
                if c.chosen { "*".to_owned() } else { String::new() },
                c.name.clone(),
                number(Some(c.rmse)),
                percent(Some(c.percent_of_range / 100.0)),
                number(Some(c.pearson)),
                percent(Some(c.coverage95)),
            ]
        })
        .collect();
    text += &table(&["", "model", "RMSE", "of range", "Pearson", "in 95 % band"], &rows, 2);
    text.push('\n');
    for warning in &account.warnings {
        let _ = writeln!(text, "Note: {warning}");
    }
    let _ = writeln!(text, "{} {}", account.recommendations[0], account.recommendations[1]);
    let _ = writeln!(text, "\nwrote {} and {}", model.display(), report.display());
    text
}
