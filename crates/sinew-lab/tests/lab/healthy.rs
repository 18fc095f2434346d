//! Machines without a fault: none is stopped, and nothing is reported.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]
#![allow(clippy::print_stderr, reason = "a campaign prints its table")]

use crate::common::healthy::{Sampled, sampled};
use rayon::prelude::*;
use sinew::machine::Machine;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{CalibratedArm, TrackIncident, TrackOutcome, TrackingTask, Verified, track_arm, verify};

/// Result of one machine.
#[derive(Debug)]
#[allow(dead_code, reason = "printed")]
struct Outcome {
    seed: u64,
    what: String,
    ended: TrackOutcome,
    reason: Option<String>,
    incidents: Vec<TrackIncident>,
    /// Simulated, s.
    seconds: f64,
}

/// With a control cycle of `period` s.
fn track(seed: u64, period: f64) -> Result<Outcome, String> {
    let text = |error: sinew_lab::Error| error.to_string();
    let Sampled { machine, what, trajectory, hold } = sampled(seed)?;
    let machine = Machine { period, ..machine };
    let rules = match verify(&machine, &trajectory, 1).map_err(text)?.verified {
        Verified::Tracks(rules) | Verified::Inaccurate(rules, _) => rules,
        Verified::Fails(reason) => return Err(format!("{what}: {reason}")),
    };
    let machine = Machine { rules, ..machine };
    let arm = CalibratedArm::new(&machine, seed).map_err(text)?;
    let task = TrackingTask {
        trajectory: &trajectory,
        repeats: 1,
        learning: false,
        final_rest: hold,
        faults: &[],
        gains: None,
        trace_interval: 1.0,
    };
    let run = track_arm(&arm, CompensationVariant::Observer, &task).map_err(text)?.numbers;
    let seconds = trajectory.duration() + hold;
    Ok(Outcome { seed, what, ended: run.ended, reason: run.reason, incidents: run.incidents, seconds })
}

/// Runs the machines of these seeds, prints the table of docs/campaigns.md and returns those that ran.
fn campaign(seeds: &[u64], period: f64) -> Vec<Outcome> {
    let results: Vec<Result<Outcome, String>> = seeds
        .par_iter()
        .map(|&seed| {
            let found = track(seed, period);
            match &found {
                Err(reason) => eprintln!("{seed} refused: {reason}"),
                Ok(run) if run.is_quiet() => eprintln!("{seed} {}: {:?}", run.what, run.ended),
                Ok(run) => eprintln!("{seed} ALARM {run:?}"),
            }
            found
        })
        .collect();
    let sampled = results.len();
    let ran: Vec<Outcome> = results.into_iter().flatten().collect();
    let count = |f: fn(&Outcome) -> bool| ran.iter().filter(|run| f(run)).count();
    eprintln!(
        "{sampled} machines, {} refused before the start, {} ran for {:.2} h: {} stopped, {} lost, {} with \
            an incident",
        sampled - ran.len(),
        ran.len(),
        ran.iter().map(|run| run.seconds).sum::<f64>() / 3600.0,
        count(|run| run.ended == TrackOutcome::Stopped),
        count(|run| run.ended == TrackOutcome::Diverged),
        count(|run| !run.incidents.is_empty())
    );
    ran
}

impl Outcome {
    fn is_quiet(&self) -> bool {
        let ended = matches!(self.ended, TrackOutcome::Completed | TrackOutcome::Inaccurate);
        ended && self.incidents.is_empty()
    }
}

#[test]
fn machines_without_a_fault_are_not_stopped_and_report_nothing() {
    // Fine encoders of light joints that stand for milliseconds, a bench's cable, no encoder.
    let ran = campaign(&[107, 119, 114, 117], 1e-3);
    assert!(ran.len() > 2 && ran.iter().all(Outcome::is_quiet), "{ran:?}");
}

#[test]
fn long_campaign_of_healthy_machines() {
    // `SINEW_HEALTHY=first seed,machines,milliseconds`; with `SINEW_LONG` a hundred at one.
    let given = std::env::var("SINEW_HEALTHY").ok();
    if given.is_none() && std::env::var_os("SINEW_LONG").is_none() {
        eprintln!("skipped: neither SINEW_LONG nor SINEW_HEALTHY is set");
        return;
    }
    let given = given.unwrap_or_else(|| "1000,100".into());
    let (seeds, milliseconds) = match given.split(',').collect::<Vec<_>>()[..] {
        [first, count] => ([first, count], "1"),
        [first, count, milliseconds] => ([first, count], milliseconds),
        _ => panic!("{given}: expected two or three numbers"),
    };
    let [first, count] = seeds.map(|number| number.parse::<u64>().unwrap());
    let seeds: Vec<u64> = (first..first + count).collect();
    let period = 1e-3 * milliseconds.parse::<f64>().unwrap();
    assert!(campaign(&seeds, period).iter().all(Outcome::is_quiet));
}
