//! Answers of the Rust libraries, with which the tests of the Python package compare bit for bit.
//!
//! One request a line on standard input, one answer a line on standard output, both JSON. No code is shared
//! with the bindings: every answer is what a user of the Rust crates computes.

mod experiment;
mod geometry;
mod identification;
mod tension;

use serde::Deserialize;
use serde_json::Value;
use std::io::{BufRead, Write};

/// What can be asked for.
#[derive(Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
enum Request {
    Pose(geometry::Pose),
    PoseLoop(geometry::PoseLoop),
    Distribute(tension::Torque),
    Cable(geometry::CableSteps),
    Identify(identification::Identify),
    Predict(identification::Predict),
    Simulate(experiment::Simulate),
    Track(experiment::Track),
}

/// Every error as text.
type Answer = Result<Value, Box<dyn std::error::Error>>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let answer = match serde_json::from_str(&line?)? {
            Request::Pose(request) => request.answer(),
            Request::PoseLoop(request) => request.answer(),
            Request::Distribute(request) => request.answer(),
            Request::Cable(request) => request.answer(),
            Request::Identify(request) => request.answer(),
            Request::Predict(request) => request.answer(),
            Request::Simulate(request) => request.answer(),
            Request::Track(request) => request.answer(),
        };
        let answer = answer.unwrap_or_else(|error| serde_json::json!({ "error": error.to_string() }));
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}
