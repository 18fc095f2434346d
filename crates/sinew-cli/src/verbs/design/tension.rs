//! `sinew design tension`.

mod problems;

use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{General, TensionArguments};
use crate::error::Error;
use crate::table::{number, table};
use crate::verbs::read_text;
use problems::ValidProblem;
use serde::Serialize;
use sinew::control::tension::{Distribution, Limit, Status};
use std::time::Instant;

/// What is printed with `--json`.
#[derive(Debug, Serialize)]
struct Solutions {
    solutions: Vec<Solved>,
}

#[derive(Debug, Serialize)]
struct Solved {
    status: &'static str,
    tension_n: Vec<f64>,
    residual_nm: Vec<f64>,
    iterations: u32,
    seconds: f64,
    #[serde(skip)]
    at_limit: [usize; 2],
}

pub(super) fn run(arguments: &TensionArguments, general: &General) -> Result<Answer, Error> {
    let file = &arguments.problems;
    let refused = |problem| Error::TensionProblems { file: file.clone(), problem };
    let problems = problems::parse(&read_text(file)?).map_err(refused)?;
    let solutions = problems.iter().enumerate().map(|(k, problem)| {
        solve(problem).map_err(|error| refused(format!("problems[{k}]{}", problem.locate(&error))))
    });
    let solutions = Solutions { solutions: solutions.collect::<Result<_, _>>()? };
    let outcome = Outcome::new(solutions.solutions.iter().all(|answer| answer.status == "optimal"));
    let content =
        if general.json { Content::json(&solutions)? } else { Content::Text(summary(&solutions.solutions)) };
    Ok(Answer { outcome, content, written: Vec::new() })
}

/// Solves one problem without a warm start; the time includes its check.
fn solve(valid: &ValidProblem) -> Result<Solved, sinew::Error> {
    let mut distribution = Distribution::new(valid.min_n.len(), valid.torque_nm.len());
    let start = Instant::now();
    let solution = distribution.solve(&valid.problem())?;
    let seconds = start.elapsed().as_secs_f64();
    let at = |limit: Limit| solution.limit.iter().filter(|l| **l == limit).count();
    Ok(Solved {
        status: match solution.status {
            Status::Optimal => "optimal",
            Status::Infeasible => "infeasible",
            Status::NotConverged => "not_converged",
        },
        tension_n: solution.tension.to_vec(),
        residual_nm: solution.residual.to_vec(),
        iterations: solution.iterations,
        seconds,
        at_limit: [at(Limit::Lower), at(Limit::Upper)],
    })
}

/// One line per problem.
fn summary(answers: &[Solved]) -> String {
    let most = |list: &[f64]| list.iter().copied().map(f64::abs).reduce(f64::max);
    let row = |(k, answer): (usize, &Solved)| {
        let [lower, upper] = answer.at_limit;
        let least = answer.tension_n.iter().copied().reduce(f64::min);
        vec![
            k.to_string(),
            answer.status.to_owned(),
            answer.tension_n.len().to_string(),
            answer.residual_nm.len().to_string(),
            number(least),
            number(most(&answer.tension_n)),
            lower.to_string(),
            upper.to_string(),
            number(most(&answer.residual_nm)),
            answer.iterations.to_string(),
            number(Some(answer.seconds * 1e6)),
        ]
    };
    let rows: Vec<_> = answers.iter().enumerate().map(row).collect();
    let head = [
        "problem",
        "status",
        "muscles",
        "joints",
        "least N",
        "most N",
        "at min",
        "at max",
        "residual Nm",
        "steps",
        "us",
    ];
    let unsolved = answers.iter().enumerate().filter(|(_, answer)| answer.status == "not_converged");
    let unsolved = unsolved.map(|(k, answer)| {
        let (muscles, joints) = (answer.tension_n.len(), answer.residual_nm.len());
        format!(
            "problem {k}, {muscles} muscles x {joints} joints, is not solved: too large or too \
            ill-conditioned\n"
        )
    });
    table(&head, &rows, 2) + &unsolved.collect::<String>()
}
