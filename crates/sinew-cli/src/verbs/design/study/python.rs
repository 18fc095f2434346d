//! A study as a Python program.

use super::file::{Backend, Objective, Sampler, Study};
use std::fmt::Write as _;

/// The program that runs a study.
pub(super) fn program(study: &Study) -> String {
    let ranges = study.parameters.iter().map(|(name, range)| {
        let log = if range.log { ", log=True" } else { "" };
        format!("    {}: Range({:?}, {:?}{log}),\n", quoted(name), range.low, range.high)
    });
    let ranges: String = ranges.collect();
    let mut imports = vec!["Study", "write_report"];
    let (foreign, objective) = match &study.objective {
        Objective::Robustness { machine, path, duration_s, compensation } => {
            imports.push("robustness");
            let mut keywords = String::new();
            if let Some(duration) = duration_s {
                let _ = write!(keywords, ", duration_s={duration:?}");
            }
            if let Some(compensation) = compensation {
                let _ = write!(keywords, ", compensation={}", quoted(compensation));
            }
            let path = path.as_ref().map(|path| format!(", {}", quoted(path))).unwrap_or_default();
            (String::new(), format!("robustness({}{path}{keywords})", quoted(machine)))
        }
        Objective::Routing { machine, muscle } => {
            imports.push("routing");
            (String::new(), format!("routing({}, {})", quoted(machine), quoted(muscle)))
        }
        Objective::Python { module, function } => {
            (format!("from {module} import {function}\n"), function.clone())
        }
    };
    let sampler = match study.sampler {
        Sampler::Uniform => None,
        Sampler::Tpe => Some("TPESampler"),
        Sampler::Nsga2 => Some("NSGAIISampler"),
    };
    let optuna = if sampler.is_some() { "import optuna\n\n" } else { "" };
    let mut options = format!("seed={}", study.seed);
    for (name, values) in [("minimize", &study.minimize), ("maximize", &study.maximize)] {
        if !values.is_empty() {
            let values: Vec<String> = values.iter().map(|value| quoted(value)).collect();
            let _ = write!(options, ", {name}=[{}]", values.join(", "));
        }
    }
    if let Some(sampler) = sampler {
        let _ = write!(options, ", sampler=optuna.samplers.{sampler}(seed={})", study.seed);
    }
    if let Some(storage) = &study.storage {
        let _ = write!(options, ", storage={}", quoted(storage));
    }
    let backend = match study.backend {
        Backend::Local => "local",
        Backend::Ray => "ray",
        Backend::Slurm => "slurm",
    };
    let mut run = format!("{}, backend={}", study.trials, quoted(backend));
    if let Some(workers) = study.workers {
        let _ = write!(run, ", workers={workers}");
    }
    if study.batch > 1 {
        let _ = write!(run, ", batch={}", study.batch);
    }
    if !study.parameters.is_empty() {
        imports.push("Range");
    }
    // As tools for Python sort them: classes before functions.
    imports.sort_unstable();
    format!(
        "{optuna}from sinew.study import {}\n{foreign}\nparameters = {{\n{ranges}}}\n\n\
         if __name__ == \"__main__\":\n    objective = {objective}\n    \
         with Study({folder}, objective, parameters, {options}) as study:\n        \
         study.run({run})\n        study.save()\n        \
         write_report(study, study.folder / \"report.html\")\n",
        imports.join(", "),
        folder = quoted(&study.folder),
    )
}

/// A text as a literal of Python, which takes the escapes of JSON.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
