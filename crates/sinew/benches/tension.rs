//! Cost of distributing a torque over muscles: the arm of `models/lm_arm.toml` in random poses, and a large random one.
//!
//! Divan tells medians; the last lines tell the tail, which a control loop cares about.

#![allow(clippy::unwrap_used, reason = "a bench that cannot start may panic")]
#![allow(clippy::print_stdout, reason = "a bench tells its numbers")]

use divan::{Bencher, black_box};
use sinew::control::tension::{Distribution, Problem, Status};
use sinew::muscle::{Geometry, Muscles};
use sinew::random::Random;
use std::time::Instant;

fn main() {
    divan::main();
    for (name, cases) in [("arm_15x7", arm()), ("random_63x20", random_63x20())] {
        for warm in [false, true] {
            tail(name, &cases, warm);
        }
    }
}

/// A problem with its numbers.
struct Case {
    muscles: usize,
    arms: Vec<f64>,
    torque: Vec<f64>,
    minimum: Vec<f64>,
    maximum: Vec<f64>,
    zeros: Vec<f64>,
    ones: Vec<f64>,
    /// Multipliers are remembered from a torque a millisecond ago.
    before: Vec<f64>,
}

impl Case {
    /// A torque that some tensions within 20 and 400 N give, and one a hundredth away from it.
    fn new(random: &mut Random, muscles: usize, joints: usize, arms: Vec<f64>) -> Self {
        let tension: Vec<f64> = (0..muscles).map(|_| 20.0 + 380.0 * random.unit()).collect();
        let mut torque = vec![0.0; joints];
        for (row, tension) in arms.chunks_exact(joints).zip(&tension) {
            torque.iter_mut().zip(row).for_each(|(torque, arm)| *torque += arm * tension);
        }
        let before = torque.iter().map(|torque| torque * (1.0 + 0.01 * random.normal())).collect();
        let list = |value: f64| vec![value; muscles];
        let (minimum, maximum, zeros, ones) = (list(20.0), list(400.0), list(0.0), list(1.0));
        Self { muscles, arms, torque, minimum, maximum, zeros, ones, before }
    }

    fn problem<'a>(&'a self, torque: &'a [f64]) -> Problem<'a> {
        Problem {
            moment_arms: &self.arms,
            torque,
            minimum: &self.minimum,
            maximum: &self.maximum,
            reference: &self.zeros,
            weight: &self.ones,
        }
    }
}

const CASES: usize = 256;

fn arm() -> Vec<Case> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/lm_arm.toml");
    let description = sinew::description::from_toml(file, &std::fs::read_to_string(file).unwrap()).unwrap();
    let robot = sinew::body::Robot::new(description.parts).unwrap();
    let muscles = Muscles::new(&robot);
    let mut geometry = Geometry::new(&robot, &muscles);
    let mut random = Random::new(1);
    let pose = |random: &mut Random| -> Vec<f64> {
        let joints = &robot.parts().joints;
        let range = |joint: &sinew::body::Joint| joint.range.unwrap_or([-1.0, 1.0]);
        joints.iter().map(range).map(|[low, high]| low + (high - low) * random.unit()).collect()
    };
    let mut cases = Vec::new();
    for _ in 0..CASES {
        let q = pose(&mut random);
        muscles.evaluate(&q, &mut geometry).unwrap();
        let mut arms = vec![0.0; muscles.count() * robot.nv()];
        muscles.dense(&geometry, &mut arms).unwrap();
        cases.push(Case::new(&mut random, muscles.count(), robot.nv(), arms));
    }
    cases
}

/// As many muscles and joints as MyoSuite's arm; each muscle crosses three joints.
fn random_63x20() -> Vec<Case> {
    let mut random = Random::new(2);
    let mut cases = Vec::new();
    for _ in 0..CASES {
        let mut arms = vec![0.0; 63 * 20];
        for (i, row) in arms.chunks_exact_mut(20).enumerate() {
            for k in 0..3 {
                row[(i + 7 * k + (random.unit() * 3.0) as usize) % 20] = 0.03 * random.normal();
            }
        }
        cases.push(Case::new(&mut random, 63, 20, arms));
    }
    cases
}

/// Solves one case after the other; when warm, each has its last torque behind it, a hundredth away from this one.
struct Runner<'a> {
    cases: &'a [Case],
    distributions: Vec<Distribution>,
    warm: bool,
    next: usize,
}

impl<'a> Runner<'a> {
    fn new(cases: &'a [Case], warm: bool) -> Self {
        let of = |case: &Case| Distribution::new(case.muscles, case.torque.len());
        Self { cases, distributions: cases.iter().map(of).collect(), warm, next: 0 }
    }

    fn step(&mut self) -> (Status, u32) {
        self.next += 1;
        let (round, k) = (self.next / self.cases.len(), self.next % self.cases.len());
        let (case, distribution) = (&self.cases[k], &mut self.distributions[k]);
        if !self.warm {
            distribution.forget();
        }
        let torque = if round % 2 == 0 { &case.torque } else { &case.before };
        let solution = black_box(distribution.solve(black_box(&case.problem(torque))).unwrap());
        (solution.status, solution.iterations)
    }
}

fn bench(bencher: Bencher, cases: &[Case], warm: bool) {
    let mut runner = Runner::new(cases, warm);
    (0..3 * cases.len()).for_each(|_| _ = runner.step());
    bencher.bench_local(|| runner.step());
}

#[divan::bench(args = [false, true], sample_size = 256, sample_count = 400)]
fn arm_15x7(bencher: Bencher, warm: bool) {
    bench(bencher, &arm(), warm);
}

#[divan::bench(args = [false, true], sample_size = 256)]
fn random_63x20_sparse(bencher: Bencher, warm: bool) {
    bench(bencher, &random_63x20(), warm);
}

/// Every call timed by itself, the clock's own time taken off.
fn tail(name: &str, cases: &[Case], warm: bool) {
    const CALLS: usize = 200_000;
    let mut runner = Runner::new(cases, warm);
    (0..3 * cases.len()).for_each(|_| _ = runner.step());
    let (mut infeasible, mut steps) = (0, 0);
    let mut times: Vec<u128> = Vec::with_capacity(CALLS);
    for _ in 0..CALLS {
        let start = Instant::now();
        let (status, iterations) = runner.step();
        times.push(start.elapsed().as_nanos());
        infeasible += usize::from(status == Status::Infeasible);
        steps += u64::from(iterations);
    }
    let mut clock: Vec<u128> = (0..10_000).map(|_| Instant::now().elapsed().as_nanos()).collect();
    clock.sort_unstable();
    times.sort_unstable();
    let at = |part: usize| times[CALLS * part / 10_000].saturating_sub(clock[5000]);
    println!(
        "{name} warm {warm}: median {} ns, p99 {} ns, p99.9 {} ns, {:.2} steps, {:.1} % infeasible",
        at(5000),
        at(9900),
        at(9990),
        steps as f64 / CALLS as f64,
        100.0 * infeasible as f64 / CALLS as f64
    );
}
