//! `sinew track`.

mod fault;
mod path;
mod record;

use super::arm::model::load_robot;
use crate::arguments::TrackArguments;
use crate::error::Error;
use crate::output::{print, refuse_overwrite, write_all};
use crate::progress::Progress;
use crate::report::tracking::{TrackView, page};
use crate::table::{number, table};
use sinew::body::Robot;
use sinew::trajectory::Trajectory;
use sinew_lab::CompensationVariant;
use sinew_lab::arm::{
    CalibratedArm, EndPointMotion, INITIAL_REST_S, TrackingNumbers, TrackingResult, TrackingTask,
    first_infeasibility, plan, track_arm,
};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Rows of a report's trace, and seconds between rows of a record.
const ROWS: f64 = 3000.0;
const RECORD_S: f64 = 0.01;
/// What is meant where nothing is said: s for a closed path, s for the way to a place, and how often.
const ROUND_S: f64 = 115.0;
const TO_S: f64 = 5.0;
const REPEATS: u32 = 6;

pub(crate) fn run(arguments: &TrackArguments) -> Result<(), Error> {
    let outputs: Vec<PathBuf> =
        [&arguments.report, &arguments.record].into_iter().flatten().cloned().collect();
    let inputs = [Some(arguments.model.clone()), path::file(&arguments.path)];
    refuse_overwrite(inputs.iter().flatten(), &outputs)?;
    let variant = checked(arguments)?;
    let robot = load_robot(&arguments.model, None)?.robot;
    let missing = |what: &str| Error::File {
        file: arguments.model.clone(),
        problem: format!("has no {what}: tracking starts and ends there"),
    };
    let pose = robot.key("start").ok_or_else(|| missing("key pose `start`"))?.to_vec();
    let site = robot.site("endpoint").ok_or_else(|| missing("site `endpoint`"))?;
    let faults = fault::wanted(&arguments.fault, &robot)?;
    let trajectory = trajectory(arguments, &robot, site, &pose)?;
    let repeats = repeats(arguments, &trajectory)?;
    if let Some(obstacle) = first_infeasibility(&robot, &trajectory)? {
        return Err(Error::Unreachable { path: arguments.path.clone(), obstacle: obstacle.to_string() });
    }
    let tip = &robot.parts().sites[site];
    let loaded = robot.with_payload(tip.body, tip.position, arguments.payload)?;
    if let Some(obstacle) = first_infeasibility(&loaded, &trajectory)? {
        return Err(Error::Overloaded { payload: arguments.payload, obstacle: obstacle.to_string() });
    }
    let progress = Progress::new();
    progress.show("calibrating the arm's cables", 0.0);
    let mut arm = CalibratedArm::new(&robot, &pose, arguments.seed)?;
    if arguments.payload > 0.0 {
        arm = arm.with_payload(tip.body, tip.position, arguments.payload)?;
    }
    progress.show("tracking", 0.4);
    let seconds = trajectory.duration() * f64::from(repeats);
    let learning = !arguments.no_learning;
    let trace_interval = if arguments.record.is_some() { RECORD_S } else { seconds / ROWS };
    let task = TrackingTask {
        trajectory: &trajectory,
        site,
        repeats,
        learning,
        final_rest: arguments.hold,
        faults: &faults,
        trace_interval,
    };
    let tracked = track_arm(&arm, variant, &task)?;
    drop(progress);
    write_results(arguments, &robot, variant, &task, tracked)
}

/// The route that is meant, in joints and time.
fn trajectory(
    arguments: &TrackArguments,
    robot: &Robot,
    site: usize,
    pose: &[f64],
) -> Result<Trajectory, Error> {
    let wanted = path::wanted(&arguments.path)?;
    let usual = match wanted {
        EndPointMotion::ClosedPath(_) => ROUND_S,
        EndPointMotion::PointToPoint(_) => TO_S,
        EndPointMotion::Waypoints(_) => {
            if let Some(given) = arguments.duration {
                let expected = "none with waypoints, which have their own times";
                return Err(Error::Argument { flag: "--duration", value: given.to_string(), expected });
            }
            path::LONGEST_S
        }
    };
    Ok(plan(robot, site, &wanted, pose, arguments.duration.unwrap_or(usual))?)
}

/// How often it is gone: what ends elsewhere than it begins, once.
fn repeats(arguments: &TrackArguments, trajectory: &Trajectory) -> Result<u32, Error> {
    match arguments.repeats {
        _ if trajectory.is_closed() => Ok(arguments.repeats.unwrap_or(REPEATS)),
        None | Some(1) => Ok(1),
        Some(many) => Err(Error::Argument {
            flag: "--repeats",
            value: many.to_string(),
            expected: "1 for a path that does not end where it begins",
        }),
    }
}

fn checked(arguments: &TrackArguments) -> Result<CompensationVariant, Error> {
    let refuse = |flag, value: String, expected| Error::Argument { flag, value, expected };
    if let Some(duration) = arguments.duration
        && !(2.0..=path::LONGEST_S).contains(&duration)
    {
        return Err(refuse("--duration", duration.to_string(), "2 to 3600 s"));
    }
    if let Some(repeats) = arguments.repeats
        && !(1..=100).contains(&repeats)
    {
        return Err(refuse("--repeats", repeats.to_string(), "1 to 100"));
    }
    if !(0.0..=path::LONGEST_S).contains(&arguments.hold) {
        return Err(refuse("--hold", arguments.hold.to_string(), "0 to 3600 s"));
    }
    if !(0.0..=5.0).contains(&arguments.payload) {
        return Err(refuse("--payload", arguments.payload.to_string(), "0 to 5 kg"));
    }
    arguments.compensation.parse().map_err(|_| {
        refuse(
            "--compensation",
            arguments.compensation.clone(),
            "none, capstan, paper, no_observer, no_disturbance_observer, observer, observer_network or perfect",
        )
    })
}

