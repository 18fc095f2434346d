//! A run that a client commands over a link.

use super::door::{Door, Pace};
use crate::error::Error;
use crate::verbs::link::key_file::read_key;
use crate::verbs::track::setup::Setup;
use sinew::control::supervisor::Supervisor;
use sinew::machine::Machine;
use sinew::trajectory::online::JointLimits;
use sinew::trajectory::{Trajectory, finite_ranges};
use sinew_link::host::{Domain, Port, Server, ServerSettings, SessionSettings};
use sinew_runtime::link::{LinkCounts, LinkedMotion, domain};
use std::net::SocketAddr;

/// What set-points may do: limits of the joints, and the pose that is held at first, rad or m.
pub(crate) struct Follower {
    pub(crate) limits: JointLimits,
    pub(crate) pose: Vec<f64>,
}

impl Follower {
    /// Of the motion that was planned and verified.
    pub(crate) fn new(machine: &Machine, trajectory: &Trajectory) -> Result<Self, Error> {
        let ranges = finite_ranges(&machine.robot, &machine.start)?;
        let limits = JointLimits::of_motion(trajectory, ranges)?;
        Ok(Self { limits, pose: machine.standing(trajectory)? })
    }
}

/// How clients are served.
pub(super) fn settings(door: &Door<'_>, machine: &Machine) -> SessionSettings {
    let lock_step = door.pace == Pace::Virtual;
    let others = SessionSettings::of_period(machine.period_ns());
    SessionSettings {
        lock_step,
        playout_delay_ns: if lock_step { 0 } else { others.playout_delay_ns },
        timeout_ns: (machine.safety.command_age * 1e9) as u64,
        unattended_ns: (machine.safety.unattended * 1e9) as u64,
        ..others
    }
}

/// What set-points the machine of a run accepts.
pub(super) fn domain_of(
    setup: &Setup,
    limits: &JointLimits,
    supervisor: &Supervisor,
) -> Result<Domain, Error> {
    let tension = supervisor.controller().gains().tension_limits();
    let name = &setup.machine.robot.parts().name;
    Ok(domain(name, &setup.machine, &limits.range, &tension)?)
}

/// Serves clients until the server is dropped, and the port of the motion that follows them.
pub(super) fn start(
    door: &Door<'_>,
    setup: &Setup,
    address: SocketAddr,
    supervisor: &Supervisor,
) -> Result<(Server, Port), Error> {
    let sessions = settings(door, &setup.machine);
    let limits = Follower::new(&setup.machine, &setup.trajectory)?.limits;
    let domain = domain_of(setup, &limits, supervisor)?;
    let key = read_key(door.arguments.link.key.as_deref())?;
    let name = &setup.machine.robot.parts().name;
    let (server, port) = Server::start(ServerSettings { address, key, domain, sessions })?;
    tell!("link: {name} listens on {}", server.address());
    Ok((server, port))
}

/// The motion that follows what comes through a port.
pub(super) fn motion(door: &Door<'_>, setup: &Setup, port: Port) -> Result<LinkedMotion, Error> {
    let (machine, sessions) = (&setup.machine, settings(door, &setup.machine));
    let Follower { limits, pose } = Follower::new(machine, &setup.trajectory)?;
    let until = door.arguments.link.until.map(|seconds| (seconds * 1e9) as u64);
    Ok(LinkedMotion::new(port, sessions, machine, limits, &pose, until)?)
}

pub(super) fn json(counts: &LinkCounts) -> serde_json::Value {
    let rejected = counts.packets.by_reason().map(|(reason, count)| (reason.name().to_owned(), count.into()));
    serde_json::json!({
        "accepted": counts.packets.accepted,
        "rejected": rejected.collect::<serde_json::Map<_, _>>(),
        "late_points": counts.late_points,
        "dropped_states": counts.dropped_states,
    })
}

pub(super) fn text(counts: &LinkCounts) -> String {
    let LinkCounts { packets, late_points, dropped_states } = counts;
    let mut text = format!(
        "Commands: {} packets accepted, {late_points} points late, {dropped_states} states dropped\n",
        packets.accepted
    );
    for (reason, count) in packets.by_reason().filter(|(_, count)| *count != 0) {
        text += &format!("rejected as {}: {count}\n", reason.name());
    }
    text
}
