//! Verification of a controller before the start: the motion is simulated on machines sampled within the
//! tolerances, other ones than that of the run, and gains are lowered until all of them track it: to its end,
//! with taut cables where load cells measure them, and with an error below that of a completed run by the
//! machine's margin, or in joint space with one that the dead bands of the cables explain. More are sampled
//! for a motion that is near to the limits of the drives or of the error: there single specimens fail in
//! single repeats.

use super::feasibility::first_infeasibility;
use super::outcome::{joint_errors, largest_bounded_error};
use super::plan::plan_tour;
use super::tracking::{INITIAL_REST_S, poses_along};
use crate::Error;
use crate::experiment::arm::{TrackRun, TrackSession};
use crate::experiment::{Slack, TrackSummary, oracle_models};
use rayon::prelude::*;
use sinew::control::arm::{ActuationMode, ArmController, ArmStatus, CableStateSource, Fault, synthesize};
use sinew::control::supervisor::{Limits, Supervisor};
use sinew::machine::{ControlRules, Machine, Task, Tolerances};
use sinew::predictor::CableModel;
use sinew::trajectory::Trajectory;
use sinew::twin::arm::ArmSpecimen;

/// Outcome of a verification.
#[derive(Debug, Clone, PartialEq)]
pub enum Verified {
    /// Every sampled machine tracks the motion with these rules.
    Tracks(ControlRules),
    /// With these rules every sampled machine comes to the motion's end. The largest error of a joint is
    /// above that of a completed run, but within what the dead bands of the cables explain: a joint that
    /// breaks away from their friction jumps. Or a cable without a load cell is slack for a while, which
    /// nothing in a run notices.
    Inaccurate(ControlRules, String),
    /// No set of rules does; what stopped a machine with the softest.
    Fails(String),
}

/// A motion with its verification.
#[derive(Debug, Clone, PartialEq)]
pub struct VerifiedMotion {
    /// Whether it is tracked, and with which rules.
    pub verified: Verified,
    /// Largest error of every joint of the sampled machines with these rules, rad or m: `[joints]`; what is
    /// normal for this motion. Empty where it fails.
    pub joint_errors: Vec<f64>,
    /// Where it fails: when on the motion a machine with the rules' own gains was stopped or had a slack
    /// cable, s; none where only its error was too large.
    pub failed_at: Option<f64>,
}

impl VerifiedMotion {
    fn new(verified: Verified, runs: &[Simulated]) -> Self {
        let joints = runs.first().map_or(0, |run| run.joint_errors.len());
        let largest = |joint: usize| runs.iter().map(|run| run.joint_errors[joint]).fold(0.0, f64::max);
        Self { verified, joint_errors: (0..joints).map(largest).collect(), failed_at: None }
    }
}

/// Factors of bandwidth, backlash compensation, position gain and damping crossover, from the rules' own to
/// the softest.
const SOFTER: [[f64; 4]; 4] =
    [[1.0, 1.0, 1.0, 1.0], [0.65, 1.0, 1.0, 1.0], [0.48, 0.55, 0.75, 1.0], [0.33, 0.4, 0.55, 0.65]];
/// Seeds of the sampled machines are those from here on: not those of any run.
const FIRST_SEED: u64 = 0x7665_7269_6679_0001;
/// Machines that are sampled, and in all for a motion near to the limits.
const SPECIMENS: usize = 2;
const SPECIMENS_NEAR: usize = 8;
/// Fractions above which a motion is near to the limits: of what it may use of its drives, and of error and
/// slack.
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