fn write_results(
    arguments: &TrackArguments,
    robot: &Robot,
    variant: CompensationVariant,
    task: &TrackingTask<'_>,
    tracked: TrackingResult,
) -> Result<(), Error> {
    let names: Vec<String> = robot.parts().tendons.iter().map(|tendon| tendon.name.clone()).collect();
    let tracking = BTreeMap::from([(variant, tracked.numbers)]);
    let mut files: Vec<(PathBuf, String)> = Vec::new();
    if let Some(path) = &arguments.report {
        let many = tracked.trace.len() as f64 / ROWS;
        let thinned: Vec<_> = tracked.trace.iter().step_by((many.ceil() as usize).max(1)).cloned().collect();
        let view = TrackView {
            heading: "Errors".to_owned(),
            lead: "The arm was built with errors that the controller does not know; each cable was calibrated alone.".to_owned(),
            tracking: &tracking,
            trace: &thinned,
            drawn: variant,
            names: &names,
            repeats: task.repeats,
            paper: false,
        };
        let title = format!("{} along {}", robot.parts().name, arguments.path);
        let amount = amount(arguments, task, variant);
        files.push((path.clone(), page(&view, &title, &amount)?));
    }
    if let Some(path) = &arguments.record {
        files.push((path.clone(), record::csv(&names, &tracked.trace)));
    }
    let bytes: Vec<_> = files.iter().map(|(path, text)| (path.clone(), text.as_bytes())).collect();
    write_all(&bytes)?;
    if arguments.json {
        let all = serde_json::json!({"simulated": true, "seed": arguments.seed, "tracking": tracking});
        return print(&(serde_json::to_string_pretty(&all)? + "\n"));
    }
    let mut text = tracking_table(&tracking);
    for hold in tracking.values().filter_map(|numbers| numbers.hold) {
        let e = hold.end_point_error_m;
        let [mean, max] = [e.mean, e.max].map(|m| number(Some(1e3 * m)));
        let [unseen, unrest] = [1e3 * hold.unseen_error_m, hold.tension_unrest_n].map(|x| number(Some(x)));
        text += &format!(
            "Held afterwards: {mean} mm off, {max} mm at most; {unseen} mm are the encoders' zeros; tensions within {unrest} N rms\n"
        );
    }
    for one in tracking.values().flat_map(|numbers| &numbers.incidents) {
        text += &format!("{:.3} to {:.3} s: {}, {}\n", one.from_s, one.until_s, one.what, one.answer);
    }
    for (path, _) in &files {
        text += &format!("Written: {}\n", path.display());
    }
    print(&text)
}

/// What was done, in a line.
fn amount(arguments: &TrackArguments, task: &TrackingTask<'_>, variant: CompensationVariant) -> String {
    let mut text = format!("{} s", (1e3 * task.trajectory.duration()).round() / 1e3);
    match task.repeats {
        1 => text += ", once",
        n => text += &format!(", {n} times"),
    }
    if arguments.payload > 0.0 {
        text += &format!(", carrying {} kg", arguments.payload);
    }
    text += &format!(", control {}, seed {}.", variant.name(), arguments.seed);
    if !arguments.fault.is_empty() {
        text +=
            &format!(" Let fail: {}; the motion begins at {INITIAL_REST_S} s.", arguments.fault.join(", "));
    }
    text + " Everything here is simulated."
}

/// The table for people.
pub(crate) fn tracking_table(tracking: &BTreeMap<CompensationVariant, TrackingNumbers>) -> String {
    let rows: Vec<Vec<String>> = tracking
        .iter()
        .map(|(name, n)| {
            let e = &n.end_point_error_m;
            let ended = match (&n.stopped_by, n.stopped_s) {
                (Some(why), _) => format!("stopped: {why}"),
                (None, Some(_)) => "lost".to_owned(),
                (None, None) => "as planned".to_owned(),
            };
            let mm = |m: f64| number(Some(1e3 * m));
            vec![
                name.to_string(),
                ended,
                mm(e.mean),
                mm(e.std),
                mm(e.max),
                mm(n.end_point_error_per_repeat_m.last().map_or(e.mean, |last| last.mean)),
                mm(n.muscle_length_error_m.mean),
            ]
        })
        .collect();
    let mut text = table(
        &["SIMULATED arm", "ended", "end point, mm: mean", "std", "max", "last repeat", "muscle length, mm"],
        &rows,
        2,
    );
    if let Some(unseen) = tracking.values().map(|n| n.unseen_error_m).next() {
        let [mean, max] = [unseen.mean, unseen.max].map(|m| number(Some(1e3 * m)));
        text += &format!(
            "Joint encoders reading what is wanted, their zeros off, would leave {mean} mm, {max} mm at most.\n"
        );
    }
    text
}
