//! Cost of distributing a torque over muscles: the arm of `models/lm_arm.toml` in random poses, and a large
//! random one; torques that can be reached, and such as cannot.
//!
//! `warm` is a start from a torque a hundredth away, `ticks` the arm on its way: pose, moment arms and torque
//! of one millisecond after the other.
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
    let groups = [
        ("arm_15x7", arm()),
        ("dense_15x7", dense_15x7_cases()),
        ("random_63x20", random_63x20()),
        ("arm_15x7_beyond", beyond(arm())),
        ("dense_15x7_beyond", beyond(dense_15x7_cases())),
        ("random_63x20_beyond", beyond(random_63x20())),
    ];
    for (name, cases) in groups {
        for warm in [false, true] {
            tail(name, &mut Runner::new(&cases, warm));
        }
    }
    tail("arm_15x7_ticks", &mut Runner::ticks(&ticks()));
}

/// A problem with its numbers.
#[derive(Clone)]
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

/// The arm's moment arms where each joint is at a part of its range.
struct Arm {
    robot: sinew::body::Robot,
    muscles: Muscles,
    geometry: Geometry,
}

impl Arm {
    fn new() -> Self {
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/lm_arm.toml");
        let description =
            sinew::description::from_toml(file, &std::fs::read_to_string(file).unwrap()).unwrap();
        let robot = sinew::body::Robot::new(description.parts).unwrap();
        let muscles = Muscles::new(&robot);
        let geometry = Geometry::new(&robot, &muscles);
        Self { robot, muscles, geometry }
    }

    fn moment_arms(&mut self, mut part: impl FnMut(usize) -> f64) -> Vec<f64> {
        let range = |joint: &sinew::body::Joint| joint.range.unwrap_or([-1.0, 1.0]);
        let ranges = self.robot.parts().joints.iter().map(range).enumerate();
        let q: Vec<f64> = ranges.map(|(j, [low, high])| low + (high - low) * part(j)).collect();
        self.muscles.evaluate(&q, &mut self.geometry).unwrap();
        let mut arms = vec![0.0; self.muscles.count() * self.robot.nv()];
        self.muscles.dense(&self.geometry, &mut arms).unwrap();
        arms
    }
}

fn arm() -> Vec<Case> {
    let (mut arm, mut random) = (Arm::new(), Random::new(1));
    let mut cases = Vec::new();
    for _ in 0..CASES {
        let arms = arm.moment_arms(|_| random.unit());
        cases.push(Case::new(&mut random, 15, 7, arms));
    }
    cases
}

/// Four seconds of the arm, each joint to and fro across most of its range in two to four seconds; its
/// muscles pull 20 to 400 N, each at its own pace.
fn ticks() -> Vec<Case> {
    let (mut arm, mut random) = (Arm::new(), Random::new(4));
    let mut turn = |count: usize| -> Vec<[f64; 2]> {
        (0..count).map(|_| [std::f64::consts::TAU * random.unit(), 1.5 + 1.5 * random.unit()]).collect()
    };
    let (joints, pulls) = (turn(7), turn(15));
    let mut cases = Vec::new();
    for tick in 0..4096 {
        let swing = |[phase, rate]: [f64; 2]| (phase + 1e-3 * rate * f64::from(tick)).sin();
        let arms = arm.moment_arms(|j| 0.5 + 0.45 * swing(joints[j]));
        let mut case = Case::new(&mut Random::new(1), 15, 7, arms);
        let tension = |i: usize| 210.0 + 190.0 * swing(pulls[i]);
        case.torque = (0..7).map(|j| (0..15).map(|i| case.arms[7 * i + j] * tension(i)).sum()).collect();
        cases.push(case);
    }
    cases
}

fn dense_15x7_cases() -> Vec<Case> {
    let mut random = Random::new(3);
    let mut cases = Vec::new();
    for _ in 0..CASES {
        let arms = (0..15 * 7).map(|_| 0.03 * random.normal()).collect();
        cases.push(Case::new(&mut random, 15, 7, arms));
    }
    cases
}