/// Finds rules with which sampled machines track a motion, and so many of its repeats as take 4 s; the
/// controller has the designed body and the true parameters of their cables, which a calibration would
/// identify; cables without a load cell are as designed.
///
/// # Errors
/// [`Error::Physics`] where trajectory and machine do not belong together.
pub fn verify(machine: &Machine, trajectory: &Trajectory, repeats: u32) -> Result<VerifiedMotion, Error> {
    // No gain lowers the errors of frames: they are what a calibration finds.
    let tolerances = Tolerances { link: 0.0, axis: 0.0, eccentricity: 0.0, flex: 0.0, ..machine.tolerances };
    let loaded = Machine { tolerances, ..machine.loaded()? };
    let design = ArmSpecimen::nominal(&loaded)?;
    let sampled =
        (0..SPECIMENS_NEAR as u64).map(|k| ArmSpecimen::sampled_around(&design, &loaded, FIRST_SEED + k));
    let specimens = sampled.collect::<Result<Vec<_>, _>>()?;
    let (few, more) = specimens.split_at(SPECIMENS);
    let mut many = near_drives(machine, trajectory)?;
    let poses = poses_along(trajectory)?;
    let repeats = repeats.clamp(1, ((LONGEST / trajectory.duration()).ceil() as u32).max(1));
    let (mut failure, mut failed_at, mut with_slack) = (String::new(), None, None);
    for factors in SOFTER {
        let rules = softened(&machine.rules, factors);
        let trial = Machine { rules, ..loaded.clone() };
        let run = |specimens: &[ArmSpecimen]| -> Result<Vec<Simulated>, Error> {
            let runs =
                specimens.par_iter().map(|built| simulate(&trial, built, (trajectory, repeats), &poses));
            runs.collect()
        };
        let mut found = run(few)?;
        let promising = !matches!(Quality::of_all(&found), Quality::Failed(_));
        many |= promising && found.iter().any(|run| run.fraction_of_limits > NEAR_ERROR);
        // Gains that leave a cable slack are only better than none.
        let worse = with_slack.is_some() && matches!(Quality::of_all(&found), Quality::Slack(_));
        if many && promising && !worse {
            found.extend(run(more)?);
        }
        let inaccurate =
            |reason: &String| VerifiedMotion::new(Verified::Inaccurate(rules, reason.clone()), &found);
        match Quality::of_all(&found) {
            Quality::Accurate => return Ok(VerifiedMotion::new(Verified::Tracks(rules), &found)),
            // Softer gains enlarge errors that the dead bands cause.
            Quality::Inaccurate(largest) => return Ok(inaccurate(largest)),
            Quality::Slack(reason) => with_slack = with_slack.or_else(|| Some(inaccurate(reason))),
            Quality::Failed(reason) => failure.clone_from(reason),
        }
        if failed_at.is_none() {
            failed_at = Some(found.iter().find_map(|run| run.failed_at));
        }
    }
    if let Some(motion) = with_slack {
        return Ok(motion);
    }
    let failed_at = failed_at.flatten();
    Ok(VerifiedMotion { failed_at, ..VerifiedMotion::new(Verified::Fails(failure), &[]) })
}

/// The same for poses of the joints: where only the end point would miss the reference by more than in a
/// completed run, the joints judge, and the error of the end point is a warning.
///
/// # Errors
/// As [`verify`].
pub fn verify_poses(
    machine: &Machine,
    trajectory: &Trajectory,
    repeats: u32,
) -> Result<VerifiedMotion, Error> {
    let motion = verify(machine, trajectory, repeats)?;
    let Verified::Fails(reason) = &motion.verified else { return Ok(motion) };
    if machine.task == Task::Joints {
        return Ok(motion);
    }
    let joints = verify(&Machine { task: Task::Joints, ..machine.clone() }, trajectory, repeats)?;
    Ok(match joints.verified {
        Verified::Tracks(rules) | Verified::Inaccurate(rules, _) => {
            VerifiedMotion { verified: Verified::Inaccurate(rules, reason.clone()), ..joints }
        }
        Verified::Fails(_) => motion,
    })
}

/// A tour with its verification.
#[derive(Debug, Clone)]
pub struct VerifiedTour {
    /// As given, or slower.
    pub trajectory: Trajectory,
    /// Of this trajectory.
    pub verified: Verified,
    /// As of [`VerifiedMotion`].
    pub joint_errors: Vec<f64>,
    /// Where it is slower, what the sampled machines did on the tour as given.
    pub slowed: Option<String>,
}

