//! Verification of a controller before the start: the motion is simulated on machines drawn within the tolerances,
//! other ones than that of the run, and gains are lowered until all of them track it: to its end, with taut cables, and
//! with an error below that of a completed run by the machine's margin. More are drawn for a motion that is near to the
//! limits of the drives or of the error: there single specimens fail in single repeats.

use super::feasibility::first_infeasibility;
use super::plan::plan_tour;
use super::report::largest_bounded_error;
use super::tracking::poses_along;
use crate::Error;
use crate::experiment::arm::{TrackRun, track};
use crate::experiment::{TrackSummary, oracle_models};
use rayon::prelude::*;
use sinew::control::arm::{ActuationMode, ArmController, CableStateSource, synthesize};
use sinew::machine::{ControlRules, Machine};
use sinew::trajectory::Trajectory;
use sinew::twin::arm::ArmSpecimen;

/// Outcome of a verification.
#[derive(Debug, Clone, PartialEq)]
pub enum Verified {
    /// Every drawn machine tracks the motion with these rules.
    Tracks(ControlRules),
    /// No set of rules does; what stopped a machine with the softest.
    Fails(String),
}

/// Factors of bandwidth, pre-travel, position gain and damping crossover, from the rules' own to the softest.
const SOFTER: [[f64; 4]; 4] =
    [[1.0, 1.0, 1.0, 1.0], [0.65, 1.0, 1.0, 1.0], [0.48, 0.55, 0.75, 1.0], [0.33, 0.4, 0.55, 0.65]];
/// Seeds of the drawn machines are those from here on: not those of any run.
const FIRST_SEED: u64 = 0x7665_7269_6679_0001;
/// Machines that are drawn, and in all for a motion near to the limits.
const SPECIMENS: u64 = 2;
const SPECIMENS_NEAR: u64 = 8;
/// Shares above which a motion is near to the limits: of what it may use of its drives, and of error and slack.
const NEAR_DRIVES: f64 = 0.7;
const NEAR_ERROR: f64 = 0.6;
/// Durations of slower tours, as multiples of the first.
const SLOWER: [f64; 2] = [2.0, 4.0];
/// Rest before and after the motion, s.
const REST: [f64; 2] = [1.0, 0.5];
/// Repeats that are simulated, s: a fast motion that once decays is kept up by the next repeats.
const LONGEST: f64 = 4.0;
/// Longest time for which a cable may be slack, s.
const MAX_SLACK: f64 = 0.25;

/// Finds rules with which drawn machines track a motion, and so many of its repeats as take 4 s; the controller has the designed body and the
/// true parameters of their cables, which a calibration would identify.
///
/// # Errors
/// [`Error::Physics`] where trajectory and machine do not belong together.
pub fn verify(machine: &Machine, trajectory: &Trajectory, repeats: u32) -> Result<Verified, Error> {
    let loaded = machine.loaded()?;
    let design = ArmSpecimen::nominal(&loaded)?;
    let drawn = |seeds: core::ops::Range<u64>| {
        seeds
            .map(|k| ArmSpecimen::drawn_around(&design, &loaded, FIRST_SEED + k))
            .collect::<Result<Vec<_>, _>>()
    };
    let mut specimens = drawn(0..if near_drives(machine, trajectory)? { SPECIMENS_NEAR } else { SPECIMENS })?;
    let poses = poses_along(trajectory)?;
    let repeats = repeats.clamp(1, ((LONGEST / trajectory.duration()).ceil() as u32).max(1));
    let mut failure = None;
    for factors in SOFTER {
        let rules = softened(&machine.rules, factors);
        let trial = Machine { rules, ..loaded.clone() };
        let run = |specimens: &[ArmSpecimen]| -> Result<Vec<TrackSummary>, Error> {
            let runs =
                specimens.par_iter().map(|built| simulate(&trial, built, (trajectory, repeats), &poses));
            runs.collect()
        };
        let mut found = run(&specimens)?;
        let tracks = |found: &[TrackSummary]| found.iter().all(|summary| problem(summary, &trial).is_none());
        let near = found.iter().any(|summary| share_of_limits(summary, &trial) > NEAR_ERROR);
        if specimens.len() as u64 == SPECIMENS && near && tracks(&found) {
            let more = drawn(SPECIMENS..SPECIMENS_NEAR)?;
            found.extend(run(&more)?);
            specimens.extend(more);
        }
        failure = found.iter().find_map(|summary| problem(summary, &trial));
        if failure.is_none() {
            return Ok(Verified::Tracks(rules));
        }
    }
    Ok(Verified::Fails(failure.unwrap_or_default()))
}

