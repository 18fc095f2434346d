//! A run that a client commands over a link.

use super::shortcomings::warn;
use super::{bus, timing};
use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{BusArgument, General, PathArgument, RunArguments};
use crate::error::Error;
use crate::interrupt;
use crate::progress::Progress;
use crate::verbs::link::key_file::read_key;
use crate::verbs::track::setup::Setup;
use sinew::control::arm::ArmStatus;
use sinew::control::supervisor::{Limits, Supervisor};
use sinew::trajectory::online::JointLimits;
use sinew::trajectory::{Reference, Trajectory, finite_ranges};
use sinew_lab::arm::{PreparedRun, TrackMode, designed_controller, stop_reason};
use sinew_lab::experiment::ModeChange;
use sinew_lab::experiment::arm::STEP;
use sinew_link::host::{Server, ServerSettings, SessionSettings};
use sinew_runtime::bus::{Bus, ClockReport, TwinBus};
use sinew_runtime::cycle::{Cycle, CycleRecord, MonotonicClock, RealTime, Timing, VirtualClock, run};
use sinew_runtime::ethercat::{
    EthercatBus, EthercatError, FrameStorage, Link, Master, RawSocketLink, SegmentLink, SimulatedMachine,
};
use sinew_runtime::link::{LinkedMotion, domain};
use std::net::SocketAddr;

/// Control cycle, ns.
const PERIOD: u64 = 1_000_000;

/// A run in preparation.
struct Linked<'a> {
    arguments: &'a RunArguments,
    address: SocketAddr,
    setup: &'a Setup,
    limits: JointLimits,
    pose: Vec<f64>,
}

pub(super) fn execute(
    arguments: &RunArguments,
    address: SocketAddr,
    general: &General,
) -> Result<Answer, Error> {
    let progress = Progress::new();
    progress.show("planning and verifying the motion whose speeds are the limits", 0.0);
    let setup = Setup::with_default_path(&arguments.motion, |_| PathArgument::Tour)?;
    let ranges = finite_ranges(&setup.machine.robot, &setup.machine.start)?;
    let limits = JointLimits::of_motion(&setup.trajectory, ranges)?;
    let pose = start_of(&setup.trajectory)?;
    let linked = Linked { arguments, address, setup: &setup, limits, pose };
    let storage = FrameStorage::new();
    if let Some(interface) = arguments.interface.as_deref().filter(|_| arguments.bus == BusArgument::Ethercat)
    {
        progress.show("bringing the devices into operation", 0.0);
        let controller = designed_controller(&setup.machine, &setup.trajectory, setup.task(1.0).gains)?;
        let limits = Limits::of(&setup.machine, controller.gains())?;
        let supervisor = Supervisor::new(controller, limits)?;
        let master = Master::new(&storage, RawSocketLink::open(interface)?)?;
        let devices = &setup.machine.devices;
        let bus =
            master.match_devices(devices).map_err(EthercatError::from)?.operate(&setup.machine, PERIOD)?;
        drop(progress);
        return linked.on(bus, supervisor, general, end_of_bus);
    }
    progress.show("calibrating the machine's cables", 0.0);
    let arm = setup.calibrate()?;
    let prepared = PreparedRun::new(&arm, setup.variant, &setup.task(1.0))?;
    let (plant, supervisor) = (prepared.run().plant()?, prepared.supervisor()?);
    drop(progress);
    match arguments.bus {
        BusArgument::Twin => linked.on(TwinBus::new(plant, STEP), supervisor, general, |_| None),
        BusArgument::Segment | BusArgument::Ethercat => {
            let simulated = SimulatedMachine::new(plant, &setup.machine);
            let segment = simulated.segment(|_| None)?;
            let master = Master::new(&storage, SegmentLink::new(segment, simulated))?;
            let matched = master.match_devices(&setup.machine.devices).map_err(EthercatError::from)?;
            linked.on(matched.operate(&setup.machine, PERIOD)?, supervisor, general, end_of_bus)
        }
    }
}

/// Lets the devices leave operation; how their clocks were kept.
fn end_of_bus<L: Link>(bus: &mut EthercatBus<'_, L>) -> Option<ClockReport> {
    let clocks = bus.clocks();
    bus.stop();
    clocks
}

fn start_of(trajectory: &Trajectory) -> Result<Vec<f64>, Error> {
    let mut start = Reference::new(trajectory.joints());
    trajectory.sample(0.0, &mut start)?;
    Ok(start.q)
}

