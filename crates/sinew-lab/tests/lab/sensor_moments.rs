//! Wrong sensors where no motion runs, and two of them at once: the reaction is safe, and the first report is
//! right.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stdout, reason = "a campaign prints its table")]

use crate::common::machines::{machine, motion};
use crate::common::sensors::{crossings, names, sampled};
use crate::common::supervised::Bench;
use rayon::prelude::*;
use sinew::control::supervisor::{Mode, NamedFault, Request};
use sinew::twin::arm::InjectedFault;

const MACHINES: [&str; 4] = ["lm_arm", "finger", "bench_joint", "planar_leg"];

/// When a sensor becomes wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Moment {
    Pretension,
    /// While the winches brake, stand, and pay out after a request to stop.
    SafeStop,
    LastTenth,
    /// A second one up to two seconds after a first.
    Two,
}

impl Moment {
    const ALL: [Self; 4] = [Self::Pretension, Self::SafeStop, Self::LastTenth, Self::Two];
}

#[derive(Debug)]
#[allow(dead_code, reason = "printed")]
struct Case {
    machine: &'static str,
    seed: u64,
    moment: Moment,
    faults: Vec<InjectedFault>,
    first: Option<(f64, NamedFault)>,
    ended: Mode,
    /// Whether the first report names one of the sensors, or a group with it.
    named: bool,
    /// Largest true tension at a drive, over its limit.
    tension: f64,
    /// Largest true speed of a joint over that without a fault.
    speed: f64,
}

/// s: pretension of a machine at the start; time for which a run is observed after its motion or its stop.
const PRETENSION: [f64; 2] = [0.02, 1.0];
const AFTER: f64 = 12.0;

fn cases(name: &'static str, seed: u64, count: usize) -> Vec<Case> {
    let machine = machine(name);
    let mut bench = Bench::new(&machine, motion(&machine, seed), seed);
    bench.repeats = 1;
    let machine = &bench.arm.machine;
    let crosses = crossings(machine);
    let (end, middle) = (bench.end(), 0.5 * bench.end());
    bench.with_session(&[], |healthy| {
        let limits: Vec<f64> =
            healthy.supervisor().limits().muscles.iter().map(|limit| limit.tension).collect();
        let (mut most, mut usual) = (vec![0.0_f64; limits.len()], 0.0_f64);
        let mut scout = healthy.clone();
        while scout.time() < end {
            scout
                .step(|row| {
                    let tensions = row.reading.tension.iter();
                    most.iter_mut().zip(tensions).for_each(|(most, tension)| *most = most.max(*tension));
                    usual = row.truth.v.iter().fold(usual, |most, v| most.max(v.abs()));
                })
                .unwrap();
        }
        let mut cases = Vec::new();
        for moment in Moment::ALL {
            let times = match moment {
                Moment::Pretension => PRETENSION,
                Moment::SafeStop => [middle, middle + 3.0],
                Moment::LastTenth => [end - 0.1, end],
                Moment::Two => [3.5, end - 2.0],
            };
            let seeds = seed ^ ((moment as u64) << 32);
            let all = sampled(
                machine,
                seeds,
                (times, &most),
                if moment == Moment::Two { 2 * count } else { count },
            );
            let together = if moment == Moment::Two { 2 } else { 1 };
            for pair in all.chunks_exact(together) {
                let mut faults: Vec<InjectedFault> = pair.iter().map(|(_, fault)| *fault).collect();
                if let [first, second] = &mut faults[..] {
                    second.start = first.start + (second.start - 3.5).rem_euclid(2.0);
                }
                let mut session = healthy.clone().with_faults(&faults).unwrap();
                let mut case = Case {
                    machine: name,
                    seed,
                    moment,
                    faults: faults.clone(),
                    first: None,
                    ended: Mode::Off,
                    named: true,
                    tension: 0.0,
                    speed: 0.0,
                };
                let stops = moment == Moment::SafeStop;
                let until = if stops { middle + AFTER } else { end + AFTER };
                while session.time() < until && case.ended != Mode::Fault {
                    let stop = stops && session.time() >= middle;
                    session.ask(if stop { Request::SafeStop } else { Request::Run });
                    session
                        .step(|row| {
                            case.first = case.first.or(row.fault.map(|fault| (row.time, fault)));
                            let tensions = row.truth.cables.iter().zip(&limits);
                            let over = tensions.map(|(cable, limit)| cable.tension_in / limit);
                            case.tension = over.fold(case.tension, f64::max);
                            case.speed =
                                row.truth.v.iter().fold(case.speed, |most, v| most.max(v.abs() / usual));
                            case.ended = row.mode;
                        })
                        .unwrap();
                }
                case.named = case.first.is_none_or(|(_, first)| {
                    faults.iter().any(|fault| names(fault.failure, first, &crosses))
                });
                cases.push(case);
            }
        }
        cases
    })
}

fn table(cases: &[Case]) -> String {
    let mut text = String::from(
        "| when | runs | reported | first named rightly | largest tension, of its limit | largest joint \
            speed, of that of the motion |\n\
         |---|---|---|---|---|---|\n",
    );
    for moment in Moment::ALL {
        let of: Vec<&Case> = cases.iter().filter(|case| case.moment == moment).collect();
        let count = |f: &dyn Fn(&Case) -> bool| of.iter().filter(|case| f(case)).count();
        let most = |f: &dyn Fn(&Case) -> f64| of.iter().map(|case| f(case)).fold(0.0, f64::max);
        text += &format!(
            "| {} | {} | {} | {} | {:.2} | {:.1} |\n",
            match moment {
                Moment::Pretension => "in pretension",
                Moment::SafeStop => "in the three seconds after a request to stop",
                Moment::LastTenth => "in the last 0.1 s of a motion",
                Moment::Two => "two within 2 s",
            },
            of.len(),
            count(&|case| case.first.is_some()),
            count(&|case| case.first.is_some() && case.named),
            most(&|case| case.tension),
            most(&|case| case.speed),
        );
    }
    text
}

/// Runs and prints them.
fn campaign(names: &[&'static str], seeds: std::ops::Range<u64>, count: usize) -> Vec<Case> {
    let jobs: Vec<(&str, u64)> =
        names.iter().flat_map(|name| seeds.clone().map(move |seed| (*name, seed))).collect();
    let all: Vec<Case> =
        jobs.into_par_iter().flat_map_iter(|(name, seed)| cases(name, seed, count)).collect();
    println!("{}", table(&all));
    for case in all.iter().filter(|case| !case.named || case.tension > 1.0) {
        println!("{case:?}");
    }
    all
}

#[test]
fn wrong_sensors_at_any_moment_and_two_at_once_leave_a_lever_within_its_limits() {
    let all = campaign(&["bench_joint"], 3..4, 9);
    let named = all.iter().filter(|case| case.named).count();
    assert!(all.len() > 30 && 20 * named >= 19 * all.len(), "{named} of {}", all.len());
    assert!(all.iter().all(|case| case.tension < 1.0 && case.speed < 3.0), "{all:?}");
}

#[test]
fn campaign_of_wrong_sensors_at_other_moments() {
    // `SINEW_MOMENTS=first seed,seeds,faults of each moment`
    let Ok(given) = std::env::var("SINEW_MOMENTS") else {
        eprintln!("skipped: SINEW_MOMENTS is not set");
        return;
    };
    let numbers: Vec<u64> = given.split(',').map(|word| word.parse().unwrap()).collect();
    let [first, seeds, count] = numbers[..] else { panic!("{given}: expected three numbers") };
    campaign(&MACHINES, first..first + seeds, count as usize);
}