/// Verifies a tour, and where the sampled machines do not track it, at half its speed and at a quarter: what
/// takes time at every reversal, to cross the dead bands of the cables, takes a smaller fraction of a slower
/// motion. The fastest that they track; else the fastest that they come to the end of; else the tour as
/// given.
///
/// # Errors
/// As [`verify`] and [`plan_tour`].
pub fn verify_tour(machine: &Machine, tour: Trajectory, repeats: u32) -> Result<VerifiedTour, Error> {
    let given = verify(machine, &tour, repeats)?;
    let (slowed, duration) = match &given.verified {
        Verified::Tracks(_) => (None, tour.duration()),
        Verified::Inaccurate(_, reason) | Verified::Fails(reason) => (Some(reason.clone()), tour.duration()),
    };
    let of = |trajectory, VerifiedMotion { verified, joint_errors, .. }, slowed| VerifiedTour {
        trajectory,
        verified,
        joint_errors,
        slowed,
    };
    let mut best = of(tour, given, None);
    if slowed.is_none() {
        return Ok(best);
    }
    for stretch in SLOWER {
        let infeasibility = |trajectory: &Trajectory| first_infeasibility(machine, trajectory, repeats);
        let trajectory = plan_tour(machine, Some(stretch * duration), infeasibility)?;
        if infeasibility(&trajectory)?.is_some() {
            continue;
        }
        let verified = verify(machine, &trajectory, repeats)?;
        let slower = of(trajectory, verified, slowed.clone());
        match (&slower.verified, &best.verified) {
            (Verified::Tracks(_), _) => return Ok(slower),
            (Verified::Inaccurate(..), Verified::Fails(_)) => best = slower,
            _ => {}
        }
    }
    Ok(best)
}

/// Whether a motion uses nearly all of the drives and tensions that it may use.
fn near_drives(machine: &Machine, trajectory: &Trajectory) -> Result<bool, Error> {
    let rules = ControlRules { margin: NEAR_DRIVES * machine.rules.margin, ..machine.rules };
    Ok(first_infeasibility(&Machine { rules, ..machine.clone() }, trajectory, 1)?.is_some())
}

fn softened(rules: &ControlRules, [bandwidth, pre_travel, position, damping]: [f64; 4]) -> ControlRules {
    ControlRules {
        bandwidth: bandwidth * rules.bandwidth,
        backlash_gain: pre_travel * rules.backlash_gain,
        position_gain: position * rules.position_gain,
        damping_crossover: damping * rules.damping_crossover,
        end_point_integral: bandwidth * rules.end_point_integral,
        ..*rules
    }
}

/// What a run of the motion shows.
struct Simulated {
    quality: Quality,
    /// Largest error of every joint, rad or m: `[joints]`.
    joint_errors: Vec<f64>,
    /// The largest fraction of a limit that the run has used: of the error, or of the time with a slack
    /// cable.
    fraction_of_limits: f64,
    /// When on the motion it was stopped or a cable was slack, s.
    failed_at: Option<f64>,
}

fn simulate(
    machine: &Machine,
    built: &ArmSpecimen,
    (trajectory, repeats): (&Trajectory, u32),
    poses: &[Vec<f64>],
) -> Result<Simulated, Error> {
    let models = known_models(machine, built)?;
    let (gains, found) = synthesize(machine, &models, poses)?;
    let limits = gains.tension_limits();
    // Without a load cell a run begins with a pretension.
    let measured = machine.muscles.iter().all(|muscle| muscle.drive.has_load_cell);
    let mode = ActuationMode::WinchSpeed(CableStateSource::Observer);
    let controller =
        ArmController::new(&machine.robot, &models, gains, mode)?.with_sheath_bends(&built.bends)?;
    let standing = machine.standing(trajectory)?;
    let run = TrackRun {
        specimen: built,
        robot: &machine.robot,
        site: machine.task.site(),
        tension_limits: &limits,
        standing: Some(&standing),
        trajectory,
        repeats,
        before: if measured { REST[0] } else { INITIAL_REST_S },
        after: REST[1],
        faults: &[],
        seed: FIRST_SEED,
    };
    // What a machine does after its stop is nothing to judge.
    let limits = if measured {
        Limits::of_gains(controller.gains())
    } else {
        Limits::from_machine(machine, controller.gains())?
    };
    let supervisor = Supervisor::new(controller, limits)?;
    let (mut session, mut stopped) = (TrackSession::supervised(&run, supervisor)?, false);
    while !stopped && session.step(|row| stopped = matches!(row.command.status, ArmStatus::Stopped(_)))? {}
    let begun = run.before + session.delay();
    let summary = session.finish();
    let slack = summary.longest_slack(|muscle| machine.muscles[muscle].drive.has_load_cell);
    let failed_by_slack = (slack.duration > MAX_SLACK).then_some(slack.until);
    let failed_at = summary.stopped.map(|(time, _)| time).or(summary.plant_failed).or(failed_by_slack);
    let dead_bands: Vec<f64> = found.joints.iter().map(|joint| joint.dead_band).collect();
    let error = largest_bounded_error(&summary, machine).map_or(0.0, |largest| largest.fraction());
    Ok(Simulated {
        quality: Quality::new(&summary, machine, &dead_bands),
        joint_errors: summary.joint_error.iter().map(|error| error.max).collect(),
        fraction_of_limits: error.max(slack.duration / MAX_SLACK),
        failed_at: failed_at.map(|time| time - begun),
    })
}

