//! The file of a study, read into values within their domains.

use serde::Deserialize;
use std::collections::BTreeMap;
use toml::Spanned;

/// A study.
#[derive(Debug)]
pub(super) struct Study {
    pub(super) folder: String,
    pub(super) trials: u32,
    pub(super) seed: u32,
    pub(super) backend: Backend,
    pub(super) workers: Option<u32>,
    pub(super) batch: u32,
    pub(super) minimize: Vec<String>,
    pub(super) maximize: Vec<String>,
    pub(super) sampler: Sampler,
    pub(super) storage: Option<String>,
    pub(super) objective: Objective,
    pub(super) parameters: BTreeMap<String, Range>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    folder: Spanned<String>,
    trials: Spanned<u32>,
    #[serde(default = "one")]
    seed: u32,
    #[serde(default)]
    backend: Backend,
    workers: Option<Spanned<u32>>,
    batch: Option<Spanned<u32>>,
    #[serde(default)]
    minimize: Vec<Spanned<String>>,
    #[serde(default)]
    maximize: Vec<Spanned<String>>,
    sampler: Option<Spanned<Sampler>>,
    storage: Option<Spanned<String>>,
    objective: Spanned<Objective>,
    #[serde(default)]
    parameters: BTreeMap<Spanned<String>, Spanned<Range>>,
}

fn one() -> u32 {
    1
}

/// Where trials run.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Backend {
    /// Threads of one process.
    #[default]
    Local,
    /// Actors of Ray.
    Ray,
    /// Array jobs of Slurm.
    Slurm,
}

/// What proposes parameters.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Sampler {
    /// Uniform draws.
    #[default]
    Uniform,
    /// Optuna's tree-structured Parzen estimator.
    Tpe,
    /// Optuna's genetic algorithm for several values.
    Nsga2,
}

/// What a trial evaluates.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case", rename_all_fields = "snake_case", deny_unknown_fields)]
pub(super) enum Objective {
    /// Tracking by simulated specimens of a machine.
    Robustness {
        machine: String,
        path: Option<String>,
        duration_s: Option<f64>,
        compensation: Option<String>,
    },
    /// Routes of the cable of one muscle.
    Routing { machine: String, muscle: String },
    /// A function of the user's module.
    Python { module: String, function: String },
}

/// Range of a parameter.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
    #[serde(default)]
    pub(super) log: bool,
}

/// Reads a study, or says in which line which key is wrong.
pub(super) fn parse(text: &str) -> Result<Study, String> {
    let at = |start: usize, problem: &str| {
        let line = text.get(..start).unwrap_or(text).matches('\n').count() + 1;
        format!("line {line}: {problem}")
    };
    let written: Written = toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start);
        let before = text.get(..start).unwrap_or_default().rfind('\n').map_or(0, |end| end + 1);
        let line = text.get(before..).unwrap_or_default().lines().next().unwrap_or_default();
        at(start, &format!("{} in `{}`", error.message().trim_end(), line.trim()))
    })?;
    if written.folder.get_ref().is_empty() {
        return Err(at(written.folder.span().start, "folder must be a path, but is empty"));
    }
    let counts = [("trials", Some(&written.trials)), ("workers", written.workers.as_ref())];
    for (name, count) in counts.into_iter().chain([("batch", written.batch.as_ref())]) {
        if let Some(count) = count.filter(|count| *count.get_ref() == 0) {
            return Err(at(
                count.span().start,
                &format!("{name} must be an integer of at least 1, but is 0"),
            ));
        }
    }
    let sampler = written.sampler.as_ref().map_or(Sampler::Uniform, |sampler| *sampler.get_ref());
    if let Some(place) = written.sampler.as_ref().filter(|_| sampler != Sampler::Uniform) {
        if written.minimize.is_empty() && written.maximize.is_empty() {
            return Err(at(place.span().start, "sampler needs a value in minimize or maximize"));
        }
        if written.parameters.is_empty() {
            return Err(at(place.span().start, "sampler needs a table [parameters.NAME]"));
        }
    }
    if let Some(place) = written.storage.as_ref().filter(|_| sampler == Sampler::Uniform) {
        return Err(at(place.span().start, "storage needs a sampler of Optuna: tpe or nsga2"));
    }
    let mut values: Vec<&str> = Vec::new();
    for value in written.minimize.iter().chain(&written.maximize) {
        if values.contains(&value.get_ref().as_str()) {
            return Err(at(value.span().start, &format!("{:?} is named twice", value.get_ref())));
        }
        values.push(value.get_ref());
    }
    for (name, range) in &written.parameters {
        let Range { low, high, log } = *range.get_ref();
        let refused = |expected: &str| {
            Err(at(name.span().start, &format!("{}: {expected}, but is {low} to {high}", name.get_ref())))
        };
        if !(low.is_finite() && high.is_finite() && low <= high) {
            return refused("a range must be finite and from low to high");
        }
        if log && low <= 0.0 {
            return refused("a logarithmic range must begin above 0");
        }
    }
    let objective = written.objective.get_ref();
    check(objective)
        .map_err(|problem| at(written.objective.span().start, &format!("objective: {problem}")))?;
    let names = |list: Vec<Spanned<String>>| list.into_iter().map(Spanned::into_inner).collect();
    Ok(Study {
        folder: written.folder.into_inner(),
        trials: written.trials.into_inner(),
        seed: written.seed,
        backend: written.backend,
        workers: written.workers.map(Spanned::into_inner),
        batch: written.batch.map_or(1, Spanned::into_inner),
        minimize: names(written.minimize),
        maximize: names(written.maximize),
        sampler,
        storage: written.storage.map(Spanned::into_inner),
        objective: written.objective.into_inner(),
        parameters: written
            .parameters
            .into_iter()
            .map(|(name, range)| (name.into_inner(), range.into_inner()))
            .collect(),
    })
}

fn check(objective: &Objective) -> Result<(), String> {
    match objective {
        Objective::Robustness { duration_s: Some(duration), .. }
            if !(duration.is_finite() && *duration > 0.0) =>
        {
            Err(format!("duration_s must be a finite number > 0, but is {duration}"))
        }
        // They become names in a program.
        Objective::Python { module, function } => {
            let dotted = |text: &str| text.split('.').all(is_name);
            match (dotted(module), is_name(function)) {
                (false, _) => Err(format!("module must be the name of a Python module, but is {module:?}")),
                (_, false) => {
                    Err(format!("function must be the name of a Python function, but is {function:?}"))
                }
                _ => Ok(()),
            }
        }
        Objective::Robustness { .. } | Objective::Routing { .. } => Ok(()),
    }
}

fn is_name(text: &str) -> bool {
    !text.starts_with(|c: char| c.is_ascii_digit())
        && !text.is_empty()
        && text.chars().all(|c| c.is_alphanumeric() || c == '_')
}
