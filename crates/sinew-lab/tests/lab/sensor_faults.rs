//! Sensors that read something else than what there is: found, named, bridged where the machine can go on
//! without them.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stdout, reason = "a campaign prints its table")]

use crate::common::machines::{machine, motion};
use crate::common::random_machine;
use crate::common::sensors::{Lie, LieCase, lies};
use crate::common::supervised::Bench;
use rayon::prelude::*;
use sinew::machine::Machine;
use sinew::trajectory::Trajectory;
use sinew_lab::arm::{Verified, first_infeasibility, plan_tour, verify};

const MACHINES: [&str; 8] = [
    "lm_arm",
    "bench_joint",
    "planar_leg",
    "finger",
    "exosuit_elbow",
    "surgical_wrist",
    "shoulder",
    "chain10",
];

/// A machine of this repository, or `random:SEED`; none where a random one is not feasible.
fn subject(name: &str, seed: u64) -> Option<(Machine, Trajectory)> {
    match name {
        "random" => [1.0, 0.7, 0.49, 0.34].into_iter().find_map(|lighter| {
            let machine = random_machine::machine(seed, lighter).ok()?.machine;
            let check = |trajectory: &Trajectory| first_infeasibility(&machine, trajectory, 1);
            let trajectory = plan_tour(&machine, None, check).ok()?;
            // As before a run: what simulated machines of the design do not track is refused.
            match verify(&machine, &trajectory, 1).ok()?.verified {
                Verified::Tracks(rules) => Some((Machine { rules, ..machine }, trajectory)),
                Verified::Inaccurate(..) | Verified::Fails(_) => None,
            }
        }),
        _ => {
            let machine = machine(name);
            let motion = motion(&machine, seed);
            Some((machine, motion))
        }
    }
}

fn campaign(name: &str, first: u64, seeds: u64, count: usize) -> (Vec<LieCase>, f64, Vec<String>) {
    let found: Vec<_> = (first..first + seeds)
        .into_par_iter()
        .filter_map(|seed| {
            let (machine, motion) = subject(name, seed)?;
            let mut bench = Bench::new(&machine, motion, seed);
            bench.repeats = 1;
            Some(lies(&bench, seed, count))
        })
        .collect();
    let (mut cases, mut hours, mut reports) = (Vec::new(), 0.0, Vec::new());
    for (more, seconds, reported) in found {
        cases.extend(more);
        hours += seconds / 3600.0;
        reports.extend(reported.into_iter().take(2));
    }
    (cases, hours, reports)
}

/// Table of a campaign in Markdown.
fn table(cases: &[LieCase]) -> String {
    let mut text = String::from(
        "| sensor | runs | found | harmless | named rightly of the found | above the bound without a report \
            | stopped wrongly | largest error, of the bound |\n|---|---|---|---|---|---|---|---|\n",
    );
    for lie in Lie::ALL {
        let of: Vec<&LieCase> = cases.iter().filter(|case| case.lie == lie).collect();
        let count = |f: &dyn Fn(&LieCase) -> bool| of.iter().filter(|case| f(case)).count();
        let found = count(&|case| case.reported.is_some());
        text += &format!(
            "| {} | {} | {found} | {} | {} | {} | {} | {:.2} |\n",
            lie.name(),
            of.len(),
            count(&LieCase::is_harmless),
            count(&|case| case.reported.is_some() && case.named),
            count(&LieCase::is_silent),
            count(&LieCase::is_stopped_wrongly),
            of.iter().map(|case| case.error).fold(0.0, f64::max),
        );
    }
    text
}

#[test]
fn wrong_sensors_are_named_or_harmless_and_leave_a_machine_within_its_bounds() {
    let (cases, _, reports) = campaign("planar_leg", 7, 1, 36);
    assert!(reports.is_empty(), "{reports:?}");
    let count = |f: &dyn Fn(&LieCase) -> bool| cases.iter().filter(|case| f(case)).count();
    let right = count(&|case| case.named && !case.is_silent() && !case.is_stopped_wrongly());
    assert!(cases.len() == 36 && right >= 35, "{right} of {}\n{}", cases.len(), table(&cases));
    assert!(count(&|case| case.reported.is_some()) >= 18, "{}", table(&cases));
}

#[test]
fn campaign_of_wrong_sensors() {
    // `SINEW_SENSORS=machine|random|all,first seed,seeds,faults`
    let Ok(given) = std::env::var("SINEW_SENSORS") else {
        eprintln!("skipped: SINEW_SENSORS is not set");
        return;
    };
    let words: Vec<&str> = given.split(',').collect();
    let [name, first, seeds, count] = words[..] else { panic!("{given}: expected four words") };
    let [first, seeds, count] = [first, seeds, count].map(|word| word.parse::<u64>().unwrap());
    let mut all = Vec::new();
    let names: Vec<&str> =
        MACHINES.into_iter().chain(["random"]).filter(|each| name == "all" || *each == name).collect();
    for name in names {
        let (cases, hours, reports) = campaign(name, first, seeds, count as usize);
        println!("\n{name}\n{}", table(&cases));
        println!("without a fault: {hours:.2} h, {reports:?}");
        for case in cases.iter().filter(|case| {
            case.is_silent()
                || case.is_stopped_wrongly()
                || !case.named
                || (case.reported.is_none() && !case.is_harmless())
        }) {
            println!("{case:?}");
        }
        all.extend(cases);
    }
    println!("\nall\n{}", table(&all));
}
