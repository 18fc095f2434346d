//! A run that a client commands over a link.

use super::seen::Seen;
use super::shortcomings::warn;
use super::stopping::Stopping;
use super::{bus, timing};
use crate::answer::{Answer, Content, Outcome};
use crate::arguments::{BusArgument, General, PathArgument, RunArguments};
use crate::error::Error;
use crate::progress::Progress;
use crate::verbs::device_files;
use crate::verbs::link::key_file::read_key;
use crate::verbs::page::{RunPage, Shown};
use crate::verbs::recording::{LinkSetup, Recording, Request};
use crate::verbs::track::setup::Setup;
use sinew::control::arm::ArmGains;
use sinew::control::supervisor::{Limits, Supervisor};
use sinew::machine::Machine;
use sinew::predictor::CableModel;
use sinew::trajectory::online::JointLimits;
use sinew::trajectory::{Reference, Trajectory, finite_ranges};
use sinew_lab::arm::{IdentifiedMachine, PreparedRun, TrackMode, stop_reason};
use sinew_lab::experiment::arm::STEP;
use sinew_link::host::{Server, ServerSettings, SessionSettings};
use sinew_runtime::cycle::{Cycle, MonotonicClock, RealTime, Timing, run};
use sinew_runtime::ethercat::{
    EthercatError, FrameStorage, Master, RawSocketLink, SegmentLink, SimulatedMachine,
};
use sinew_runtime::link::{LinkedMotion, RunMotion, domain};
use sinew_session::{CycleRecord, Plant, TwinPlant, VirtualClock};
use std::net::SocketAddr;

/// Control cycle, ns.
const PERIOD: u64 = 1_000_000;

/// A run in preparation.
struct Linked<'a> {
    arguments: &'a RunArguments,
    address: SocketAddr,
    setup: &'a Setup,
    follower: Follower,
    sessions: SessionSettings,
    bus: &'static str,
}

/// What set-points may do: limits of the joints, and the pose that is held at first, rad or m.
pub(crate) struct Follower {
    pub(crate) limits: JointLimits,
    pub(crate) pose: Vec<f64>,
}

impl Follower {
    /// Of the motion that was planned and verified.
    pub(crate) fn of(machine: &Machine, trajectory: &Trajectory) -> Result<Self, Error> {
        let ranges = finite_ranges(&machine.robot, &machine.start)?;
        let limits = JointLimits::of_motion(trajectory, ranges)?;
        let mut start = Reference::new(trajectory.joints());
        trajectory.sample(0.0, &mut start)?;
        Ok(Self { limits, pose: start.q })
    }
}

pub(super) fn execute(
    arguments: &RunArguments,
    address: SocketAddr,
    general: &General,
) -> Result<Answer, Error> {
    let progress = Progress::new();
    progress.show("planning and verifying the motion whose speeds are the limits", 0.0);
    let setup = Setup::with_default_path(&arguments.motion, |_| PathArgument::Tour)?;
    let descriptions = device_files::read(&arguments.devices, &setup.machine.devices)?;
    let follower = Follower::of(&setup.machine, &setup.trajectory)?;
    let mut sessions = SessionSettings {
        lock_step: arguments.virtual_time,
        timeout_ns: (setup.machine.safety.command_age * 1e9) as u64,
        unattended_ns: (setup.machine.safety.unattended * 1e9) as u64,
        ..SessionSettings::default()
    };
    if sessions.lock_step {
        sessions.playout_delay_ns = 0;
    }
    let bus = arguments.bus.name();
    let linked = Linked { arguments, address, setup: &setup, follower, sessions, bus };
    let storage = FrameStorage::new();
    if let Some(interface) = arguments.interface.as_deref().filter(|_| arguments.bus == BusArgument::Ethercat)
    {
        progress.show("bringing the devices into operation", 0.0);
        let gains = setup.task(1.0).gains;
        let identified = IdentifiedMachine::designed(&setup.machine, &setup.trajectory, gains)?;
        let controller = identified.plain_controller()?;
        let limits = Limits::of(&setup.machine, controller.gains())?;
        let supervisor = Supervisor::new(controller, limits)?;
        let recording = linked.record(&identified.gains, &identified.models, false)?;
        let master = Master::new(&storage, RawSocketLink::open(interface)?)?;
        let devices = &setup.machine.devices;
        // From here on drives have power: whoever ends the run stops them.
        let stopping = Stopping::begin();
        let bus =
            master.match_devices(devices).map_err(EthercatError::from)?.operate(&setup.machine, PERIOD)?;
        drop(progress);
        return linked.on(bus, On { supervisor, recording, stopping }, general);
    }
    progress.show("calibrating the machine's cables", 0.0);
    let arm = setup.calibrate()?;
    let prepared = PreparedRun::new(&arm, setup.variant, &setup.task(1.0))?;
    let (plant, supervisor) = (prepared.run().plant()?, prepared.supervisor()?);
    let recording = linked.record(&prepared.gains, &arm.models, true)?;
    drop(progress);
    match arguments.bus {
        BusArgument::Twin => {
            let on = On { supervisor, recording, stopping: Stopping::begin() };
            linked.on(TwinPlant::new(plant, STEP), on, general)
        }
        BusArgument::Segment | BusArgument::Ethercat => {
            let simulated = SimulatedMachine::new(plant, &setup.machine);
            let segment = simulated.segment(&descriptions)?;
            let master = Master::new(&storage, SegmentLink::new(segment, simulated))?;
            let matched = master.match_devices(&setup.machine.devices).map_err(EthercatError::from)?;
            let on = On { supervisor, recording, stopping: Stopping::begin() };
            linked.on(matched.operate(&setup.machine, PERIOD)?, on, general)
        }
    }
}

