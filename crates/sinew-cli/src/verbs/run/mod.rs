//! `sinew track` and `sinew run`: one session with a machine, whatever moves it and whatever it follows.

mod bus;
mod door;
mod ended;
mod gears;
mod link;
mod ros;
mod stopping;
mod timing;
mod watch;

use super::device_files;
use super::page::{RunPage, Shown};
use super::recording::{LinkSetup, Recording, Request};
use super::track::setup::Setup;
use crate::answer::Answer;
use crate::arguments::{BusArgument, General, RunArguments, TrackArguments};
use crate::error::Error;
use crate::progress::Progress;
pub(crate) use door::{Door, Pace};
use ended::Ended;
pub(crate) use link::Follower;
use ros::RunNode;
use sinew::control::arm::ArmGains;
use sinew::control::supervisor::{Limits, Supervisor};
use sinew::predictor::CableModel;
use sinew::trajectory::Schedule;
use sinew_identify::gear::GearFit;
use sinew_lab::arm::{INITIAL_REST_S, IdentifiedMachine, PreparedRun, TrackOutcome, TrackingNumbers};
use sinew_lab::experiment::Evaluation;
use sinew_runtime::Bus;
use sinew_runtime::can::{self, CanBus, SimulatedLink};
use sinew_runtime::cycle::{Cycle, MonotonicClock, RealTime, Timing, run as step_through};
use sinew_runtime::ethercat::{
    EthercatDevice, EthercatError, FrameStorage, Master, SegmentLink, SimulatedMachine,
};
use sinew_runtime::link::{LinkedMotion, RunMotion};
use sinew_runtime::servos::{self, ServoBus, ServoDevice, SimulatedLines};
use sinew_segment::DescriptionFile;
use sinew_session::{CycleRecord, Plant, Scheduled, TwinPlant, VirtualClock};
use stopping::Stopping;
use watch::{Judged, Seen, Watch};

pub(crate) fn run(arguments: &RunArguments, general: &General) -> Result<Answer, Error> {
    start(&Door::run(arguments), general)
}

pub(crate) fn track(arguments: &TrackArguments, general: &General) -> Result<Answer, Error> {
    start(&Door::track(arguments), general)
}

fn start(door: &Door<'_>, general: &General) -> Result<Answer, Error> {
    door.check(general.no_clobber)?;
    let progress = Progress::new();
    progress.show("planning and verifying the motion", 0.0);
    let setup = door.setup();
    drop(progress);
    let setup = setup?;
    if let (false, Some(sensor)) = (matches!(door.bus, BusArgument::Twin), setup.machine.unmeasured()) {
        return Err(Error::Unmeasured(sensor));
    }
    let descriptions = device_files::read(door.devices, setup.devices.of())?;
    door.tell_start(&setup);
    door.tell_duration(&setup);
    let timed = door.pace == Pace::RealTime;
    let shown =
        Shown { bus: door.bus.name(), simulated: door.is_simulated(), linked: door.is_linked(), timed };
    let page = RunPage::start(&door.arguments.page, &setup, &shown)?;
    let prepared = Prepared { door, setup: &setup, progress: Progress::new() };
    let ended = match door.bus {
        BusArgument::Real(bus) => prepared.on_hardware(bus, door.interface, page)?,
        _ => prepared.simulated(&descriptions, page)?,
    };
    drop(prepared);
    ended.answer(door, &setup, general.json)
}

/// A run before its machine.
struct Prepared<'a> {
    door: &'a Door<'a>,
    setup: &'a Setup,
    progress: Progress,
}

