//! Motions at the limit of what a machine can do: what the check before the start accepts, the machine
//! tracks.

use crate::bench::Bench;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;

const MACHINES: [&str; 8] = [
    "bench_joint",
    "planar_leg",
    "finger",
    "exosuit_elbow",
    "surgical_wrist",
    "shoulder",
    "lm_arm",
    "chain10",
];

/// Ratio of successive durations: the last accepted motion is this near to the first refused one.
const FASTER: f64 = 0.75;

/// Waypoints from the start pose to a random one and back, in `duration` s each.
fn waypoints(joints: &[(String, f64, f64)], duration: f64) -> String {
    let names: Vec<&str> = joints.iter().map(|(name, ..)| name.as_str()).collect();
    let row = |time: f64, q: &dyn Fn(&(String, f64, f64)) -> f64| {
        let cells: Vec<String> = joints.iter().map(|joint| format!("{:?}", q(joint))).collect();
        format!("{time:?},{}\n", cells.join(","))
    };
    let start = |joint: &(String, f64, f64)| joint.1;
    let target = |joint: &(String, f64, f64)| joint.2;
    format!("time_s,{}\n", names.join(","))
        + &row(0.0, &start)
        + &row(duration, &target)
        + &row(2.0 * duration, &start)
}

/// One motion, faster and faster until it is refused: how many were accepted, and which of them failed.
fn to_the_edge(bench: &Bench, machine: &str, seed: u64) -> (usize, Vec<String>) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let shown: Value =
        serde_json::from_str(&bench.run(&format!("machine show {machine} --json")).stdout).unwrap();
    let mut joints: Vec<(String, f64, f64)> = Vec::new();
    for joint in shown["joints"].as_array().unwrap() {
        let [low, high] = [0, 1].map(|k| joint["range"][k].as_f64().unwrap_or([-1.0, 1.0][k]));
        let start = joint["start"].as_f64().unwrap();
        let target = low + (high - low) * random.random_range(0.1..0.9);
        let moves = joints.is_empty() || random.random_bool(0.6);
        joints.push((joint["name"].as_str().unwrap().to_owned(), start, if moves { target } else { start }));
    }
    let (mut accepted, mut failed) = (0, Vec::new());
    let mut duration = 4.0 * random.random_range(FASTER..1.0);
    while duration > 0.05 {
        bench.write("way.csv", waypoints(&joints, duration));
        let command = format!("track {machine} --path joints:way.csv --hold 1 --seed {} --json", seed + 1000);
        let run = bench.run(&command);
        let document: Value = serde_json::from_str(&run.stdout).unwrap();
        let ended = document["tracking"]["observer"]["ended"].as_str().unwrap_or("refused");
        match (ended, run.code) {
            ("as_planned", Some(0)) => accepted += 1,
            ("refused", Some(2 | 3)) => break,
            _ => {
                let why = &document["tracking"]["observer"]["reason"];
                let table = bench.read("way.csv");
                failed.push(format!(
                    "{machine}, seed {seed}, {duration:.3} s: {ended}, {why}, {}\n{table}",
                    run.stderr
                ));
                break;
            }
        }
        duration *= FASTER;
    }
    (accepted, failed)
}

/// `SINEW_EDGE=first,seeds` for others than the 200 named here.
#[test]
fn long_motions_on_the_edge_that_are_accepted_are_tracked() {
    if std::env::var_os("SINEW_LONG").is_none() {
        return;
    }
    let asked = std::env::var("SINEW_EDGE").unwrap_or_else(|_| "0,200".to_owned());
    let (first, count) = asked.split_once(',').unwrap();
    let (first, count): (u64, u64) = (first.parse().unwrap(), count.parse().unwrap());
    let bench = Bench::new();
    let (mut edges, mut all, mut failures) = (0, 0, Vec::new());
    for seed in first..first + count {
        let machine = MACHINES[(seed % MACHINES.len() as u64) as usize];
        let (accepted, failed) = to_the_edge(&bench, machine, seed);
        edges += usize::from(accepted > 0);
        all += accepted;
        println!("{seed} {machine}: {accepted} accepted, failed: {failed:?}");
        failures.extend(failed);
    }
    println!("{edges} motions reached their edge with {all} accepted runs; {} failed", failures.len());
    assert!(edges as u64 * 2 >= count, "only {edges} of {count} motions were feasible at all");
    assert!(failures.is_empty(), "{failures:#?}");
}