/// The true parameters of the cables, which a calibration would identify; without a load cell, as designed.
fn known_models(machine: &Machine, built: &ArmSpecimen) -> Result<Vec<CableModel>, Error> {
    let mut models = oracle_models(built);
    let designed = oracle_models(&ArmSpecimen::nominal(machine)?);
    for ((model, designed), muscle) in models.iter_mut().zip(designed).zip(&machine.muscles) {
        if !muscle.drive.has_load_cell {
            *model = designed;
        }
    }
    Ok(models)
}

/// How well a run tracks the motion, and what is wrong with it.
enum Quality {
    Accurate,
    Inaccurate(String),
    /// Accurate, with a slack cable that has no load cell.
    Slack(String),
    Failed(String),
}

impl Quality {
    fn new(summary: &TrackSummary, machine: &Machine, dead_bands: &[f64]) -> Self {
        let name = |k: usize| machine.robot.parts().tendons[k].name.as_str();
        if let Some((_, fault)) = summary.stopped {
            let reason = super::stop_reason::stop_reason(fault, summary.threshold, &machine.robot);
            return Self::Failed(if blames_a_part(fault) {
                error_taken_for_a_fault(summary, machine, &reason)
            } else {
                reason
            });
        }
        if summary.plant_failed.is_some() {
            return Self::Failed("motion faster than the cables allow".to_owned());
        }
        let measured = |muscle: usize| machine.muscles[muscle].drive.has_load_cell;
        let slack = |of: &dyn Fn(usize) -> bool| {
            let Slack { duration, muscle, .. } = summary.longest_slack(of);
            (duration > MAX_SLACK).then(|| format!("cable of {} slack for {duration:.2} s", name(muscle)))
        };
        if let Some(reason) = slack(&measured) {
            return Self::Failed(reason);
        }
        // Zero errors of the encoders and everything that differs from machine to machine need a margin.
        let margin = machine.rules.margin;
        let Some(largest) =
            largest_bounded_error(summary, machine).filter(|largest| largest.fraction() > margin)
        else {
            return slack(&|muscle| !measured(muscle)).map_or(Self::Accurate, Self::Slack);
        };
        match &largest.joint {
            None => Self::Failed(format!(
                "end-point error of {:.1} mm, above {:.1} mm",
                1e3 * largest.error,
                1e3 * margin * largest.bound
            )),
            Some((joint, unit)) => {
                let bound = margin * largest.bound;
                let reason =
                    format!("error of {joint} of {:.3} {unit}, above {bound:.3} {unit}", largest.error);
                let excess =
                    joint_errors(summary, machine, dead_bands).any(|error| error.fraction() > margin);
                if excess { Self::Failed(reason) } else { Self::Inaccurate(reason) }
            }
        }
    }

    /// The worst of several runs, of equal ones the first.
    fn of_all(runs: &[Simulated]) -> &Self {
        let worst = runs.iter().map(|run| &run.quality).rev().max_by_key(|quality| quality.rank());
        worst.unwrap_or(&Self::Accurate)
    }

    fn rank(&self) -> u8 {
        match self {
            Self::Accurate => 0,
            Self::Inaccurate(_) => 1,
            Self::Slack(_) => 2,
            Self::Failed(_) => 3,
        }
    }
}

/// Whether a fault is that of a part; simulated machines of the design have none.
fn blames_a_part(fault: Fault) -> bool {
    matches!(
        fault,
        Fault::JointSensor(_)
            | Fault::MotorSensor(_)
            | Fault::TensionSensor(_)
            | Fault::Drive(_)
            | Fault::Cable(_)
    )
}

