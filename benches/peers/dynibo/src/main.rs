//! Inverse dynamics of the seven-joint arm of `crates/sinew/tests/sinew/description/pinocchio.json`, both by
//! turns.
//!
//! Prints for each the least and the median of the rounds, ns per pose, and how far the torques are from the
//! file's.

use std::hint::black_box;
use std::time::Instant;

const ROUNDS: usize = 301;
const CALLS: usize = 2000;

struct Case {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    tau: Vec<f64>,
}

/// One round: ns per call over all cases in turn.
fn round(cases: &[Case], work: &mut impl FnMut(&Case)) -> f64 {
    let start = Instant::now();
    for k in 0..CALLS {
        work(black_box(&cases[k % cases.len()]));
    }
    start.elapsed().as_secs_f64() * 1e9 / CALLS as f64
}

fn apart(tau: &[f64], case: &Case) -> f64 {
    let most = case.tau.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    tau.iter().zip(&case.tau).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs())) / most
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../crates/sinew/tests/sinew/description/pinocchio.json");
    let golden: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path)?)?;
    let arm = &golden["robots"][0];
    let urdf = arm["urdf"].as_str().ok_or("no URDF")?;
    let list = |value: &serde_json::Value| serde_json::from_value::<Vec<f64>>(value.clone());
    let mut cases = Vec::new();
    for case in arm["cases"].as_array().ok_or("no cases")? {
        let tau = list(&case["inverse"])?;
        cases.push(Case { q: list(&case["q"])?, v: list(&case["v"])?, a: list(&case["a"])?, tau });
    }
    let file = std::env::temp_dir().join(format!("sinew-peer-{}.urdf", std::process::id()));
    std::fs::write(&file, urdf)?;
    let other = dynibo::Robot::from_urdf(&file);
    std::fs::remove_file(&file)?;
    let mut other = other?;
    let own = sinew::body::Robot::new(sinew::description::from_urdf("arm.urdf", urdf, None)?.parts)?;
    let (mut scratch, mut tau) = (sinew::body::Scratch::new(&own), vec![0.0; own.nv()]);
    let mut their_tau = vec![0.0; own.nv()];
    let mut ours = |case: &Case, tau: &mut [f64]| {
        own.inverse_dynamics(&case.q, &case.v, &case.a, &mut scratch, tau).expect("seven numbers each");
    };
    let mut theirs = |case: &Case, tau: &mut [f64]| {
        other.inverse_dynamics(&case.q, &case.v, &case.a, &[], tau).expect("seven numbers each");
    };
    let mut worst = [0.0_f64; 2];
    for case in &cases {
        ours(case, &mut tau);
        theirs(case, &mut their_tau);
        worst = [worst[0].max(apart(&tau, case)), worst[1].max(apart(&their_tau, case))];
    }
    let mut times = [Vec::new(), Vec::new()];
    for _ in 0..ROUNDS {
        times[0].push(round(&cases, &mut |case| {
            ours(case, &mut tau);
            black_box(&tau);
        }));
        times[1].push(round(&cases, &mut |case| {
            theirs(case, &mut their_tau);
            black_box(&their_tau);
        }));
    }
    for ((name, times), worst) in ["sinew", "dynibo 0.5.3"].iter().zip(&mut times).zip(worst) {
        times.sort_by(f64::total_cmp);
        let (least, median) = (times[0], times[ROUNDS / 2]);
        println!("{name} inverse dynamics, 7 joints: least {least:.0} ns, median {median:.0} ns, from \
            Pinocchio {worst:.1e}");
    }
    Ok(())
}
