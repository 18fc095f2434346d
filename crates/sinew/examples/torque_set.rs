//! Vertices and facets of sets of joint torques, and how long they take.
//!
//! Reads `[{"moment_arms_m": [[..], ..], "min_n": [..], "max_n": [..]}, ..]` from standard input, a row of moment
//! arms per muscle, and writes `[{"vertices": .., "normals": .., "offsets": .., "seconds": ..}, ..]`; `seconds` is
//! the least of several runs. Without input, the set of one joint between two muscles.
//!
//! Used by `benches/peers/capability.sh`.

#![allow(clippy::print_stdout, reason = "an example prints")]

use serde_json::{Value, json};
use sinew::control::capability::{Polytope, TorqueSet};
use std::error::Error;
use std::hint::black_box;
use std::time::Instant;

/// A joint between two muscles.
const SAMPLE: &str = r#"[{"moment_arms_m": [[0.02], [-0.03]], "min_n": [20, 20], "max_n": [200, 200]}]"#;

/// Runs of which the fastest counts.
const RUNS: usize = 9;

fn numbers(value: &Value) -> Option<Vec<f64>> {
    value.as_array()?.iter().map(Value::as_f64).collect()
}

fn solve(problem: &Value) -> Result<Value, Box<dyn Error>> {
    let bad = "expected moment_arms_m, min_n and max_n";
    let rows = problem["moment_arms_m"].as_array().ok_or(bad)?;
    let rows: Vec<Vec<f64>> = rows.iter().map(numbers).collect::<Option<_>>().ok_or(bad)?;
    let (least, most) = numbers(&problem["min_n"]).zip(numbers(&problem["max_n"])).ok_or(bad)?;
    let joints = rows.first().map_or(0, Vec::len);
    let arms = rows.concat();
    let limits: Vec<[f64; 2]> = least.iter().zip(&most).map(|(least, most)| [*least, *most]).collect();
    let mut seconds = f64::INFINITY;
    let mut found = None;
    for _ in 0..RUNS {
        let start = Instant::now();
        let set = TorqueSet::new(black_box(&arms), joints, black_box(&limits))?;
        let now = set.polytope()?;
        seconds = seconds.min(start.elapsed().as_secs_f64());
        found = Some(black_box(now));
    }
    let Polytope { vertices, facets } = found.ok_or("no run")?;
    let normals: Vec<_> = facets.iter().map(|facet| &facet.normal).collect();
    let offsets: Vec<_> = facets.iter().map(|facet| facet.offset).collect();
    Ok(json!({"vertices": vertices, "normals": normals, "offsets": offsets, "seconds": seconds}))
}

fn main() -> Result<(), Box<dyn Error>> {
    let input = std::io::read_to_string(std::io::stdin())?;
    let input = if input.trim().is_empty() { SAMPLE } else { &input };
    let problems: Vec<Value> = serde_json::from_str(input)?;
    let answers: Vec<Value> = problems.iter().map(solve).collect::<Result<_, _>>()?;
    println!("{}", serde_json::to_string(&answers)?);
    Ok(())
}
