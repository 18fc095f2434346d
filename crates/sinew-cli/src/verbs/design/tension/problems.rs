//! The file of distribution problems: as written (JSON fields and types), then as valid (lengths).

use serde::Deserialize;
use sinew::Error;
use sinew::control::tension::Problem;

/// The file as written.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenFile {
    problems: Vec<WrittenProblem>,
}

/// A problem as written, muscles by rows.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WrittenProblem {
    moment_arms: Vec<Vec<f64>>,
    torque_nm: Vec<f64>,
    min_n: Vec<f64>,
    max_n: Vec<f64>,
    /// Zero where it is not given.
    reference_n: Option<Vec<f64>>,
    /// One where it is not given.
    weight: Option<Vec<f64>>,
}

/// A problem whose lists have the right lengths; [`Problem::check`] checks the numbers.
#[derive(Debug)]
pub(super) struct ValidProblem {
    /// Row by row.
    moment_arms: Vec<f64>,
    pub(super) torque_nm: Vec<f64>,
    pub(super) min_n: Vec<f64>,
    max_n: Vec<f64>,
    reference_n: Vec<f64>,
    weight: Vec<f64>,
}

/// Reads the whole file; an error begins with the path of the value that is wrong.
pub(super) fn parse(text: &str) -> Result<Vec<ValidProblem>, String> {
    // The derived reader takes a list for an object's fields in their order.
    if text.trim_start().starts_with('[') {
        return Err(r#"expected an object, {"problems": [..]}, got a list"#.to_owned());
    }
    let mut json = serde_json::Deserializer::from_str(text);
    let file: WrittenFile = serde_path_to_error::deserialize(&mut json).map_err(|error| {
        let (path, cause) = (error.path().to_string(), error.inner());
        if cause.is_data() { format!("{path}: {cause}") } else { format!("is no JSON: {cause}") }
    })?;
    json.end().map_err(|error| format!("is no JSON: {error}"))?;
    let problems = file.problems.into_iter().enumerate();
    problems.map(|(k, problem)| validate(problem).map_err(|error| format!("problems[{k}].{error}"))).collect()
}

/// Checks the lengths; an error begins with the field.
fn validate(written: WrittenProblem) -> Result<ValidProblem, String> {
    let (muscles, joints) = (written.moment_arms.len(), written.torque_nm.len());
    let check_length = |field: String, list: &[f64], expected: usize, owner: &str| {
        let got = list.len();
        if got == expected {
            return Ok(());
        }
        Err(format!("{field}: expected {expected} numbers, one per {owner}, got {got}"))
    };
    for (i, row) in written.moment_arms.iter().enumerate() {
        check_length(format!("moment_arms[{i}]"), row, joints, "joint")?;
    }
    let reference_n = written.reference_n.unwrap_or_else(|| vec![0.0; muscles]);
    let weight = written.weight.unwrap_or_else(|| vec![1.0; muscles]);
    for (field, list) in [
        ("min_n", &written.min_n),
        ("max_n", &written.max_n),
        ("reference_n", &reference_n),
        ("weight", &weight),
    ] {
        check_length(field.to_owned(), list, muscles, "muscle")?;
    }
    Ok(ValidProblem {
        moment_arms: written.moment_arms.concat(),
        torque_nm: written.torque_nm,
        min_n: written.min_n,
        max_n: written.max_n,
        reference_n,
        weight,
    })
}

impl ValidProblem {
    pub(super) fn problem(&self) -> Problem<'_> {
        Problem {
            moment_arms: &self.moment_arms,
            torque: &self.torque_nm,
            minimum: &self.min_n,
            maximum: &self.max_n,
            reference: &self.reference_n,
            weight: &self.weight,
        }
    }

    /// An error of the solver in terms of the file: the place inside the problem, what is expected there and
    /// what was given.
    pub(super) fn locate(&self, error: &Error) -> String {
        let Error::EntryOutOfDomain { name, index, expected, got } = *error else {
            return format!(": {error}");
        };
        let joints = self.torque_nm.len().max(1);
        let place = match name {
            "moment_arms" => format!("moment_arms[{}][{}]", index / joints, index % joints),
            "torque" => format!("torque_nm[{index}]"),
            "minimum" => format!("min_n[{index}]"),
            "maximum" => format!("max_n[{index}]"),
            "reference" => format!("reference_n[{index}]"),
            name => format!("{name}[{index}]"),
        };
        let expected = match self.max_n.get(index) {
            Some(max) if name == "minimum" && got > *max => format!("<= max_n[{index}] = {max}"),
            _ => expected.to_owned(),
        };
        // Large numbers in powers of ten, not with all their digits.
        let got = if got.abs() < 1e15 { got.to_string() } else { format!("{got:e}") };
        format!(".{place}: expected {expected}, got {got}")
    }
}
