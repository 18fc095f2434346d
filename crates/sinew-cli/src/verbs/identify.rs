//! `sinew identify`.

use super::columns::account;
use crate::answer::{Answer, Content};
use crate::arguments::{General, IdentifyArguments, PreferArgument, RoleArguments, WriteArguments};
use crate::error::Error;
use crate::output::{Folder, bold, one_line, print, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::table::{number, percent, table};
use sinew_identify::identify::{Identification, Keep, Options, Preference, check_options, identify};
use sinew_identify::log::{ReadOptions, RequestedRoles, read_dataset};
use sinew_identify::report::{Grade, IdentificationReport};
use sinew_report::{picture_svg, render};
use std::fmt::Write;
use std::path::{Path, PathBuf};

pub(crate) fn run(arguments: &IdentifyArguments, general: &General) -> Result<Answer, Error> {
    let folder = arguments.out.as_deref().map(Folder::open).transpose()?;
    if let Some(folder) = &folder {
        refuse_overwrite(&arguments.logs, &output_files(folder, &arguments.write), general.no_clobber)?;
    }
    let progress = Progress::new();
    progress.show("reading logs", 0.0);
    let reading = ReadOptions {
        skip_s: arguments.skip,
        far_required: true,
        paths: arguments.logs.clone(),
        columns: arguments.columns.options(),
        ..ReadOptions::default()
    };
    let data = read_dataset(&role_flags(&arguments.roles), &reading)?;
    let models =
        if arguments.model.iter().any(|m| m == "auto") { Vec::new() } else { arguments.model.clone() };
    let prefer = match arguments.prefer {
        PreferArgument::Accurate => Preference::Accurate,
        PreferArgument::Simple => Preference::Simple { loss_percent: arguments.loss },
    };
    let options = Options { seed: arguments.write.seed, models, keep: keep(&arguments.keep), prefer };
    check_options(&data, &options)?;
    let (Some(folder), false) = (folder, arguments.dry_run) else {
        let logs = || serde_json::json!({"logs": data.logs, "columns": data.columns});
        let content = if general.json { Content::json(&logs())? } else { Content::Text(account(&data)) };
        return Ok(Answer::done(content, Vec::new()));
    };
    if !general.json {
        // Before the fit, so that a wrong role is seen in time.
        print(&(account(&data) + "\n"))?;
    }
    let identification = identify(&data, &options, &|stage, done| progress.show(stage, done))?;
    drop(progress);
    write_results(&folder, &arguments.write, &identification, general.json)
}

/// `all`, or names.
fn keep(names: &[String]) -> Keep {
    match names {
        [] => Keep::Judged,
        [all] if all == "all" => Keep::All,
        names => Keep::Logs(names.to_vec()),
    }
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
        ignore: roles.ignore.clone(),
    }
}

/// Every file that [`write_results`] writes.
pub(crate) fn output_files(folder: &Folder, write: &WriteArguments) -> Vec<PathBuf> {
    let files = [folder.file("model.json"), folder.file("report.html")];
    files.into_iter().chain(write.picture.clone()).collect()
}

/// Writes model, report and picture, all or none; the answer is the summary.
pub(crate) fn write_results(
    folder: &Folder,
    write: &WriteArguments,
    identification: &Identification,
    json: bool,
) -> Result<Answer, Error> {
    let report = &identification.report;
    let (model_path, page_path) = (folder.file("model.json"), folder.file("report.html"));
    let model = identification.model.to_json().map_err(sinew_identify::Error::from)?;
    let page = render(report)?;
    let mut files = vec![(model_path.clone(), model.as_bytes()), (page_path.clone(), page.as_bytes())];
    let picture =
        write.picture.as_ref().map(|path| Ok::<_, Error>((path, picture_svg(report)?))).transpose()?;
    if let Some((path, picture)) = &picture {
        files.push(((*path).clone(), picture.as_bytes()));
    }
    let written = write_all(&files)?;
    let content = if json {
        Content::json(&summary(report, &model_path))?
    } else {
        Content::Text(summary_text(report))
    };
    Ok(Answer::done(content, written))
}

