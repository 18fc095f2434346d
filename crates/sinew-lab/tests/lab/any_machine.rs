//! Random machines, from a finger to an arm: each planned, calibrated on its own bench and tracked by rules
//! alone.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stdout, reason = "a campaign prints its table")]

use crate::common;

use common::random_machine::{RandomMachine, machine};
use rayon::prelude::*;
use sinew::machine::{Machine, SafetyLimits};
use sinew::trajectory::Trajectory;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{
    CalibratedArm, TrackOutcome, TrackingTask, Verified, first_infeasibility, plan_tour, track_arm,
    verify_tour,
};
use std::ops::Range;

/// Result on one machine.
#[derive(Debug)]
#[allow(dead_code, reason = "printed")]
struct Tracked {
    seed: u64,
    joints: usize,
    muscles: usize,
    first_link: f64,
    /// Of the tour, s.
    duration: f64,
    /// Whether the simulated machines of the design track it accurately.
    accurate: bool,
    ended: TrackOutcome,
    reason: Option<String>,
    slack: f64,
    /// Mean joint error, rad, and over the mean dead band of the joints.
    error: f64,
    over_dead_band: f64,
    worst: f64,
    /// Ratio to the observer with true parameters.
    over_true: f64,
    incidents: usize,
    stuck_mode: f64,
}

/// Masses of the links that are tried until the tensions give the torque.
const LIGHTER: [f64; 4] = [1.0, 0.7, 0.49, 0.34];

/// What a machine is driven and measured by.
#[derive(Debug, Clone, Copy)]
enum Equipment {
    /// Motors with encoders and load cells, encoders at the joints.
    Usual,
    /// Serial servos, whose readings are a period old: 4096 counts of the horn, no load cells.
    Servos { joint_encoders: bool },
}

impl Equipment {
    fn fit(self, machine: &mut Machine, period: f64) {
        machine.period = period;
        machine.safety = SafetyLimits::at_period(period);
        let Self::Servos { joint_encoders } = self else { return };
        machine.reading_age = period;
        for muscle in &mut machine.muscles {
            muscle.drive.has_load_cell = false;
            muscle.drive.encoder.counts = 4096.0 / muscle.drive.reducer.ratio;
        }
        if !joint_encoders {
            machine.encoders.fill(None);
        }
    }
}

/// A random machine of a period, s, with a tour of its ranges.
fn feasible(seed: u64, period: f64, equipment: Equipment) -> Result<(RandomMachine, Trajectory), String> {
    let text = |error: sinew_lab::Error| error.to_string();
    let mut reason = String::new();
    for lighter in LIGHTER {
        let mut sampled = machine(seed, lighter).map_err(|error| error.to_string())?;
        equipment.fit(&mut sampled.machine, period);
        let check = |trajectory: &Trajectory| first_infeasibility(&sampled.machine, trajectory, 1);
        let trajectory = plan_tour(&sampled.machine, None, check).map_err(text)?;
        match first_infeasibility(&sampled.machine, &trajectory, 1).map_err(text)? {
            None => return Ok((sampled, trajectory)),
            Some(violated) => reason = violated.to_string(),
        }
    }
    Err(reason)
}

/// One repeat, without faults.
fn once(trajectory: &Trajectory) -> TrackingTask<'_> {
    TrackingTask {
        trajectory,
        repeats: 1,
        learning: false,
        final_rest: 0.0,
        faults: &[],
        gains: None,
        trace_interval: 1.0,
    }
}

/// Numbers, separated by commas, of a variable of the environment; none where it is not set.
fn given(name: &str) -> Option<Vec<f64>> {
    let given = std::env::var(name).ok()?;
    Some(given.split(',').map(|number| number.parse().unwrap()).collect())
}

