//! Cost of an action of one environment and of what is told after it, alone and of 64 together on one thread;
//! of a reset. Items of steps are simulated milliseconds.

#![allow(clippy::unwrap_used, reason = "a bench that cannot start may panic")]

use divan::{Bencher, counter::ItemsCount};
use sinew::machine::Machine;
use sinew::twin::cable::Resolution;
use sinew_gym::{
    Environment, EnvironmentBatch, EnvironmentDesign, Outcomes, Randomisation, ResetMode, Settings, Task,
};
use std::sync::Arc;

fn main() {
    divan::main();
}

/// Milliseconds of an action.
const INTERVAL: u32 = 10;

fn design(name: &str, cells: usize, substeps: usize) -> Arc<EnvironmentDesign> {
    let path = format!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../models/{}.toml"), name);
    let text = std::fs::read_to_string(path).unwrap();
    let read = sinew::description::machine_from_toml(name, &text, &mut |_| Err("no other file".into()));
    let machine: Machine = read.unwrap().machine;
    let settings = Settings {
        interval_ms: INTERVAL,
        steps: u32::MAX,
        resolution: Resolution { cells, substeps },
        ..Settings::default()
    };
    Arc::new(EnvironmentDesign::new(&machine, Task::Reach, settings, Randomisation::default()).unwrap())
}

fn environment(name: &str, cells: usize, substeps: usize) -> Environment {
    Environment::new(design(name, cells, substeps), 1).unwrap()
}

#[divan::bench(args = [("bench_joint", 24, 2), ("lm_arm", 24, 2), ("lm_arm", 12, 1)])]
fn step(bencher: Bencher, (name, cells, substeps): (&str, usize, usize)) {
    let start = environment(name, cells, substeps);
    let action = vec![0.0; start.design().actions()];
    bencher.counter(ItemsCount::new(20 * INTERVAL)).with_inputs(|| start.clone()).bench_local_refs(
        |environment| {
            for _ in 0..20 {
                divan::black_box(environment.step(&action).unwrap());
            }
        },
    );
}

const WORLDS: u64 = 64;

#[divan::bench(args = [(24, 2), (12, 1)])]
fn worlds_one_by_one(bencher: Bencher, (cells, substeps): (usize, usize)) {
    let design = design("lm_arm", cells, substeps);
    let mut worlds: Vec<Environment> =
        (0..WORLDS).map(|seed| Environment::new(design.clone(), seed).unwrap()).collect();
    let (action, mut out) = (vec![0.0; design.actions()], vec![0.0; design.observations()]);
    bencher.counter(ItemsCount::new(WORLDS * u64::from(INTERVAL))).bench_local(|| {
        for world in &mut worlds {
            let ended = world.step(&action).unwrap().terminated;
            if ended {
                world.reset(None).unwrap();
            }
            world.observe(divan::black_box(&mut out));
        }
    });
}

#[divan::bench(args = [(24, 2), (12, 1)])]
fn worlds_together(bencher: Bencher, (cells, substeps): (usize, usize)) {
    let design = design("lm_arm", cells, substeps);
    let seeds: Vec<u64> = (0..WORLDS).collect();
    let mut batch = EnvironmentBatch::new(&design, &seeds, ResetMode::SameStep, 1).unwrap();
    let count = seeds.len();
    let actions = vec![0.0; count * design.actions()];
    let mut told = [(); 2].map(|()| vec![0.0; count * design.observations()]);
    let mut numbers = [(); 3].map(|()| vec![0.0; count]);
    let mut ends = [(); 2].map(|()| vec![false; count]);
    bencher.counter(ItemsCount::new(WORLDS * u64::from(INTERVAL))).bench_local(|| {
        let ([observations, last_observations], [rewards, errors, last_errors]) = (&mut told, &mut numbers);
        let [terminated, truncated] = &mut ends;
        let mut out =
            Outcomes { observations, rewards, terminated, truncated, errors, last_observations, last_errors };
        batch.step(&actions, &mut out).unwrap();
    });
}

#[divan::bench]
fn observe(bencher: Bencher) {
    let environment = environment("lm_arm", 24, 2);
    let mut out = vec![0.0; environment.design().observations()];
    // A hundred at once: one alone is shorter than the clock's own time.
    bencher.counter(ItemsCount::new(100_u32)).bench_local(|| {
        for _ in 0..100 {
            environment.observe(divan::black_box(&mut out));
        }
    });
}

#[divan::bench]
fn reset(bencher: Bencher) {
    let mut environment = environment("lm_arm", 24, 2);
    bencher.bench_local(|| environment.reset(None).unwrap());
}