/// The error that came first, and the part that was blamed for what it did.
fn error_taken_for_a_fault(summary: &TrackSummary, machine: &Machine, part: &str) -> String {
    let rigid = vec![0.0; summary.joint_error.len()];
    let largest = joint_errors(summary, machine, &rigid).max_by(|a, b| a.fraction().total_cmp(&b.fraction()));
    match largest.and_then(|largest| Some((largest.error, largest.joint?))) {
        Some((error, (joint, unit))) => {
            format!("error of {joint} of {error:.3} {unit}, which looks like a fault ({part})")
        }
        None => format!("what looks like a fault ({part})"),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a failing test may panic")]
    use super::super::testing::{bench_joint, lm_arm};
    use super::*;

    /// The word for a run of one joint with this error, as a fraction of its range, and dead band.
    fn judged(machine: &Machine, fraction: f64, dead_band: f64) -> &'static str {
        judged_slack(machine, fraction, dead_band, 0.0)
    }

    /// The same with a cable that was slack for this time, s.
    fn judged_slack(machine: &Machine, fraction: f64, dead_band: f64, slack: f64) -> &'static str {
        let joints = machine.robot.independent_joints();
        let parts = &machine.robot.parts().joints;
        let ranges: Vec<f64> =
            joints.iter().map(|&joint| parts[joint].range.map_or(1.0, |[a, b]| b - a)).collect();
        let mut summary = TrackSummary::new(vec![1.0; machine.muscles.len()], ranges.clone(), machine.period);
        summary.joint_error[0].record(fraction * ranges[0]);
        summary.end_point_error.record(fraction);
        summary.slack[0].duration = slack;
        match Quality::new(&summary, machine, &vec![dead_band; joints.len()]) {
            Quality::Accurate => "accurate",
            Quality::Inaccurate(_) => "inaccurate",
            Quality::Slack(_) => "slack",
            Quality::Failed(_) => "failed",
        }
    }

    #[test]
    fn a_joint_error_that_its_dead_band_explains_is_inaccurate_and_a_larger_one_a_failure() {
        let machine = bench_joint();
        let range = machine.robot.parts().joints[0].range.map(|[low, high]| high - low).unwrap();
        assert_eq!(judged(&machine, 0.079, 0.1 * range), "accurate");
        assert_eq!(judged(&machine, 0.081, 0.1 * range), "failed");
        assert_eq!(judged(&machine, 0.081, range), "inaccurate");
        assert_eq!(judged(&machine, 0.199, range), "inaccurate");
        assert_eq!(judged(&machine, 0.201, range), "failed");
    }

    #[test]
    fn a_slack_cable_is_a_failure_where_a_load_cell_shows_it_and_a_warning_where_none_does() {
        let mut machine = bench_joint();
        assert_eq!(judged_slack(&machine, 0.01, 0.0, 0.24), "accurate");
        assert_eq!(judged_slack(&machine, 0.01, 0.0, 0.26), "failed");
        machine.muscles[0].drive.has_load_cell = false;
        assert_eq!(judged_slack(&machine, 0.01, 0.0, 0.26), "slack");
        assert_eq!(judged_slack(&machine, 0.5, 0.0, 0.26), "failed");
        machine.muscles[0].drive.has_load_cell = true;
        machine.muscles[1].drive.has_load_cell = false;
        assert_eq!(judged_slack(&machine, 0.01, 0.0, 0.26), "failed");
    }

    #[test]
    fn no_dead_band_excuses_the_error_of_an_end_point() {
        let machine = lm_arm();
        assert_eq!(judged(&machine, 0.019, 10.0), "accurate");
        assert_eq!(judged(&machine, 0.021, 10.0), "failed");
    }

    #[test]
    fn the_worst_of_several_runs_decides() {
        let run =
            |quality| Simulated { quality, joint_errors: vec![], fraction_of_limits: 0.0, failed_at: None };
        let runs =
            [run(Quality::Accurate), run(Quality::Inaccurate("a".into())), run(Quality::Failed("b".into()))];
        assert!(matches!(Quality::of_all(&runs), Quality::Failed(reason) if reason == "b"));
        assert!(matches!(Quality::of_all(&runs[..2]), Quality::Inaccurate(reason) if reason == "a"));
        assert!(matches!(Quality::of_all(&runs[..1]), Quality::Accurate));
    }
}
