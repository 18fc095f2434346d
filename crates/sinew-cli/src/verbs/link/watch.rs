//! `sinew link watch`.

use super::key_file::read_key;
use crate::answer::{Answer, Content};
use crate::arguments::{General, LinkWatchArguments};
use crate::error::Error;
use crate::interrupt;
use crate::output::{print, stdout_is_coloured};
use crate::table::{number, table};
use sinew_link::client::{Client, ClientSession};
use sinew_link::{JointState, MuscleState, Rejection};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

/// Time in which the machine's link is to answer.
const PATIENCE: Duration = Duration::from_secs(5);
/// Time between two Watch packets, which keep the session alive; also the longest wait for a state.
const ALIVE: Duration = Duration::from_millis(20);
/// Time between two prints of the tables.
const PICTURE: Duration = Duration::from_millis(200);

pub(super) fn run(arguments: &LinkWatchArguments, general: &General) -> Result<Answer, Error> {
    let key = read_key(arguments.key.as_deref())?;
    let mut client = Client::connect_to_watch(arguments.address, key.as_ref(), PATIENCE)?;
    let (begin, stop) = (Instant::now(), interrupt::answer());
    let (mut alive, mut picture, mut states) = (None, None, 0_u64);
    let due = |last: &mut Option<Instant>, period: Duration| {
        let due = last.is_none_or(|last: Instant| last.elapsed() >= period);
        if due {
            *last = Some(Instant::now());
        }
        due
    };
    while !stop.load(Ordering::Relaxed)
        && arguments.duration.is_none_or(|most| begin.elapsed().as_secs_f64() < most)
    {
        if due(&mut alive, ALIVE) {
            client.watch()?;
        }
        match client.receive(ALIVE) {
            Ok(_) => states += 1,
            Err(sinew_link::Error::NoAnswer { .. }) => continue,
            Err(error) => return Err(error.into()),
        }
        if general.json {
            print(&format!("{}\n", line(client.session())))?;
        } else if due(&mut picture, PICTURE) {
            // Clears the screen of a terminal.
            let clear = if stdout_is_coloured() { "\x1b[H\x1b[2J" } else { "" };
            print(&format!("{clear}{}\n", text(client.session())))?;
        }
    }
    let all = summary(client.session(), states);
    client.close()?;
    let content = if general.json { Content::json(&all)? } else { Content::Text(String::new()) };
    Ok(Answer::done(content, Vec::new()))
}

/// The whole watch as a JSON document.
fn summary(session: &ClientSession, states: u64) -> serde_json::Value {
    let round_trip = session.peer().round_trip();
    serde_json::json!({
        "machine": session.machine(),
        "states": states,
        "states_lost": session.peer().lost(),
        "commands_lost": session.counts().lost,
        "round_trip_us": {
            "min": (round_trip.count > 0).then_some(round_trip.min_ns as f64 * 1e-3),
            "mean": round_trip.mean_ns().map(|mean| mean as f64 * 1e-3),
            "max": (round_trip.count > 0).then_some(round_trip.max_ns as f64 * 1e-3),
        },
    })
}

/// One state as a line of JSON.
fn line(session: &ClientSession) -> serde_json::Value {
    let (state, counts) = (session.state(), session.counts());
    let mut line = serde_json::json!({
        "machine_time_s": state.machine_time_ns as f64 * 1e-9,
        "cycle": state.cycle,
        "mode": state.mode.name(),
        "fault": state.fault,
        "flags": state.flags,
        "queued": state.queued,
        "end_point_m": state.end_point,
        "round_trip_us": session.peer().round_trip().last_ns as f64 * 1e-3,
        "commands_lost": counts.lost,
        "rejected": counts.rejected,
        "last_rejection": counts.last_rejection.map(Rejection::name),
    });
    // Every number of the records by its name: one list of all joints or muscles each.
    let joints: Vec<_> = state.joints().iter().map(|joint| joint.numbers()).collect();
    let muscles: Vec<_> = state.muscles().iter().map(|muscle| muscle.numbers()).collect();
    for (k, field) in JointState::FIELDS.iter().enumerate() {
        line[field.name] = joints.iter().map(|numbers| numbers[k]).collect();
    }
    for (k, field) in MuscleState::FIELDS.iter().enumerate() {
        line[field.name] = muscles.iter().map(|numbers| numbers[k]).collect();
    }
    line
}

/// The newest state as tables.
fn text(session: &ClientSession) -> String {
    let (state, counts, peer) = (session.state(), session.counts(), session.peer());
    let joints: Vec<Vec<String>> = state
        .joints()
        .iter()
        .enumerate()
        .map(|(k, joint)| {
            let numbers = joint.numbers().map(|x| number(Some(1e3 * x)));
            [k.to_string()].into_iter().chain(numbers).collect()
        })
        .collect();
    let muscles: Vec<Vec<String>> = state
        .muscles()
        .iter()
        .enumerate()
        .map(|(k, muscle)| {
            let numbers = [muscle.tension_in_n, muscle.tension_out_estimated_n, 1e3 * muscle.position_in_m];
            [k.to_string()].into_iter().chain(numbers.map(|x| number(Some(x)))).collect()
        })
        .collect();
    let [x, y, z] = state.end_point.map(|x| 1e3 * x);
    format!(
        "{}: {} at {:.3} s, end point {x:.1} {y:.1} {z:.1} mm\n{}{}round trip {:.1} us, lost {} commands \
            and {} states, {} rejected{}\n",
        session.machine(),
        state.mode.name(),
        state.machine_time_ns as f64 * 1e-9,
        table(&["joint", "position, mrad or mm", "per s", "reference"], &joints, 1),
        table(&["muscle", "tension at the drive, N", "at the anchor", "motor, mm"], &muscles, 1),
        peer.round_trip().last_ns as f64 * 1e-3,
        counts.lost,
        peer.lost(),
        counts.rejected,
        counts.last_rejection.map(|reason| format!(", last: {}", reason.name())).unwrap_or_default(),
    )
}
