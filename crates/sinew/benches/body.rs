//! Cost of the body's mechanics and of the muscles' geometry, on the arm of the golden files and on random
//! ones.
//!
//! `SINEW_BODY_GOLDEN` may name a folder with more robots (`benches/peers/body_golden.py`).

#![allow(clippy::unwrap_used, reason = "a bench that cannot start may panic")]

use divan::{Bencher, black_box};
use serde::Deserialize;
use sinew::body::{Parts, Poses, Robot, Scratch};
use sinew::muscle::{Geometry, Muscles};
use std::path::{Path, PathBuf};

fn main() {
    divan::main();
}

#[derive(Deserialize)]
struct Golden {
    parts: Parts,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
}

/// Robots whose files are at hand.
fn robots() -> impl Iterator<Item = &'static str> {
    ["lm_arm", "chain7", "myoarm"].into_iter().filter(|name| load(name).is_some())
}

/// Those of them that have muscles.
fn robots_with_muscles() -> impl Iterator<Item = &'static str> {
    robots().filter(|name| load(name).is_some_and(|(robot, _)| !robot.parts().tendons.is_empty()))
}

/// A robot and some of its poses; nothing where its file is not at hand.
fn load(name: &str) -> Option<(Robot, Vec<Case>)> {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden");
    let extra = std::env::var_os("SINEW_BODY_GOLDEN").map(PathBuf::from);
    let bytes = [extra, Some(own)]
        .into_iter()
        .flatten()
        .find_map(|folder| std::fs::read(folder.join(format!("{name}.json"))).ok())?;
    let golden: Golden = serde_json::from_slice(&bytes).unwrap();
    Some((Robot::new(golden.parts).unwrap(), golden.cases))
}

/// Runs `work` on one pose after the other.
fn poses(bencher: Bencher, name: &str, mut work: impl FnMut(&Robot, &Case)) {
    let (robot, cases) = load(name).unwrap();
    let mut next = 0;
    bencher.bench_local(|| {
        next = (next + 1) % cases.len();
        work(&robot, black_box(&cases[next]));
    });
}

#[divan::bench(args = robots(), sample_size = 500)]
fn inverse_dynamics(bencher: Bencher, name: &str) {
    let (robot, _) = load(name).unwrap();
    let (mut scratch, mut tau) = (Scratch::new(&robot), vec![0.0; robot.nv()]);
    poses(bencher, name, |robot, case| {
        robot.inverse_dynamics(&case.q, &case.v, &case.a, &mut scratch, &mut tau).unwrap();
        black_box(&tau);
    });
}

#[divan::bench(args = robots(), sample_size = 500)]
fn mass_matrix(bencher: Bencher, name: &str) {
    let (robot, _) = load(name).unwrap();
    let (mut scratch, mut mass) = (Scratch::new(&robot), vec![0.0; robot.nv() * robot.nv()]);
    poses(bencher, name, |robot, case| {
        robot.mass_matrix(&case.q, &mut scratch, &mut mass).unwrap();
        black_box(&mass);
    });
}

#[divan::bench(args = robots(), sample_size = 500)]
fn forward_dynamics(bencher: Bencher, name: &str) {
    let (robot, _) = load(name).unwrap();
    let (mut scratch, mut a) = (Scratch::new(&robot), vec![0.0; robot.nv()]);
    poses(bencher, name, |robot, case| {
        robot.forward_dynamics(&case.q, &case.v, &case.a, &mut scratch, &mut a).unwrap();
        black_box(&a);
    });
}

#[divan::bench(args = robots(), sample_size = 500)]
fn forward_kinematics(bencher: Bencher, name: &str) {
    let (robot, _) = load(name).unwrap();
    let mut poses_found = Poses::new(&robot);
    poses(bencher, name, |robot, case| {
        robot.forward_kinematics(&case.q, &mut poses_found).unwrap();
        black_box(&poses_found);
    });
}

/// Lengths and moment arms, kinematics included.
#[divan::bench(args = robots_with_muscles(), sample_size = 100)]
fn muscles(bencher: Bencher, name: &str) {
    let (robot, _) = load(name).unwrap();
    let muscles = Muscles::new(&robot);
    let mut geometry = Geometry::new(&robot, &muscles);
    poses(bencher, name, |_, case| {
        muscles.evaluate(&case.q, &mut geometry).unwrap();
        black_box(&geometry);
    });
}
