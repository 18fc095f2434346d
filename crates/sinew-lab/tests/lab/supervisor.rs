//! Supervised machines: every fault is found, answered by a safe stop, and recovered from; nothing is found
//! without one.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use crate::common::{machines, supervised};
use machines::{machine, motion};
use rayon::prelude::*;
use sinew::control::supervisor::{FaultKind, Mode, NamedFault};
use sinew::twin::arm::{Failure, InjectedFault, Worn};
use sinew_session::{BusFault, Exchange};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::ops::Range;
use supervised::{Bench, Case, Healthy, Injection};

/// Machines of the campaign.
const MACHINES: [&str; 4] = ["bench_joint", "planar_leg", "finger", "lm_arm"];

fn campaign(name: &str, seeds: Range<u64>, per_kind: usize) -> (Vec<Case>, Vec<Healthy>) {
    let machine = machine(name);
    let found: Vec<(Vec<Case>, Healthy)> = seeds
        .into_par_iter()
        .map(|seed| Bench::new(&machine, motion(&machine, seed), seed).faults(per_kind))
        .collect();
    let (cases, healthy): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    (cases.into_iter().flatten().collect(), healthy)
}

/// A fraction of sorted numbers.
fn quantile(sorted: &[f64], fraction: f64) -> f64 {
    let index = (sorted.len().saturating_sub(1) as f64 * fraction).round() as usize;
    sorted.get(index).copied().unwrap_or(f64::NAN)
}

/// The table of a campaign, in Markdown.
fn table(cases: &[Case]) -> String {
    let mut by_kind: BTreeMap<Injection, Vec<&Case>> = BTreeMap::new();
    cases.iter().for_each(|case| by_kind.entry(case.injection).or_default().push(case));
    let mut text = String::from(
        "| fault | runs | found | named rightly | first report, ms: median | most | safe stop, ms: most | \
         joint speed after it, rad/s: most | tension over its limit: most | recovered \
         |\n|---|---|---|---|---|---|---|---|---|---|\n",
    );
    for (injection, cases) in by_kind {
        let mut reports: Vec<f64> =
            cases.iter().filter_map(|case| case.reported.map(|(time, _)| 1e3 * time)).collect();
        reports.sort_by(f64::total_cmp);
        let stops = cases.iter().filter_map(|case| case.stopped.map(|(time, _)| 1e3 * time));
        // Where nothing stops there is neither a time nor a speed after it.
        let (stop, fall) = match stops.reduce(f64::max) {
            Some(stop) => {
                let fall = cases.iter().map(|case| case.fall).fold(0.0, f64::max);
                (format!("{stop:.0}"), format!("{fall:.2}"))
            }
            None => ("none".into(), "-".into()),
        };
        let tension = cases.iter().map(|case| case.tension).fold(0.0, f64::max);
        let count = |f: &dyn Fn(&Case) -> bool| cases.iter().filter(|case| f(case)).count();
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {:.0} | {:.0} | {stop} | {fall} | {tension:.2} | {} of {} |",
            injection.name(),
            cases.len(),
            reports.len(),
            count(&|case| case.named),
            quantile(&reports, 0.5),
            quantile(&reports, 1.0),
            count(&|case| case.recovered == Some(true)),
            count(&|case| case.recovered.is_some()),
        );
    }
    text
}

#[test]
fn campaign_of_supervised_faults() {
    // `SINEW_SUPERVISOR=machine|all,first seed,seeds,faults per kind`; with `SINEW_SUPERVISOR_WRITE` set the
    // table of all goes to the documentation.
    let Ok(given) = std::env::var("SINEW_SUPERVISOR") else {
        eprintln!("skipped: SINEW_SUPERVISOR is not set");
        return;
    };
    let words: Vec<&str> = given.split(',').collect();
    let [name, first, seeds, count] = words[..] else { panic!("{given}: expected four words") };
    let [first, seeds, count] = [first, seeds, count].map(|word| word.parse::<u64>().unwrap());
    let (mut all, mut healthy_hours) = (Vec::new(), 0.0);
    for machine in MACHINES.into_iter().filter(|machine| name == "all" || *machine == name) {
        let (cases, healthy) = campaign(machine, first..first + seeds, count as usize);
        eprintln!("\n{machine}\n{}", table(&cases));
        for case in
            cases.iter().filter(|case| case.reported.is_none() || !case.named || case.recovered != Some(true))
        {
            eprintln!("{case:?}");
        }
        let hours = healthy.iter().map(|healthy| healthy.seconds).sum::<f64>() / 3600.0;
        let errors = healthy.iter().map(|healthy| healthy.errors[1] / healthy.errors[0]).fold(0.0, f64::max);
        let mut reports: Vec<&String> =
            healthy.iter().flat_map(|healthy| healthy.reports.iter().take(3)).collect();
        reports.truncate(12);
        eprintln!(
            "without a fault: {hours:.2} h; error with one exchange in 1000 lost: {errors:.3}; {reports:?}"
        );
        healthy_hours += hours;
        all.extend(cases);
    }
    eprintln!("\nall\n{}", table(&all));
    if std::env::var_os("SINEW_SUPERVISOR_WRITE").is_some() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/fault_campaigns.md");
        let page = std::fs::read_to_string(path).unwrap();
        let (before, rest) = page.split_once(BEGIN).expect("the mark before the table");
        let (_, after) = rest.split_once(END).expect("the mark after the table");
        let about =
            format!("`SINEW_SUPERVISOR={given}`, {} runs, without a fault {healthy_hours:.2} h:", all.len());
        let text = format!("{before}{BEGIN}\nSimulated, {about}\n\n{}\n{END}{after}", table(&all));
        std::fs::write(path, text).unwrap();
    }
}

