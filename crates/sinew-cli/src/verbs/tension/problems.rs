//! The file of problems, as written and as valid: every mistake is told with its place.

use serde_json::{Map, Value};
use sinew::Error;
use sinew::control::tension::Problem;

/// A problem as the file has it.
#[derive(Debug)]
pub(super) struct Owned {
    /// Row by row.
    moment_arms: Vec<f64>,
    pub(super) torque_nm: Vec<f64>,
    pub(super) min_n: Vec<f64>,
    max_n: Vec<f64>,
    reference_n: Vec<f64>,
    weight: Vec<f64>,
}

const FIELDS: [&str; 6] = ["moment_arms", "torque_nm", "min_n", "max_n", "reference_n", "weight"];

/// Reads the whole file.
pub(super) fn parse(text: &str) -> Result<Vec<Owned>, String> {
    let value: Value = serde_json::from_str(text).map_err(|e| format!("is no JSON: {e}"))?;
    let file = object(&value, "the file", &["problems"])?;
    let problems = array(file.get("problems"), "problems")?;
    problems.iter().enumerate().map(|(k, problem)| one(problem, &format!("problems[{k}]"))).collect()
}

/// One problem: `reference_n` is zero and `weight` one where they are not given.
fn one(value: &Value, place: &str) -> Result<Owned, String> {
    let problem = object(value, place, &FIELDS)?;
    let field = |name: &str| (problem.get(name), format!("{place}.{name}"));
    let (torque, at) = field("torque_nm");
    let torque_nm = numbers(torque, &at, None)?;
    let (arms, at) = field("moment_arms");
    let mut moment_arms = Vec::new();
    let rows = array(arms, &at)?;
    for (i, row) in rows.iter().enumerate() {
        moment_arms.extend(numbers(Some(row), &format!("{at}[{i}]"), Some((torque_nm.len(), "joint")))?);
    }
    let muscles = rows.len();
    let list = |name: &str| {
        let (value, at) = field(name);
        numbers(value, &at, Some((muscles, "muscle")))
    };
    let optional = |name: &str, default: f64| match problem.get(name) {
        None | Some(Value::Null) => Ok(vec![default; muscles]),
        Some(_) => list(name),
    };
    Ok(Owned {
        moment_arms,
        torque_nm,
        min_n: list("min_n")?,
        max_n: list("max_n")?,
        reference_n: optional("reference_n", 0.0)?,
        weight: optional("weight", 1.0)?,
    })
}

/// A value as it may stand in a message.
fn shown(value: Option<&Value>) -> String {
    const MOST: usize = 40;
    match value {
        None => "nothing".to_owned(),
        Some(Value::Array(list)) => format!("a list of {}", list.len()),
        Some(Value::Object(_)) => "an object".to_owned(),
        Some(value) => value.to_string().chars().take(MOST).collect(),
    }
}

fn object<'a>(value: &'a Value, place: &str, known: &[&str]) -> Result<&'a Map<String, Value>, String> {
    let object = value.as_object().ok_or_else(|| {
        format!("{place}: expected an object with {}, got {}", known.join(", "), shown(Some(value)))
    })?;
    match object.keys().find(|key| !known.contains(&key.as_str())) {
        Some(key) => Err(format!("{place}: unknown field `{key}`, expected {}", known.join(", "))),
        None => Ok(object),
    }
}

fn array<'a>(value: Option<&'a Value>, place: &str) -> Result<&'a [Value], String> {
    let list = value.and_then(Value::as_array).map(Vec::as_slice);
    list.ok_or_else(|| format!("{place}: expected a list, got {}", shown(value)))
}

/// A list of numbers, `expected` so many: one per muscle or joint.
fn numbers(value: Option<&Value>, place: &str, expected: Option<(usize, &str)>) -> Result<Vec<f64>, String> {
    let list = array(value, place)?;
    if let Some((count, whose)) = expected.filter(|(count, _)| *count != list.len()) {
        return Err(format!("{place}: expected {count} numbers, one per {whose}, got {}", list.len()));
    }
    let number = |(k, value): (usize, &Value)| {
        value.as_f64().ok_or_else(|| format!("{place}[{k}]: expected a number, got {}", shown(Some(value))))
    };
    list.iter().enumerate().map(number).collect()
}

impl Owned {
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

    /// Where in the problem an error is, and which: the solver's names in terms of the file.
    pub(super) fn place(&self, error: &Error) -> String {
        let Error::OutOfDomain { name, expected, got } = error else { return format!(": {error}") };
        let (field, list) = match *name {
            "moment_arms" => ("moment_arms", &self.moment_arms),
            "torque" => ("torque_nm", &self.torque_nm),
            "minimum" => ("min_n", &self.min_n),
            "maximum" => ("max_n", &self.max_n),
            "reference" => ("reference_n", &self.reference_n),
            _ => ("weight", &self.weight),
        };
        if *expected == "<= maximum" {
            let k = (0..list.len()).find(|&k| self.min_n[k] > self.max_n[k]).unwrap_or(0);
            return format!(".min_n[{k}]: expected <= max_n[{k}] = {}, got {got}", self.max_n[k]);
        }
        let k = list.iter().position(|value| value.to_bits() == got.to_bits()).unwrap_or(0);
        let joints = self.torque_nm.len().max(1);
        let at =
            if *name == "moment_arms" { format!("{}][{}", k / joints, k % joints) } else { k.to_string() };
        // A number of three hundred digits is not read by anybody.
        let got = if got.abs() < 1e15 { got.to_string() } else { format!("{got:e}") };
        format!(".{field}[{at}]: expected {expected}, got {got}")
    }
}