fn track(seed: u64, period: f64, equipment: Equipment) -> Result<Tracked, String> {
    let text = |error: sinew_lab::Error| error.to_string();
    let (RandomMachine { machine, first_link }, trajectory) = feasible(seed, period, equipment)?;
    let tour = verify_tour(&machine, trajectory, 1).map_err(text)?;
    let (accurate, rules) = match tour.verified {
        Verified::Tracks(rules) => (true, rules),
        Verified::Inaccurate(rules, _) => (false, rules),
        Verified::Fails(reason) => return Err(format!("verification: {reason}")),
    };
    let trajectory = tour.trajectory;
    let machine = Machine { rules, ..machine };
    let arm = CalibratedArm::new(&machine, seed).map_err(text)?.with_normal_errors(tour.joint_errors);
    let (_, found) = arm.gains(&trajectory).map_err(text)?;
    let task = once(&trajectory);
    let run = track_arm(&arm, CompensationVariant::Observer, &task).map_err(text)?.numbers;
    let truth = track_arm(&arm, CompensationVariant::Perfect, &task).map_err(text)?.numbers;
    let error = run.joint_error_rad.unwrap();
    let band = found.joints.iter().map(|joint| joint.dead_band).sum::<f64>() / found.joints.len() as f64;
    Ok(Tracked {
        seed,
        joints: found.joints.len(),
        muscles: found.muscles.len(),
        first_link,
        duration: trajectory.duration(),
        accurate,
        ended: run.ended,
        reason: run.reason,
        slack: run.longest_slack_s,
        error: error.mean,
        over_dead_band: error.mean / band,
        worst: error.max,
        over_true: error.mean / truth.joint_error_rad.unwrap().mean,
        incidents: run.incidents.len(),
        stuck_mode: found.stuck_mode,
    })
}

/// Value below which a fraction of the list lies.
fn quantile(mut list: Vec<f64>, fraction: f64) -> f64 {
    list.sort_by(f64::total_cmp);
    list.get((list.len().saturating_sub(1) as f64 * fraction).round() as usize).copied().unwrap_or(f64::NAN)
}

/// Tracks machines of these seeds, prints what the documentation tabulates, and returns those that were
/// neither stopped nor lost.
fn campaign(seeds: Range<u64>, period: f64, equipment: Equipment) -> Vec<Tracked> {
    let results: Vec<Result<Tracked, String>> = seeds
        .into_par_iter()
        .map(|seed| {
            let found = track(seed, period, equipment);
            println!("{seed} at {period} s: {found:?}");
            found
        })
        .collect();
    let count = results.len();
    let tracked: Vec<Tracked> = results.into_iter().flatten().collect();
    let accepted = tracked.len();
    let inaccurate = tracked.iter().filter(|t| !t.accurate).count();
    let lost = |t: &Tracked| matches!(t.ended, TrackOutcome::Stopped | TrackOutcome::Diverged);
    let good: Vec<Tracked> = tracked.into_iter().filter(|t| !lost(t)).collect();
    let of = |f: fn(&Tracked) -> f64| good.iter().map(f).collect::<Vec<f64>>();
    let large: Vec<f64> = good.iter().filter(|t| t.first_link >= 0.15).map(|t| 1e3 * t.error).collect();
    println!("refused {} of {count}", count - accepted);
    println!("accepted as inaccurate {inaccurate}");
    println!("neither stopped nor lost {} of {}", good.len(), accepted);
    for limit in [0.25, 0.05] {
        let taut = good.iter().filter(|t| t.slack <= limit).count();
        println!("and never slack for more than {limit} s: {taut}");
    }
    let over = of(|t| 100.0 * t.over_dead_band);
    println!(
        "error over dead band, %: median {:.2}, p90 {:.2}",
        quantile(over.clone(), 0.5),
        quantile(over, 0.9)
    );
    println!(
        "first link of 0.15 m and more, mrad: median {:.2}, p90 {:.2}",
        quantile(large.clone(), 0.5),
        quantile(large, 0.9)
    );
    let ratio = of(|t| t.over_true);
    println!(
        "over true parameters: median {:.2}, p90 {:.2}",
        quantile(ratio.clone(), 0.5),
        quantile(ratio, 0.9)
    );
    // Of a hundred machines 95 % are desired (docs/campaigns.md).
    assert!(2 * good.len() >= accepted && !good.is_empty());
    good
}

#[test]
fn random_machines_track_a_tour_of_their_ranges_by_rules_alone() {
    let good = campaign(6056..6058, 1e-3, Equipment::Usual);
    assert!(good.len() == 2);
    assert!(good.iter().all(|tracked| tracked.over_dead_band < 0.02 && tracked.over_true < 1.3));
}