impl Linked<'_> {
    fn on<B: Bus>(
        &self,
        bus: B,
        supervisor: Supervisor,
        general: &General,
        end: impl FnOnce(&mut B) -> Option<ClockReport>,
    ) -> Result<Answer, Error> {
        let Self { arguments, setup, .. } = self;
        let machine = &setup.machine;
        let sessions = SessionSettings {
            lock_step: arguments.virtual_time,
            playout_delay_ns: if arguments.virtual_time {
                0
            } else {
                SessionSettings::default().playout_delay_ns
            },
            timeout_ns: (machine.safety.command_age * 1e9) as u64,
            ..SessionSettings::default()
        };
        let tension: Vec<[f64; 2]> =
            supervisor.controller().gains().muscles.iter().map(|muscle| muscle.tension).collect();
        let name = &machine.robot.parts().name;
        let domain = domain(name, machine, &self.limits.range, &tension)?;
        let key = read_key(arguments.link.key.as_deref())?;
        let (server, port) = Server::start(ServerSettings { address: self.address, key, domain, sessions })?;
        eprintln!("link: {name} listens on {}", server.address());
        let until = arguments.link.until.map(|seconds| (seconds * 1e9) as u64);
        let motion = LinkedMotion::new(port, sessions, machine, self.limits.clone(), &self.pose, until)?;
        let simulated = arguments.bus != BusArgument::Ethercat;
        let cycle = Cycle::linked(bus, supervisor, motion, STEP);
        let mut cycle = if simulated { cycle.with_waiting_machine() } else { cycle };
        let mut seen = Seen::default();
        let mut times = Timing::new();
        let see = |record: &CycleRecord<'_, B>| {
            seen.record(record);
            Ok(())
        };
        let stop = interrupt::answer();
        let real_time = if arguments.virtual_time {
            run(&mut cycle, &mut VirtualClock::default(), PERIOD, stop, &mut times, see)?;
            RealTime::default()
        } else {
            let real_time = RealTime::request();
            run(&mut cycle, &mut MonotonicClock, PERIOD, stop, &mut times, see)?;
            real_time
        };
        let counts = cycle.link().map(LinkedMotion::counts);
        let statistics = cycle.statistics();
        let threshold = seen.stopped.and_then(|(_, fault)| cycle.supervisor().threshold(fault));
        let clocks = end(&mut cycle.into_bus());
        drop(server);
        warn(&real_time);

        let ended = seen.ended(arguments.link.until.is_some());
        let reason = seen
            .stopped
            .map(|(time, fault)| format!("{} at {time:.3} s", stop_reason(fault, threshold, &machine.robot)));
        let rejected = counts.iter().flat_map(|counts| counts.packets.by_reason().collect::<Vec<_>>());
        let rejected: serde_json::Map<String, serde_json::Value> =
            rejected.map(|(reason, count)| (reason.name().to_owned(), count.into())).collect();
        let mut all = serde_json::json!({
            "simulated": simulated,
            "run": {
                "ended": ended,
                "reason": reason,
                "cycles": seen.cycles,
                "modes": seen.modes.iter().map(TrackMode::new).collect::<Vec<_>>(),
                "digest": format!("{:016x}", seen.digest.0),
            },
            "link": {
                "accepted": counts.map(|counts| counts.packets.accepted),
                "rejected": rejected,
                "late_points": counts.map(|counts| counts.late_points),
                "dropped_states": counts.map(|counts| counts.dropped_states),
            },
            "bus": bus::json(&statistics, clocks),
        });
        if simulated {
            all["seed"] = setup.seed.into();
        }
        if !arguments.virtual_time {
            all["timing_us"] = timing::json(&times);
        }
        let content = if general.json { Content::json(&all)? } else { self.text(&all, &times) };
        Ok(Answer { outcome: Outcome::of(seen.stopped.is_none()), content, written: Vec::new() })
    }

    fn text(&self, all: &serde_json::Value, times: &Timing) -> Content {
        let (run, link) = (&all["run"], &all["link"]);
        let reason = run["reason"].as_str().map(|reason| format!(": {reason}")).unwrap_or_default();
        let ended = run["ended"].as_str().unwrap_or_default().replace('_', " ");
        let mut text = format!(
            "Ended {ended}{reason} after {:.3} s\nLink: {} packets accepted, {} points late, {} states dropped\n",
            run["cycles"].as_u64().unwrap_or(0) as f64 * STEP,
            link["accepted"],
            link["late_points"],
            link["dropped_states"],
        );
        let rejected = link["rejected"].as_object().into_iter().flatten();
        for (reason, count) in rejected.filter(|(_, count)| count.as_u64() != Some(0)) {
            text += &format!("rejected as {reason}: {count}\n");
        }
        if !self.arguments.virtual_time {
            text += &timing::text(times);
        }
        Content::Text(text)
    }
}

/// What was seen of a run.
#[derive(Default)]
struct Seen {
    cycles: u64,
    modes: Vec<ModeChange>,
    stopped: Option<(f64, sinew::control::arm::Fault)>,
    digest: Digest,
}

impl Seen {
    fn record<B>(&mut self, record: &CycleRecord<'_, B>) {
        let command = &record.command;
        self.cycles += 1;
        if self.modes.last().is_none_or(|last| last.mode != command.mode) {
            self.modes.push(ModeChange {
                time: record.moment.time,
                mode: command.mode,
                fault: command.fault,
            });
        }
        if let ArmStatus::Stopped(fault) = command.arm.status {
            self.stopped.get_or_insert((record.moment.time, fault));
        }
        record.feedback.motor.iter().chain(&record.feedback.tension).for_each(|x| self.digest.add(*x));
        record.feedback.joint.iter().chain(command.arm.q).for_each(|x| self.digest.add(*x));
    }

    fn ended(&self, until: bool) -> &'static str {
        match self.stopped {
            Some(_) => "stopped",
            None if interrupt::is_requested() => "interrupted",
            None if until => "as_planned",
            None => "turned_off",
        }
    }
}

/// FNV-1a over the bits of every reading and estimate: equal for runs that are equal to the bit.
struct Digest(u64);

impl Default for Digest {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Digest {
    fn add(&mut self, number: f64) {
        for byte in number.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }
}
