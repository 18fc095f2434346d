//! Tension distribution: the answers of `sinew design tension --json` against the interior-point solver
//! Clarabel.
//!
//!     tension-clarabel PROBLEMS.json SOLUTIONS.json
//!
//! Clarabel stops near 1e-8, so that tensions cannot be compared to 1e-9: cost, torque and limits can.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettingsBuilder, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, ZeroConeT};
use serde_json::Value;

type Failure = Box<dyn std::error::Error>;

fn list(value: &Value) -> Vec<f64> {
    value.as_array().map(|list| list.iter().filter_map(Value::as_f64).collect()).unwrap_or_default()
}

fn read(place: &str, field: &str) -> Result<Vec<Value>, Failure> {
    let mut file: Value = serde_json::from_str(&std::fs::read_to_string(place)?)?;
    match file[field].take() {
        Value::Array(list) => Ok(list),
        _ => Err(format!("{place}: expected a list \"{field}\"").into()),
    }
}

/// Tensions of least cost, or none where Clarabel does not say that it solved the problem.
fn clarabel(problem: &Value) -> Result<Option<Vec<f64>>, Failure> {
    let (weight, reference) = (list(&problem["weight"]), list(&problem["reference_n"]));
    let (low, high, torque) = (list(&problem["min_n"]), list(&problem["max_n"]), list(&problem["torque_nm"]));
    let arms: Vec<Vec<f64>> = problem["moment_arms"].as_array().into_iter().flatten().map(list).collect();
    let (m, n) = (weight.len(), torque.len());
    let diagonal = |values: Vec<f64>| CscMatrix::new(m, m, (0..=m).collect(), (0..m).collect(), values);
    let cost = diagonal(weight.clone());
    let slope: Vec<f64> = weight.iter().zip(&reference).map(|(w, f)| -w * f).collect();
    // One column per muscle: its arms, its greatest and its minimum tension.
    let (mut start, mut row, mut value) = (vec![0], vec![], vec![]);
    for (i, arms) in arms.iter().enumerate() {
        row.extend(0..n);
        value.extend(arms);
        row.extend([n + i, n + m + i]);
        value.extend([1.0, -1.0]);
        start.push(row.len());
    }
    let rules = CscMatrix::new(n + 2 * m, m, start, row, value);
    let mut bounds = torque;
    bounds.extend(&high);
    bounds.extend(low.iter().map(|low| -low));
    let settings = DefaultSettingsBuilder::default()
        .verbose(false)
        .max_iter(200)
        .tol_gap_abs(1e-12)
        .tol_gap_rel(1e-12)
        .tol_feas(1e-12)
        .build()?;
    let cones = [ZeroConeT(n), NonnegativeConeT(2 * m)];
    let mut solver = DefaultSolver::new(&cost, &slope, &rules, &bounds, &cones, settings)?;
    solver.solve();
    let solved = matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
    Ok(solved.then_some(solver.solution.x))
}

/// Cost relative to its size, and largest miss of a torque relative to the sum of its terms.
fn judge(problem: &Value, tension: &[f64]) -> (f64, f64) {
    let (weight, reference) = (list(&problem["weight"]), list(&problem["reference_n"]));
    let cost = weight.iter().zip(&reference).zip(tension).map(|((w, r), t)| w * (t - r) * (t - r)).sum();
    let mut residual = list(&problem["torque_nm"]);
    let mut scale: Vec<f64> = residual.iter().map(|torque| torque.abs()).collect();
    for (arms, tension) in problem["moment_arms"].as_array().into_iter().flatten().zip(tension) {
        for (joint, arm) in list(arms).iter().enumerate() {
            residual[joint] -= arm * tension;
            scale[joint] += (arm * tension).abs();
        }
    }
    let miss = residual.iter().zip(&scale).map(|(r, s)| if *r == 0.0 { 0.0 } else { r.abs() / s });
    (cost, miss.fold(0.0, f64::max))
}

fn main() -> Result<(), Failure> {
    let [_, problems, solutions] = &std::env::args().collect::<Vec<_>>()[..] else {
        return Err("tension-clarabel PROBLEMS.json SOLUTIONS.json".into());
    };
    let (mut compared, mut without, mut apart) = (0, 0, 0.0_f64);
    let (mut above, mut below, mut our_miss, mut their_miss) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0_f64);
    for (problem, solution) in read(problems, "problems")?.iter().zip(&read(solutions, "solutions")?) {
        if solution["status"] != "optimal" {
            continue;
        }
        let Some(theirs) = clarabel(problem)? else {
            without += 1;
            continue;
        };
        let ours = list(&solution["tension_n"]);
        let ((our_cost, ours_off), (their_cost, theirs_off)) = (judge(problem, &ours), judge(problem, &theirs));
        let gap = (our_cost - their_cost) / their_cost.max(1e-300);
        (above, below) = (above.max(gap), below.max(-gap));
        (our_miss, their_miss) = (our_miss.max(ours_off), their_miss.max(theirs_off));
        let size = ours.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
        let difference = ours.iter().zip(&theirs).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        apart = apart.max(difference / size);
        compared += 1;
    }
    print!("clarabel: {compared} compared, {without} without answer; ");
    print!("cost above clarabel's by at most {above:.1e}, below by at most {below:.1e}; ");
    println!("torque missed by at most {our_miss:.1e}, clarabel {their_miss:.1e}; tensions apart \
        {apart:.1e}");
    Ok(())
}