/// Machines with what is left of their sensors. Observers that followed load cells used to let go of joints
/// without encoders, and verification began without the tensions that a pretension tells.
#[test]
fn machines_with_fewer_sensors_are_verified_and_tracked() {
    let cases = [
        ("planar_leg", true, false, 0.01),
        ("finger", true, false, 0.008),
        ("surgical_wrist", true, false, 0.008),
        ("surgical_wrist", false, true, 0.008),
        ("surgical_wrist", false, false, 0.012),
    ];
    for (name, load_cells, joint_encoders, most) in cases {
        let mut machine = common::machines::machine(name);
        machine.muscles.iter_mut().for_each(|muscle| muscle.drive.has_load_cell = load_cells);
        if !joint_encoders {
            machine.encoders.fill(None);
        }
        let tour = common::machines::motion(&machine, 1);
        let tour = verify_tour(&machine, tour, 1).unwrap();
        let Verified::Tracks(rules) = tour.verified else { panic!("{name}: {:?}", tour.verified) };
        let arm = CalibratedArm::new(&Machine { rules, ..machine }, 1).unwrap();
        let task = once(&tour.trajectory);
        let run = track_arm(&arm, CompensationVariant::Observer, &task).unwrap().numbers;
        let error = run.joint_error_rad.unwrap().mean;
        assert!(run.ended == TrackOutcome::Completed && error < most, "{name}: {:?} {error}", run.ended);
    }
}

#[test]
fn long_campaign_of_random_machines() {
    // `SINEW_MACHINES=first seed,machines`; with `SINEW_LONG` twelve.
    let given = std::env::var("SINEW_MACHINES").ok();
    if given.is_none() && std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: neither SINEW_LONG nor SINEW_MACHINES is set");
        return;
    }
    let given = given.unwrap_or_else(|| "1000,12".into());
    let numbers: Vec<u64> = given.split(',').map(|number| number.parse().unwrap()).collect();
    let [first, count] = numbers[..] else { panic!("{given}: expected two numbers") };
    campaign(first..first + count, 1e-3, Equipment::Usual);
}

#[test]
fn long_campaign_of_random_machines_at_several_periods() {
    // `SINEW_PERIODS=first seed,machines,milliseconds,..`
    let Some(numbers) = given("SINEW_PERIODS") else {
        eprintln!("skipped: SINEW_PERIODS is not set");
        return;
    };
    let [first, count, ref periods @ ..] = numbers[..] else { panic!("{numbers:?}: expected three numbers") };
    let first = first as u64;
    let mut reference: Option<Vec<Tracked>> = None;
    for period in periods {
        println!("period of {period} ms");
        let good = campaign(first..first + count as u64, 1e-3 * period, Equipment::Usual);
        let mean = |list: &[Tracked]| list.iter().map(|t| t.over_dead_band).sum::<f64>() / list.len() as f64;
        println!("mean error over dead band, %: {:.2}", 100.0 * mean(&good));
        let Some(before) = &reference else {
            reference = Some(good);
            continue;
        };
        let ratios: Vec<f64> = good
            .iter()
            .filter_map(|t| Some(t.over_dead_band / before.iter().find(|b| b.seed == t.seed)?.over_dead_band))
            .collect();
        println!(
            "over that of the first period: mean {:.2}; of machines of both: mean {:.2}, median {:.2}, p90 {:.2}",
            mean(&good) / mean(before),
            ratios.iter().sum::<f64>() / ratios.len() as f64,
            quantile(ratios.clone(), 0.5),
            quantile(ratios, 0.9)
        );
    }
}

#[test]
fn long_campaign_of_random_machines_on_servos() {
    // `SINEW_SERVOS=first seed,machines,milliseconds`
    let Some(numbers) = given("SINEW_SERVOS") else {
        eprintln!("skipped: SINEW_SERVOS is not set");
        return;
    };
    let [first, count, period] = numbers[..] else { panic!("{numbers:?}: expected three numbers") };
    for joint_encoders in [true, false] {
        println!("with joint encoders: {joint_encoders}");
        let seeds = first as u64..first as u64 + count as u64;
        campaign(seeds, 1e-3 * period, Equipment::Servos { joint_encoders });
    }
}