/// What is on a bus.
struct On {
    supervisor: Supervisor,
    recording: Option<Recording>,
    stopping: Stopping,
}

impl Linked<'_> {
    /// Begins the recording, if there is to be one.
    fn record(
        &self,
        gains: &ArmGains,
        models: &[CableModel],
        calibrated: bool,
    ) -> Result<Option<Recording>, Error> {
        let Self { arguments, setup, sessions, .. } = self;
        let link = Some(LinkSetup::of(sessions));
        Recording::start(&Request { arguments, setup, gains, models, calibrated, link })
    }

    fn on<P: Plant>(&self, plant: P, on: On, general: &General) -> Result<Answer, Error> {
        let Self { arguments, setup, sessions, follower, .. } = self;
        let On { supervisor, mut recording, mut stopping } = on;
        let (machine, sessions) = (&setup.machine, *sessions);
        let tension: Vec<[f64; 2]> =
            supervisor.controller().gains().muscles.iter().map(|muscle| muscle.tension).collect();
        let name = &machine.robot.parts().name;
        let domain = domain(name, machine, &follower.limits.range, &tension)?;
        let key = read_key(arguments.link.key.as_deref())?;
        let (server, port) = Server::start(ServerSettings { address: self.address, key, domain, sessions })?;
        eprintln!("link: {name} listens on {}", server.address());
        let until = arguments.link.until.map(|seconds| (seconds * 1e9) as u64);
        let limits = follower.limits.clone();
        let motion = LinkedMotion::new(port, sessions, machine, limits, &follower.pose, until)?;
        let simulated = arguments.bus != BusArgument::Ethercat;
        let shown = Shown { bus: self.bus, simulated, linked: true, timed: !arguments.virtual_time };
        let mut page = RunPage::start(&arguments.page, setup, &shown)?;
        let motion = RunMotion::from(motion).with_tape(recording.as_mut().and_then(Recording::take_tape));
        let mut cycle = stopping.of(Cycle::new(plant, supervisor, motion, STEP), page.as_ref());
        let end_at_once = stopping.at_once();
        let mut seen = Seen::default();
        let mut times = Timing::new();
        let see = |record: &CycleRecord<'_, P>| {
            seen.record(record);
            if let Some(recording) = &mut recording {
                recording.record(record);
            }
            if let Some(page) = &mut page {
                page.show(record);
            }
            stopping.see(record);
            Ok(())
        };
        let real_time = if arguments.virtual_time {
            run(&mut cycle, &mut VirtualClock::default(), PERIOD, end_at_once, &mut times, see)?;
            RealTime::default()
        } else {
            let real_time = RealTime::request();
            run(&mut cycle, &mut MonotonicClock, PERIOD, end_at_once, &mut times, see)?;
            real_time
        };
        let recording = recording.map(Recording::end);
        let counts = cycle.motion().link().map(LinkedMotion::counts);
        let statistics = cycle.statistics();
        let threshold = seen.stopped.and_then(|(_, fault)| cycle.supervisor().threshold(fault));
        let clocks = cycle.plant().clocks();
        drop(cycle);
        drop(server);
        warn(&real_time);

        let from_elsewhere = stopping.stopped(page.as_ref());
        let ended = seen.ended(from_elsewhere, arguments.link.until.is_some());
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
        if let Some(recording) = &recording {
            all["recording"] = recording.json.clone();
        }
        if simulated {
            all["seed"] = setup.seed.into();
        }
        if !arguments.virtual_time {
            all["timing_us"] = timing::json(&times);
        }
        let content = if general.json {
            Content::json(&all)?
        } else {
            let told = recording.as_ref().map_or("", |recording| &recording.text);
            Content::Text(self.text(&all, &times) + told)
        };
        let whole = recording.as_ref().is_none_or(|recording| recording.whole);
        let written = recording.into_iter().map(|recording| recording.written).collect();
        Ok(Answer {
            outcome: Outcome::of(seen.stopped.is_none() && from_elsewhere.is_none() && whole),
            content,
            written,
        })
    }

    fn text(&self, all: &serde_json::Value, times: &Timing) -> String {
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
        text
    }
}