/// A tour at half the speed of one that no drawn machine tracks, or at a quarter, and the rules with which they track it; none where that
/// does not help. What takes time at every reversal, to cross the dead bands of the cables, takes a smaller share of a slower motion.
///
/// # Errors
/// As [`verify`] and [`plan_tour`].
pub fn slower_tour(
    machine: &Machine,
    tour: &Trajectory,
    repeats: u32,
) -> Result<Option<(Trajectory, ControlRules)>, Error> {
    for stretch in SLOWER {
        let infeasibility = |trajectory: &Trajectory| first_infeasibility(machine, trajectory, repeats);
        let slower = plan_tour(machine, Some(stretch * tour.duration()), infeasibility)?;
        if infeasibility(&slower)?.is_none()
            && let Verified::Tracks(rules) = verify(machine, &slower, repeats)?
        {
            return Ok(Some((slower, rules)));
        }
    }
    Ok(None)
}

/// Whether a motion uses nearly all of the drives and tensions that it may use.
fn near_drives(machine: &Machine, trajectory: &Trajectory) -> Result<bool, Error> {
    let rules = ControlRules { margin: NEAR_DRIVES * machine.rules.margin, ..machine.rules };
    Ok(first_infeasibility(&Machine { rules, ..machine.clone() }, trajectory, 1)?.is_some())
}

fn softened(rules: &ControlRules, [bandwidth, pre_travel, position, damping]: [f64; 4]) -> ControlRules {
    ControlRules {
        bandwidth: bandwidth * rules.bandwidth,
        pre_travel_gain: pre_travel * rules.pre_travel_gain,
        position_gain: position * rules.position_gain,
        damping_crossover: damping * rules.damping_crossover,
        ..*rules
    }
}

fn simulate(
    machine: &Machine,
    built: &ArmSpecimen,
    (trajectory, repeats): (&Trajectory, u32),
    poses: &[Vec<f64>],
) -> Result<TrackSummary, Error> {
    let models = oracle_models(built);
    let (gains, _) = synthesize(machine, &models, poses)?;
    let limits = gains.tension_limits();
    let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let controller =
        ArmController::new(&machine.robot, &models, gains, mode)?.with_sheath_bends(&built.bends)?;
    let run = TrackRun {
        specimen: built,
        robot: &machine.robot,
        site: machine.task.site(),
        tension_limits: &limits,
        trajectory,
        repeats,
        before: REST[0],
        after: REST[1],
        faults: &[],
        seed: FIRST_SEED,
    };
    Ok(track(&run, controller, |_| {})?)
}

/// What keeps a run from being one that tracks.
fn problem(summary: &TrackSummary, machine: &Machine) -> Option<String> {
    let name = |k: usize| machine.robot.parts().tendons[k].name.as_str();
    if let Some((_, fault)) = summary.stopped {
        return Some(super::stop_reason::stop_reason(fault, summary.threshold, &machine.robot));
    }
    if summary.plant_failed.is_some() {
        return Some("motion faster than the cables allow".to_owned());
    }
    let (slack, muscle) = summary.slack;
    if slack > MAX_SLACK {
        return Some(format!("cable of {} slack for {slack:.2} s", name(muscle)));
    }
    // Zero errors of the encoders and everything that differs from machine to machine need a margin.
    let margin = machine.rules.margin;
    let largest = largest_bounded_error(summary, machine).filter(|largest| largest.share() > margin)?;
    Some(match largest.joint {
        None => format!(
            "end-point error of {:.1} mm, above {:.1} mm",
            1e3 * largest.error,
            1e3 * margin * largest.bound
        ),
        Some(joint) => {
            format!("error of {joint} of {:.3}, above {:.3}", largest.error, margin * largest.bound)
        }
    })
}

/// The largest share of a limit that a run has used: of the error, or of the time with a slack cable.
fn share_of_limits(summary: &TrackSummary, machine: &Machine) -> f64 {
    let error = largest_bounded_error(summary, machine).map_or(0.0, |largest| largest.share());
    error.max(summary.slack.0 / MAX_SLACK)
}