/// The report without its traces, for `--json`.
fn summary(report: &IdentificationReport, model: &Path) -> serde_json::Value {
    serde_json::json!({
        "model": model.display().to_string(),
        "far": report.far,
        "far_unit": report.far_unit,
        "far_range": report.far_range,
        "chosen": report.chosen,
        "expected": report.expected,
        "beyond": report.beyond,
        "specimen": report.specimen,
        "grade": report.grade,
        "candidates": report.candidates,
        "influence": report.influence,
        "classical": report.classical,
        "headline": report.headline,
        "logs": report.logs,
        "columns": report.columns,
        "question": report.question,
        "warnings": report.warnings,
        "advice": report.recommendations,
        "seed": report.seed,
    })
}

/// How much each log spoils the prediction of the others; nothing with too few logs.
fn influence_text(report: &IdentificationReport) -> String {
    if report.influence.is_empty() {
        return String::new();
    }
    let rows: Vec<Vec<String>> = report
        .influence
        .iter()
        .map(|row| {
            let verdict = if row.dropped { "excluded" } else { "kept" };
            let ratios = [row.influence, row.deviation].map(|ratio| number(Some(ratio.exp())));
            [one_line(&row.log), verdict.to_owned()].into_iter().chain(ratios).collect()
        })
        .collect();
    let mut text =
        "Leave-one-log-out influence: error on the other logs with it in training, over that without it; its \
            own error over theirs; in the order of the logs\n\n"
            .to_owned();
    text += &table(&["log", "", "influence", "own error"], &rows, 2);
    for row in report.influence.iter().filter(|row| !row.remark.is_empty()) {
        let _ = writeln!(text, "{}: {}", one_line(&row.log), row.remark);
    }
    text.push('\n');
    text
}

/// The summary for the terminal.
fn summary_text(report: &IdentificationReport) -> String {
    let mut text = influence_text(report);
    let _ = writeln!(text, "Cross-validated prediction of {}. {}\n", bold(&report.far), report.question);
    let rows: Vec<Vec<String>> = report
        .candidates
        .iter()
        .filter(|c| c.failed.is_none())
        .map(|c| {
            vec![
                if c.chosen { "*".to_owned() } else { String::new() },
                c.name.clone(),
                number(Some(c.score)),
                number(Some(c.rmse)),
                percent(Some(c.percent_of_range / 100.0)),
                number(Some(c.pearson)),
                percent(Some(c.coverage95)),
                c.size.to_string(),
            ]
        })
        .collect();
    text += &table(
        &["", "model", "mean of folds", "RMSE", "of range", "Pearson", "in 95 % band", "parameters"],
        &rows,
        2,
    );
    for candidate in &report.candidates {
        if let Some(reason) = &candidate.failed {
            let _ = writeln!(text, "   {}: not compared, because {reason}", candidate.name);
        }
    }
    let unit = if report.far_unit.is_empty() { "the unit of the far side" } else { &report.far_unit };
    let _ = writeln!(
        text,
        "Sorted by the geometric mean of the RMSEs of the folds, in {unit}, by which a model is chosen.\n"
    );
    let _ = writeln!(text, "{}\n", report.chosen.reason);
    if let Some(headline) = &report.headline {
        let _ = writeln!(text, "{}\n", headline.in_words());
    }
    for warning in &report.warnings {
        let _ = writeln!(text, "Note: {warning}");
    }
    let _ = writeln!(text, "{} {}", report.recommendations[0], report.recommendations[1]);
    if report.grade != Grade::Use {
        text +=
            "`sinew twin plan --out plan.csv` writes a programme of motions that shows what a model needs.\n";
    }
    text.push('\n');
    text
}