/// Asks for more than there is: 5 to 50 N m more at every joint, as often as it takes.
fn beyond(mut cases: Vec<Case>) -> Vec<Case> {
    let mut random = Random::new(5);
    for case in &mut cases {
        let mut distribution = Distribution::new(case.muscles, case.torque.len());
        let more: Vec<f64> = case.torque.iter().map(|_| 5.0 * random.normal()).collect();
        for _ in 0..10 {
            for torque in [&mut case.torque, &mut case.before] {
                torque.iter_mut().zip(&more).for_each(|(torque, more)| *torque += more);
            }
            let mut reached =
                |torque: &[f64]| distribution.solve(&case.problem(torque)).unwrap().status == Status::Optimal;
            if !reached(&case.torque) && !reached(&case.before) {
                break;
            }
        }
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

/// Solves one case after the other; when warm, each has its last torque behind it, a hundredth away from this
/// one.
struct Runner<'a> {
    cases: &'a [Case],
    distributions: Vec<Distribution>,
    /// The millisecond that it is.
    now: Case,
    start: Start,
    next: usize,
}

/// What a case starts from.
#[derive(Clone, Copy, PartialEq)]
enum Start {
    Nothing,
    /// Its own torque, a hundredth away.
    Itself,
    /// The case before it. There is one distribution for all, and the way is gone back at its end. Only
    /// moment arms and torque are new, and fresh in the cache, as where a controller has just found them.
    Neighbour,
}

impl<'a> Runner<'a> {
    fn new(cases: &'a [Case], warm: bool) -> Self {
        let of = |case: &Case| Distribution::new(case.muscles, case.torque.len());
        let start = if warm { Start::Itself } else { Start::Nothing };
        Self { cases, distributions: cases.iter().map(of).collect(), now: cases[0].clone(), start, next: 0 }
    }

    fn ticks(cases: &'a [Case]) -> Self {
        Self { start: Start::Neighbour, ..Self::new(cases, true) }
    }

    fn step(&mut self) -> (Status, u32) {
        self.prepare();
        self.solve()
    }

    /// What comes before the time that counts.
    fn prepare(&mut self) {
        self.next += 1;
        let (back, k) = self.at();
        match self.start {
            Start::Nothing => self.distributions[k].forget(),
            Start::Itself => {}
            Start::Neighbour => {
                let case = &self.cases[if back { self.cases.len() - 1 - k } else { k }];
                self.now.arms.copy_from_slice(&case.arms);
                self.now.torque.copy_from_slice(&case.torque);
            }
        }
    }

    /// Whether on the way back, and the case.
    fn at(&self) -> (bool, usize) {
        (self.next / self.cases.len() % 2 == 1, self.next % self.cases.len())
    }

    fn solve(&mut self) -> (Status, u32) {
        let (back, k) = self.at();
        let (case, distribution, back) = match self.start {
            Start::Neighbour => (&self.now, &mut self.distributions[0], false),
            _ => (&self.cases[k], &mut self.distributions[k], back),
        };
        let torque = if back { &case.before } else { &case.torque };
        let solution = black_box(distribution.solve(black_box(&case.problem(torque))).unwrap());
        (solution.status, solution.iterations)
    }
}

fn bench(bencher: Bencher, mut runner: Runner) {
    (0..3 * runner.cases.len()).for_each(|_| _ = runner.step());
    bencher.bench_local(|| runner.step());
}

#[divan::bench(args = [false, true], sample_size = 256, sample_count = 400)]
fn arm_15x7(bencher: Bencher, warm: bool) {
    bench(bencher, Runner::new(&arm(), warm));
}

#[divan::bench(args = [false, true], sample_size = 256)]
fn arm_15x7_beyond(bencher: Bencher, warm: bool) {
    bench(bencher, Runner::new(&beyond(arm()), warm));
}

#[divan::bench(args = [false, true], sample_size = 256)]
fn dense_15x7(bencher: Bencher, warm: bool) {
    bench(bencher, Runner::new(&dense_15x7_cases(), warm));
}

#[divan::bench(args = [false, true], sample_size = 256)]
fn dense_15x7_beyond(bencher: Bencher, warm: bool) {
    bench(bencher, Runner::new(&beyond(dense_15x7_cases()), warm));
}

#[divan::bench(args = [false, true], sample_size = 256)]
fn random_63x20_sparse(bencher: Bencher, warm: bool) {
    bench(bencher, Runner::new(&random_63x20(), warm));
}

/// Every call timed by itself, the clock's own time taken off.
fn tail(name: &str, runner: &mut Runner) {
    const CALLS: usize = 100_000;
    (0..3 * runner.cases.len()).for_each(|_| _ = runner.step());
    let (mut infeasible, mut steps) = (0, 0);
    let mut times: Vec<u128> = Vec::with_capacity(CALLS);
    for _ in 0..CALLS {
        runner.prepare();
        let start = Instant::now();
        let (status, iterations) = runner.solve();
        times.push(start.elapsed().as_nanos());
        infeasible += usize::from(status == Status::Infeasible);
        steps += u64::from(iterations);
    }
    let mut clock: Vec<u128> = (0..10_000).map(|_| Instant::now().elapsed().as_nanos()).collect();
    clock.sort_unstable();
    times.sort_unstable();
    let start = match runner.start {
        Start::Nothing => " warm false",
        Start::Itself => " warm true",
        Start::Neighbour => "",
    };
    let at = |part: usize| times[CALLS * part / 10_000].saturating_sub(clock[5000]);
    println!(
        "{name}{start}: median {} ns, p99 {} ns, p99.9 {} ns, {:.2} steps, {:.1} % infeasible",
        at(5000),
        at(9900),
        at(9990),
        steps as f64 / CALLS as f64,
        100.0 * infeasible as f64 / CALLS as f64
    );
}