impl Prepared<'_> {
    /// With the devices on an interface, and what the machine file says of their cables.
    fn on_hardware(&self, bus: &Bus, interface: &str, page: Option<RunPage>) -> Result<Ended, Error> {
        let Self { setup, progress, .. } = self;
        progress.show("bringing the devices into operation", 0.0);
        let task = setup.task();
        let identified = IdentifiedMachine::designed(&setup.machine, &setup.trajectory, task.gains)?;
        let mut controller = identified.plain_controller()?;
        if task.learning && task.repeats > 1 {
            controller = controller.with_iterative_learning(setup.trajectory.duration())?;
        }
        let limits = Limits::from_machine(&setup.machine, controller.gains())?;
        let supervisor = Supervisor::new(controller, limits)?;
        let mut wire = (bus.open)(interface)?;
        // Before any drive moves, and before the thread has its priority.
        let recording = self.record(&identified.gains, &identified.models, None)?;
        // From here on drives have power: whoever ends the run stops them.
        let watch = self.watch(recording, page, RunNode::start(self.door, setup, &supervisor)?, None);
        let plant = wire.operate(&setup.machine, &setup.devices)?;
        self.step(plant, supervisor, watch).map(|(ended, ..)| ended)
    }

    /// With a specimen that is drawn and calibrated, alone or behind simulated devices.
    fn simulated(&self, descriptions: &[DescriptionFile], page: Option<RunPage>) -> Result<Ended, Error> {
        let Self { door, setup, progress } = self;
        progress.show("calibrating the machine's cables", 0.0);
        let arm = setup.calibrate()?;
        let prepared = PreparedRun::new(&arm, setup.variant, &setup.task())?;
        let conditions = prepared.run();
        let (plant, supervisor) = (conditions.plant()?, prepared.supervisor()?);
        let judged = Judged {
            evaluation: Evaluation::new(&conditions)?,
            robot: &arm.machine.robot,
            stride: self.stride(),
            trace: Vec::new(),
            count: 0,
            time: 0.0,
        };
        let recording = self.record(&prepared.gains, &arm.models, Some(&arm.gears))?;
        let node = RunNode::start(door, setup, &supervisor)?;
        let watch = self.watch(recording, page, node, Some(judged).filter(|_| !door.is_linked()));
        let (mut ended, judged, supervisor) = match door.bus {
            BusArgument::Twin => self.step(TwinPlant::new(plant), supervisor, watch)?,
            BusArgument::Chain => {
                let servos: &[ServoDevice] = setup.devices.of();
                let ports = ServoDevice::ports(servos);
                let machine = servos::SimulatedMachine::new(plant, &setup.machine, servos, &ports, false);
                let bus = ServoBus::start(SimulatedLines::new(machine), &setup.machine, servos)?;
                self.step(bus, supervisor, watch)?
            }
            BusArgument::Nodes => {
                let nodes = setup.devices.of();
                let machine = can::SimulatedMachine::new(plant, &setup.machine, nodes, true);
                let bus = CanBus::start(SimulatedLink::new(machine), &setup.machine, nodes)?;
                self.step(bus, supervisor, watch)?
            }
            // The latter is not simulated.
            BusArgument::Segment | BusArgument::Real(_) => {
                let devices: &[EthercatDevice] = setup.devices.of();
                let simulated = SimulatedMachine::new(plant, &setup.machine, devices.to_vec());
                let segment = simulated.segment(descriptions)?;
                let storage = FrameStorage::new();
                let master = Master::new(&storage, SegmentLink::new(segment, simulated))?;
                let matched = master.match_devices(devices).map_err(EthercatError::from)?;
                self.step(matched.operate(&setup.machine)?, supervisor, watch)?
            }
        };
        ended.gears = gears::named(&setup.machine, &arm.gears);
        if let Some(judged) = judged {
            let summary = judged.evaluation.finish(&supervisor);
            let limits = (conditions.tension_limits, arm.joint_error_limits());
            let numbers = TrackingNumbers::new(&summary, &arm.machine, limits.0, &limits.1);
            let mut numbers = numbers.map_err(sinew_lab::Error::from)?;
            if let (None, Some(stopped)) = (numbers.stopped_s, ended.stopped) {
                (numbers.ended, numbers.reason) = (TrackOutcome::Stopped, Some(stopped.by().to_owned()));
            }
            ended.tracking = Some(numbers);
            ended.trace = judged.trace;
        }
        Ok(ended)
    }

    /// Cycles from row to row of the trace that a table or a report needs.
    fn stride(&self) -> Option<u64> {
        let interval = match (self.door.table(), &self.door.arguments.report) {
            (Some(_), _) => super::track::RECORD_INTERVAL_S,
            (None, Some(_)) => self.setup.motion_s() / super::track::REPORT_ROWS,
            (None, None) => return None,
        };
        Some((interval / self.setup.machine.period).round().clamp(1.0, 1e9) as u64)
    }

    fn record(
        &self,
        gains: &ArmGains,
        models: &[CableModel],
        gears: Option<&[Option<GearFit>]>,
    ) -> Result<Option<Recording>, Error> {
        let Self { door, setup, .. } = self;
        let link = door.is_linked().then(|| LinkSetup::new(&link::settings(door, &setup.machine)));
        Recording::start(&Request { door, setup, gains, models, gears, link })
    }

    /// From here on Ctrl-C is answered by a safe stop.
    fn watch<'a>(
        &'a self,
        recording: Option<Recording>,
        page: Option<RunPage>,
        node: Option<RunNode>,
        judged: Option<Judged<'a>>,
    ) -> Watch<'a> {
        let linked = self.door.is_linked();
        Watch {
            seen: Seen::new(self.setup.trajectory.joints(), linked),
            judged,
            recording,
            page,
            node,
            stopping: Stopping::begin(),
            progress: (!linked).then(|| (&self.progress, self.setup.run_s())),
            ends_at_fault: !self.door.is_simulated() && !linked,
        }
    }

    /// The cycles, to the end of the motion, of the client's use of the machine, or of a stop.
    fn step<'a, P: Plant>(
        &self,
        plant: P,
        supervisor: Supervisor,
        mut watch: Watch<'a>,
    ) -> Result<(Ended, Option<Judged<'a>>, Supervisor), Error> {
        let Self { door, setup, .. } = self;
        let (server, port) = match door.arguments.link.link {
            Some(address) => {
                let (server, port) = link::start(door, setup, address, &supervisor)?;
                (Some(server), Some(port))
            }
            None => (None, watch.node.as_mut().and_then(RunNode::take_port)),
        };
        let motion = match port {
            Some(port) => {
                self.progress.end();
                RunMotion::from(link::motion(door, setup, port)?)
            }
            None => {
                let (repeats, rest) = (setup.repeats, setup.hold_s);
                let schedule = Schedule::new(&setup.trajectory, repeats, INITIAL_REST_S, rest)?;
                let standing = setup.machine.standing(&setup.trajectory)?;
                Scheduled::new(schedule, &setup.machine.robot, &standing)?.into()
            }
        };
        let motion = motion.with_tape(watch.recording.as_mut().and_then(Recording::take_tape));
        let cycle = Cycle::new(plant, supervisor, motion, setup.machine.period);
        let mut cycle = watch.stopping.of(cycle, watch.page.as_ref());
        let (end, mut timing) = (watch.stopping.at_once(), Timing::new());
        let see = |record: &CycleRecord<'_, P>| watch.see(record);
        let (mut real_time, period) = (RealTime::default(), setup.machine.period_ns());
        match door.pace {
            Pace::Virtual => {
                step_through(&mut cycle, &mut VirtualClock::default(), period, end, &mut timing, see)?;
            }
            Pace::Watched => step_through(&mut cycle, &mut MonotonicClock, period, end, &mut timing, see)?,
            Pace::RealTime => {
                real_time = RealTime::request();
                step_through(&mut cycle, &mut MonotonicClock, period, end, &mut timing, see)?;
            }
        }
        let counts = cycle.motion().link().map(LinkedMotion::counts);
        let (statistics, clocks) = (cycle.statistics(), cycle.plant().clocks());
        let supervisor = cycle.supervisor().clone();
        // The machine stops here, before anything is waited for.
        drop(cycle);
        drop(server);
        let Watch { seen, judged, recording, page, node, stopping, .. } = watch;
        let ended = Ended {
            stopped: stopping.stopped(page.as_ref()),
            threshold: seen.stopped.and_then(|(_, fault)| supervisor.threshold(fault)),
            health: supervisor.health().to_vec(),
            seen,
            tracking: None,
            gears: Vec::new(),
            trace: Vec::new(),
            timing,
            real_time,
            statistics,
            clocks,
            counts,
            node: node.map(RunNode::end),
            recording: recording.map(Recording::end),
        };
        Ok((ended, judged, supervisor))
    }
}
