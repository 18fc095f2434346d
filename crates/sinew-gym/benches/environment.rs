//! Cost of an action of one environment and of what is told after it; of a reset. Items of steps are
//! simulated milliseconds.

#![allow(clippy::unwrap_used, reason = "a bench that cannot start may panic")]

use divan::{Bencher, counter::ItemsCount};
use sinew::machine::Machine;
use sinew::twin::cable::Resolution;
use sinew_gym::{Environment, EnvironmentDesign, Randomisation, Settings, Task};
use std::sync::Arc;

fn main() {
    divan::main();
}

/// Milliseconds of an action.
const INTERVAL: u32 = 10;

fn environment(name: &str, cells: usize, substeps: usize) -> Environment {
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
    let design = EnvironmentDesign::new(&machine, Task::Reach, settings, Randomisation::default()).unwrap();
    Environment::new(Arc::new(design), 1).unwrap()
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
