//! The page of an identification: its data in the template.

use super::error::Error;
use super::format::{count, duration, percent, percent_of_range, plural, significant, with_unit};
use super::plot::Plot;
use super::record::{Signals, records};
use super::shell::{SHELL, Shell};
use super::{checks, laws, loops, models, residuals, traces};
use askama::Template;
use sinew_identify::log::Role;
use sinew_identify::report::{Candidate, Grade, IdentificationReport};

#[derive(Template)]
#[template(path = "report.html")]
struct Page<'a> {
    report: &'a IdentificationReport,
    simulated: bool,
    far_unit: &'static str,
    inputs: Vec<InputView>,
    verdict: Option<Verdict>,
    grade: &'static str,
    advice: Vec<&'a str>,
    amount: String,
    models: models::Models,
    parallelogram: Option<Plot>,
    loops: String,
    /// More than one record.
    many: bool,
    traces: Option<traces::Traces>,
    residuals: Vec<residuals::Residual>,
    calibration: checks::Calibration,
    influence: Vec<checks::InfluenceBar>,
    logs: Vec<LogRow<'a>>,
    conditions: Vec<(String, String)>,
    laws: Vec<laws::Law>,
    parameters: Vec<laws::ParameterRow>,
    band_factor: String,
    size: String,
    range: String,
    shell: Shell,
    uplot_style: &'static str,
    uplot: &'static str,
    uplot_licence: &'static str,
    script: &'static str,
}

struct InputView {
    column: String,
    role: &'static str,
}

struct Verdict {
    name: String,
    percent: String,
    rmse: String,
    pearson: String,
    coverage: String,
    trusted: bool,
}

struct LogRow<'a> {
    name: &'a str,
    samples: String,
    trials: usize,
    duration: String,
    rate: String,
    findings: &'a [String],
}

/// One self-contained HTML page about an identification. The same report gives the same bytes.
///
/// # Errors
/// [`Error`] where the page could not be written; no content of a report makes that happen.
pub fn render(report: &IdentificationReport) -> Result<String, Error> {
    let signals = Signals::new(report);
    let records = records(report);
    let samples: usize = report.logs.iter().map(|l| l.samples).sum();
    let seconds: f64 = report.logs.iter().map(|l| l.duration_s).sum();
    let drawn = loops::shown(&records).len();
    let page = Page {
        report,
        simulated: simulated(report),
        far_unit: signals.far_unit,
        inputs: report
            .inputs
            .iter()
            .map(|i| InputView { column: i.column.clone(), role: role(i.role) })
            .collect(),
        verdict: chosen(report).map(|c| verdict(c, &signals)),
        grade: grade(report.grade),
        advice: report.recommendations.iter().map(String::as_str).filter(|a| !a.is_empty()).collect(),
        amount: format!(
            "{}, {}, {}",
            plural(report.logs.len(), "log", "logs"),
            plural(samples, "sample", "samples"),
            duration(seconds)
        ),
        models: models::table(report),
        parallelogram: loops::plot(&records, &signals),
        loops: match drawn < records.len() {
            true => format!("{drawn} evenly spaced of {} records are shown.", count(records.len())),
            false => String::new(),
        },
        many: records.len() > 1,
        traces: traces::section(&records, &signals, report.far_range)?,
        residuals: residuals::plots(&records, &signals),
        calibration: checks::calibration(&records, &signals, report.far_range),
        influence: checks::influence(report),
        logs: report.logs.iter().map(log_row).collect(),
        conditions: report.conditions.iter().map(|c| (c.column.clone(), values(&c.values))).collect(),
        laws: report.classical.iter().map(|c| laws::law(c, &signals)).collect(),
        parameters: report.chosen.parameters.iter().map(laws::parameter).collect(),
        band_factor: significant(report.chosen.band_factor, 3),
        size: count(report.chosen.size),
        range: with_unit(&significant(report.far_range, 3), signals.far_unit),
        shell: SHELL,
        uplot_style: sinew_view::UPLOT_STYLE,
        uplot: sinew_view::UPLOT,
        uplot_licence: sinew_view::UPLOT_LICENCE,
        script: include_str!("../assets/traces.js"),
    };
    Ok(page.render()?)
}

fn grade(grade: Grade) -> &'static str {
    match grade {
        Grade::Use => "use",
        Grade::UseWithCare => "use with care",
        Grade::DoNotUse => "do not use",
    }
}

/// The selected model among the evaluated ones.
pub(super) fn chosen(report: &IdentificationReport) -> Option<&Candidate> {
    report.candidates.iter().find(|c| c.chosen).filter(|c| c.failed.is_none())
}

/// Whether any log is labelled as simulated.
pub(super) fn simulated(report: &IdentificationReport) -> bool {
    let is_labelled = |text: &str| text.to_lowercase().contains("simulated");
    report.logs.iter().any(|l| is_labelled(&l.name) || l.findings.iter().any(|f| is_labelled(f)))
}

fn verdict(c: &Candidate, signals: &Signals) -> Verdict {
    Verdict {
        name: c.name.clone(),
        percent: percent_of_range(c.percent_of_range),
        rmse: with_unit(&significant(c.rmse, 3), signals.far_unit),
        pearson: significant(c.pearson, 4),
        coverage: percent(c.coverage95),
        trusted: c.coverage95 >= 0.85,
    }
}

fn role(role: Role) -> &'static str {
    match role {
        Role::Effort => "effort",
        Role::Motion => "motion",
        Role::Anchor => "far-end motion",
        Role::Given => "given",
    }
}

fn log_row(log: &sinew_identify::log::LogInfo) -> LogRow<'_> {
    LogRow {
        name: &log.name,
        samples: count(log.samples),
        trials: log.trials,
        duration: duration(log.duration_s),
        rate: with_unit(&significant(1.0 / log.interval_s, 3), "Hz"),
        findings: &log.findings,
    }
}

/// The first values of a condition, so that a long list stays one line.
fn values(all: &[String]) -> String {
    const SHOWN: usize = 12;
    let mut text = all.iter().take(SHOWN).map(String::as_str).collect::<Vec<_>>().join(", ");
    if all.len() > SHOWN {
        text.push_str(&format!(" and {} more", all.len() - SHOWN));
    }
    text
}