/// Marks around the table in the documentation.
const BEGIN: &str = "<!-- campaign -->\n";
const END: &str = "<!-- end of campaign -->\n";

#[test]
fn a_short_campaign_finds_every_fault_and_recovers() {
    let (cases, healthy) = campaign("bench_joint", 1..2, 1);
    for case in &cases {
        assert!(case.reported.is_some() && case.named, "{case:?}");
        assert_eq!(case.recovered, Some(true), "{case:?}");
        // A broken cable leaves the lever to its antagonist and to gravity; a load goes on pulling.
        let free = matches!(
            case.injection,
            Injection::CableBreak | Injection::SlackAfterBreak | Injection::Overload
        );
        assert!(free || (case.fall < 1.0 && case.tension < 1.0), "{case:?}");
    }
    for healthy in healthy {
        assert!(healthy.reports.is_empty() && healthy.errors[1] < 1.2 * healthy.errors[0], "{healthy:?}");
    }
}

/// Stop after the motion has begun, s after it, and the faults that were reported, where every `every`th
/// cycle is late, s.
fn late_cycles(every: u64, lateness: f64) -> (Option<f64>, Vec<FaultKind>) {
    let machine = machine("bench_joint");
    Bench::new(&machine, motion(&machine, 1), 1).with_session(&[], |mut session| {
        let (mut stopped, mut reported, mut cycle) = (None, Vec::new(), 0_u64);
        while session.time() < 8.0 && stopped.is_none() {
            cycle += 1;
            let late = cycle > 4000 && cycle.is_multiple_of(every);
            let fault = late.then_some(BusFault::Late { by_ns: (lateness * 1e9) as u32 });
            session.set_exchange(Some(Exchange { fault }));
            session
                .step(|row| {
                    if row.mode == Mode::SafeStop {
                        stopped = Some(row.time - 4.0);
                    }
                    reported.extend(row.fault.map(NamedFault::kind));
                })
                .unwrap();
        }
        reported.dedup();
        (stopped, reported)
    })
}

#[test]
fn stalls_are_bridged_and_reported_and_lasting_lateness_stops_the_machine() {
    // Three stalls of 10 ms in a second.
    assert_eq!(late_cycles(333, 0.010), (None, vec![FaultKind::LateCycles]));
    let (stopped, reported) = late_cycles(333, 0.013);
    assert!(stopped.is_some_and(|time| time < 0.34), "the first stall of 13 ms: {stopped:?}");
    assert_eq!(reported, [FaultKind::LateCycles]);
    let (stopped, _) = late_cycles(1, 0.0005);
    assert!(stopped.is_some_and(|time| (0.039..0.044).contains(&time)), "{stopped:?}");
}

/// Wear of one cable from the 15th minute on, s of motion, and what is to be found.
fn wears(muscle: usize) -> [(&'static str, f64, Vec<InjectedFault>, FaultKind); 3] {
    let wear = |what, fraction, duration| {
        let failure = Failure::Wear { muscle, what, fraction };
        vec![InjectedFault { start: 903.0, duration, failure }]
    };
    let growth = wear(Worn::Friction, 0.2, 3600.0);
    let loss = wear(Worn::Pretension, 0.5, 3600.0);
    let strand = wear(Worn::Stiffness, 1.0 / 6.0, f64::INFINITY);
    [
        ("friction + 20 % in an hour", 4500.0, growth, FaultKind::FrictionDrift),
        ("T_0 halved in an hour", 4500.0, loss, FaultKind::PretensionDrift),
        ("a strand of seven broken", 3600.0, strand, FaultKind::StiffnessDrift),
    ]
}

#[test]
fn campaign_of_worn_cables() {
    // `SINEW_HEALTH=machine,seed,hours`: a healthy run of so many hours, or for 0 hours runs with one worn
    // cable.
    let Ok(given) = std::env::var("SINEW_HEALTH") else {
        eprintln!("skipped: SINEW_HEALTH is not set");
        return;
    };
    let words: Vec<&str> = given.split(',').collect();
    let [name, seed, hours] = words[..] else { panic!("{given}: expected three words") };
    let (seed, hours) = (seed.parse::<u64>().unwrap(), hours.parse::<f64>().unwrap());
    let machine = machine(name);
    if hours > 0.0 {
        let found = Bench::new(&machine, motion(&machine, seed), seed).wears(3600.0 * hours, &[]);
        eprintln!("{name}, seed {seed}, healthy for {hours} h: {found:?}");
        assert_eq!((found.found, found.stopped), (None, None));
        return;
    }
    let muscle = seed as usize % machine.muscles.len();
    wears(muscle).into_par_iter().for_each(|(what, seconds, faults, _)| {
        let found = Bench::new(&machine, motion(&machine, seed), seed).wears(seconds, &faults);
        eprintln!("{name}, seed {seed}, muscle {muscle}, {what}: {found:?}");
    });
}

#[test]
fn long_wear_of_a_cable_is_named_before_tracking_is_a_fifth_worse() {
    if std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: SINEW_LONG is not set");
        return;
    }
    for (name, seed) in [("bench_joint", 1), ("finger", 12)] {
        let machine = machine(name);
        let muscle = seed as usize % machine.muscles.len();
        wears(muscle).into_par_iter().for_each(|(what, seconds, faults, kind)| {
            let worn = Bench::new(&machine, motion(&machine, seed), seed).wears(seconds, &faults);
            assert!(worn.found.is_some_and(|it| (it.1, it.2) == (kind, muscle)), "{name}, {what}: {worn:?}");
            assert!(worn.error_when_found.is_some_and(|error| error < 1.2), "{name}, {what}: {worn:?}");
        });
    }
}
