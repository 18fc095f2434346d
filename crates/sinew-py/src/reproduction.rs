//! The programme of `yuan2023` on the twin.

use crate::failure::Failure;
use crate::long_call;
use pyo3::prelude::*;
use sinew_lab::machine_file::load_machine;
use sinew_lab::reproduce::{ArmOptions, BenchOptions, reproduce_arm, reproduce_bench};
use std::path::Path;

/// Repeats the paper's experiments; see `sinew.reproduce`. The numbers as JSON.
#[pyfunction]
pub(crate) fn reproduce(
    py: Python<'_>,
    part: &str,
    quick: bool,
    seed: u64,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let (bench, arm) = match part {
        "all" => (true, true),
        "bench" => (true, false),
        "arm" => (false, true),
        other => {
            let expected = "part must be \"all\", \"bench\" or \"arm\"";
            return Err(Failure::refused(format!("{expected}, but is {other:?}")).into());
        }
    };
    long_call::run(py, progress, threads, move |progress| {
        let fraction = if bench && arm { 0.6 } else { f64::from(u8::from(bench)) };
        let mut all = serde_json::json!({"simulated": true, "seed": seed});
        if bench {
            let options = if quick { BenchOptions::quick(seed) } else { BenchOptions::full(seed) };
            let part = reproduce_bench(&options, &|stage, done| progress.tell(stage, fraction * done))?;
            all = serde_json::to_value(&part.results)?;
        }
        if arm {
            let machine = load_machine(Path::new("lm_arm"), None)?.machine;
            let options = if quick { ArmOptions::quick(seed) } else { ArmOptions::full(seed) };
            let tell = |stage: &str, done: f64| progress.tell(stage, fraction + (1.0 - fraction) * done);
            let part = reproduce_arm(&machine, &options, &tell)?;
            if let Some(object) = all.as_object_mut() {
                object.insert("tracking".to_owned(), serde_json::to_value(&part.tracking)?);
            }
        }
        Ok(serde_json::to_string(&all)?)
    })
}

/// Style sheet of the reports.
#[pyfunction]
pub(crate) fn page_style() -> String {
    sinew_report::page_style()
}
